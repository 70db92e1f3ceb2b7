//! MERL `.binary`: an isotropic BRDF over half and difference angles, as measured by Matusik, Pfister, Brand, McMillan,
//! "A Data-Driven Reflectance Model" (SIGGRAPH 2003).
//!
//! Three 32-bit counts (90, 90, 180), then red, green and blue, each a block of doubles, all little-endian. The value
//! of (θh, θd, φd) has the index φd + 180 (θd + 90 θh); θh stands on a square-root scale over 90°, θd in steps of 1°,
//! φd in steps of 1° over 180° (the other half is the same by reciprocity). Stored values are f_r over 1/1500,
//! 1.15/1500 and 1.66/1500; negative ones mean that no light can go that way. 34,992,012 bytes. The first step of
//! the square-root scale is 0.011°, the twentieth 0.45° wide: narrow lobes on the normal are resolved, tilted ones
//! of less than 2° are not.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::io::{self, Read, Write};

use glam::{DQuat, DVec3};
use rayon::prelude::*;
use thiserror::Error;

use crate::slope::direction;
use crate::verify::goniometer::table::BrdfTable;

const HALF: usize = 90;
const DIFFERENCE: usize = 90;
const AROUND: usize = 180;
const CELLS: usize = HALF * DIFFERENCE * AROUND;
/// What a stored 1 means, 1/sr.
const SCALES: [f64; 3] = [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0];
/// Largest [`anisotropy`] beyond noise that still counts as isotropic.
pub(crate) const ISOTROPIC_WITHIN: f64 = 0.05;

/// How much a table changes when the plate is turned under light and viewer: the mean |f - mean of f over turns| over
/// the mean of f, each weighted with its flux; and the part of it that the table's standard errors explain.
///
/// Both 0 for a table of one azimuth, which was declared isotropic when it was measured.
pub fn anisotropy(table: &BrdfTable) -> (f64, f64) {
    let axes = table.axes();
    if axes.is_isotropic() {
        return (0.0, 0.0);
    }
    let (polar, turns) = (axes.theta_i().len(), axes.phi_i().len());
    // A turn by one azimuth shifts half vectors by rows / turns rows, not whole ones in general.
    let sums: Vec<[f64; 3]> = (0..polar)
        .into_par_iter()
        .map(|theta| {
            let mut sum = [0.0; 3];
            for cell in 0..axes.cells() {
                let weight = f64::from(table.slice_projected(theta)[cell]);
                if weight <= 0.0 {
                    continue;
                }
                let u = (cell % axes.columns()) as f64 + 0.5;
                let v = (cell / axes.columns()) as f64 + 0.5;
                let (u, v) = (u / axes.columns() as f64, v / axes.rows() as f64);
                let values: Vec<f64> = (0..turns)
                    .filter_map(|turn| {
                        table.within_slice(theta + polar * turn, u, (v + turn as f64 / turns as f64).fract())
                    })
                    .collect();
                let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
                let apart = values.iter().map(|value| (value - mean).abs()).sum::<f64>() / values.len().max(1) as f64;
                // The mean |x| of a normal distribution is sqrt(2/π) of its spread.
                let noise = f64::from(table.slice_error(theta)[cell]) * (2.0 / PI).sqrt();
                sum = [sum[0] + weight * apart, sum[1] + weight * noise, sum[2] + weight * mean];
            }
            sum
        })
        .collect();
    let [apart, noise, mean] = sums.iter().fold([0.0; 3], |a, b| [a[0] + b[0], a[1] + b[1], a[2] + b[2]]);
    if mean > 0.0 { (apart / mean, noise / mean) } else { (0.0, 0.0) }
}

/// A BRDF in MERL's form, 1/sr; NaN where no light can go.
#[derive(Clone, Debug, PartialEq)]
pub struct Merl {
    channels: [Vec<f64>; 3],
}

impl Merl {
    /// From red, green and blue tables (the same one thrice for grey), averaged over the azimuths of incidence and over
    /// both ways of the light. Fails if one of them is not isotropic, see [`anisotropy`].
    pub fn from_tables(tables: [&BrdfTable; 3]) -> Result<Self, MerlError> {
        let mut channels: [Vec<f64>; 3] = Default::default();
        for k in 0..3 {
            if let Some(same) = (0..k).find(|&j| std::ptr::eq(tables[j], tables[k])) {
                channels[k] = channels[same].clone();
                continue;
            }
            let (apart, noise) = anisotropy(tables[k]);
            if apart - noise > ISOTROPIC_WITHIN {
                return Err(MerlError::Anisotropic { percent: 100.0 * apart });
            }
            channels[k] = averaged(tables[k]);
        }
        Ok(Self { channels })
    }

