//! The table of settings, in the order of the help.

use super::Form::{Switch, Switches, Table, Text, Words};
use super::{Section, Setting, SurfaceKind, Unit, Word};

/// Facets on one plate at the most.
pub const MOST_FACETS: usize = 4_000_000;

/// Nodes along a side of a sheet's cell at the least.
pub const LEAST_GRID: usize = 16;

const fn word(word: &'static str, help: &'static str) -> Word {
    Word { word, before: None, help }
}

const fn renamed(word: &'static str, before: &'static str, help: &'static str) -> Word {
    Word { word, before: Some(before), help }
}

pub(super) const PLAIN: Setting = Setting {
    name: "",
    before: None,
    key: "",
    section: Section::Optics,
    form: Table,
    unit: Unit::None,
    ranges: &[],
    only: None,
    unset: "",
    help: "",
    more: "",
    remedy: "",
    at: |recipe| &mut recipe.design.seed,
};
const LENGTH: Setting = Setting { form: Text("MM"), unit: Unit::Millimetres, section: Section::Plate, ..PLAIN };
const ANGLE: Setting = Setting { form: Text("DEG"), unit: Unit::Degrees, ..PLAIN };
const COUNT: Setting = Setting { form: Text("N"), section: Section::Plate, ..PLAIN };
const DESIGN: Setting = Setting { section: Section::Design, ..PLAIN };
const SHEET: Setting = Setting { only: Some(SurfaceKind::Sheet), section: Section::Design, ..LENGTH };
const FACETS: Setting = Setting { only: Some(SurfaceKind::Facets), ..DESIGN };

