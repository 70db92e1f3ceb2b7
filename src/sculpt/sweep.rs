//! A cutter swept over heights on a grid of places, one axis after the other.
//!
//! The tip stands as low at each place as the surface lets it: its path is the highest of all heights z(x + a) - u(a),
//! where u is the cutter's underside over the distance a from its axis. What it leaves is the lowest underside that
//! passes over a point: the lowest of all path(x - a) + u(a). Where u is a sum of one function of x and one of y, both
//! sweeps part into rows and columns.

use rayon::prelude::*;

use crate::progress::{Cancelled, Progress};

use super::places::Places;

/// Part of a cutter's profile along one axis: steps aside from the tip, and minus the height of the underside there, mm.
pub(crate) type Profile = [(isize, f32)];

/// What a cutter leaves of the heights `z`, rows of `width` places: its path first, then the surface below it.
///
/// `along_x` and `along_y` are the profile along rows and columns. Rows and columns continue into themselves.
pub(crate) fn milled_heights(
    z: &[f32],
    width: usize,
    along_x: &Profile,
    along_y: &Profile,
    progress: &Progress,
) -> Result<Vec<f32>, Cancelled> {
    let all = Places::all([width, z.len() / width]);
    milled_places(z, width, [along_x, along_y], [&all; 4], progress)
}

/// The same at some places alone: `swept` are those of the path along rows, the path, the surface along rows and the surface,
/// each of which lies in the one before, a sweep's reach from its rim. `z` need only be known a reach around the first.
pub(super) fn milled_places(
    z: &[f32],
    width: usize,
    [along_x, along_y]: [&Profile; 2],
    swept: [&Places; 4],
    progress: &Progress,
) -> Result<Vec<f32>, Cancelled> {
    let mut z = swept_along_rows(z, width, along_x, (Sweep::Path, swept[0]), progress)?;
    z = swept_across_rows(&z, width, along_y, (Sweep::Path, swept[1]), progress)?;
    z = swept_along_rows(&z, width, along_x, (Sweep::Surface, swept[2]), progress)?;
    swept_across_rows(&z, width, along_y, (Sweep::Surface, swept[3]), progress)
}

/// How far a profile reaches from its tip, places.
pub(super) fn reach(profile: &Profile) -> usize {
    profile.iter().map(|(aside, _)| aside.unsigned_abs()).max().unwrap_or(0)
}

/// Which of the two sweeps.
#[derive(Clone, Copy, PartialEq)]
enum Sweep {
    /// out(x) = max over the profile of z(x + aside) + depth.
    Path,
    /// out(x) = min over the profile of z(x - aside) - depth.
    Surface,
}

fn swept_along_rows(
    z: &[f32],
    width: usize,
    profile: &Profile,
    (sweep, places): (Sweep, &Places),
    progress: &Progress,
) -> Result<Vec<f32>, Cancelled> {
    let reach = reach(profile);
    let mut out = vec![0.0f32; z.len()];
    let rows = z.par_chunks(width).zip(&places.rows);
    out.par_chunks_mut(width).zip(rows).with_min_len(16).try_for_each_init(
        Vec::new,
        |around, (out, (row, ranges))| {
            progress.check()?;
            for range in ranges {
                around.clear();
                around.extend((range.start..range.end + 2 * reach).map(|k| row[(k + reach * (width - 1)) % width]));
                let out = &mut out[range.clone()];
                sweep.line(out, profile, |aside| &around[reach.wrapping_add_signed(aside)..][..range.len()]);
            }
            Ok(())
        },
    )?;
    Ok(out)
}

fn swept_across_rows(
    z: &[f32],
    width: usize,
    profile: &Profile,
    (sweep, places): (Sweep, &Places),
    progress: &Progress,
) -> Result<Vec<f32>, Cancelled> {
    let rows = (z.len() / width) as isize;
    let mut out = vec![0.0f32; z.len()];
    out.par_chunks_mut(width).zip(&places.rows).enumerate().with_min_len(16).try_for_each(|(j, (out, ranges))| {
        progress.check()?;
        let row = |aside: isize| (j as isize + aside).rem_euclid(rows) as usize;
        for range in ranges {
            sweep.line(&mut out[range.clone()], profile, |aside| &z[row(aside) * width..][range.clone()]);
        }
        Ok(())
    })?;
    Ok(out)
}

impl Sweep {
    /// One row of the result; `shifted(aside)` is the row of heights that many steps aside.
    fn line<'a>(self, out: &mut [f32], profile: &Profile, shifted: impl Fn(isize) -> &'a [f32]) {
        match self {
            Self::Path => {
                out.fill(f32::NEG_INFINITY);
                for &(aside, depth) in profile {
                    for (o, v) in out.iter_mut().zip(shifted(aside)) {
                        let v = v + depth;
                        *o = if v > *o { v } else { *o };
                    }
                }
            }
            Self::Surface => {
                out.fill(f32::INFINITY);
                for &(aside, depth) in profile {
                    for (o, v) in out.iter_mut().zip(shifted(-aside)) {
                        let v = v - depth;
                        *o = if v < *o { v } else { *o };
                    }
                }
            }
        }
    }
}
