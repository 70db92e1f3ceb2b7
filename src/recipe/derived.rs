//! What follows from a recipe: what was not given, and what each stage asks for.

use super::file_size::FileSize;
use super::{
    Arrangement, BorderFinish, DesignSettings, Heights, HighlightSettings, LightSettings, PlateSettings, Recipe, Seen,
    SurfaceKind,
};
use crate::brdf::material::{Material, Substance};
use crate::brdf::microfacet::Lobe;
use crate::facets::arrange::anneal::Annealing;
use crate::facets::sample::Sampling;
use crate::picture::Reading;
use crate::relief::rim::Rim;
use crate::sculpt::plan::{PREVIEW_NODES, SheetSpec, suitable_grid};
use crate::setup::Setup;
use crate::sharpen::BlurKernel;
use crate::verify::experiment::Measuring;

/// How far a rim throws its light past the picture, degrees, lamp and metal's lobe aside: twice the blur at which pictures
/// are compared, so that nothing of it shows at their rim.
const PAST_IMAGE: f64 = 2.0;

/// Triangles of a sheet's upper side where nothing was asked: an STL of 150 MB, if it is not thinned.
const USUAL: f64 = 3e6;

impl Recipe {
    /// Facets along x and y: as asked, or 30 each way.
    pub fn facets(&self) -> [usize; 2] {
        self.plate.facets.unwrap_or([30, 30])
    }

    /// How facets are drawn.
    pub fn sampling(&self) -> Sampling {
        self.design.sample.unwrap_or_default()
    }

    /// Which facet goes where.
    pub fn arrangement(&self) -> Arrangement {
        self.design.arrange.unwrap_or_default()
    }

    /// How facets are annealed, where they are.
    pub fn annealing(&self) -> Annealing {
        self.design.annealing.unwrap_or_default()
    }

    /// Triangles of the file of a sheet whose cells have `grid` nodes a side, or a few more.
    pub(crate) fn triangles(&self, grid: usize) -> f64 {
        self.file_triangles(self.cells().map(|cells| cells * grid))
    }

    /// Triangles of the file of a sheet of `squares` along x and y, or a few more.
    pub(crate) fn file_triangles(&self, squares: [usize; 2]) -> f64 {
        let [columns, rows] = squares.map(|n| n as f64);
        // The sides and the base have three for each edge around the plate; a rim has four more.
        let around = 2.0 * (columns + rows);
        2.0 * columns * rows + around * if self.plate.border > 0.0 { 7.0 } else { 3.0 }
    }

    /// Those of its upper side.
    pub(crate) fn surface_triangles(&self, grid: usize) -> f64 {
        2.0 * self.cells().map(|cells| (cells * grid) as f64).iter().product::<f64>()
    }

    /// Whether a sheet of `grid` nodes a side of a cell has no more triangles than it may, before it is thinned. Where nothing
    /// was asked, only those of its upper surface count.
    pub(crate) fn fits_the_file(&self, grid: usize) -> bool {
        match (self.file_size(), self.plate.max_triangles) {
            (FileSize::AtMost(most), _) => self.fits_before_thinning(grid, most),
            (_, Some(most)) => self.triangles(grid) <= most as f64,
            (_, None) => self.surface_triangles(grid) <= USUAL,
        }
    }

    fn fits_before_thinning(&self, grid: usize, most: usize) -> bool {
        self.triangles(grid) <= USUAL.max(most as f64)
    }

    /// Nodes along a side of a cell, where a file of `most` triangles is thinned from them.
    pub(super) fn usual_grid(&self, most: usize) -> usize {
        suitable_grid(self.cell(), self.design.sheet.cutter, |grid| self.fits_before_thinning(grid, most))
    }

    fn cell(&self) -> glam::DVec2 {
        glam::DVec2::from(self.plate.size) / glam::DVec2::from(self.cells().map(|n| n as f64))
    }

    /// How heights are found: as asked, or cyclic where the arrangement is cyclic.
    pub fn heights(&self) -> Heights {
        self.design.heights.unwrap_or(match self.arrangement() {
            Arrangement::Anneal => Heights::Cyclic,
            Arrangement::Transport | Arrangement::Random => Heights::Free,
        })
    }

    /// How finely light is sent over its plate.
    pub fn measuring(&self) -> Measuring {
        Measuring { rays: self.verify.rays, seed: self.design.seed, ..Measuring::default() }
    }

