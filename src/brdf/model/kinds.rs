//! The table of models: how each is called, which numbers it takes, and what it is made of.

use std::sync::Arc;

use glam::DVec3;

use super::Model;
use super::ashikhmin_shirley::AshikhminShirley;
use super::diffuse::{Lambert, OrenNayar};
use super::lafortune::{LafortuneLobe, lafortune};
use super::microfacets::{Microfacets, Shadowing};
use super::normals::{Profile, ProfileNormals};
use super::parts::Turned;
use super::phong::Phong;
use super::ward::Ward;
use crate::brdf::microfacet::{Lobe, LobeError, MicrofacetDistribution};

/// What comes of building a model.
type Built = Result<Arc<dyn Model>, LobeError>;

/// One number of a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Number {
    /// What it is, for messages.
    pub what: &'static str,
    /// The least that it may be.
    pub low: f64,
    /// The most.
    pub high: f64,
}

/// A model by name.
#[derive(Debug)]
pub struct Kind {
    /// In flags and recipes.
    pub name: &'static str,
    /// Numbers, in their order.
    pub numbers: &'static [Number],
    /// So many of them must be given.
    pub needed: usize,
    /// An example of its numbers.
    pub example: &'static str,
    /// Scatters evenly: mirrors cannot make it.
    pub is_base: bool,
    /// Makes the model; as many numbers as were given, each within its range.
    build: fn(&[f64]) -> Built,
}

impl Kind {
    /// All of them, in the order in which they are explained.
    pub const ALL: &'static [Self] = KINDS;

    /// The one called `name`.
    pub fn named(name: &str) -> Option<&'static Self> {
        KINDS.iter().find(|kind| kind.name == name)
    }

    /// Lobe after lobe of the same numbers, parted by a slash.
    pub fn repeats(&self) -> bool {
        self.name == "lafortune"
    }

    /// Makes the model.
    pub fn build(&self, numbers: &[f64]) -> Result<Arc<dyn Model>, LobeError> {
        (self.build)(numbers)
    }
}

