//! How alike a continuous plate looks from window to window: what is left of the picture when only a part of the plate
//! is lit or seen.
//!
//! Light is that of the first bounce off mirrors: each triangle that the light reaches from the front sends its share to
//! one place, whatever stands in the way (`verify::measure` follows all of it). A window is made of whole squares of the
//! grid. Of a relief that repeats, a window of one cell holds every square of the cell once wherever it lies, so that all
//! such windows look the same; half a cell along each side holds a quarter of them.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

use super::score::{blurred, distance};
use super::verdict::MAIN_BLUR;
use crate::progress::{Cancelled, Progress};
use crate::projection::View;
use crate::raster::Raster;
use crate::relief::periodic::PeriodicRelief;
use crate::setup::Setup;
use crate::sharpen::{BlurKernel, seen};
use crate::slope::{Slope, mirror};

/// Windows of half a cell: one at a random place in each of 4 × 4 parts of the cell.
pub(crate) const PLACES: usize = PARTS * PARTS;
const PARTS: usize = 4;

/// Light in the wrong place over windows of one size: total variation as a share of all light that falls on the window,
/// at a blur of [`MAIN_BLUR`]. What misses the image is in the wrong place too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Misplaced {
    /// Over all windows.
    pub mean: f64,
    /// In the worst window.
    pub largest: f64,
}

/// How like the picture the windows of a plate are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Likeness {
    /// Windows of one cell.
    pub cell: Misplaced,
    /// Windows of half a cell along each side.
    pub half_cell: Misplaced,
}

/// What windows are compared with, and how.
#[derive(Clone, Copy)]
pub struct Wanted<'a> {
    /// Flux per pixel, sum 1, row 0 on top.
    pub target: &'a Raster,
    /// What the light of windows is seen through, if not sharply.
    pub blur: Option<&'a BlurKernel>,
    /// The places of windows follow from it.
    pub seed: u64,
}

/// Compares windows of `relief` with what is wanted; `None` if one of them gets no light.
pub fn likeness(
    relief: &PeriodicRelief,
    setup: &Setup,
    wanted: Wanted,
    progress: &Progress,
) -> Result<Option<Likeness>, Cancelled> {
    let Wanted { target, blur, seed } = wanted;
    let light = FirstBounce::new(relief, setup, (target.width, target.height), progress)?;
    let n = relief.nodes;
    let wanted = blurred(target, setup.view(), MAIN_BLUR.to_radians());
    let misplaced = |corners: &[[usize; 2]], side: usize| {
        let each = |&corner: &[usize; 2]| {
            progress.check()?;
            let Some(sent) = light.window(corner, side) else { return Ok(None) };
            let blurred = blur.map(|blur| seen(&sent, blur));
            Ok(Some(misplaced(blurred.as_ref().unwrap_or(&sent), &wanted, setup.view())))
        };
        let values = corners.par_iter().map(each).collect::<Result<Vec<Option<f64>>, Cancelled>>()?;
        let Some(values) = values.into_iter().collect::<Option<Vec<f64>>>() else { return Ok(None) };
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        Ok(Some(Misplaced { mean, largest: values.into_iter().fold(0.0, f64::max) }))
    };
    let half = (n / 2).max(1);
    let (cell, half_cell) = (misplaced(&[[0, 0]], n)?, misplaced(&places(relief, half, seed), half)?);
    Ok(cell.zip(half_cell).map(|(cell, half_cell)| Likeness { cell, half_cell }))
}

/// Misplaced light of one cell of `relief` by first bounces, seen through `blur` if there is one, against `target`: as
/// [`likeness`] finds it for any window of one cell. `None` if no light falls on it.
pub fn misplaced_by_a_cell(
    relief: &PeriodicRelief,
    setup: &Setup,
    blur: Option<&BlurKernel>,
    target: &Raster,
) -> Option<f64> {
    let light = FirstBounce::new(relief, setup, (target.width, target.height), &Progress::silent()).ok()?;
    let sent = light.window([0, 0], relief.nodes)?;
    let image = blur.map_or_else(|| sent.clone(), |blur| seen(&sent, blur));
    Some(misplaced(&image, &blurred(target, setup.view(), MAIN_BLUR.to_radians()), setup.view()))
}

