//! The plate, or a shape that wears its relief, as a person sees it.

use facetmill::export::float_tiff::write_float_tiff;
use facetmill::export::rendered_view::{Exposure, view_page};
use facetmill::progress::{Progress, Stage};
use facetmill::report::measure::{Measured, ShapeFacts, ViewFacts};
use facetmill::trace::Surface;
use facetmill::trace::traced_plate::Task;
use facetmill::verify::render::{RenderError, RenderedView, Shape, ViewSettings, render};

use super::{Bench, Outcome};
use crate::args::MeasureArgs;
use crate::console::Failure;
use crate::files::Staged;
use crate::tables::row;

/// Paths a pixel, unless --rays says how many in all.
const PATHS: u64 = 256;

/// Paths a pixel at the most.
const MOST_PATHS: u64 = 1 << 24;

struct ViewTask<'a> {
    bench: &'a Bench,
    settings: ViewSettings,
    progress: &'a Progress<'a>,
}

impl Task for ViewTask<'_> {
    type Output = Result<RenderedView, RenderError>;
    fn on<S: Surface>(self, surface: &S) -> Self::Output {
        render(&self.bench.experiment(surface), &self.settings, self.progress)
    }
}

pub fn measure(
    args: &MeasureArgs,
    bench: &Bench,
    staged: &mut Staged,
    progress: &Progress,
) -> Result<Outcome, Failure> {
    let settings = settings(args, bench)?;
    progress.stage(Stage::View);
    let view = bench.plate.run(ViewTask { bench, settings, progress }).map_err(|error| refused(&error, bench))?;
    progress.stage(Stage::Files);
    let exposure = Exposure { heading: format!("{}, {}", bench.name, bench.made_of), ..Exposure::default() };
    staged.write_png("look.png", &view_page(&view, &settings, &exposure))?;
    staged.write("look.tiff", |out| write_float_tiff(&view.radiance, out))?;
    staged.write("look_error.tiff", |out| write_float_tiff(&view.errors, out))?;
    let ViewSettings { theta, phi, distance, .. } = settings;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
    let (radiance, error) = (mean(&view.radiance.values), mean(&view.errors.values));
    let measured = Measured::View(ViewFacts {
        camera_deg: [theta, phi],
        distance_mm: distance,
        field_of_view_deg: settings.field_of_view,
        shape: match settings.shape {
            Shape::Flat => ShapeFacts::Flat,
            Shape::Sphere { radius } => ShapeFacts::Sphere(radius),
            Shape::Cylinder { radius } => ShapeFacts::Cylinder(radius),
        },
        ambient: settings.ambient,
        paths_a_pixel: settings.rays,
        pixels: "look.tiff holds radiance in 1/sr for a lamp whose irradiance across its beam is 1",
        mean_radiance: radiance,
        mean_error: error,
        greatest_radiance: view.radiance.max(),
        mean_trapped: mean(&view.trapped.values),
    });
    let rows = vec![
        row(
            "camera",
            format!("{distance} mm"),
            format!("away, at {theta}°, {phi}°; {:.2}° across", settings.field_of_view),
        ),
        row("paths", settings.rays.to_string(), "or a little more for each pixel"),
        row(
            "brightest",
            format!("{:.4} /sr", view.radiance.max()),
            "pixel; a white matt plate straight below the lamp has 0.318",
        ),
        row("noise", format!("{:.2} %", 100.0 * error / radiance.max(f64::MIN_POSITIVE)), "of a pixel, on average"),
    ];
    let mut notes = Vec::new();
    if bench.lamp.is_point() && bench.material.is_smooth() {
        let material = &bench.material;
        notes.push(format!(
            "A lamp without size is seen nowhere in smooth {material}: only its surroundings are. Give --light-radius."
        ));
    }
    Ok(Outcome { measured, rows, notes, look_at: "look.png" })
}

/// What the flags ask for; without them, all of the plate in the picture.
fn settings(args: &MeasureArgs, bench: &Bench) -> Result<ViewSettings, Failure> {
    let usual = ViewSettings::default();
    let side = bench.measuring.resolution;
    let shape = args.wrap.map_or(Shape::Flat, Into::into);
    let distance = args.distance.unwrap_or(usual.distance);
    let [theta, phi] = args.camera.unwrap_or([usual.theta, usual.phi]);
    // All of it, and a rim.
    let fitting = match shape {
        Shape::Flat => 1.2 * (0.5 * bench.opened.size.truncate().length() / distance).atan(),
        Shape::Sphere { radius } | Shape::Cylinder { radius } => 1.15 * (radius / distance).min(1.0).asin(),
    };
    let pixels = (side * side) as u64;
    // A number of at least as many rays as there are pixels has always been that of all of them together.
    let each = |rays: u64| if rays >= pixels { rays / pixels } else { rays };
    let paths = args.rays().map_or(PATHS, each);
    if paths > MOST_PATHS {
        let most = MOST_PATHS * pixels;
        let all = args.rays().unwrap_or(0);
        return Err(Failure::Usage(format!("--rays is {all}: at most {most} serve --look at --resolution {side}")));
    }
    Ok(ViewSettings {
        theta,
        phi,
        distance,
        field_of_view: args.field.unwrap_or((2.0 * fitting.to_degrees()).clamp(1e-6, 160.0)),
        size: [side, side],
        shape,
        ambient: args.ambient.unwrap_or(usual.ambient),
        rays: u32::try_from(paths).unwrap_or(u32::MAX),
        max_bounces: bench.measuring.max_bounces,
        seed: bench.measuring.seed,
    })
}

/// What the library refuses although each flag by itself makes sense, with the flags that help.
fn refused(error: &RenderError, bench: &Bench) -> Failure {
    Failure::Impossible(match error {
        RenderError::Cancelled(cancelled) => return (*cancelled).into(),
        RenderError::PointOnSmooth { .. } => {
            let material = &bench.material;
            format!(
                "a lamp without size is seen nowhere in smooth {material}: give it a size with --light-radius 0.2665 \
                 (the sun's), or make the plate rough with --material {material}:ggx:0.1"
            )
        }
        RenderError::Ends => "--wrap needs a relief that goes on without end: leave out --extent finite; \
                            a relief that stands on no grid cannot be wrapped"
            .into(),
        RenderError::Inside { distance } => {
            format!("a camera {distance} mm away is inside the plate or what it is wrapped on: raise --distance")
        }
        error => error.to_string(),
    })
}