    /// Cells along x and y: as asked; else one dome of facets, and about nine cells of a sheet, as square as
    /// the plate lets them be.
    pub fn cells(&self) -> [usize; 2] {
        let usual = || match self.surface() {
            SurfaceKind::Facets => [1, 1],
            SurfaceKind::Sheet => {
                let [x, y] = self.plate.size;
                let side = (x * y / 9.0).sqrt().min(x).min(y);
                [x, y].map(|length| (length / side).round() as usize)
            }
        };
        self.plate.cells.map_or_else(usual, |cells| cells.0)
    }

    /// What a sheet of this recipe shall be.
    pub fn sculpting(&self) -> SheetSpec {
        let PlateSettings { grid, .. } = self.plate;
        let (cells, cell) = (self.cells(), self.cell());
        let DesignSettings { sheet: settings, seed, .. } = self.design;
        if settings.preview {
            return SheetSpec { cell, cells, grid: grid.unwrap_or(PREVIEW_NODES), seed, settings };
        }
        let suitable = || suitable_grid(cell, settings.cutter, |grid| self.fits_the_file(grid));
        SheetSpec { cell, cells, grid: grid.unwrap_or_else(suitable), seed, settings }
    }

    /// How the picture file is to be read.
    pub fn reading(&self) -> Reading {
        let HighlightSettings { encoding, invert, rotate, fit, seen, half_field, projection, .. } = self.highlight;
        Reading { encoding, invert, rotate, fit, aspect: half_field.aspect(projection), mirrored: seen == Seen::OnWall }
    }

    /// From the eye to a wall nearby, mm: as asked, or 3 m.
    pub fn eye_distance(&self) -> f64 {
        self.verify.eye_distance.unwrap_or(3000.0)
    }

    /// How the rim is finished: as asked, or left dull.
    pub fn border_finish(&self) -> BorderFinish {
        self.plate.border_finish.unwrap_or_default()
    }

    /// The rim of the plate, as it lies in `setup`.
    pub fn rim(&self, setup: &Setup) -> Rim {
        let width = self.plate.border;
        match self.border_finish() {
            BorderFinish::Matt | BorderFinish::Polished => width.into(),
            BorderFinish::Sloped(Some(degrees)) => Rim { width, fall: degrees.to_radians().tan() },
            BorderFinish::Sloped(None) => {
                // All but a thousandth of a Gaussian lobe lies within three and a half of its standard deviations.
                let blur = setup.light_radius() + 3.5 * self.plate.lobe.to_radians();
                Rim::past_image(setup, width, PAST_IMAGE.to_radians() + blur)
            }
        }
    }

    /// Light, image and a plate lying flat; of lamp and wall nearby what the plate's middle sees of them.
    pub fn setup(&self) -> Setup {
        let near = self.scene().ok().flatten();
        if let Some(setup) = near.as_ref().and_then(Setup::from_middle) {
            return setup;
        }
        let LightSettings { theta, phi, radius } = self.light;
        let HighlightSettings { projection, half_field, .. } = self.highlight;
        let [theta, phi, radius, half_field] = [theta, phi, radius, half_field.reach()].map(f64::to_radians);
        Setup::new(theta, phi, radius, projection, half_field)
    }

    /// What the lamp of `setup` and the plate's metal blur, if they do.
    pub fn blur(&self, setup: &Setup) -> Option<BlurKernel> {
        BlurKernel::new(setup, self.plate.lobe.to_radians())
    }

    /// What the plate is made of: a mirror that takes no light, with Gaussian microscopic slopes if it has a lobe.
    ///
    /// A tilt by t throws light 2t aside, so that their standard deviation is half the lobe's, and Beckmann's α is √2
    /// times that. Below [`Lobe::ALPHA`](crate::brdf::microfacet::Lobe::ALPHA), about 0.08°, it is smooth.
    pub fn metal(&self) -> Material {
        Material::new(Substance::Mirror, self.metal_lobe()).unwrap_or_default()
    }

    /// Its microscopic slopes, if it is not smooth.
    pub(crate) fn metal_lobe(&self) -> Option<Lobe> {
        let slope = self.normal_spread();
        Lobe::beckmann_of_rms(slope, slope).ok()
    }

    /// Standard deviation of the metal's normals along each axis, radians: half of what they throw light aside.
    pub fn normal_spread(&self) -> f64 {
        0.5 * self.plate.lobe.to_radians()
    }

    /// Size of a facet, mm.
    pub fn pitch(&self) -> glam::DVec2 {
        let (size, facets) = (self.plate.size, self.facets());
        glam::DVec2::new(size[0] / facets[0] as f64, size[1] / facets[1] as f64)
    }
}
