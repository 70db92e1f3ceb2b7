//! What the numbers of flags must be, whatever the plate: told before any file is read.

use facetmill::verify::render::{Shape, ViewSettings};
use facetmill::verify::wall::WallSettings;

use super::brdf;
use crate::args::MeasureArgs;
use crate::console::Failure;
use crate::plates::MARGIN;
use crate::ranges::{whole, within};

/// Wall and camera, mm.
const LENGTH: (f64, f64) = (*WallSettings::LENGTH.start(), *WallSettings::LENGTH.end());

/// Refuses a flag whose number makes no sense, naming it.
pub fn check(args: &MeasureArgs) -> Result<(), Failure> {
    if args.brdf {
        brdf::axes(args)?;
    }
    whole("resolution", args.resolution, 16, if args.wall.is_some() { WallSettings::MOST_PIXELS } else { 4096 })?;
    let most = 100_000_000_000;
    whole("rays", args.rays().filter(|_| args.look).map(|rays| usize::try_from(rays).unwrap_or(usize::MAX)), 1, most)?;
    whole("max-bounces", args.max_bounces.map(|n| n as usize), 1, 1000)?;
    within("margin", args.margin, MARGIN)?;
    within("lamp-half-field", args.lamp_half_field, (0.01, 60.0))?;
    within("error", args.error, (1e-6, 0.999))?;
    within("wall", args.wall, LENGTH)?;
    within("lamp-distance", args.lamp_distance, LENGTH)?;
    // None is a point.
    within("lamp-radius", args.lamp_radius.filter(|radius| *radius != 0.0), LENGTH)?;
    within("wall-tilt", args.wall_tilt, (-WallSettings::MOST_TILT, WallSettings::MOST_TILT))?;
    within("wall-width", args.wall_width, (2.0 * LENGTH.0, 2.0 * LENGTH.1))?;
    within("camera", args.camera.map(|[theta, _]| theta), (0.0, 89.9))?;
    within("camera", args.camera.map(|[_, phi]| phi), (-360.0, 360.0))?;
    within("distance", args.distance, LENGTH)?;
    within("field", args.field, (*ViewSettings::FIELD_OF_VIEW.start(), *ViewSettings::FIELD_OF_VIEW.end()))?;
    let radius = args.wrap.map(Into::into).and_then(|shape: Shape| shape.radius());
    within("wrap", radius, LENGTH)?;
    within("ambient", args.ambient, (0.0, 1e9))
}
