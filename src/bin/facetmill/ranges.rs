//! What the numbers of flags must be.

use crate::console::Failure;

/// Refuses a number outside `low` to `high`, naming its flag.
pub fn within(flag: &str, value: Option<f64>, (low, high): (f64, f64)) -> Result<(), Failure> {
    // A value that is not a number is in no range.
    match value.filter(|value| !(low..=high).contains(value)) {
        None => Ok(()),
        Some(value) if value.abs() >= 1e15 || (value != 0.0 && value.abs() < 1e-6) => {
            Err(Failure::Usage(format!("--{flag} is {value:e}: it must be from {low} to {high}")))
        }
        Some(value) => Err(Failure::Usage(format!("--{flag} is {value}: it must be from {low} to {high}"))),
    }
}

/// The same of whole numbers.
pub fn whole(flag: &str, value: Option<usize>, low: usize, high: usize) -> Result<(), Failure> {
    match value.filter(|value| !(low..=high).contains(value)) {
        None => Ok(()),
        Some(value) => Err(Failure::Usage(format!("--{flag} is {value}: it must be from {low} to {high}"))),
    }
}
