//! The virtual gonioreflectometer: light from every incident direction of a grid over a relief, sorted by half vector.
//!
//! After Westin, Arvo, Torrance, "Predicting Reflectance Functions from Complex Surfaces" (SIGGRAPH 1992): the relief is
//! the material's microgeometry, and its BRDF the share of light that leaves through each cell of outgoing directions.

use glam::DVec3;

use super::table::{BrdfAxes, BrdfTable};
use crate::brdf::material::Material;
use crate::progress::Progress;
use crate::projection::Projection;
use crate::setup::Setup;
use crate::trace::Surface;
use crate::verify::experiment::{Experiment, Measuring, Sensor};
use crate::verify::measure::collect;
use crate::verify::tally::MeasureError;

/// A measured BRDF, and the light that it does not hold.
#[derive(Clone, Debug)]
pub struct Swept {
    /// The BRDF.
    pub table: BrdfTable,
    /// By incident direction, as shares of incident light.
    pub balance: Vec<LightBalance>,
}

/// Where light from one incident direction went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightBalance {
    /// Left upward: the albedo.
    pub up: f64,
    /// Of what left upward, after more than one bounce.
    pub multi_bounce: f64,
    /// Was taken by the material.
    pub taken: f64,
    /// Was still bouncing after the last bounce followed: what the table lacks.
    pub trapped: f64,
    /// Left downward past the plate's edge, or met its outer sides; none on an endless panel.
    pub past_edges: f64,
    /// Left so near the horizon that no cell of the table holds it.
    pub unheld: f64,
}

/// Outgoing directions by the half vector that they have with one incident direction.
struct HalfVectors<'a> {
    axes: &'a BrdfAxes,
    light: DVec3,
}

impl Sensor for HalfVectors<'_> {
    fn size(&self) -> (usize, usize) {
        (self.axes.columns(), self.axes.rows())
    }

    fn pixel(&self, direction: DVec3) -> Option<usize> {
        self.axes.cell_under(self.light, direction)
    }
}

/// Measures the BRDF of `surface` on the grid of `axes`, `measuring.rays` rays for each incident direction.
///
/// For the BRDF of a material the surface should be an endless panel; a finite plate loses light past its edges.
/// Fails if light from some direction meets nothing.
pub fn sweep<S: Surface>(
    surface: &S,
    material: &Material,
    axes: BrdfAxes,
    measuring: &Measuring,
    progress: &Progress,
) -> Result<Swept, MeasureError> {
    let slices = axes.slices();
    let mut table = BrdfTable::new(axes.clone());
    let mut balance = Vec::with_capacity(slices);
    for slice in 0..slices {
        let (theta, phi) = axes.incident_angles(slice);
        let setup = Setup::new(theta, phi, 0.0, Projection::Equidistant, 1.0);
        let experiment = Experiment { material: material.clone(), ..Experiment::new(surface, &setup) };
        let seed = measuring.seed.wrapping_add((slice as u64) << 20);
        let sensor = HalfVectors { axes: &axes, light: setup.light() };
        let measured = collect(&experiment, &sensor, &Measuring { seed, ..*measuring }, &progress.hushed())?;
        let whole = &measured.whole;
        let up = whole.up();
        let (mut share, mut error) = (whole.share_image().scaled(up), measured.pixel_errors().scaled(up));
        pool(table.axes(), table.slice_projected(slice), &mut share.values, &mut error.values);
        // Lengths fit and all is finite: the table and the sensor are of the same axes, and light came in.
        let set = table.set_flux(slice, &share.values, &error.values);
        let unheld = set.map_err(|_| MeasureError::NoLight)? + whole.outside_image / whole.incident;
        balance.push(LightBalance {
            up,
            multi_bounce: whole.multi_bounce(),
            taken: whole.taken / whole.incident,
            trapped: whole.trapped / whole.incident,
            past_edges: (whole.escaped_down + whole.absorbed) / whole.incident,
            unheld,
        });
        progress.fraction((slice + 1) as f64 / slices as f64);
    }
    Ok(Swept { table, balance })
}

/// Half vectors nearer to the normal than this, degrees, are counted together.
const POOLED: f64 = 0.5;

