//! The words and numbers that flags take.

use clap::ValueEnum;
use facetmill::recipe::settings::value::pair;
pub use facetmill::recipe::settings::value::{count, number, whole};

/// Threads, within what a machine can have.
pub fn threads(text: &str) -> Result<usize, String> {
    count(text).and_then(|n| if (1..=1024).contains(&n) { Ok(n) } else { Err("write a number from 1 to 1024".into()) })
}

/// `30x20`: whole numbers along x and y.
pub fn counts(text: &str) -> Result<[usize; 2], String> {
    pair(text, 'x', count)
}

/// `45,90`: an angle from an axis and an azimuth.
pub fn angles(text: &str) -> Result<[f64; 2], String> {
    pair(text, ',', number)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ExtentArg {
    /// The plate as it is
    Finite,
    /// Copies of it side by side without end
    Endless,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum MethodArg {
    /// Weyrich et al., SIGGRAPH 2009
    #[value(name = "weyrich2009")]
    Weyrich2009,
}