/// Lower left corners of windows of `side` squares a side, spread over the cell.
fn places(relief: &PeriodicRelief, side: usize, seed: u64) -> Vec<[usize; 2]> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut unit = || random.random::<f64>();
    // Where there is but one cell, a window that reaches over its rim would lie half beyond the plate.
    let room = relief.cells.map(|cells| if cells > 1 { relief.nodes } else { relief.nodes + 1 - side });
    let mut along = |part: usize, room: usize| {
        let at = (part as f64 + unit()) / PARTS as f64;
        ((at * room as f64) as usize).min(room - 1)
    };
    (0..PLACES).map(|k| [along(k % PARTS, room[0]), along(k / PARTS, room[1])]).collect()
}

/// By how much the light of a cell of `relief` changes with its heights, as `sculpt::detail` asks: the total variation
/// between the light of other heights and that of its own, at a blur of [`MAIN_BLUR`].
pub fn change<'a>(
    relief: &'a PeriodicRelief,
    setup: &'a Setup,
    progress: &'a Progress,
) -> Result<impl Fn(&[f32]) -> Result<f64, Cancelled> + 'a, Cancelled> {
    let light = |heights: &[f32]| {
        let PeriodicRelief { nodes, cell, cells, tilt, .. } = *relief;
        let other = PeriodicRelief { nodes, heights: heights.to_vec(), cell, cells, tilt };
        // Of fine grids, such as a tool's, every other square along either side says as much.
        let every = if nodes >= FINE && nodes.is_multiple_of(2) { 2 } else { 1 };
        Ok(FirstBounce::of_every(every, &other, setup, CHANGE_RESOLUTION, progress)?.window([0, 0], nodes / every))
    };
    let before = light(&relief.heights)?.map(|image| blurred(&image, setup.view(), MAIN_BLUR.to_radians()));
    Ok(move |heights: &[f32]| {
        Ok(match (&before, light(heights)?) {
            (Some(before), Some(after)) => misplaced(&after, before, setup.view()),
            (None, None) => 0.0,
            _ => 1.0,
        })
    })
}

/// Nodes a side from which on a quarter of the squares is enough to see by how much light changes: 65,000 triangles or more.
const FINE: usize = 360;

/// Pixels of the image on which changes are seen.
const CHANGE_RESOLUTION: (usize, usize) = (256, 256);

/// Total variation between `light` (a share of what falls on a window) and `wanted`, which is blurred already.
fn misplaced(light: &Raster, wanted: &Raster, view: &View) -> f64 {
    let seen = blurred(light, view, MAIN_BLUR.to_radians());
    // What is in neither image sits in one more bin, "elsewhere".
    0.5 * (distance(&seen, wanted) + (seen.sum() - wanted.sum()).abs())
}

/// Where the triangles of one cell send light at the first bounce.
pub struct FirstBounce {
    nodes: usize,
    resolution: (usize, usize),
    /// Both triangles of every square.
    triangles: Vec<[TriangleLight; 2]>,
}

/// The light of one triangle.
#[derive(Clone, Copy)]
struct TriangleLight {
    /// Pixel of the image; [`NOWHERE`] if it misses the image or is sent down.
    pixel: u32,
    /// Light that falls on it, in that of a triangle that faces the light.
    light: f32,
}

const NOWHERE: u32 = u32::MAX;

impl FirstBounce {
    /// For an image of `resolution` = (width, height) pixels.
    pub fn new(
        relief: &PeriodicRelief,
        setup: &Setup,
        resolution: (usize, usize),
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        Self::of_every(1, relief, setup, resolution, progress)
    }

    /// The same of one square in `every` along either side, as if they were all of a grid as much coarser.
    fn of_every(
        every: usize,
        relief: &PeriodicRelief,
        setup: &Setup,
        resolution: (usize, usize),
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let n = relief.nodes;
        let (step, l) = (relief.step(), setup.light());
        let light_of = |[p, q]: [f64; 2]| {
            let slope = Slope::new(relief.tilt.p + p / step.x, relief.tilt.q + q / step.y);
            // All triangles have the same footprint.
            let light = slope.intercept(l).max(0.0) as f32;
            let o = mirror(l, slope.normal());
            let uv = if o.z > 0.0 { setup.image_of(o) } else { None };
            let pixel = uv.and_then(|uv| View::pixel_at(uv, resolution.0, resolution.1));
            TriangleLight { pixel: pixel.map_or(NOWHERE, |(column, row)| (row * resolution.0 + column) as u32), light }
        };
        let square = |i: usize, j: usize| relief.triangle_rises(i, j).0.map(light_of);
        let nowhere = TriangleLight { pixel: NOWHERE, light: 0.0 };
        let side = n / every;
        let mut triangles = vec![[nowhere; 2]; side * side];
        triangles.par_chunks_mut(side).enumerate().try_for_each(|(j, row)| {
            row.iter_mut().enumerate().for_each(|(i, triangles)| *triangles = square(i * every, j * every));
            progress.check()
        })?;
        Ok(Self { nodes: side, resolution, triangles })
    }