impl PartialEq for Kind {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

const fn number(what: &'static str, low: f64, high: f64) -> Number {
    Number { what, low, high }
}

const ALBEDO: Number = number("reflectance", 0.0, 1.0);
const EXPONENT: Number = number("exponent", 0.0, 1e5);
const DEGREES: Number = number("turn in degrees", -360.0, 360.0);
const ALPHAS: &[Number] = &[number("roughness along x", 1e-3, 2.0), number("roughness along y", 1e-3, 2.0), DEGREES];
const ROUGH_PIGMENT: &[Number] = &[ALBEDO, number("spread of slopes in degrees", 0.0, 60.0)];
const WIDTH: &[Number] = &[number("width of tilts in radians", 1e-3, 2.0)];

const KINDS: &[Kind] = &[
    Kind {
        name: "lambert",
        numbers: &[ALBEDO],
        needed: 1,
        example: "0.5",
        is_base: true,
        build: |n| Ok(Arc::new(Lambert { albedo: n[0] })),
    },
    Kind {
        name: "oren-nayar",
        numbers: ROUGH_PIGMENT,
        needed: 2,
        example: "0.5,20",
        is_base: true,
        build: |n| oren_nayar(n, false),
    },
    Kind {
        name: "oren-nayar-qualitative",
        numbers: ROUGH_PIGMENT,
        needed: 2,
        example: "0.5,20",
        is_base: true,
        build: |n| oren_nayar(n, true),
    },
    Kind {
        name: "phong",
        numbers: &[EXPONENT],
        needed: 1,
        example: "40",
        is_base: false,
        build: |n| Ok(Arc::new(Phong { exponent: n[0] })),
    },
    Kind {
        name: "blinn-phong",
        numbers: &[EXPONENT],
        needed: 1,
        example: "40",
        is_base: false,
        build: |n| profile(Profile::Power(n[0]), Shadowing::Smith),
    },
    Kind {
        name: "gaussian",
        numbers: WIDTH,
        needed: 1,
        example: "0.2",
        is_base: false,
        build: |n| profile(Profile::Gaussian(n[0]), Shadowing::Grooves),
    },
    Kind {
        name: "beckmann",
        numbers: ALPHAS,
        needed: 1,
        example: "0.2 or 0.1,0.3 or 0.1,0.3,45",
        is_base: false,
        build: |n| lobe(n, MicrofacetDistribution::Beckmann, Shadowing::Smith),
    },
    Kind {
        name: "cook-torrance",
        numbers: ALPHAS,
        needed: 1,
        example: "0.2",
        is_base: false,
        build: |n| lobe(n, MicrofacetDistribution::Beckmann, Shadowing::Grooves),
    },
    Kind {
        name: "ggx",
        numbers: ALPHAS,
        needed: 1,
        example: "0.2 or 0.2,0.05 or 0.2,0.05,30",
        is_base: false,
        build: |n| lobe(n, MicrofacetDistribution::Ggx, Shadowing::Smith),
    },
    Kind {
        name: "shifted-gamma",
        numbers: &[number("alpha", 1e-3, 2.0), number("power", -5.0, 20.0)],
        needed: 2,
        example: "0.196,0.707",
        is_base: false,
        build: |n| profile(Profile::ShiftedGamma { alpha: n[0], power: n[1] }, Shadowing::Smith),
    },
    Kind {
        name: "ward",
        numbers: ALPHAS,
        needed: 1,
        example: "0.2 or 0.1,0.3 or 0.1,0.3,45",
        is_base: false,
        build: |n| ward(n, false),
    },
    Kind {
        name: "ward-bounded",
        numbers: ALPHAS,
        needed: 1,
        example: "0.2 or 0.1,0.3",
        is_base: false,
        build: |n| ward(n, true),
    },
    Kind {
        name: "ashikhmin-shirley",
        numbers: &[
            number("exponent along x", 0.0, 1e5),
            number("exponent along y", 0.0, 1e5),
            number("specular reflectance", 0.0, 1.0),
            number("diffuse reflectance", 0.0, 1.0),
            DEGREES,
        ],
        needed: 2,
        example: "100,1000 or 100,1000,0.5,0.3",
        is_base: false,
        build: |n| {
            let at = |k: usize, else_: f64| n.get(k).copied().unwrap_or(else_);
            let model = AshikhminShirley { exponents: [n[0], n[1]], specular: at(2, 1.0), diffuse: at(3, 0.0) };
            Ok(turned(model, n.get(4)))
        },
    },
    Kind {
        name: "lafortune",
        numbers: &[
            number("Cx", -10.0, 10.0),
            number("Cy", -10.0, 10.0),
            number("Cz", -10.0, 10.0),
            number("exponent", 0.0, 1e5),
        ],
        needed: 4,
        example: "-1,-1,0.95,20 or -1,-1,0.95,20/-0.7,-0.7,0.7,5",
        is_base: false,
        build: |n| {
            let lobe = |n: &[f64]| LafortuneLobe { direction: DVec3::new(n[0], n[1], n[2]), exponent: n[3] };
            lafortune(n.chunks_exact(4).map(lobe).collect())
                .map(|model| Arc::new(model) as Arc<dyn Model>)
                .ok_or(LobeError::Roughness(f64::NAN))
        },
    },
];

fn oren_nayar(n: &[f64], qualitative: bool) -> Built {
    Ok(Arc::new(OrenNayar { albedo: n[0], sigma: n[1].to_radians(), qualitative }))
}

fn profile(profile: Profile, shadowing: Shadowing) -> Built {
    Ok(Arc::new(Microfacets { normals: ProfileNormals::new(profile), shadowing }))
}

/// The second roughness is the first where it is not given.
fn alphas(n: &[f64]) -> [f64; 2] {
    [n[0], n.get(1).copied().unwrap_or(n[0])]
}

fn lobe(n: &[f64], law: MicrofacetDistribution, shadowing: Shadowing) -> Built {
    let [x, y] = alphas(n);
    Ok(turned(Microfacets { normals: Lobe::new(law, x, y)?, shadowing }, n.get(2)))
}

fn ward(n: &[f64], bounded: bool) -> Built {
    Ok(turned(Ward { alpha: alphas(n), bounded }, n.get(2)))
}

fn turned<M: Model + 'static>(model: M, degrees: Option<&f64>) -> Arc<dyn Model> {
    match degrees {
        Some(degrees) if *degrees != 0.0 => Arc::new(Turned::new(model, degrees.to_radians())),
        _ => Arc::new(model),
    }
}
