//! The settings of a plate of patches, a part of the table.

use super::Form::Text;
use super::table::PLAIN;
use super::{Section, Setting, Unit};

const DIRECTION: Setting = Setting {
    form: Text("THETA,PHI"),
    unit: Unit::Degrees,
    section: Section::Patches,
    ranges: &[[0.0, 85.0], [-360.0, 360.0]],
    ..PLAIN
};
const ANGLE: Setting = Setting { form: Text("DEG"), ranges: &[[0.2, 30.0]], ..DIRECTION };

/// How the plate is divided, and who looks from where.
pub(super) const PATCHES: [Setting; 6] = [
    Setting {
        name: "patches",
        key: "patches.count",
        form: Text("NxM"),
        unit: Unit::None,
        ranges: &[[1.0, 1000.0]],
        unset: "60 along the longer side, of 1 mm at least",
        help: "Patches along x and y of a plate for --portrait or maps",
        more: "Each is a small relief that shows one tone. Patches smaller than 1 mm blur their light by diffraction, which \
               is told; smaller than 0.2 mm, or than twenty of --min-feature, they are refused.",
        at: |recipe| &mut recipe.patches.count,
        ..DIRECTION
    },
    Setting {
        name: "viewer",
        key: "patches.viewer",
        unset: "where a flat plate mirrors the lamp",
        help: "Who sees the portrait: degrees from the plate's normal, azimuth from +x",
        more: "The azimuth counts counter-clockwise seen from above, as that of --light. Every patch is tilted so that the \
               viewer sees it, which costs brightness where lamp and viewer are not opposite.",
        at: |recipe| &mut recipe.patches.viewer,
        ..DIRECTION
    },
    Setting {
        name: "viewer-distance",
        key: "patches.viewer-distance",
        form: Text("MM"),
        unit: Unit::Millimetres,
        ranges: &[[50.0, 1e6]],
        unset: "500",
        help: "From the plate's middle to the viewer's eye, mm",
        at: |recipe| &mut recipe.patches.viewer_distance,
        ..DIRECTION
    },
    Setting {
        name: "spare",
        key: "patches.spare",
        unset: "to four sides",
        help: "Where the light goes that the viewer shall not see: degrees from the plate's normal, azimuth from +x",
        more: "As much as the walls between patches let pass; the report says how much.",
        at: |recipe| &mut recipe.patches.spare,
        ..DIRECTION
    },
    Setting {
        name: "patch-lobe",
        key: "patches.lobe",
        unset: "3",
        help: "Half width of a patch's lobe, degrees of tilt; with --gloss that of white",
        more: "The viewer sees the picture within twice this angle to every side; narrower lobes are brighter.",
        at: |recipe| &mut recipe.patches.lobe,
        ..ANGLE
    },
    Setting {
        name: "widest-lobe",
        key: "patches.widest-lobe",
        unset: "8",
        help: "Half width of the lobe where --gloss is black, degrees of tilt",
        at: |recipe| &mut recipe.patches.widest_lobe,
        ..ANGLE
    },
];
