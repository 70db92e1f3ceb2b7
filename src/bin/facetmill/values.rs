//! The words and numbers that flags take.

use clap::ValueEnum;
use facetmill::recipe::settings::value::pair;
pub use facetmill::recipe::settings::value::{count, number, whole};

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
}
