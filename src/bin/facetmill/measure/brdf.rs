//! The BRDF over all directions: tables for renderers, text for spreadsheets, pictures for people.

use std::time::Instant;

use facetmill::export::brdf_csv::write_brdf_csv;
use facetmill::export::bsdf::{BsdfColour, BsdfError, BsdfFacts, BsdfSettings, write_bsdf};
use facetmill::export::hemisphere_maps::hemisphere_maps;
use facetmill::export::merl::{Merl, MerlError};
use facetmill::export::polar_slices::{RadialScale, polar_slices};
use facetmill::progress::{Progress, Stage};
use facetmill::report::measure::{BrdfFacts, DirectionFacts, Measured};
use facetmill::trace::Surface;
use facetmill::trace::traced_plate::Task;
use facetmill::verify::experiment::Measuring;
use facetmill::verify::goniometer::sweep::{LightBalance, Swept, sweep};
use facetmill::verify::goniometer::table::{BrdfAxes, Laws};
use facetmill::verify::tally::MeasureError;

use super::{Bench, Outcome};
use crate::args::MeasureArgs;
use crate::console::Failure;
use crate::files::Staged;
use crate::ranges::whole;
use crate::tables::{percent, row};

/// The most grazing light, degrees. What a ball shows near its rim lies beyond 85.
const GRAZING: f64 = 88.0;

/// Polar angles of light, unless --polar says.
const POLARS: usize = 16;

/// Rays for each direction of light, unless --rays says.
const RAYS: u64 = 200_000;

/// Polar angles of the slices and maps that are drawn, degrees.
const DRAWN: [f64; 5] = [0.0, 15.0, 30.0, 45.0, 60.0];

struct Turned<'a> {
    bench: &'a Bench,
    axes: BrdfAxes,
    measuring: Measuring,
    progress: &'a Progress<'a>,
}

impl Task for Turned<'_> {
    type Output = Result<Swept, MeasureError>;
    fn on<S: Surface>(self, surface: &S) -> Self::Output {
        let (material, measuring, lights) = (&self.bench.material, &self.measuring, self.axes.slices());
        let fewer = Measuring { rays: measuring.rays.min(TRIED), ..*measuring };
        let started = Instant::now();
        sweep(surface, material, self.tried(), &fewer, &Progress::silent())?;
        let a_ray = started.elapsed().as_secs_f64() / (2 * fewer.rays) as f64;
        let about = how_much(lights, measuring.rays, a_ray);
        self.progress.stage_with(Stage::Goniometer, &about);
        sweep(surface, material, self.axes, measuring, self.progress)
    }
}

impl Turned<'_> {
    /// Two directions of light, on whose rays the time of all is guessed.
    fn tried(&self) -> BrdfAxes {
        let nodes = BrdfAxes::polar_nodes(2, TRIED_TO.to_radians());
        BrdfAxes::isotropic(nodes, self.axes.columns(), self.axes.rows()).unwrap_or_else(|_| self.axes.clone())
    }
}

/// Rays of a direction from which the time of all is guessed, and how grazing the second of its directions is, degrees.
const TRIED: u64 = 20_000;
const TRIED_TO: f64 = 60.0;

/// What a person is told before a sweep, in which a ray takes `a_ray` seconds.
fn how_much(lights: usize, rays: u64, a_ray: f64) -> String {
    let seconds = lights as f64 * rays as f64 * a_ray;
    let time = match seconds {
        ..10.0 => String::new(),
        10.0..120.0 => format!(": about {seconds:.0} s"),
        _ => format!(": about {:.0} min", seconds / 60.0),
    };
    format!("{lights} directions of light, {rays} rays each{time}")
}

