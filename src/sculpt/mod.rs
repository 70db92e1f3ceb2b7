//! A sheet whose light is the picture: one periodic grid of heights, optimised triangle for triangle as it is written.
//!
//! # The loss
//!
//! The heights z of a cell, mm, are found by lowering
//!
//! ```text
//!     L(y) = ½ Σ w d · (W ∗ w d)  +  v · Σ R/A · len · c(Δs)  +  g · Σ (z - [z])²
//!
//!     d = light(G ∗ z) + r - t,      z = C(P y),      Ŵ(k) = exp(-k²σ²) / (k² + k0²)^α
//! ```
//!
//! | symbol | what it is | where |
//! |---|---|---|
//! | y | the unknowns, one a node | [`objective`] |
//! | P | every wave divided by its frequency, so that equal changes of y change slopes equally; short waves damped for `min_feature` | [`objective`] |
//! | C | closing: the least surface above that the cutter can touch everywhere | [`closing`] |
//! | G | a Gaussian, the polish | [`periodic_filter`] |
//! | light | the share of the plate that has each slope, a histogram over slopes in degrees of the picture: triangles, and fillets at concave edges | [`light_model`] |
//! | r | tool residual: light of the relief as milled on the tool's grid less that of the model, found anew every some steps and taken as constant between | [`tool`] |
//! | t | the wanted share of each slope | [`target`] |
//! | w | 1 at the brightest part of the picture, more where it is darker | [`slope_loss`] |
//! | W | kernel over the plane of slopes: blur σ, degrees, and preference α for differences far apart | [`slope_loss`] |
//! | Δs, len, A, c | jump of slope at a concave edge, its length, the cell's area, and what the jump costs | [`concave_edges`] |
//! | R | the cutter's valley radius, mm | [`crate::cutter`] |
//! | \[z\] | z clamped to the free range of the depth limit | [`depth_limit`] |
//! | v, g | weights, set at the start of each descent as shares of the first term | [`plan`] |
//!
//! Without a cutter C, r and the second term fall away; without polish G; without a limit of depth the third term.
//!
//! # The steps
//!
//! [`plan`] lists them for a sheet, [`stages`] takes them:
//!
//! 1. **Tries**, on at most 128 nodes a side: [`start`] gives several first reliefs, each goes down from σ = 3° to 0.5°, and
//!    the one with the least light in the wrong place is kept.
//! 2. **Matching**, for a cutter, on at most 256: [`matching`] brings the slopes near the wanted ones.
//! 3. **Descent** on the same grid by L-BFGS ([`crate::descent`]) at σ = 0.5°, 0.35°, 0.25°.
//! 4. **Finer grids**, each the double of the one before ([`resample`]), with two more descents on each.
//! 5. **Clearing**, for a cutter: nodes that it still does not reach are raised (`filling`).
//!
//! For a lamp and a wall nearby, [`room`] goes on from there over the whole plate.
//!
//! [`bisection`] covers a finished sheet with fewer triangles.
//!
//! [`checkpoint`] holds the state between two steps. [`bound`] says what no relief can do better, [`detail`] on how small
//! mirrors the light depends, [`milled_facets`] what a cutter leaves of a plate of facets.

pub mod settings;

pub mod edge_slopes;

pub mod periodic_filter;

pub mod start;

pub mod target;

pub mod bound;

pub mod detail;

pub mod slope_histogram;

pub mod axis_histogram;

pub mod closing;

mod places;

pub mod resample;

pub mod bisection;

mod rises;

pub mod sweep;

pub mod tool;

pub mod milled_facets;

pub mod matching;

pub mod concave_edges;

pub mod light_model;

pub mod slope_loss;

pub mod depth_limit;

pub mod objective;

mod filling;

pub mod plan;

pub mod checkpoint;

pub mod stages;

pub mod room;
