//! Which numbers of a sum of models are free, and on which scale they are moved.

use crate::brdf::model::named::{Kind, Named, Term};
use crate::brdf::model::parts::Share;

/// How a parameter is moved without bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Scale {
    /// Its logarithm: what is positive.
    Log,
    /// The logarithm of p/(1 - p): what lies between 0 and 1.
    Odds,
    /// Itself.
    Plain,
}

/// Which number of a term.
#[derive(Clone, Debug, PartialEq)]
enum Place {
    /// These numbers, all the same.
    Numbers(&'static [usize]),
    /// Its share.
    Share,
}

#[derive(Clone, Debug)]
struct Parameter {
    term: usize,
    place: Place,
    scale: Scale,
    what: &'static str,
}

/// A sum of terms with its free parameters.
#[derive(Clone, Debug)]
pub(super) struct Shape {
    terms: Vec<Term>,
    free: Vec<Parameter>,
}

impl Shape {
    /// `terms` as a start; those that scatter evenly have one free number, their reflectance.
    pub fn new(terms: Vec<Term>) -> Self {
        let mut free = Vec::new();
        for (term, own) in terms.iter().enumerate() {
            let mut add = |what, place, scale| free.push(Parameter { term, place, scale, what });
            if own.kind.is_base {
                add("diffuse reflectance", Place::Numbers(&[0]), Scale::Odds);
                continue;
            }
            match (own.kind.name, own.numbers.len()) {
                ("lafortune", _) => {
                    if own.numbers[0] == own.numbers[1] {
                        add("Cx and Cy", Place::Numbers(&[0, 1]), Scale::Plain);
                    } else {
                        add("Cx", Place::Numbers(&[0]), Scale::Plain);
                        add("Cy", Place::Numbers(&[1]), Scale::Plain);
                    }
                    add("Cz", Place::Numbers(&[2]), Scale::Plain);
                    add("exponent", Place::Numbers(&[3]), Scale::Log);
                    // Its coefficients are its share.
                    continue;
                }
                ("shifted-gamma", _) => {
                    add("alpha", Place::Numbers(&[0]), Scale::Log);
                    add("power", Place::Numbers(&[1]), Scale::Plain);
                }
                ("ashikhmin-shirley", _) if own.numbers[0] == own.numbers[1] => {
                    add("exponent", Place::Numbers(&[0, 1]), Scale::Log);
                }
                (_, 1) => add(own.kind.numbers[0].what, Place::Numbers(&[0]), Scale::Log),
                _ => {
                    add(own.kind.numbers[0].what, Place::Numbers(&[0]), Scale::Log);
                    add(own.kind.numbers[1].what, Place::Numbers(&[1]), Scale::Log);
                }
            }
            match own.share {
                Share::Even(_) => add("share", Place::Share, Scale::Log),
                Share::Schlick(_) => add("F0", Place::Share, Scale::Odds),
                Share::Index(_) => add("index of refraction", Place::Share, Scale::Plain),
            }
        }
        Self { terms, free }
    }

    /// The parameters of the start.
    pub fn start(&self) -> Vec<f64> {
        self.free.iter().map(|own| own.scale.to(self.value(own))).collect()
    }

    fn value(&self, own: &Parameter) -> f64 {
        let term = &self.terms[own.term];
        match (&own.place, term.share) {
            (Place::Numbers(slots), _) => term.numbers[slots[0]],
            (Place::Share, Share::Even(value) | Share::Schlick(value) | Share::Index(value)) => value,
        }
    }

    /// The terms at `at`.
    pub fn terms(&self, at: &[f64]) -> Vec<Term> {
        let mut terms = self.terms.clone();
        for (own, at) in self.free.iter().zip(at) {
            let (term, value) = (&mut terms[own.term], own.scale.from(*at));
            match &own.place {
                Place::Numbers(slots) => slots.iter().for_each(|slot| term.numbers[*slot] = value),
                Place::Share => {
                    term.share = match term.share {
                        Share::Even(_) => Share::Even(value),
                        Share::Schlick(_) => Share::Schlick(value),
                        Share::Index(_) => Share::Index(value),
                    }
                }
            }
        }
        terms
    }

    /// The model at `at`, if there is one.
    pub fn model(&self, at: &[f64]) -> Option<Named> {
        Named::new(self.terms(at)).ok()
    }

    /// Name, value and standard error of every parameter, from `at` and the errors there.
    pub fn told(&self, at: &[f64], errors: &[f64]) -> Vec<(String, f64, f64)> {
        let told = |(own, (at, error)): (&Parameter, (&f64, &f64))| {
            let value = own.scale.from(*at);
            let name = format!("{}: {}", self.terms[own.term].kind.name, own.what);
            (name, value, error * own.scale.slope(value))
        };
        self.free.iter().zip(at.iter().zip(errors)).map(told).collect()
    }
}

impl Scale {
    fn to(self, value: f64) -> f64 {
        match self {
            Self::Log => value.max(1e-9).ln(),
            Self::Odds => {
                let share = value.clamp(1e-6, 1.0 - 1e-6);
                (share / (1.0 - share)).ln()
            }
            Self::Plain => value,
        }
    }

    fn from(self, at: f64) -> f64 {
        match self {
            Self::Log => at.exp(),
            Self::Odds => 1.0 / (1.0 + (-at).exp()),
            Self::Plain => at,
        }
    }

    /// By how much the value moves with the parameter.
    fn slope(self, value: f64) -> f64 {
        match self {
            Self::Log => value,
            Self::Odds => value * (1.0 - value),
            Self::Plain => 1.0,
        }
    }
}

/// A term of the kind called `name`, if there is one.
pub(super) fn term(name: &str, numbers: Vec<f64>, share: Share) -> Option<Term> {
    Some(Term { kind: Kind::named(name)?, numbers, share })
}
