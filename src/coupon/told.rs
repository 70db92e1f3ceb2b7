//! A figure with its standard error.

/// Parts of the passes that are left out in turn.
pub(super) const BLOCKS: usize = 20;

/// A figure that was measured, or why it was not.
#[derive(Clone, Debug, PartialEq)]
pub enum Told {
    /// Its value and standard error, mm.
    Measured {
        /// The value.
        value: f64,
        /// Its standard error.
        error: f64,
    },
    /// It cannot be told, since…
    Untold(String),
}

impl Told {
    /// What was measured.
    pub fn value(&self) -> Option<f64> {
        match self {
            Self::Measured { value, .. } => Some(*value),
            Self::Untold(_) => None,
        }
    }

    /// Of a figure with what it is when each part is left out.
    pub(super) fn jackknife(value: f64, without: &[f64]) -> Self {
        let n = without.len() as f64;
        let mean = without.iter().sum::<f64>() / n;
        let spread = without.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
        Self::Measured { value, error: ((n - 1.0) / n * spread).sqrt() }
    }
}