pub fn measure(
    args: &MeasureArgs,
    bench: &Bench,
    staged: &mut Staged,
    progress: &Progress,
) -> Result<Outcome, Failure> {
    let axes = axes(args)?;
    let rays = args.rays().unwrap_or(RAYS);
    let measuring = Measuring { rays, ..bench.measuring };
    let swept = bench.plate.run(Turned { bench, axes, measuring, progress }).map_err(|error| {
        Failure::of_measure(error, "light from some directions meets nothing of the plate: check units and orientation")
    })?;
    let table = &swept.table;

    progress.stage(Stage::Files);
    let mut notes = Vec::new();
    let description =
        format!("facetmill: {} plate of {}", if bench.endless { "endless" } else { "finite" }, bench.material);
    let mut bsdf = Vec::new();
    let written = write_bsdf(
        BsdfColour::Grey(table),
        &BsdfSettings { description: description.clone(), ..BsdfSettings::measured() },
        &mut bsdf,
    )
    .map_err(|error: BsdfError| Failure::Impossible(format!("brdf.bsdf: {error}")))?;
    staged.write_bytes("brdf.bsdf", &bsdf)?;
    staged.write("brdf.csv", |out| write_brdf_csv(table, out))?;
    match Merl::from_tables([table; 3]) {
        Ok(merl) => {
            let mut bytes = Vec::new();
            merl.write(&mut bytes).map_err(|error| Failure::Impossible(format!("brdf.binary: {error}")))?;
            staged.write_bytes("brdf.binary", &bytes)?;
        }
        Err(error @ MerlError::Anisotropic { .. }) => notes.push(format!("No brdf.binary was written: {error}.")),
        Err(error) => return Err(Failure::Impossible(format!("brdf.binary: {error}"))),
    }
    let heading = format!("BRDF of {}, {}", bench.name, bench.made_of);
    let drawn = DRAWN.map(f64::to_radians);
    staged.write_png("slices.png", &polar_slices(table, &drawn, 0.0, RadialScale::Logarithmic, &heading))?;
    let azimuths: &[f64] = if table.axes().is_isotropic() { &[0.0] } else { &[0.0, 90.0] };
    let lights_drawn: Vec<(f64, f64)> =
        azimuths.iter().flat_map(|phi| drawn.map(|theta| (theta, phi.to_radians()))).collect();
    staged.write_png("maps.png", &hemisphere_maps(table, &lights_drawn, &heading))?;

    let trapped = worst(&swept, |l| l.trapped);
    if trapped > 1e-3 {
        notes.push(format!(
            "Up to {:.2}% of the light still bounces at the end and is not in the table: raise --max-bounces.",
            100.0 * trapped
        ));
    }
    Ok(Outcome {
        measured: Measured::Brdf(facts(&swept, rays, written)),
        rows: rows(&swept, rays),
        notes,
        look_at: "slices.png",
    })
}

/// What the report says of a sweep in which each direction sent `rays` rays.
fn facts(swept: &Swept, rays: u64, bsdf: BsdfFacts) -> BrdfFacts {
    let (table, laws) = (&swept.table, swept.table.laws());
    let by_light: Vec<_> = swept
        .balance
        .iter()
        .enumerate()
        .map(|(slice, light)| {
            let (theta, phi) = table.axes().incident_angles(slice);
            DirectionFacts {
                theta_deg: theta.to_degrees(),
                phi_deg: phi.to_degrees(),
                albedo: light.up,
                multi_bounce: light.multi_bounce,
                taken: light.taken,
                trapped: light.trapped,
                past_edges: light.past_edges,
                unheld: light.unheld,
            }
        })
        .collect();
    BrdfFacts {
        rays_each: rays,
        half_vectors: [table.axes().columns(), table.axes().rows()],
        least: laws.least,
        greatest_albedo: laws.greatest_albedo.0,
        greatest_albedo_error: laws.greatest_albedo.1,
        reciprocity_error: laws.reciprocity_error,
        reciprocity_noise: laws.reciprocity_noise,
        rays_each_for_5_percent: enough(&laws, rays),
        bsdf,
        directions: by_light,
    }
}

/// Noise of reciprocity that nobody minds.
const QUIET: f64 = 0.05;

/// About how many rays from each direction bring the noise of reciprocity to [`QUIET`], `rays` having been sent; two digits.
fn enough(laws: &Laws, rays: u64) -> u64 {
    // Noise falls with the square root of their number.
    let wanted = rays as f64 * (laws.reciprocity_noise / QUIET).powi(2);
    let step = 10f64.powf((wanted.max(10.0).log10()).floor() - 1.0);
    ((wanted / step).ceil() * step) as u64
}

