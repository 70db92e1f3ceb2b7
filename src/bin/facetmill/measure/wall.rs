//! The reflection on a wall, in millimetres.

use facetmill::export::float_tiff::write_float_tiff;
use facetmill::export::rendered_view::{Exposure, wall_page};
use facetmill::job::pictures::rays;
use facetmill::lamp::Lamp;
use facetmill::progress::{Progress, Stage};
use facetmill::recipe::Seen;
use facetmill::report::measure::{Measured, WallFacts};
use facetmill::scene::Scene;
use facetmill::trace::Surface;
use facetmill::trace::traced_plate::Task;
use facetmill::verify::thrown::plate_origin;
use facetmill::verify::wall::{WallError, WallImage, WallSettings, wall_image};

use super::{Bench, Outcome};
use crate::args::MeasureArgs;
use crate::console::Failure;
use crate::files::Staged;
use crate::tables::{Row, percent, row};

struct WallTask<'a> {
    bench: &'a Bench,
    /// Lamp and wall of the design's own scene, if they are to be taken.
    scene: Option<&'a Scene>,
    /// Distance and radius of a lamp nearby, mm.
    ball: Option<(f64, f64)>,
    settings: WallSettings,
    progress: &'a Progress<'a>,
}

impl Task for WallTask<'_> {
    type Output = Result<WallImage, WallError>;
    fn on<S: Surface>(self, surface: &S) -> Self::Output {
        let mut experiment = self.bench.experiment(surface);
        if let Some((distance, radius)) = self.ball {
            experiment = experiment.under_ball(distance, radius);
        }
        if let Some(scene) = self.scene {
            experiment = experiment.in_scene(scene, plate_origin(surface));
        }
        wall_image(&experiment, &self.settings, &self.bench.measuring, self.progress)
    }
}

pub fn measure(
    args: &MeasureArgs,
    bench: &Bench,
    staged: &mut Staged,
    progress: &Progress,
) -> Result<Outcome, Failure> {
    let scene = bench.scene.as_ref();
    let usual = scene.and_then(|scene| scene.wall()).map_or_else(WallSettings::default, |wall| (*wall).into());
    let wall_distance = args.wall.unwrap_or(usual.wall_distance);
    let (ball, notes) = ball(args, bench);
    let (lamp_distance, lamp_radius) = ball.unwrap_or((f64::INFINITY, 0.0));
    // The whole highlight, what the plate's own size adds, and a rim.
    let reach = bench.recipe.highlight.half_field.reach().min(80.0).to_radians().tan();
    let spread = 0.5 * bench.opened.size.truncate().max_element() * (1.0 + wall_distance / lamp_distance);
    let all = if scene.is_some() { usual.half_width } else { 1.1 * (wall_distance * reach + spread) };
    let half_width = args.wall_width.map_or(all, |width| 0.5 * width);
    let wall_tilt = args.wall_tilt.unwrap_or(usual.wall_tilt);
    let settings = WallSettings { wall_distance, wall_tilt, half_width, ..usual };
    progress.stage(Stage::Wall);
    let ball = ball.filter(|_| scene.is_none());
    let image = bench.plate.run(WallTask { bench, scene, ball, settings, progress }).map_err(refused)?;
    progress.stage(Stage::Files);
    let mirrored = bench.recipe.highlight.seen == Seen::OnWall;
    let exposure = Exposure {
        mirrored,
        heading: format!("Light on a wall by {}, {}", bench.name, bench.made_of),
        ..Exposure::default()
    };
    staged.write_png("wall.png", &wall_page(&image, &settings, &exposure))?;
    staged.write("wall.tiff", |out| write_float_tiff(&image.irradiance(), out))?;
    staged.write("wall_error.tiff", |out| write_float_tiff(&image.errors(), out))?;
    let [landed, beside, nowhere] = image.shares();
    let blur = image.blur;
    let measured = Measured::Wall(WallFacts {
        wall_distance_mm: wall_distance,
        wall_tilt_deg: settings.wall_tilt,
        lamp_distance_mm: lamp_distance.is_finite().then_some(lamp_distance),
        lamp_radius_mm: lamp_radius,
        width_mm: 2.0 * half_width,
        resolution: bench.measuring.resolution,
        pixels: "wall.tiff holds irradiance as a multiple of that on the plate's middle, row 0 at the top (v = +1)",
        mirrored,
        in_picture: landed.0,
        in_picture_error: landed.1,
        beside_picture: beside.0,
        on_no_wall: nowhere.0,
        blur_by_plate_mm: blur.plate.to_array(),
        blur_by_lamp_mm: blur.lamp.to_array(),
        blur_by_plate_deg: [blur.plate_angle.x.to_degrees(), blur.plate_angle.y.to_degrees()],
        blur_by_lamp_deg: blur.lamp_angle.to_degrees(),
        image_noise_tv: image.measurement.image_noise(),
        rays: image.measurement.whole.rays,
    });
    let rows = rows(wall_distance, &image);
    Ok(Outcome { measured, rows, notes, look_at: "wall.png" })
}

