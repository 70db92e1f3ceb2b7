//! The report of a fit.

use serde::Serialize;

/// Models fitted to a measured reflectance.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FitReport {
    /// The program and its version.
    pub program: &'static str,
    /// What was fitted.
    pub file: String,
    /// Pairs of directions that were compared.
    pub directions: usize,
    /// Whether it was taken to look the same however it is turned.
    pub isotropic: bool,
    /// What a person should know of how it was read.
    pub notes: Vec<String>,
    /// The fits, best first.
    pub fits: Vec<FitFacts>,
}

/// One model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FitFacts {
    /// Its words, as they can stand behind `--goal` and `--material`.
    pub spec: String,
    /// Lobes besides the even base.
    pub lobes: usize,
    /// Root of the mean squared difference of log(1 + f_r cosθi), weighted with solid angles.
    pub error: f64,
    /// Every free number.
    pub parameters: Vec<Parameter>,
}

/// A number that was fitted.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Parameter {
    /// What it is.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Its standard error, from the Jacobian.
    pub standard_error: f64,
}
