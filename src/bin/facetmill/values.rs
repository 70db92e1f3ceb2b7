//! The words and numbers that flags take.

use clap::ValueEnum;
use facetmill::goal::spec::{GoalPart, GoalSpec, GoalSpecError};
use facetmill::recipe::settings::value::pair;
pub use facetmill::recipe::settings::value::{count, number, whole};
use facetmill::relief::placement::Axis;
use facetmill::verify::verdict::MAIN_BLUR;

/// A goal such as `ward:0.1,0.3`.
pub fn goal(text: &str) -> Result<GoalSpec, String> {
    text.parse().map_err(|error: GoalSpecError| error.to_string())
}

/// Threads, within what a machine can have.
pub fn threads(text: &str) -> Result<usize, String> {
    count(text).and_then(|n| if (1..=1024).contains(&n) { Ok(n) } else { Err("write a number from 1 to 1024".into()) })
}

/// Memory such as `500M` or `4G`, in bytes.
pub fn memory(text: &str) -> Result<u64, String> {
    const LEAST: f64 = 1e6;
    let would_do = || String::from("write a size, such as 500M or 4G");
    let digits = text.trim().trim_end_matches(['b', 'B']);
    let (digits, unit) = match digits.char_indices().next_back() {
        Some((at, 'k' | 'K')) => (&digits[..at], 1e3),
        Some((at, 'm' | 'M')) => (&digits[..at], 1e6),
        Some((at, 'g' | 'G')) => (&digits[..at], 1e9),
        Some((at, 't' | 'T')) => (&digits[..at], 1e12),
        _ => (digits, 1.0),
    };
    let bytes = unit * number(digits).map_err(|_| would_do())?;
    // What is no number is in no range.
    if (LEAST..=1e18).contains(&bytes) { Ok(bytes as u64) } else { Err(format!("{}, from 1M to 1000000T", would_do())) }
}

/// `30x20`: whole numbers along x and y.
pub fn counts(text: &str) -> Result<[usize; 2], String> {
    pair(text, 'x', count)
}

/// `45,90`: an angle from an axis and an azimuth.
pub fn angles(text: &str) -> Result<[f64; 2], String> {
    pair(text, ',', number)
}

/// `0,0,-1.5`: a place.
pub fn place(text: &str) -> Result<[f64; 3], String> {
    let numbers = text.split(',').map(number).collect::<Result<Vec<f64>, String>>();
    match numbers.map(<[f64; 3]>::try_from) {
        Ok(Ok(place)) => Ok(place),
        _ => Err("write three numbers with commas between them, such as 0,0,-1.5".into()),
    }
}

/// `0.02` or `0.02@0.5`, also `2%`: a share and a blur in degrees.
pub fn limit(text: &str) -> Result<Limit, String> {
    let (share, blur) = text.split_once('@').map_or((text, None), |(share, blur)| (share, Some(blur)));
    let (share, part) = share.strip_suffix('%').map_or((share, 1.0), |share| (share, 0.01));
    let limit = Limit { share: part * number(share)?, blur: blur.map_or(Ok(MAIN_BLUR), number)? };
    if !(limit.share > 0.0 && limit.share <= 1.0) {
        return Err("the share must be above 0 and at most 1, such as 0.02 or 2%".into());
    }
    if !(0.05..=30.0).contains(&limit.blur) {
        return Err("the blur must be from 0.05 to 30 degrees, such as 0.02@1".into());
    }
    Ok(limit)
}

/// The most light that may be misplaced or lost, seen through a blur.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// Share of the incident light.
    pub share: f64,
    /// Standard deviation, degrees.
    pub blur: f64,
}

/// The unit of a mesh, as mm to one of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum UnitArg {
    /// Millimetres
    Mm,
    /// Inches
    #[value(alias = "inch")]
    In,
    /// Centimetres
    Cm,
    /// Metres
    M,
    /// Thousandths of a millimetre
    Um,
}

impl UnitArg {
    /// mm to one of it.
    pub fn mm(self) -> f64 {
        match self {
            Self::Mm => 1.0,
            Self::In => 25.4,
            Self::Cm => 10.0,
            Self::M => 1000.0,
            Self::Um => 0.001,
        }
    }
}

/// The axis of a mesh along which its relief looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum UpArg {
    /// x
    X,
    /// y
    Y,
    /// z
    Z,
    /// Against x
    #[value(name = "-x")]
    MinusX,
    /// Against y
    #[value(name = "-y")]
    MinusY,
    /// Against z, as with --flip
    #[value(name = "-z")]
    MinusZ,
}

impl UpArg {
    /// The same as the library says it.
    pub fn axis(self) -> Axis {
        match self {
            Self::X => Axis::X,
            Self::Y => Axis::Y,
            Self::Z => Axis::Z,
            Self::MinusX => Axis::MinusX,
            Self::MinusY => Axis::MinusY,
            Self::MinusZ => Axis::MinusZ,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ExtentArg {
    /// The plate as it is
    Finite,
    /// Copies of it side by side without end
    Endless,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum GoalPartArg {
    /// Without what scatters evenly
    Specular,
    /// All of it
    All,
}

impl From<GoalPartArg> for GoalPart {
    fn from(part: GoalPartArg) -> Self {
        match part {
            GoalPartArg::Specular => Self::Specular,
            GoalPartArg::All => Self::All,
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum MethodArg {
    /// Weyrich et al., SIGGRAPH 2009
    #[value(name = "weyrich2009")]
    Weyrich2009,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_a_number_and_its_unit() {
        for (text, bytes) in
            [("4G", 4e9), ("500M", 5e8), ("1.5GB", 1.5e9), ("2t", 2e12), ("2000 kb", 2e6), ("7000000", 7e6)]
        {
            assert_eq!(memory(text), Ok(bytes as u64), "{text}");
        }
        for text in ["", "G", "four", "1e99", "-4G", "nan", "inf", "10", "0", "4X", "é"] {
            assert!(memory(text).is_err_and(|error| error.contains("500M")), "{text}");
        }
    }

    #[test]
    fn a_limit_is_a_share_and_a_blur_of_one_degree_unless_said() {
        assert_eq!(limit("0.02"), Ok(Limit { share: 0.02, blur: 1.0 }));
        assert_eq!(limit("2%@0.5"), Ok(Limit { share: 0.02, blur: 0.5 }));
        for wrong in ["", "@1", "0", "-0.1", "1.1", "0.02@0", "0.02@40", "0.02@", "two", "nan"] {
            assert!(limit(wrong).is_err(), "{wrong}");
        }
    }
}
