//! The relief as microgeometry: its normals, and how much of it is seen.

use std::io::Write;

use facetmill::export::rendered_view::{Exposure, slopes_page};
use facetmill::progress::{Cancelled, Progress, Stage};
use facetmill::raster::Raster;
use facetmill::report::measure::{Measured, NdfFacts};
use facetmill::trace::Surface;
use facetmill::trace::traced_plate::Task;
use facetmill::verify::microgeometry::{Masking, NormalDistribution, masking};
use glam::DVec2;

use super::{Bench, Outcome};
use crate::args::MeasureArgs;
use crate::console::Failure;
use crate::files::Staged;
use crate::tables::{percent, row};

/// Cells of the distribution of normals: along the polar angle, around the azimuth.
const CELLS: (usize, usize) = (256, 128);

/// Rays from each direction that masking is told for, unless --rays says.
const RAYS: u64 = 200_000;

/// Slope at the rim of the picture, as a multiple of the steeper RMS slope.
const RIM: f64 = 4.0;

struct Counted<'a> {
    rays: u64,
    seed: u64,
    progress: &'a Progress<'a>,
}

impl Task for Counted<'_> {
    type Output = Result<Option<(NormalDistribution, Vec<Masking>)>, Cancelled>;
    fn on<S: Surface>(self, surface: &S) -> Self::Output {
        let Some(normals) = NormalDistribution::of(surface, CELLS.0, CELLS.1) else { return Ok(None) };
        Ok(Some((normals, masking(surface, self.rays, self.seed, self.progress)?)))
    }
}

pub fn measure(
    args: &MeasureArgs,
    bench: &Bench,
    staged: &mut Staged,
    progress: &Progress,
) -> Result<Outcome, Failure> {
    progress.stage(Stage::Normals);
    let rays = args.rays().unwrap_or(RAYS);
    let task = Counted { rays, seed: bench.measuring.seed, progress };
    let (normals, rows_of_masking) = bench.plate.run(task)?.ok_or_else(|| {
        Failure::Impossible(
            "this relief stands on no grid: --ndf needs one of planar facets or of heights, as `design` writes".into(),
        )
    })?;
    progress.stage(Stage::Files);
    let rim = RIM * normals.rms_slope[0].max(normals.rms_slope[1]).max(1e-6);
    let picture = slope_picture(&normals, bench.measuring.resolution, rim);
    let exposure = Exposure { heading: format!("Slopes of {}", bench.name), ..Exposure::default() };
    staged.write_png("ndf.png", &slopes_page(&picture, rim, &exposure))?;
    staged.write("ndf.csv", |out| {
        writeln!(out, "# distribution of normals: area of surface per steradian and per area of plate; cell means")?;
        writeln!(out, "theta,phi,density")?;
        for (index, density) in normals.density.iter().enumerate().filter(|(_, d)| **d > 0.0) {
            let u = ((index % normals.columns) as f64 + 0.5) / normals.columns as f64;
            let v = ((index / normals.columns) as f64 + 0.5) / normals.rows as f64;
            writeln!(out, "{:.4},{:.4},{density:e}", 90.0 * u * u, 360.0 * v - 180.0)?;
        }
        Ok(())
    })?;
    staged.write("masking.csv", |out| {
        writeln!(
            out,
            "# share of the surface facing a direction that is seen from there, its standard error, and what it"
        )?;
        writeln!(out, "# would be were the relief endless, without walls; both: seen from there and from its mirror direction; degrees")?;
        writeln!(out, "theta,phi,seen,error,endless,both")?;
        for m in &rows_of_masking {
            let (theta, phi) = (m.theta.to_degrees(), m.phi.to_degrees());
            writeln!(out, "{theta:.1},{phi:.1},{:.6},{:.6},{:.6},{:.6}", m.seen, m.error, m.endless, m.both)?;
        }
        Ok(())
    })?;
    let seen_at = |theta: f64| {
        let near = |m: &&Masking| (m.theta.to_degrees() - theta).abs() < 0.1;
        let all: Vec<f64> = rows_of_masking.iter().filter(near).map(|m| m.seen).collect();
        all.iter().sum::<f64>() / all.len().max(1) as f64
    };
    let [p, q] = normals.rms_slope;
    let measured = Measured::Ndf(NdfFacts {
        rays_each: rays,
        rms_slope: [p, q],
        beckmann_alpha: [p * std::f64::consts::SQRT_2, q * std::f64::consts::SQRT_2],
        excess_area: normals.excess_area,
        picture_rim_slope: rim,
        seen_at_deg: [0.0, 30.0, 60.0, 80.0].map(|theta| (theta, seen_at(theta))).into_iter().collect(),
    });
    let rows = vec![
        row("RMS slope", format!("{p:.4}, {q:.4}"), "along x and y; ndf.png reaches four times the greater"),
        row(
            "as Beckmann",
            format!("{:.4}, {:.4}", p * 2f64.sqrt(), q * 2f64.sqrt()),
            "alpha of the lobe with these slopes",
        ),
        row("excess area", percent(normals.excess_area), "of surface beyond the plate's own"),
        row("seen at 60°", percent(seen_at(60.0)), "of what faces the viewer; the rest hides behind other facets"),
        row("seen at 80°", percent(seen_at(80.0)), "of what faces the viewer"),
    ];
    Ok(Outcome { measured, rows, notes: Vec::new(), look_at: "ndf.png" })
}

/// Density of slopes over the square of slopes within `rim`, x right, y up: p(s) = D (m·z)⁴.
fn slope_picture(normals: &NormalDistribution, side: usize, rim: f64) -> Raster {
    Raster::from_fn(side, side, |column, row| {
        let at = |k: usize| (2.0 * (k as f64 + 0.5) / side as f64 - 1.0) * rim;
        let slope = DVec2::new(at(column), -at(row));
        let theta = slope.length().atan();
        // Normals lean against the slope.
        let phi = (-slope.y).atan2(-slope.x);
        let u = (theta / std::f64::consts::FRAC_PI_2).sqrt();
        let v = (phi / std::f64::consts::TAU + 0.5).rem_euclid(1.0);
        let cell = |at: f64, n: usize| ((at * n as f64) as usize).min(n - 1);
        normals.density[cell(v, normals.rows) * normals.columns + cell(u, normals.columns)] * theta.cos().powi(4)
    })
}
