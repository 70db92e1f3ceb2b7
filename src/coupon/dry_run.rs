//! A test piece as a stated machine and polish would leave it, and what instruments would say of it: to try the reading.

use std::fmt::Write;

use glam::DVec2;
use rayon::prelude::*;

use super::layout::{Coupon, POLISHED_FROM};
use crate::export::sheet::{SheetError, sheet_solid};
use crate::milling::machine::Machine;
use crate::milling::made::{BareSurface, Machining};
use crate::milling::random::{normal, stream};
use crate::progress::Progress;

/// Solid under the lowest point, mm; nothing depends on it.
const THICKNESS: f64 = 1.0;

/// Fewest decimals of a finishing program.
const DECIMALS: u32 = 4;

/// Standard deviations of the polish that a point is gathered from, and places over them.
const REACH: f64 = 4.0;
const PLACES: usize = 48;

/// A piece that was made.
pub struct Piece {
    surface: BareSurface,
    size: DVec2,
    /// Standard deviation of the polish of its right half, mm; 0 for none.
    polish: f64,
}

/// What an instrument does to heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instrument {
    /// From one point to the next, mm.
    pub spacing: f64,
    /// Standard deviation of a point's height, mm.
    pub noise: f64,
    /// How far the piece lies beside its place across the passes, mm, and how much the line climbs in all, mm.
    pub aside: f64,
    /// The climb of each line from its begin to its end, mm.
    pub climb: f64,
    /// Of the noise.
    pub seed: u64,
}

impl Piece {
    /// `coupon` made by `machine`, whose errors follow from `seed`, its right half polished by `polish` mm.
    ///
    /// # Errors
    /// The work is abandoned.
    pub fn new(
        coupon: &Coupon,
        machine: &Machine,
        (polish, seed): (f64, u64),
        progress: &Progress,
    ) -> Result<Self, SheetError> {
        let mesh = sheet_solid(&coupon.relief(), THICKNESS, 0.0, progress)?;
        let machine = Machine { decimals: machine.decimals.max(DECIMALS), ..machine.clone() };
        let machining = Machining { machine, cutter: coupon.cutter, passes: coupon.passes(), polish: None, seed };
        let ways = coupon.ways(&machining, &machining.tips(&mesh), progress)?;
        Ok(Self { surface: machining.bare(&ways, 0), size: coupon.size(), polish })
    }

    /// Heights of a line across the passes at `x` mm, at `count` even places from `from` mm on, mm.
    pub(super) fn heights(&self, x: f64, [from, spacing]: [f64; 2], count: usize) -> Vec<f64> {
        if x < POLISHED_FROM || self.polish == 0.0 {
            let at = |k: usize| self.surface.height(DVec2::new(x, from + spacing * k as f64));
            return (0..count).into_par_iter().map(at).collect();
        }
        // Smoothed along the passes first, at places that keep no step with teeth, then across them.
        let fine = (self.polish / 8.0).min(2.0 * spacing);
        let reach = (REACH * self.polish / fine).ceil() as usize;
        let rows = (spacing * count as f64 / fine).ceil() as usize + 2 * reach + 2;
        let weight = |share: f64| (-0.5 * share * share).exp();
        let row = |k: usize| {
            let y = (from + fine * (k as f64 - reach as f64)).clamp(0.0, self.size.y);
            let (mut sum, mut weights) = (0.0, 0.0);
            for j in 0..PLACES {
                let share = REACH * (2.0 * (j as f64 + crate::golden::golden(j + 13 * k)) / PLACES as f64 - 1.0);
                sum += weight(share) * self.surface.height(DVec2::new(x + self.polish * share, y));
                weights += weight(share);
            }
            sum / weights
        };
        let rows: Vec<f64> = (0..rows).into_par_iter().map(row).collect();
        let at = |k: usize| {
            let place = spacing * k as f64 / fine;
            let (mut sum, mut weights) = (0.0, 0.0);
            for (j, z) in rows.iter().enumerate().skip(place as usize).take(2 * reach + 2) {
                let weight = weight((j as f64 - reach as f64 - place) * fine / self.polish);
                sum += weight * z;
                weights += weight;
            }
            sum / weights
        };
        (0..count).map(at).collect()
    }

    /// A scan of the lines at `places` (x in mm), as text with the columns x, y, z in mm.
    pub fn scan(&self, places: &[f64], instrument: &Instrument) -> String {
        let Instrument { spacing, noise, aside, climb, seed } = *instrument;
        let count = (self.size.y / spacing) as usize;
        let mut text = String::from("x_mm,y_mm,z_mm\n");
        for (line, x) in places.iter().enumerate() {
            let mut random = stream(seed, line as u64);
            // Each line counts its heights from somewhere.
            let zero = normal(&mut random) * 0.01;
            let heights = self.heights(*x, [0.0, spacing], count);
            for (k, z) in heights.iter().enumerate() {
                let (y, share) = (spacing * k as f64, k as f64 / count as f64);
                let z = z + zero + climb * share + noise * normal(&mut random);
                let _ = writeln!(text, "{x},{:.6},{z:.7}", y + aside);
            }
        }
        text
    }
}