/// Near the normal cells are needles that hardly any ray hits: there neighbours around the azimuth count together, so
/// many that what they cover is about as wide as long, and around the normal itself all of them. Light is only spread
/// within the group, in proportion to [`BrdfAxes::projected`]; errors add as independent ones do.
fn pool(axes: &BrdfAxes, projected: &[f32], share: &mut [f64], error: &mut [f64]) {
    let (columns, rows) = (axes.columns(), axes.rows());
    let edge = |k: usize| std::f64::consts::FRAC_PI_2 * (k as f64 / columns as f64).powi(2);
    let mut spread = |cells: &[usize]| {
        let sum = |values: &dyn Fn(usize) -> f64| cells.iter().map(|&cell| values(cell)).sum::<f64>();
        let whole = sum(&|cell| f64::from(projected[cell]));
        if whole > 0.0 {
            let light = sum(&|cell| share[cell]) / whole;
            let scatter = sum(&|cell| error[cell] * error[cell]).sqrt() / whole;
            for &cell in cells {
                let part = f64::from(projected[cell]);
                (share[cell], error[cell]) = (light * part, scatter * part);
            }
        }
    };
    let middle = (1..columns).take_while(|&k| edge(k) <= POOLED.to_radians()).last().unwrap_or(0);
    let disc: Vec<usize> = (0..columns * rows).filter(|cell| cell % columns < middle).collect();
    spread(&disc);
    for column in middle..columns {
        let long = edge(column + 1) - edge(column);
        let wide = 0.5 * (edge(column + 1) + edge(column)).sin() * std::f64::consts::TAU / rows as f64;
        let mut group = 1;
        while wide * (group as f64) < 0.7 * long && rows.is_multiple_of(2 * group) {
            group *= 2;
        }
        for first in (0..rows).step_by(group).filter(|_| group > 1) {
            let cells: Vec<usize> = (first..first + group).map(|row| row * columns + column).collect();
            spread(&cells);
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::relief::faceted::{Facet, FacetedRelief};
    use crate::slope::Slope;
    use crate::trace::grid::GridSurface;

    fn plate(slopes: &[(f64, f64)]) -> GridSurface {
        let facets = slopes.iter().map(|&(p, q)| Facet { height: 0.0, slope: Slope::new(p, q) }).collect();
        GridSurface::panel(
            &FacetedRelief::uniform(slopes.len(), 1, DVec2::new(slopes.len() as f64, 1.0), facets),
            &Progress::silent(),
        )
        .unwrap()
    }

    #[test]
    fn a_flat_rough_panel_has_the_brdf_of_its_material() {
        let material: Material = "aluminium:ggx:0.4".parse().unwrap();
        let axes = BrdfAxes::isotropic(vec![0.0, 0.6, 1.1], 24, 12).unwrap();
        let measuring = Measuring { rays: 400_000, ..Measuring::default() };
        let swept = sweep(&plate(&[(0.0, 0.0)]), &material, axes.clone(), &measuring, &Progress::silent()).unwrap();
        let analytic = BrdfTable::from_fn(axes.clone(), |wi, wo| material.eval(wi, wo) / wo.z);
        let mut tested = 0;
        for slice in 0..axes.slices() {
            assert_eq!(swept.balance[slice].past_edges, 0.0);
            for (cell, (&mean, &error)) in
                swept.table.slice(slice).iter().zip(swept.table.slice_error(slice)).enumerate()
            {
                let expected = f64::from(analytic.slice(slice)[cell]);
                // Well above the noise: the parts tell their own scatter, sixteen of them with heavy tails.
                if expected > 0.05 && error > 0.0 {
                    let z = (f64::from(mean) - expected) / f64::from(error).max(0.003 * expected);
                    assert!(z.abs() < 6.5, "{slice} {cell}: {mean} {expected} {error}");
                    tested += 1;
                }
            }
        }
        assert!(tested > 200, "{tested}");
        assert!(swept.table.reciprocity_error() < 0.1, "{}", swept.table.reciprocity_error());
    }

    #[test]
    fn the_noise_of_few_rays_is_told_apart_from_a_breach_of_reciprocity() {
        let material: Material = "aluminium:ggx:0.4".parse().unwrap();
        let axes = BrdfAxes::isotropic(vec![0.0, 0.4, 0.8, 1.2], 24, 12).unwrap();
        let [few, many] = [2_000, 200_000].map(|rays| {
            let measuring = Measuring { rays, ..Measuring::default() };
            let panel = plate(&[(0.0, 0.0)]);
            sweep(&panel, &material, axes.clone(), &measuring, &Progress::silent()).unwrap().table.laws()
        });
        // Of few rays nearly all of it is noise, and a hundred times as many have a tenth of the noise.
        assert!(few.reciprocity_error > 0.1, "{few:?}");
        let share = few.reciprocity_noise / few.reciprocity_error;
        assert!((0.6..1.5).contains(&share), "{few:?}");
        let ratio = few.reciprocity_noise / many.reciprocity_noise;
        assert!((7.0..14.0).contains(&ratio), "{few:?} {many:?}");
    }

    #[test]
    fn light_is_neither_made_nor_lost_on_an_endless_mirror_panel() {
        let panel = plate(&[(0.3, 0.1), (-0.5, 0.0), (0.2, -0.6), (0.0, 0.4)]);
        let axes = BrdfAxes::anisotropic(vec![0.0, 0.7, 1.4], 4, 32, 16).unwrap();
        let measuring = Measuring { rays: 20_000, max_bounces: 64, ..Measuring::default() };
        let swept = sweep(&panel, &Material::MIRROR, axes, &measuring, &Progress::silent()).unwrap();
        for (slice, balance) in swept.balance.iter().enumerate() {
            assert!((balance.up + balance.trapped - 1.0).abs() < 1e-9, "{balance:?}");
            let (albedo, _) = swept.table.albedo(slice);
            assert!((albedo + balance.unheld - balance.up).abs() < 1e-5, "{albedo} {balance:?}");
        }
    }
}
