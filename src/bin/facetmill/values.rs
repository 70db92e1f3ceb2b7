//! The words and numbers that flags take.

use std::num::IntErrorKind;

use clap::ValueEnum;
use facetmill::facets::sample::Sampling;
use facetmill::highlight::Quantity;
use facetmill::picture::PictureFit;
use facetmill::projection::Projection;
use facetmill::recipe::{Arrangement, Heights, Seen, SurfaceKind};

/// A number with or without a fraction; whether it makes sense is for the recipe to say.
pub fn number(text: &str) -> Result<f64, String> {
    text.trim().parse().map_err(|_| "write a number, such as 12.5".into())
}

/// A whole number.
pub fn whole(text: &str) -> Result<u64, String> {
    text.trim().parse().map_err(|error: std::num::ParseIntError| match error.kind() {
        IntErrorKind::PosOverflow => format!("{text} is too large"),
        _ => "write a whole number, such as 30".into(),
    })
}

/// How many facets or cells.
pub fn count(text: &str) -> Result<usize, String> {
    whole(text)?.try_into().map_err(|_| format!("{text} is too large"))
}

/// Threads, within what a machine can have.
pub fn threads(text: &str) -> Result<usize, String> {
    count(text).and_then(|n| if (1..=1024).contains(&n) { Ok(n) } else { Err("write a number from 1 to 1024".into()) })
}

/// `30x20`: sizes along x and y.
pub fn size(text: &str) -> Result<[f64; 2], String> {
    pair(text, 'x', number)
}

/// `30x20`: whole numbers along x and y.
pub fn counts(text: &str) -> Result<[usize; 2], String> {
    pair(text, 'x', count)
}

/// `45,90`: an angle from an axis and an azimuth.
pub fn angles(text: &str) -> Result<[f64; 2], String> {
    pair(text, ',', number)
}

fn pair<T>(text: &str, between: char, each: impl Fn(&str) -> Result<T, String>) -> Result<[T; 2], String> {
    let (first, second) = text
        .split_once(between)
        .ok_or_else(|| format!("write two numbers with '{between}' between them, such as 30{between}20"))?;
    Ok([each(first)?, each(second)?])
}

/// A flag's words for a library enum: names and meaning here, science there.
macro_rules! words {
    ($arg:ident for $library:ident { $($(#[$doc:meta])* $word:ident),+ $(,)? }) => {
        #[derive(Clone, Copy, Debug, ValueEnum)]
        pub enum $arg { $($(#[$doc])* $word),+ }

        impl From<$arg> for $library {
            fn from(arg: $arg) -> Self {
                match arg { $($arg::$word => Self::$word),+ }
            }
        }
    };
}

words!(ProjectionArg for Projection {
    /// Sines of the angles from the plate's normal
    Orthographic,
    /// Equal angles from the mirror direction
    Equidistant,
    /// A flat screen across the mirror direction
    Screen,
});
words!(QuantityArg for Quantity {
    /// How bright the plate looks from there
    Radiance,
    /// Flux per steradian
    Intensity,
    /// Flux per pixel; on a screen, irradiance
    Flux,
});
words!(SeenArg for Seen {
    /// A map of viewers, from above the plate
    FromAbove,
    /// Thrown on a wall, from the plate's side
    OnWall,
});
words!(FitArg for PictureFit {
    /// Black bars
    Pad,
    /// Cut what is longer
    Crop,
    /// Distort
    Stretch,
});
words!(SurfaceArg for SurfaceKind {
    /// Planar facets
    #[value(alias = "flat")]
    Facets,
    /// One sheet without steps
    #[value(alias = "continuous")]
    Sheet,
});
words!(SampleArg for Sampling {
    /// Centroidal cells of equal mass
    Voronoi,
    /// Independent draws
    Random,
    /// A Sobol sequence
    Sobol,
});
words!(ArrangeArg for Arrangement {
    /// Optimal transport: a dome, no valleys
    Transport,
    /// The 2009 paper's annealing
    Anneal,
    /// No order
    Random,
});
words!(HeightsArg for Heights {
    /// Smallest steps, edges free
    Free,
    /// Smallest steps on a plate that continues into itself
    Cyclic,
    /// As printed in the 2009 paper
    Weyrich2009,
});

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