    /// The BRDF of a channel for light from `wi` seen from `wo`: the value of the cell they fall into.
    pub fn at(&self, channel: usize, wi: DVec3, wo: DVec3) -> f64 {
        let m = (wi + wo).normalize_or(DVec3::Z);
        let theta = m.z.clamp(-1.0, 1.0).acos();
        let d = DQuat::from_rotation_y(-theta) * (DQuat::from_rotation_z(-m.y.atan2(m.x)) * wi);
        let half = ((theta / FRAC_PI_2).max(0.0).sqrt() * HALF as f64) as usize;
        let difference = (d.z.clamp(-1.0, 1.0).acos() / FRAC_PI_2 * DIFFERENCE as f64) as usize;
        let around = (d.y.atan2(d.x).rem_euclid(PI) / PI * AROUND as f64) as usize;
        let index =
            around.min(AROUND - 1) + AROUND * (difference.min(DIFFERENCE - 1) + DIFFERENCE * half.min(HALF - 1));
        self.channels[channel.min(2)][index]
    }

    /// Share of cells that hold no value in one of the channels or more.
    pub fn invalid_share(&self) -> f64 {
        let [red, green, blue] = &self.channels;
        let invalid = red.iter().zip(green).zip(blue).filter(|((r, g), b)| r.is_nan() || g.is_nan() || b.is_nan());
        invalid.count() as f64 / CELLS as f64
    }

    /// Writes the `.binary` file.
    pub fn write(&self, out: &mut impl Write) -> Result<(), MerlError> {
        for count in [HALF, DIFFERENCE, AROUND] {
            out.write_all(&(count as i32).to_le_bytes())?;
        }
        for (channel, scale) in self.channels.iter().zip(SCALES) {
            let stored = channel.iter().flat_map(|v| if v.is_nan() { -1.0 } else { v / scale }.to_le_bytes());
            out.write_all(&stored.collect::<Vec<u8>>())?;
        }
        Ok(())
    }

    /// Reads a `.binary` file. Fails on other counts, on a file of another length, and if the reader fails.
    pub fn read(source: &mut impl Read) -> Result<Self, MerlError> {
        let mut bytes = Vec::new();
        // One byte more than belongs tells a longer file from a right one.
        source.take(12 + 24 * CELLS as u64 + 1).read_to_end(&mut bytes)?;
        let counts = [HALF, DIFFERENCE, AROUND].map(|n| (n as i32).to_le_bytes()).concat();
        if bytes.len() != 12 + 24 * CELLS || bytes[..12] != counts {
            return Err(MerlError::Format);
        }
        let mut values = bytes[12..].chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap_or_default()));
        let channels = SCALES.map(|scale| {
            let stored = values.by_ref().take(CELLS);
            stored.map(|v| if v >= 0.0 { v * scale } else { f64::NAN }).collect()
        });
        Ok(Self { channels })
    }
}

/// The table at the middle of every cell of MERL's.
fn averaged(table: &BrdfTable) -> Vec<f64> {
    let turns = table.axes().phi_i().len();
    (0..CELLS)
        .into_par_iter()
        .map(|index| {
            let (around, rest) = (index % AROUND, index / AROUND);
            let (difference, half) = (rest % DIFFERENCE, rest / DIFFERENCE);
            let theta_h = ((half as f64 + 0.5) / HALF as f64).powi(2) * FRAC_PI_2;
            let d = direction(
                (difference as f64 + 0.5) / DIFFERENCE as f64 * FRAC_PI_2,
                (around as f64 + 0.5) / AROUND as f64 * PI,
            );
            let tilt = DQuat::from_rotation_y(theta_h);
            let (wi, wo) = (tilt * d, tilt * DVec3::new(-d.x, -d.y, d.z));
            if wi.z <= 0.0 || wo.z <= 0.0 {
                return f64::NAN;
            }
            let sum: f64 = (0..turns)
                .map(|turn| {
                    let turn = DQuat::from_rotation_z(TAU * turn as f64 / turns as f64);
                    table.at(turn * wi, turn * wo) + table.at(turn * wo, turn * wi)
                })
                .sum();
            (sum / (2 * turns) as f64).max(0.0)
        })
        .collect()
}

