//! The highlight image of one lamp, with all its digits and errors.

use facetmill::export::float_tiff::write_float_tiff;
use facetmill::export::rendered_view::{Exposure, highlight_page};
use facetmill::job::pictures::rays;
use facetmill::progress::{Progress, Stage};
use facetmill::report::measure::{HighlightImageFacts, Measured};
use facetmill::trace::Surface;
use facetmill::trace::traced_plate::Task;
use facetmill::verify::experiment::HighlightImage;
use facetmill::verify::measure::collect;
use facetmill::verify::tally::{MeasureError, Measurement, Tally};

use super::{Bench, Outcome};
use crate::console::Failure;
use crate::files::Staged;
use crate::tables::row;

struct Lit<'a> {
    bench: &'a Bench,
    progress: &'a Progress<'a>,
}

impl Task for Lit<'_> {
    type Output = Result<Measurement, MeasureError>;
    fn on<S: Surface>(self, surface: &S) -> Self::Output {
        let Bench { setup, measuring, .. } = self.bench;
        let screen = HighlightImage { setup, resolution: measuring.resolution };
        collect(&self.bench.experiment(surface), &screen, measuring, self.progress)
    }
}

/// Key, name, meaning and value of something that light can come to, as a share of incident light.
type Share = (&'static str, &'static str, &'static str, fn(&Tally) -> f64);

/// Everything that light can come to.
const SHARES: [Share; 9] = [
    ("up", "reflected", "of the light leaves upward", |t| t.up()),
    ("up_single", "by one bounce", "of the light leaves upward after it", |t| t.up_single / t.incident),
    ("up_multi", "by more", "of the light leaves upward after two bounces or more", |t| t.up_multi / t.incident),
    ("outside_image", "beside image", "of the light leaves upward past the image's rim", |t| {
        t.outside_image / t.incident
    }),
    ("taken", "absorbed", "of the light is taken by the material", |t| t.taken / t.incident),
    ("escaped_down", "past edges", "of the light leaves downward past the plate's edges", |t| {
        t.escaped_down / t.incident
    }),
    ("absorbed", "on the sides", "of the light meets the plate's outer sides, which are black", |t| {
        t.absorbed / t.incident
    }),
    ("trapped", "trapped", "of the light wants more bounces than were followed", |t| t.trapped / t.incident),
    ("first_hit_wall", "on walls first", "of the light meets a step between facets first", |t| {
        t.first_hit_wall / t.incident
    }),
];

pub fn measure(bench: &Bench, staged: &mut Staged, progress: &Progress) -> Result<Outcome, Failure> {
    progress.stage(Stage::Tracing);
    let measurement = bench.plate.run(Lit { bench, progress }).map_err(|error| {
        Failure::of_measure(error, "no light reaches the plate's optical area: check units, orientation and --light")
    })?;
    progress.stage(Stage::Files);
    let whole = &measurement.whole;
    let image = whole.share_image();
    let noise = measurement.image_noise();
    let exposure =
        Exposure { heading: format!("Highlight of {}, {}", bench.name, bench.made_of), ..Exposure::default() };
    staged.write_png("highlight.png", &highlight_page(&image, bench.setup.view(), &exposure))?;
    staged.write("highlight.tiff", |out| write_float_tiff(&image, out))?;
    staged.write("highlight_error.tiff", |out| write_float_tiff(&measurement.pixel_errors(), out))?;

    let errors = measurement.standard_errors(|tally| SHARES.map(|(_, _, _, share)| share(tally)));
    let (mut shares, mut share_errors) = (Vec::new(), Vec::new());
    let mut rows = vec![
        row(
            "plate",
            format!("{:.2} × {:.2} mm", bench.opened.size.x, bench.opened.size.y),
            format!("of {}", bench.made_of),
        ),
        row("rays", rays(whole.rays), "traced"),
        row(
            "image noise",
            format!("{:.3} %", 100.0 * noise),
            "of the light may be in a wrong pixel by chance; more --rays, or --error",
        ),
    ];
    for ((key, name, meaning, share), error) in SHARES.into_iter().zip(errors) {
        let value = share(whole);
        shares.push((key, value));
        share_errors.push((key, error));
        if value.abs() > 5e-5 {
            let figure = format!("{:.2} %", 100.0 * value);
            rows.push(row(name, figure, format!("{meaning} (± {:.3})", 100.0 * error)));
        }
    }
    let mut notes = Vec::new();
    let backface = whole.backface / whole.incident;
    if backface > 1e-4 {
        let percent = 100.0 * backface;
        notes.push(format!(
            "{percent:.2}% of the light meets faces from behind: the mesh leaks or is turned inside out."
        ));
    }
    let trapped = whole.trapped / whole.incident;
    if trapped > 1e-3 {
        let percent = 100.0 * trapped;
        notes.push(format!("{percent:.2}% of the light still bounces at the end: raise --max-bounces."));
    }
    let measured = Measured::Highlight(HighlightImageFacts {
        projection: bench.recipe.highlight.projection,
        half_field: bench.recipe.highlight.half_field.reach(),
        resolution: bench.measuring.resolution,
        pixels: "highlight.tiff holds shares of upward light, row 0 at v = +1; highlight_error.tiff their standard errors",
        rays: whole.rays,
        image_noise_tv: noise,
        shares_of_incident: shares.into_iter().collect(),
        standard_errors: share_errors.into_iter().collect(),
        backface,
        balance: whole.balance(),
    });
    Ok(Outcome { measured, rows, notes, look_at: "highlight.png" })
}
