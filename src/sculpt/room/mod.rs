//! A sheet for a lamp and a wall nearby: one grid of heights over the whole plate, each triangle's light counted where it
//! lands on the wall.
//!
//! It begins as a far design, one cell repeated, which is laid on the base of [`NearField`](crate::near::NearField) and
//! warped ([`placed`]). That is the end for `base` and `warp`; `exact` goes on with a descent in which cells may differ.
//! Its loss is that of the far design ([`sculpt`](super)), with
//!
//! - bins of the picture on the wall in place of bins of slopes ([`landing`]),
//! - free rims: heights change by waves of a somewhat larger square, of which what lies on the plate is taken,
//! - blurs that end at the eye's, 2 mm on the wall, so that equal cells no longer pile their spots on one another.

pub mod placed;

pub mod landing;

pub mod plate_grid;

pub mod fillets;

pub mod light;

pub mod milling;

pub mod objective;

pub mod exact;

#[cfg(test)]
mod tests;