/// Why a MERL file cannot be written or read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MerlError {
    /// The plate does not look the same when it is turned.
    #[error(
        "this BRDF changes by {percent:.0} % when the plate is turned, and a MERL file can only hold one that does not; write .bsdf instead"
    )]
    Anisotropic {
        /// See [`anisotropy`].
        percent: f64,
    },
    /// Not a MERL file.
    #[error("not a MERL file: it must hold 90 x 90 x 180 values three times, 34992012 bytes in all")]
    Format,
    /// The writer or reader failed.
    #[error("the MERL file cannot be written or read: {0}")]
    Io(#[from] io::Error),
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verify::goniometer::table::BrdfAxes;

    fn axes(azimuths: usize) -> BrdfAxes {
        let polar = BrdfAxes::polar_nodes(10, f64::to_radians(88.0));
        match azimuths {
            1 => BrdfAxes::isotropic(polar, 96, 24).unwrap(),
            _ => BrdfAxes::anisotropic(polar, azimuths, 96, 24).unwrap(),
        }
    }

    /// Reciprocal and isotropic, with a lobe.
    fn lobe(wi: DVec3, wo: DVec3) -> f64 {
        let m = (wi + wo).normalize();
        (-(1.0 - m.z) / 0.03).exp() * (1.0 + wi.dot(wo)) + 0.05
    }

    #[test]
    fn a_table_survives_the_file() {
        let (one, other) = (BrdfTable::from_fn(axes(1), lobe), BrdfTable::from_fn(axes(1), |_, _| 0.2));
        let merl = Merl::from_tables([&one, &other, &one]).unwrap();
        let mut file = Vec::new();
        merl.write(&mut file).unwrap();
        assert_eq!(file.len(), 34_992_012);
        let back = Merl::read(&mut file.as_slice()).unwrap();
        let (mut apart, mut count) = (0.0, 0.0);
        for k in 0..2000 {
            let k = f64::from(k);
            let wi = direction(1.3 * (0.618 * k).fract(), TAU * (0.755 * k).fract());
            let wo = direction(1.3 * (0.324 * k).fract(), TAU * (0.211 * k).fract());
            for (channel, wanted) in [(0, lobe(wi, wo)), (1, 0.2), (2, lobe(wi, wo))] {
                let found = back.at(channel, wi, wo);
                assert!((found / merl.at(channel, wi, wo) - 1.0).abs() < 1e-12);
                assert!((back.at(channel, wo, wi) / found - 1.0).abs() < 0.15, "{wi} {wo}");
                (apart, count) = (apart + (found / wanted - 1.0).abs(), count + 1.0);
            }
        }
        // Cells are 1° wide and hold one value each.
        assert!(apart / count < 0.03, "{}", apart / count);
        for broken in [&file[..100], &file[..file.len() - 1], &[file.clone(), vec![0]].concat(), &vec![0; file.len()]] {
            assert!(matches!(Merl::read(&mut &broken[..]), Err(MerlError::Format)));
        }
    }

    #[test]
    fn only_what_looks_the_same_all_around_is_taken() {
        let round = BrdfTable::from_fn(axes(4), lobe);
        let (apart, noise) = anisotropy(&round);
        assert!(apart < 0.01 && noise == 0.0, "{apart}");
        let merl = Merl::from_tables([&round; 3]).unwrap();
        let (wi, wo) = (direction(0.5, 1.0), direction(0.6, -2.0));
        assert!((merl.at(0, wi, wo) / lobe(wi, wo) - 1.0).abs() < 0.05);
        let brushed = BrdfTable::from_fn(axes(4), |wi, wo| {
            let m = (wi + wo).normalize();
            (-(m.x * m.x / 0.02 + m.y * m.y / 0.06)).exp()
        });
        assert!(anisotropy(&brushed).0 > 0.2);
        let refused = Merl::from_tables([&round, &round, &brushed]).unwrap_err();
        assert!(refused.to_string().contains("when the plate is turned"));
    }
}
