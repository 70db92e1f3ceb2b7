//! Models in words: `NAME:NUMBERS[:SHARE]`, several of them joined by `+`, as in `ggx:0.2,0.05,30` or
//! `lambert:0.3+ward:0.1,0.3:0.4`.
//!
//! SHARE is what a lobe reflects of what it would: a number, or Fresnel's share as `schlick=F0` or `index=ETA`. Without one a
//! lobe reflects everything.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use glam::DVec3;
use thiserror::Error;

pub use super::kinds::{Kind, Number};
use super::parts::{Share, Sum, Weakened};
use super::{Model, greatest_albedo};
use crate::brdf::microfacet::LobeError;

/// Most terms of a sum and lobes of a term.
const MOST: usize = 16;

/// One term of a sum: a model and its share.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    /// Which model.
    pub kind: &'static Kind,
    /// Its numbers, as many as were given.
    pub numbers: Vec<f64>,
    /// What it reflects of what it would.
    pub share: Share,
}

impl Term {
    /// The model with its share.
    pub fn model(&self) -> Result<Arc<dyn Model>, NamedError> {
        let model = self.kind.build(&self.numbers)?;
        Ok(match self.share {
            Share::Even(1.0) => model,
            share => Arc::new(Weakened { model, share }),
        })
    }

    fn check(self) -> Result<Self, NamedError> {
        let (kind, count) = (self.kind, self.numbers.len());
        let sound = match kind.repeats() {
            true => count > 0 && count.is_multiple_of(kind.needed) && count <= MOST * kind.needed,
            false => (kind.needed..=kind.numbers.len()).contains(&count),
        };
        if !sound {
            let names: Vec<_> = kind.numbers.iter().map(|number| number.what).collect();
            return Err(NamedError::Numbers { name: kind.name, takes: names.join(", "), example: kind.example });
        }
        for (value, number) in self.numbers.iter().zip(kind.numbers.iter().cycle()) {
            if !(number.low..=number.high).contains(value) {
                return Err(NamedError::Range { name: kind.name, number: *number, value: *value });
            }
        }
        let (what, value, low, high) = match self.share {
            Share::Even(share) => ("share", share, 0.0, 100.0),
            Share::Schlick(share) => ("reflectance straight on", share, 0.0, 1.0),
            Share::Index(eta) => ("index of refraction", eta, 1.0, 100.0),
        };
        if !(low..=high).contains(&value) {
            return Err(NamedError::Range { name: kind.name, number: Number { what, low, high }, value });
        }
        Ok(self)
    }
}

/// A sum of models with its words. Parsing and [`Display`](fmt::Display) are inverse.
///
/// ```
/// use facetmill::brdf::model::Model;
/// use facetmill::brdf::model::named::Named;
/// use facetmill::slope::direction;
///
/// let brushed: Named = "lambert:0.1+ward:0.1,0.3:0.6".parse()?;
/// let (wi, wo) = (direction(0.3, 0.0), direction(0.4, 3.0));
/// assert!((brushed.value(wi, wo) - brushed.value(wo, wi)).abs() < 1e-12); // reciprocal
/// assert!(brushed.albedo(wi) < 0.75);
/// assert_eq!(brushed.to_string(), "lambert:0.1+ward:0.1,0.3:0.6");
/// # Ok::<(), facetmill::brdf::model::named::NamedError>(())
/// ```
#[derive(Clone)]
pub struct Named {
    terms: Vec<Term>,
    sum: Sum,
}

impl Named {
    /// The sum of `terms`.
    ///
    /// # Errors
    /// No terms or too many, numbers that are missing, too many or out of range.
    pub fn new(terms: Vec<Term>) -> Result<Self, NamedError> {
        if terms.is_empty() || terms.len() > MOST {
            return Err(NamedError::Terms(terms.len()));
        }
        let terms = terms.into_iter().map(Term::check).collect::<Result<Vec<_>, _>>()?;
        let sum = Sum(terms.iter().map(Term::model).collect::<Result<_, _>>()?);
        Ok(Self { terms, sum })
    }

    /// Its terms.
    pub fn terms(&self) -> &[Term] {
        &self.terms
    }

    /// Without what scatters evenly, and without the pigment of Ashikhmin and Shirley; `None` if nothing else is there.
    pub fn without_base(&self) -> Option<Self> {
        let lobes = self.terms.iter().filter(|term| !term.kind.is_base).cloned().map(|mut term| {
            if term.kind.name == "ashikhmin-shirley" && term.numbers.len() > 3 {
                term.numbers[3] = 0.0;
            }
            term
        });
        Self::new(lobes.collect()).ok()
    }

    /// Whether it looks the same however it is turned about the normal.
    pub fn is_isotropic(&self) -> bool {
        self.terms.iter().all(|term| {
            let pair = || term.numbers.chunks(4).all(|n| n.len() < 2 || n[0] == n[1]);
            let paired = ["ggx", "beckmann", "cook-torrance", "ward", "ward-bounded", "ashikhmin-shirley", "lafortune"];
            !paired.contains(&term.kind.name) || pair()
        })
    }

    /// Whether `text` begins as a model does.
    pub fn begins(text: &str) -> bool {
        let first = text.split([':', '+']).next().unwrap_or_default();
        Kind::named(first.trim()).is_some()
    }