/// Settings of highlight, plate and design.
pub(super) const GENERAL: &[Setting] = &[
    Setting {
        name: "half-field",
        key: "highlight.half-field",
        form: Text("DEG[xDEG]"),
        ranges: &[[0.1, 85.0], [0.1, 85.0]],
        help: "Angle from the picture's middle to its rim, degrees",
        more: "On a wall at a distance D the picture is 2·D·tan(angle) wide: 20° give 0.73 m at 1 m. The field is a \
               square, and --fit says how a picture that is not fills it; 30x18 makes it 30° to the right and left and \
               18° up and down.",
        at: |recipe| &mut recipe.highlight.half_field,
        ..ANGLE
    },
    Setting {
        name: "projection",
        key: "highlight.projection",
        form: Words(
            "NAME",
            &[
                word("orthographic", "Sines of the angles from the plate's normal"),
                word("equidistant", "Equal angles from the mirror direction"),
                word("screen", "A flat screen across the mirror direction"),
            ],
        ),
        help: "How directions are laid out on the picture",
        at: |recipe| &mut recipe.highlight.projection,
        ..PLAIN
    },
    Setting {
        name: "quantity",
        key: "highlight.quantity",
        form: Words(
            "NAME",
            &[
                word("radiance", "How bright the plate looks from there"),
                word("intensity", "Flux per steradian"),
                word("flux", "Flux per pixel; on a screen, irradiance"),
            ],
        ),
        help: "What a pixel's value says",
        at: |recipe| &mut recipe.highlight.quantity,
        ..PLAIN
    },
    Setting {
        name: "seen",
        key: "highlight.seen",
        form: Words(
            "SIDE",
            &[
                word("from-above", "A map of viewers, from above the plate"),
                word("on-wall", "Thrown on a wall, from the plate's side"),
            ],
        ),
        help: "From which side the picture is looked at",
        more: "Thrown on a wall or ceiling, a picture meant to be seen from above the plate is mirrored; on-wall turns it \
               right.",
        at: |recipe| &mut recipe.highlight.seen,
        ..PLAIN
    },
    Setting {
        name: "light",
        key: "light",
        form: Text("THETA,PHI"),
        ranges: &[[0.0, 85.0], [-360.0, 360.0]],
        help: "The lamp: degrees from the plate's normal, azimuth from +x",
        more: "The azimuth counts counter-clockwise seen from above: 30,90 is a lamp 30° off the normal toward +y. The \
               angle is 0 to 85.",
        at: |recipe| &mut recipe.light,
        ..ANGLE
    },
    Setting {
        name: "light-radius",
        key: "light.radius",
        // With a lamp aslant less: all of it stays above the plate.
        ranges: &[[0.0, 89.0]],
        help: "Angular radius of a distant lamp, degrees; the sun has 0.2665",
        more: "A disc of 10 mm at 1 m has 0.29. It blurs the highlight by as much. The design sharpens the light it asks \
               of the mirrors to make up for that, as far as light can be sharpened, and the proof counts it.",
        at: |recipe| &mut recipe.light.radius,
        ..ANGLE
    },
    Setting {
        name: "lobe",
        key: "plate.lobe",
        ranges: &[[0.0, 10.0]],
        help: "Scatter of the polished base metal, degrees: standard deviation of its deflections, 0 to 10",
        more: "No metal is a perfect mirror: milled and polished aluminium spreads light by about 1, which is 2.35 \
               between the points of half brightness. As with --light-radius, the design sharpens its light against it \
               and the proof is of such metal. If unsure say less: against too wide a lobe light is sharpened until it \
               shows. Small tilts by t throw light 2t aside: a lobe of 1 is Beckmann's roughness alpha = sqrt(2) \
               (lobe/2 in radians) = 0.0123.",
        at: |recipe| &mut recipe.plate.lobe,
        ..ANGLE
    },
    Setting {
        name: "invert",
        key: "highlight.invert",
        form: Switch,
        help: "Dark parts of the picture are the light",
        at: |recipe| &mut recipe.highlight.invert,
        ..PLAIN
    },
    Setting {
        name: "rotate",
        key: "highlight.rotate",
        ranges: &[[-360.0, 360.0]],
        help: "Turn the drawing counter-clockwise, degrees",
        at: |recipe| &mut recipe.highlight.rotate,
        ..ANGLE
    },
    Setting {
        name: "fit",
        key: "highlight.fit",
        form: Words(
            "HOW",
            &[word("pad", "Black bars"), word("crop", "Cut what is longer"), word("stretch", "Distort")],
        ),
        help: "How a picture that is not square fills the field",
        at: |recipe| &mut recipe.highlight.fit,
        ..PLAIN
    },
    Setting {
        name: "encoding",
        key: "highlight.encoding",
        form: Switches(&[
            word("linear", "Pixel values are proportional to light  [default: only in 16-bit and float pictures]"),
            word("srgb", "Pixel values are sRGB  [default: only in 8-bit pictures]"),
        ]),
        help: "How the numbers of the picture stand for light",
        at: |recipe| &mut recipe.highlight.encoding,
        ..PLAIN
    },
    Setting {
        name: "size",
        key: "plate.size",
        form: Text("WxH"),
        ranges: &[[0.01, 10_000.0]],
        help: "Optical area along x and y, mm",
        at: |recipe| &mut recipe.plate.size,
        ..LENGTH
    },
    Setting {
        name: "facets",
        key: "plate.facets",
        form: Text("NxM"),
        ranges: &[[1.0, MOST_FACETS as f64]],
        only: Some(SurfaceKind::Facets),
        unset: "30x30",
        help: "Facets along x and y on the whole plate",
        more: "Each is one flat mirror and one spot of light: 30x30 facets on 30x30 mm are 900 mirrors of 1 mm. More \
               facets show finer detail, smaller ones need a smaller cutter.",
        at: |recipe| &mut recipe.plate.facets,
        ..COUNT
    },
    Setting {
        name: "cells",
        key: "plate.cells",
        form: Text("K"),
        ranges: &[[1.0, MOST_FACETS as f64]],
        unset: "3; 1 with flat facets",
        help: "Repeat the whole highlight in K x K cells, or in 5x3",
        more: "One cell is a single dome, which seen from near by lights up in one place only. 3 x 3 cells of 10 mm each \
               hold the whole highlight, so the plate looks the same all over. 5x3 suits a plate of 50 x 30 mm. Numbers of \
               facets must be divisible by those of cells.",
        at: |recipe| &mut recipe.plate.cells,
        ..COUNT
    },
    Setting {
        name: "thickness",
        key: "plate.thickness",
        ranges: &[[0.01, 1000.0]],
        help: "Solid metal under the lowest point, mm",
        at: |recipe| &mut recipe.plate.thickness,
        ..LENGTH
    },
    Setting {
        name: "border",
        key: "plate.border",
        ranges: &[[0.0, 1000.0]],
        help: "Rim around the optical area, mm",
        more: "It begins level with the relief's lowest point, so that it shades nothing. What becomes of its light, \
               --border-finish says.",
        at: |recipe| &mut recipe.plate.border,
        ..LENGTH
    },
    Setting {
        name: "border-finish",
        key: "plate.border-finish",
        section: Section::Plate,
        form: Text("FINISH"),
        ranges: &[[1.0, 60.0]],
        unset: "matt",
        help: "How the --border is finished: matt, polished, or sloped:DEG, falling outward by so many degrees",
        more: "A flat rim that is polished with the rest is one large mirror: 3 mm around 30 mm throw 30 % of all light \
               into the middle of the picture. matt: it stays flat and is to be left dull, and counts as dark. \
               polished: its light counts. sloped: it is polished and throws its light past the picture; without \
               degrees it falls by the least that does.",
        at: |recipe| &mut recipe.plate.border_finish,
        ..ANGLE
    },
    Setting {
        name: "surface",
        key: "plate.surface",
        form: Words(
            "KIND",
            &[renamed("facets", "flat", "Planar facets"), renamed("sheet", "continuous", "One sheet without steps")],
        ),
        unset: "sheet; facets with --facets or another flag that only facets have",
        help: "Kind of relief",
        more: "One sheet has no steps and puts ten times less light in the wrong place than 900 facets; its STL is large. \
               Flags that the kind does not have are refused.",
        at: |recipe| &mut recipe.plate.surface,
        ..COUNT
    },
    Setting {
        name: "grid",
        key: "plate.grid",
        ranges: &[[LEAST_GRID as f64, 4096.0]],
        only: Some(SurfaceKind::Sheet),
        unset: "as suits cutter and file",
        help: "Nodes along each side of a cell of a sheet",
        remedy: "raise --grid",
        at: |recipe| &mut recipe.plate.grid,
        ..COUNT
    },
    Setting {
        name: "max-triangles",
        key: "plate.max-triangles",
        ranges: &[[1000.0, 2e8]],
        only: Some(SurfaceKind::Sheet),
        unset: "500000, or as many as the light needs",
        help: "Triangles of a sheet's file at the most, the fewer where it is smooth",
        remedy: "raise --max-triangles",
        at: |recipe| &mut recipe.plate.max_triangles,
        ..COUNT
    },
    Setting {
        name: "for-cutter",
        key: "design.cutter",
        form: Text("CUTTER"),
        unit: Unit::Millimetres,
        ranges: &[[1e-3, 100.0]],
        help: "Cutter whose work is proved too: ball:DIAMETER in mm; a sheet is shaped for it",
        more: "A ball leaves its radius in valleys and at the foot of walls. Facets stay as they are, and the report says \
               what becomes of their light; a sheet is shaped so that its light is right as the cutter leaves it.",
        remedy: "take a smaller cutter",
        at: |recipe| &mut recipe.design.sheet.cutter,
        ..DESIGN
    },
    Setting {
        name: "min-feature",
        key: "design.min-feature",
        ranges: &[[0.0, 100.0]],
        unset: "0",
        help: "Leave out details of a sheet narrower than this, mm",
        more: "A mirror of 0.1 mm spreads light by about 0.3°: detail that lives on smaller ones is lost to diffraction.",
        remedy: "lower --min-feature",
        at: |recipe| &mut recipe.design.sheet.min_feature,
        ..SHEET
    },
    Setting {
        name: "polish",
        before: Some("levelling"),
        key: "design.polish",
        ranges: &[[0.0, 100.0]],
        unset: "0",
        help: "Polish or paint after the cutter, as a Gaussian over the heights of this standard deviation, mm",
        more: "Both fill valleys and round ridges. The relief is shaped so that its light is right afterwards; with \
               --for-cutter the proof as milled counts it too. 0.02 mm blunts what is narrower than about 0.05 mm.",
        at: |recipe| &mut recipe.design.sheet.polish,
        ..SHEET
    },
    Setting {
        name: "max-depth",
        key: "design.max-depth",
        ranges: &[[1e-4, 1000.0]],
        help: "The most from the lowest to the highest point of a cell of a sheet about its mean plane, mm",
        more: "Shallow reliefs need many hills, and so valleys: light is less exact. A relief that stays too deep is \
               refused. Smaller cells (--cells) are shallower. The plate's mean slope tilts it on top of that.",
        remedy: "raise --max-depth",
        at: |recipe| &mut recipe.design.sheet.max_depth,
        ..SHEET
    },
    Setting {
        name: "sample",
        key: "design.sample",
        form: Words(
            "HOW",
            &[
                word("voronoi", "Centroidal cells of equal mass"),
                word("random", "Independent draws"),
                word("sobol", "A Sobol sequence"),
            ],
        ),
        unset: "voronoi",
        help: "How facets are drawn from the highlight",
        at: |recipe| &mut recipe.design.sample,
        ..FACETS
    },
    Setting {
        name: "arrange",
        key: "design.arrange",
        form: Words(
            "HOW",
            &[
                word("transport", "Optimal transport: a dome, no valleys"),
                word("anneal", "The 2009 paper's annealing"),
                word("random", "No order"),
            ],
        ),
        unset: "transport",
        help: "Which facet goes where",
        at: |recipe| &mut recipe.design.arrange,
        ..FACETS
    },
    Setting {
        name: "heights",
        key: "design.heights",
        form: Words(
            "HOW",
            &[
                word("free", "Smallest steps, edges free"),
                word("cyclic", "Smallest steps on a plate that continues into itself"),
                word("weyrich2009", "As printed in the 2009 paper"),
            ],
        ),
        unset: "free, cyclic with --arrange anneal",
        help: "How heights follow from slopes",
        at: |recipe| &mut recipe.design.heights,
        ..FACETS
    },
    Setting {
        name: "annealing",
        key: "design.annealing",
        help: "How facets are annealed, where it is not the usual way",
        at: |recipe| &mut recipe.design.annealing,
        ..FACETS
    },
    Setting {
        name: "level",
        key: "design.distribution.level",
        form: Switch,
        help: "Mount the plate tilted so that its mean slope is zero",
        more: "An off-centre highlight tilts the whole relief: a mean slope of 5° climbs 2.6 mm over 30 mm. Levelled, the \
               plate stays thin and is mounted at that angle instead, which the table and the report tell.",
        at: |recipe| &mut recipe.design.distribution.level,
        ..DESIGN
    },
    Setting {
        name: "slope-cap",
        key: "design.distribution.slope-cap",
        section: Section::Design,
        ranges: &[[0.1, 85.0]],
        help: "Steepest facet, degrees; light that needs steeper ones is cut",
        at: |recipe| &mut recipe.design.distribution.slope_cap,
        ..ANGLE
    },
];