/// The same for a person.
fn rows(swept: &Swept, rays: u64) -> Vec<[String; 3]> {
    let laws = swept.table.laws();
    let lights = swept.table.axes().slices();
    vec![
        row("directions", lights.to_string(), format!("of light, {rays} rays each")),
        row("albedo", percent(laws.greatest_albedo.0), albedo(laws.greatest_albedo)),
        row("bounced twice", percent(worst(swept, |l| l.multi_bounce)), "of what leaves, where most does"),
        row("past the edges", percent(worst(swept, |l| l.past_edges)), "of the light, where most does"),
        row(
            "reciprocity",
            percent(laws.reciprocity_error),
            if laws.reciprocity_noise > QUIET {
                format!(
                    "mean difference when light and viewer change places; about {} of it is noise of few rays: \
                     --rays {} makes that 5 %",
                    percent(laws.reciprocity_noise.min(laws.reciprocity_error)),
                    enough(&laws, rays)
                )
            } else {
                "mean difference when light and viewer change places: noise, and cells".into()
            },
        ),
    ]
}

/// What is said of the greatest albedo and its standard error. No law lets more than all light leave; what a table holds
/// beyond that is chance, and the width of its cells.
fn albedo((share, error): (f64, f64)) -> String {
    let beyond = if share > 1.0 { "; what is beyond 100 % is noise of the rays, and cells" } else { "" };
    format!("of the light leaves, where most does (± {:.2}){beyond}", 100.0 * error)
}

/// The largest of a share over all directions of light.
fn worst(swept: &Swept, share: fn(&LightBalance) -> f64) -> f64 {
    swept.balance.iter().map(share).fold(0.0, f64::max)
}

pub fn axes(args: &MeasureArgs) -> Result<BrdfAxes, Failure> {
    let polar = args.polar.unwrap_or(POLARS);
    let azimuths = args.azimuths.unwrap_or(16);
    let [columns, rows] = args.half_vectors.unwrap_or([128, 64]);
    for (flag, value, least, most) in [("polar", polar, 2, 180), ("azimuths", azimuths, 1, 360)] {
        whole(flag, Some(value), least, most)?;
    }
    let nodes = BrdfAxes::polar_nodes(polar, f64::to_radians(GRAZING));
    let axes = match azimuths {
        1 => BrdfAxes::isotropic(nodes, columns, rows),
        _ => BrdfAxes::anisotropic(nodes, azimuths, columns, rows),
    };
    let axes = axes.map_err(|error| Failure::Usage(format!("--polar, --azimuths, --half-vectors: {error}")))?;
    // Eight bytes a cell in memory, and pictures and files of the like size.
    if axes.slices() * axes.cells() > MOST_CELLS {
        return Err(Failure::Usage(format!(
            "--polar x --azimuths x --half-vectors is {} cells: at most {MOST_CELLS} are measured",
            axes.slices() * axes.cells()
        )));
    }
    if axes.cells() > MOST_CELLS_EACH {
        return Err(Failure::Usage(format!(
            "--half-vectors is {columns}x{rows}: at most {MOST_CELLS_EACH} cells are measured for each direction of light"
        )));
    }
    Ok(axes)
}

/// Cells for one direction of light, of which every part of the measurement holds its own: 2 GB in memory.
const MOST_CELLS_EACH: usize = 16_777_216;

/// Cells of a table: 1 GB in memory.
const MOST_CELLS: usize = 128_000_000;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_sweeps_say_beforehand_how_long() {
        assert_eq!(how_much(16, 1000, 1e-4), "16 directions of light, 1000 rays each");
        assert_eq!(how_much(241, 200_000, 1e-6), "241 directions of light, 200000 rays each: about 48 s");
        assert!(how_much(241, 2_000_000, 1e-6).ends_with(": about 8 min"));
    }

    #[test]
    fn an_albedo_above_one_is_told_as_noise() {
        assert!(!albedo((0.9731, 0.001)).contains("beyond"));
        assert!(albedo((1.0019, 0.0012)).contains("(± 0.12); what is beyond 100 % is noise"));
    }
}