    /// The image of the window of `side` squares a side whose lower left corner is node `corner`: shares of the light that
    /// falls on the window, which reaches into the next cells where it must. `None` if no light falls on it.
    pub fn window(&self, [i0, j0]: [usize; 2], side: usize) -> Option<Raster> {
        let n = self.nodes;
        let mut image = Raster::zeros(self.resolution.0, self.resolution.1);
        let mut all = 0.0;
        for j in j0..j0 + side {
            let row = &self.triangles[j % n * n..][..n];
            for triangle in (i0..i0 + side).flat_map(|i| row[i % n]) {
                let light = f64::from(triangle.light);
                all += light;
                if triangle.pixel != NOWHERE {
                    image.values[triangle.pixel as usize] += light;
                }
            }
        }
        (all > 0.0).then(|| image.scaled(1.0 / all))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use glam::DVec2;

    use super::*;
    use crate::projection::Projection;
    use crate::relief::height_grid::rises;
    use crate::relief::periodic::drawn;

    const SIDE: usize = 128;

    fn setup(theta: f64) -> Setup {
        Setup::new(theta, 0.3, 0.0, Projection::Equidistant, f64::to_radians(20.0))
    }

    fn relief(nodes: usize, cells: [usize; 2], height: impl Fn(f64, f64) -> f64) -> PeriodicRelief {
        let heights = drawn(nodes, height);
        PeriodicRelief { nodes, heights, cell: DVec2::new(2.0, 3.0), cells, tilt: Slope::new(0.02, -0.01) }
    }

    fn hills(waves: f64) -> impl Fn(f64, f64) -> f64 {
        move |x, y| 0.04 / waves * ((TAU * waves * x).sin() * (TAU * waves * (y + 0.1)).cos() + (TAU * waves * x).cos())
    }

    fn sent(relief: &PeriodicRelief, setup: &Setup) -> FirstBounce {
        FirstBounce::new(relief, setup, (SIDE, SIDE), &Progress::silent()).unwrap()
    }

    fn compared(relief: &PeriodicRelief, setup: &Setup, target: &Raster, seed: u64) -> Option<Likeness> {
        likeness(relief, setup, Wanted { target, blur: None, seed }, &Progress::silent()).unwrap()
    }

    /// Light that just such a cell would send, moved by a degree or so.
    fn moved(relief: &PeriodicRelief, setup: &Setup) -> Raster {
        let elsewhere = PeriodicRelief { tilt: Slope::new(0.03, -0.01), ..relief.clone() };
        sent(&elsewhere, setup).window([0, 0], relief.nodes).unwrap().normalised()
    }

    #[test]
    fn windows_of_one_cell_show_what_the_cell_shows() {
        let setup = setup(0.4);
        let relief = relief(40, [3, 3], hills(1.0));
        let target = moved(&relief, &setup);
        let light = sent(&relief, &setup);
        let wanted = blurred(&target, setup.view(), MAIN_BLUR.to_radians());
        let whole = compared(&relief, &setup, &target, 1).unwrap().cell;
        assert!(whole.mean > 0.01 && whole.mean < 0.5 && whole.largest == whole.mean);
        for corner in places(&relief, 40, 5) {
            let figure = misplaced(&light.window(corner, 40).unwrap(), &wanted, setup.view());
            assert!((figure - whole.mean).abs() < 1e-6, "{figure} {whole:?}");
        }
    }

    #[test]
    fn half_a_cell_shows_all_where_the_relief_repeats_in_it() {
        let setup = setup(0.0);
        let fine = relief(40, [2, 2], |x, y| hills(1.0)((2.0 * x).fract(), (2.0 * y).fract()) / 2.0);
        let coarse = relief(40, [2, 2], hills(1.0));
        let [same, other] = [fine, coarse].map(|relief| compared(&relief, &setup, &moved(&relief, &setup), 3).unwrap());
        for figure in [same.half_cell.mean, same.half_cell.largest] {
            assert!((figure - same.cell.mean).abs() < 1e-6, "{same:?}");
        }
        assert!(other.half_cell.mean > 2.0 * other.cell.mean, "{other:?}");
    }

    #[test]
    fn half_of_a_dome_shows_a_quarter_of_its_light() {
        // A dome whose slopes are even over a square: every window of half a cell holds half of them along x and y. Blur
        // brings back a little of the three quarters that are missing.
        let setup = setup(0.0);
        let dome = relief(128, [2, 2], |x, y| -0.15 * (2.0 * (x - 0.5).powi(2) + 3.0 * (y - 0.5).powi(2)));
        let target = sent(&dome, &setup).window([0, 0], 128).unwrap();
        let figures = compared(&dome, &setup, &target, 7).unwrap();
        assert!(figures.cell.largest < 1e-9);
        assert!((figures.half_cell.mean - 0.68).abs() < 0.03, "{figures:?}");
        assert!(figures.half_cell.largest < 0.75);
    }

    #[test]
    fn light_that_misses_the_image_is_lost() {
        let setup = setup(0.0);
        let flat = relief(16, [1, 1], |_, _| 0.0);
        let target = moved(&flat, &setup);
        let steep = PeriodicRelief { tilt: Slope::new(0.5, 0.0), ..flat };
        let figures = compared(&steep, &setup, &target, 0).unwrap();
        assert!((figures.cell.mean - 1.0).abs() < 1e-3 && (figures.half_cell.largest - 1.0).abs() < 1e-3);
        let away = PeriodicRelief { tilt: Slope::new(5.0, 0.0), ..steep };
        let grazing = Setup::new(1.4, 0.0, 0.0, Projection::Equidistant, 0.3);
        assert_eq!(compared(&away, &grazing, &target, 0), None);
    }

    #[test]
    fn light_changes_with_the_heights_alone() {
        let setup = setup(0.2);
        let relief = relief(32, [1, 1], hills(1.0));
        let silent = Progress::silent();
        let changed = change(&relief, &setup, &silent).unwrap();
        let change = |z: &[f32]| changed(z).unwrap();
        assert_eq!(change(&relief.heights), 0.0);
        let raised: Vec<f32> = relief.heights.iter().map(|z| z + 0.25).collect();
        assert!(change(&raised) < 1e-3);
        let lower: Vec<f32> = relief.heights.iter().map(|z| 0.8 * z).collect();
        let flat = change(&[0.0; 1024]);
        assert!(change(&lower) > 0.02 && flat > 2.0 * change(&lower) && flat <= 1.0);
    }

    #[test]
    fn windows_stay_on_a_plate_of_one_cell() {
        for (cells, most) in [([1, 1], [20, 20]), ([2, 1], [39, 20]), ([3, 3], [39, 39])] {
            let relief = relief(40, cells, |_, _| 0.0);
            let places = places(&relief, 20, 9);
            assert_eq!(places.len(), PLACES);
            for axis in 0..2 {
                let largest = places.iter().map(|c| c[axis]).max().unwrap();
                assert!(largest <= most[axis] && largest > most[axis] * 3 / 4 - 1, "{places:?}");
            }
        }
    }

    #[test]
    fn squares_are_cut_along_their_higher_diagonal() {
        assert!(rises([1.0, 0.0, 0.0, 0.5]) && !rises([0.0, 1.0, 1.0, 0.0]) && !rises([0.0; 4]));
        // One high node: of the four squares around it the folds run down from it, and none lies across them.
        let spike = relief(4, [1, 1], |x, y| if x == 0.5 && y == 0.5 { 0.1 } else { 0.0 });
        let light = sent(&spike, &setup(0.0));
        let pixel = |k: usize| light.triangles[k].map(|g| g.pixel);
        let level = light.triangles[0][0].pixel;
        for k in [5, 6, 9, 10] {
            assert!(pixel(k).iter().all(|&p| p != level), "{k}");
        }
    }
}