/// Distance and radius of a lamp nearby, mm, and what is to be said of it: as given, else the design's own.
fn ball(args: &MeasureArgs, bench: &Bench) -> (Option<(f64, f64)>, Vec<String>) {
    let own = match bench.recipe.scene() {
        Ok(Some(scene)) => match scene.lamp() {
            Lamp::Ball { middle, radius } => Some((middle.length(), *radius)),
            _ => None,
        },
        _ => None,
    };
    if let Some(distance) = args.lamp_distance {
        return (Some((distance, args.lamp_radius.unwrap_or_default())), Vec::new());
    }
    let other = args.lamp.is_some() || ["light", "light-radius"].iter().any(|name| args.settings.has(name));
    let note = own.filter(|_| other).map(|(distance, _)| {
        format!("The design's lamp {distance:.0} mm away is left out for the one that was named: --lamp-distance puts that near.")
    });
    (own.filter(|_| !other), note.into_iter().collect())
}

/// What a person is told of a wall `wall_distance` mm away.
fn rows(wall_distance: f64, image: &WallImage) -> Vec<Row> {
    let ([landed, beside, _], blur) = (image.shares(), image.blur);
    // What passes the wall's horizon is spread without end.
    let length = |mm: f64| if mm.is_finite() { format!("{mm:.1} mm") } else { "endless".into() };
    vec![
        row(
            "wall",
            format!("{wall_distance} mm"),
            format!("away; the picture is {:.0} mm wide", 2.0 * image.half_width),
        ),
        row("rays", rays(image.measurement.whole.rays), "traced"),
        row("lands", percent(landed.0), "of the light, in the picture"),
        row("beside it", percent(beside.0), "of the light lands on the wall beyond the picture"),
        row(
            "plate's blur",
            length(blur.plate.max_element()),
            "wide: the spot that a flat mirror in the plate's place would throw",
        ),
        row(
            "lamp's blur",
            length(blur.lamp.max_element()),
            "wide: the lamp's image, as through a pinhole; each point of the highlight is blurred by both",
        ),
    ]
}

/// What the library refuses although each flag by itself makes sense, with the flags that help.
fn refused(error: WallError) -> Failure {
    Failure::Impossible(match error {
        WallError::Cancelled(cancelled) => return cancelled.into(),
        WallError::LampInPlate { .. } => {
            "the lamp would dip below the top of the plate: raise --lamp-distance, or lower --lamp-radius or --light"
                .into()
        }
        WallError::WallInPlate { .. } => {
            "the wall would cut the plate or stand behind it: raise --wall, or lower --wall-tilt or --light".into()
        }
        WallError::Length { what, value } => {
            format!("the {what} would be {value:e} mm, which is no wall: lower --wall, or set --wall-width")
        }
        WallError::Unlit => "no light of the lamp meets the plate: check units, orientation and --light".into(),
        error => error.to_string(),
    })
}