    /// Fails if it reflects more light than it gets.
    ///
    /// # Errors
    /// An albedo above 1.005 at some incidence, with the remedy.
    pub fn keep_energy(&self) -> Result<(), NamedError> {
        let (albedo, theta) = greatest_albedo(self, if self.is_isotropic() { 1 } else { 4 });
        // The quadrature knows albedos to a few thousandths.
        if albedo > 1.005 {
            return Err(NamedError::Energy { albedo, degrees: theta.to_degrees(), remedy: 0.99 / albedo });
        }
        Ok(())
    }
}

impl Model for Named {
    fn value(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.sum.value(wi, wo)
    }

    fn sample(&self, wi: DVec3, u: [f64; 3]) -> DVec3 {
        self.sum.sample(wi, u)
    }

    fn density(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.sum.density(wi, wo)
    }

    fn albedo(&self, wi: DVec3) -> f64 {
        self.sum.albedo(wi)
    }
}

impl FromStr for Named {
    type Err = NamedError;

    fn from_str(text: &str) -> Result<Self, NamedError> {
        // Past the most terms there is nothing to read on for.
        Self::new(text.trim().split('+').take(MOST + 1).map(term).collect::<Result<_, _>>()?)
    }
}

fn term(text: &str) -> Result<Term, NamedError> {
    let mut parts = text.trim().split(':');
    let name = parts.next().unwrap_or_default();
    let kind = Kind::named(&name.to_lowercase()).ok_or_else(|| NamedError::Unknown(name.to_owned()))?;
    let numbers = parts.next().unwrap_or_default();
    let numbers = match numbers.is_empty() {
        true => Vec::new(),
        false if !kind.repeats() && numbers.contains('/') => return Err(NamedError::NotANumber(numbers.to_owned())),
        false => numbers.split([',', '/']).take(4 * MOST + 1).map(number).collect::<Result<_, _>>()?,
    };
    let share = match parts.next().map(|text| text.split_once('=').unwrap_or(("", text))) {
        None => Share::Even(1.0),
        Some(("", text)) => Share::Even(number(text)?),
        Some(("schlick", text)) => Share::Schlick(number(text)?),
        Some(("index", text)) => Share::Index(number(text)?),
        Some((other, _)) => return Err(NamedError::Share(other.to_owned())),
    };
    match parts.next() {
        Some(rest) => Err(NamedError::TooMuch(rest.to_owned())),
        None => Ok(Term { kind, numbers, share }),
    }
}

fn number(text: &str) -> Result<f64, NamedError> {
    text.trim().parse().map_err(|_| NamedError::NotANumber(text.to_owned()))
}

impl fmt::Display for Term {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:", self.kind.name)?;
        for (k, value) in self.numbers.iter().enumerate() {
            let mark = match k {
                0 => "",
                k if self.kind.repeats() && k % self.kind.needed == 0 => "/",
                _ => ",",
            };
            write!(f, "{mark}{value}")?;
        }
        match self.share {
            Share::Even(1.0) => Ok(()),
            Share::Even(share) => write!(f, ":{share}"),
            Share::Schlick(straight_on) => write!(f, ":schlick={straight_on}"),
            Share::Index(eta) => write!(f, ":index={eta}"),
        }
    }
}

impl fmt::Display for Named {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, term) in self.terms.iter().enumerate() {
            let plus = if k > 0 { "+" } else { "" };
            write!(f, "{plus}{term}")?;
        }
        Ok(())
    }
}

impl fmt::Debug for Named {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Named({self})")
    }
}

impl PartialEq for Named {
    fn eq(&self, other: &Self) -> bool {
        self.terms == other.terms
    }
}

/// All names, for messages.
pub fn names() -> String {
    Kind::ALL.iter().map(|kind| kind.name).collect::<Vec<_>>().join(", ")
}

/// Why there is no such model.
#[derive(Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum NamedError {
    /// Not in the table.
    #[error("'{0}' is not a model of reflectance; known are {known}", known = names())]
    Unknown(String),
    /// A number is missing or there are too many.
    #[error("'{name}' takes {takes}, as in {name}:{example}")]
    Numbers {
        /// The model.
        name: &'static str,
        /// What it takes.
        takes: String,
        /// Numbers that would do.
        example: &'static str,
    },
    /// A number out of range.
    #[error("{what} of '{name}' must be {low} to {high}, not {value}", what = number.what, low = number.low, high = number.high)]
    Range {
        /// The model.
        name: &'static str,
        /// Which number, and what it may be.
        number: Number,
        /// What it is.
        value: f64,
    },
    /// Not a decimal number.
    #[error("'{0}' in a model is not a number; write as in ggx:0.2,0.05,30")]
    NotANumber(String),
    /// A share that is neither a number nor Fresnel's.
    #[error("'{0}=' is no kind of share; write a number, schlick=F0 or index=ETA, as in ggx:0.2:schlick=0.04")]
    Share(String),
    /// Something after the end.
    #[error("'{0}' is one part too many in a model; write as in ggx:0.2:0.5")]
    TooMuch(String),
    /// An empty sum, or a very long one.
    #[error("a sum of models has 1 to {MOST} terms, not {0}")]
    Terms(usize),
    /// It reflects more than it gets.
    #[error(
        "this model sends back {albedo:.3} times the light that comes in at {degrees:.0} degrees, and no material can: \
         give its lobes smaller shares ({remedy:.3} of what they have would do)"
    )]
    Energy {
        /// Its greatest albedo.
        albedo: f64,
        /// Polar angle of incidence where it is.
        degrees: f64,
        /// A factor that would do.
        remedy: f64,
    },
    /// A roughness out of range.
    #[error(transparent)]
    Lobe(#[from] LobeError),
}
