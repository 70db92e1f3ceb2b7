//! Why a recipe cannot be followed, in one sentence with what would do.

use super::files::MOST_STEP_FACETS;
use super::settings::LEAST_GRID;
use super::{Format, HalfField, SceneFault, SurfaceKind};
use crate::cutter::UnmodelledCutter;
use crate::milling::made::MachiningError;

/// Why a recipe cannot be followed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RecipeError {
    /// Not TOML, or not of this program: what, and on which line.
    #[error("line {1} makes no sense: {0}")]
    Unreadable(String, usize),
    /// A number outside what is possible.
    #[error("{setting} is {value}: it must be from {low} to {high}")]
    OutOfRange {
        /// Name of the setting, as in the flag.
        setting: &'static str,
        /// What was asked.
        value: f64,
        /// Least possible.
        low: f64,
        /// Most possible.
        high: f64,
    },
    /// A picture that is too long for the square that it is counted in.
    #[error("half-field is {field}: the picture may be at most ten times as long one way as the other")]
    LongField {
        /// What was asked, degrees.
        field: HalfField,
    },
    /// Lamp and wall nearby that make no scene.
    #[error(transparent)]
    Scene(#[from] SceneFault),
    /// A setting of one kind of relief beside one of the other.
    #[error("{setting} is for {}: leave out one of the two", other_kind(*kind, decisive))]
    OtherKind {
        /// Name of the setting without meaning, as in the flag.
        setting: &'static str,
        /// Name of the setting that decided for the other kind.
        decisive: &'static str,
        /// The kind of the relief.
        kind: SurfaceKind,
    },
    /// A setting of making without a machine.
    #[error("{setting} is for a plate that a machine makes: name one with --machine, or leave it out")]
    NoMachine {
        /// Name of the setting, as in the flag.
        setting: &'static str,
    },
    /// A machine that is none.
    #[error("machine: {0}")]
    Machine(String),
    /// A machine without a cutter.
    #[error("machine: say what it cuts with, such as --for-cutter ball:0.5 (--cutter of a plate that is there)")]
    NoCutter,
    /// A worn cutter of which it is not known how it wears.
    #[error(
        "worn: how the cutter wears is not known: name one of the library, such as ball-0.5, or give the radius of its flat as tip-flat of a machine file"
    )]
    NoWear,
    /// A preview of what has none.
    #[error("preview is of a sheet for a lamp and a wall far away, by no machine: leave out {with}, or preview")]
    NoPreview {
        /// What it does not go with, as in the flag.
        with: &'static str,
    },
    /// A surface that is too fine for a file.
    #[error("as-made-stl is for a plate that is polished: give --polish too, or leave it out")]
    NoPolish,
    /// A proof that there is not.
    #[error(
        "machine: the proof as made in a room is of a polished plate: give --polish too, or leave out the flags of lamp and wall nearby"
    )]
    BareNearby,
    /// What the machine cannot make.
    #[error(transparent)]
    Machining(#[from] MachiningError),
    /// A format that the library was built without.
    #[error("also: {format} needs the feature `meshes`, which this program was built without: leave it out")]
    FormatLeftOut {
        /// The format.
        format: Format,
    },
    /// A format of planar faces for what has none.
    #[error(
        "also: step holds planar faces, and this plate is a sheet of very many triangles: take 3mf in its place, or flat \
         facets (--surface facets)"
    )]
    StepOfSheet,
    /// More faces than CAD programs take.
    #[error(
        "also: {columns}x{rows} facets are more than the {most} that are written as step: take 3mf in its place, or fewer \
         --facets",
        most = MOST_STEP_FACETS
    )]
    StepTooLarge {
        /// Facets along x.
        columns: usize,
        /// Facets along y.
        rows: usize,
    },
    /// A finish of a rim that is not there.
    #[error("border-finish is for a plate with a rim: give --border too, or leave it out")]
    NoBorder,
    /// A setting of patches without a portrait.
    #[error(
        "{setting} is for a plate of patches: name what it shall show with --portrait PICTURE or --gloss MAP, or leave it out"
    )]
    NoPatches {
        /// Name of the setting, as in the flag.
        setting: &'static str,
    },
    /// A setting of other plates beside a portrait.
    #[error("{setting} is not for a plate of patches: leave it out, or --portrait and the maps")]
    NotOfPatches {
        /// Name of the setting, as in the flag.
        setting: &'static str,
    },
    /// Both ways of asking for patches.
    #[error("portrait is the picture that becomes maps: leave it out, or --gloss, --normal, --anisotropy and --albedo")]
    PortraitAndMaps,
    /// Patches of a few wavelengths or features.
    #[error(
        "patches would be {side:.3} mm wide, and must be at least {least:.3} mm: take at most --patches {}x{}, or a larger --size",
        most[0],
        most[1]
    )]
    SmallPatches {
        /// Their shorter side, mm.
        side: f64,
        /// The shortest that can be, mm.
        least: f64,
        /// Patches along x and y at the most.
        most: [usize; 2],
    },
    /// Patches twice as long as wide.
    #[error("patches would be {across:.3} mm by {up:.3} mm: choose --patches in proportion to --size")]
    LongPatches {
        /// Along x, mm.
        across: f64,
        /// Along y, mm.
        up: f64,
    },
    /// Too coarse, odd or too many nodes.
    #[error(
        "a patch of {nodes} nodes a side cannot be made: it needs an even number of 12 or more within the budget; choose --grid so, take fewer --patches, or raise --max-triangles"
    )]
    PatchNodes {
        /// Nodes along a side of a patch.
        nodes: usize,
    },
    /// Spare light where the viewer is, or too far away.
    #[error(
        "spare light cannot go there: choose --spare more than four times --patch-lobe away from where a flat plate mirrors the lamp, and at most 50 degrees away"
    )]
    Spare,
    /// Facets do not divide into cells.
    #[error(
        "{columns}x{rows} facets do not divide into {}x{} cells: take --facets {near_columns}x{near_rows}, or other --cells",
        cells[0],
        cells[1]
    )]
    Indivisible {
        /// Facets along x.
        columns: usize,
        /// Facets along y.
        rows: usize,
        /// Cells along x and y.
        cells: [usize; 2],
        /// The nearest number along x that divides.
        near_columns: usize,
        /// The nearest number along y that divides.
        near_rows: usize,
    },
    /// More than fits.
    #[error("{columns}x{rows} facets are more than the 4 million that one plate can have: take fewer --facets")]
    TooManyFacets {
        /// Facets along x.
        columns: usize,
        /// Facets along y.
        rows: usize,
    },
    /// Facets twenty times as long as wide.
    #[error("facets would be {across:.3} mm by {up:.3} mm: choose --facets in proportion to --size")]
    Slivers {
        /// Facet size along x, mm.
        across: f64,
        /// Facet size along y, mm.
        up: f64,
    },
    /// The transforms want pairs of nodes.
    #[error("a grid of {grid} nodes is odd: take --grid {}", grid + 1)]
    OddGrid {
        /// Nodes a side.
        grid: usize,
    },
    /// Cells four times as long as wide.
    #[error(
        "cells would be {across:.3} mm by {up:.3} mm: leave out --cells, choose a --size whose sides differ by less than four times, or take flat facets (--facets)"
    )]
    LongCells {
        /// Cell size along x, mm.
        across: f64,
        /// Cell size along y, mm.
        up: f64,
    },
    /// Over the budget.
    #[error("the grid needs {triangles:.0} triangles, over the budget: {}, or raise --max-triangles", fewer(*most))]
    TooManyTriangles {
        /// Triangles on the plate.
        triangles: f64,
        /// The largest grid within the budget.
        most: usize,
    },
    /// A cutter that sheets cannot be designed for.
    #[error(transparent)]
    UnmodelledCutter(#[from] UnmodelledCutter),
    /// A ball wider than what it shall cut.
    #[error("a cutter of {diameter} mm cannot cut cells of {cell:.3} mm: take a smaller cutter or fewer --cells")]
    CutterBeyondCell {
        /// Its diameter, mm.
        diameter: f64,
        /// Shorter side of a cell, mm.
        cell: f64,
    },
    /// A cutter too small to follow over a plate.
    #[error(
        "a cutter of {diameter} mm is too small to be followed over the whole plate: name one of {least} mm or more in --for-cutter, take a smaller --size, or leave the cutter out"
    )]
    CutterTooFine {
        /// Its diameter, mm.
        diameter: f64,
        /// The smallest that can be, mm.
        least: f64,
    },
    /// A cutter that takes thousands of facets to pass over.
    #[error(
        "a cutter of {diameter} mm is too wide to be followed over facets of {pitch:.4} mm: take a smaller cutter in --for-cutter or fewer --facets"
    )]
    CutterTooWide {
        /// Its diameter, mm.
        diameter: f64,
        /// Shorter side of a facet, mm.
        pitch: f64,
    },
    /// A cutter that does not reach to the bottom of the relief.
    #[error(
        "the relief is {depth:.3} mm deep about its mean plane, and the cutter reaches {flutes} mm: name one that reaches deeper (facetmill cutters lists them, --flutes says it of others), or make the relief shallower with more --cells or --patches or a smaller --size"
    )]
    BeyondFlutes {
        /// From the relief's lowest to its highest point about its mean plane, mm.
        depth: f64,
        /// How deep the cutter can go, mm.
        flutes: f64,
    },
    /// Polish that leaves nothing.
    #[error(
        "a polish of {polish} mm leaves nothing of cells of {cell:.3} mm: it must be less than a quarter of them, take a smaller --polish or fewer --cells"
    )]
    PolishBeyondCell {
        /// Standard deviation, mm.
        polish: f64,
        /// Shorter side of a cell, mm.
        cell: f64,
    },
}

fn fewer(most: usize) -> String {
    if most < LEAST_GRID { "take fewer --cells".into() } else { format!("lower --grid to {most}") }
}

fn other_kind(kind: SurfaceKind, decisive: &str) -> String {
    match kind {
        SurfaceKind::Facets => format!("a sheet, and --{decisive} makes this plate one of flat facets"),
        SurfaceKind::Sheet => format!("flat facets, and --{decisive} makes this plate a sheet"),
    }
}

impl RecipeError {
    /// Whether the settings are sound one by one but no plate can have them together.
    pub fn is_impossible(&self) -> bool {
        match self {
            Self::Unreadable(..) | Self::OutOfRange { .. } | Self::OtherKind { .. } | Self::NoBorder => false,
            Self::NoPatches { .. } | Self::NotOfPatches { .. } | Self::PortraitAndMaps => false,
            Self::NoMachine { .. }
            | Self::NoPreview { .. }
            | Self::Machine(_)
            | Self::NoCutter
            | Self::NoWear
            | Self::NoPolish
            | Self::BareNearby => false,
            Self::Scene(fault) => fault.is_impossible(),
            _ => true,
        }
    }
}
