//! What stands over each rectangle of a grid: one plane, or two triangles between four nodes.

use glam::{DVec2, DVec3};

use crate::progress::{Cancelled, Progress};
use crate::relief::faceted::FacetedRelief;
use crate::relief::height_grid::HeightGrid;

use super::grid_lines::GridLines;

/// A ray's way over one cell: points `from + t direction` for t from `entered` to `left`, the first of them not below the
/// cell's surface.
#[derive(Clone, Copy, Debug)]
pub struct Stretch {
    /// Start of the ray, mm.
    pub from: DVec3,
    /// Its unit direction.
    pub direction: DVec3,
    /// Where it comes over the cell.
    pub entered: f64,
    /// Where it leaves it, at least `entered`.
    pub left: f64,
}

/// Planar pieces over the cells of a grid; cells are named by column and row.
pub trait HeightField: Sync {
    /// Pieces of equal footprint over each cell: 1 or 2.
    const PIECES: usize;

    /// Height over (x, y) in the cell (i, j), mm, and the piece that stands there.
    fn surface(&self, i: usize, j: usize, x: f64, y: f64) -> (f64, u8);

    /// Height over (x, y) in the cell (i, j), mm.
    #[inline]
    fn height(&self, i: usize, j: usize, x: f64, y: f64) -> f64 {
        self.surface(i, j, x, y).0
    }

    /// Where the stretch first meets the cell's surface, and which piece of it.
    fn meet(&self, i: usize, j: usize, stretch: Stretch) -> Option<(f64, u8)>;

    /// Whether a ray that is not below the cell's surface and goes along `direction` cannot meet it.
    fn clears(&self, i: usize, j: usize, direction: DVec3) -> bool;

    /// The piece over a point of the cell (i, j), told in shares of its width and depth from its lower left corner.
    fn piece(&self, i: usize, j: usize, share: DVec2) -> u8;

    /// Height over (x, y) of the plane of one piece, mm.
    fn height_of(&self, i: usize, j: usize, piece: u8, x: f64, y: f64) -> f64;

    /// Gradient (p, q) of a piece.
    fn gradient(&self, i: usize, j: usize, piece: u8) -> (f64, f64);

    /// The highest point over the cell.
    fn top(&self, i: usize, j: usize) -> f64;

    /// Memory, bytes.
    fn bytes(&self) -> usize;
}

/// One plane a cell: z = z0 + p x + q y.
#[derive(Clone, Debug)]
pub struct FacetPlanes {
    planes: Vec<Plane>,
    tops: Vec<f32>,
    columns: usize,
}

#[derive(Clone, Copy, Debug)]
struct Plane {
    z0: f64,
    p: f64,
    q: f64,
}

impl Plane {
    #[inline]
    fn height(self, x: f64, y: f64) -> f64 {
        self.z0 + self.p * x + self.q * y
    }

    #[inline]
    fn climb(self, d: DVec3) -> f64 {
        d.z - self.p * d.x - self.q * d.y
    }

    /// Where a ray falls below the plane before `left`, if it does.
    #[inline]
    fn meet(self, stretch: Stretch) -> Option<f64> {
        let Stretch { from, direction, entered, left } = stretch;
        let above = from.z - self.height(from.x, from.y);
        let climb = self.climb(direction);
        (climb < 0.0 && above + left * climb < 0.0).then(|| (-above / climb).clamp(entered, left))
    }
}

impl FacetPlanes {
    /// The facets of `relief`.
    pub fn new(relief: &FacetedRelief, progress: &Progress) -> Result<Self, Cancelled> {
        let columns = relief.columns();
        let plane = |i: usize, j: usize| {
            let (facet, middle) = (relief.facet(i, j), relief.middle(i, j));
            let (p, q) = (facet.slope.p, facet.slope.q);
            Plane { z0: facet.height - p * middle.x - q * middle.y, p, q }
        };
        let top = |i, j| relief.corner_heights(i, j).into_iter().fold(f64::NEG_INFINITY, f64::max);
        let (mut planes, mut tops) = (Vec::with_capacity(relief.facets.len()), Vec::with_capacity(relief.facets.len()));
        for j in 0..relief.rows() {
            progress.check()?;
            planes.extend((0..columns).map(|i| plane(i, j)));
            tops.extend((0..columns).map(|i| (top(i, j) as f32).next_up()));
        }
        Ok(Self { planes, tops, columns })
    }

    #[inline]
    fn plane(&self, i: usize, j: usize) -> Plane {
        self.planes[j * self.columns + i]
    }
}

impl HeightField for FacetPlanes {
    const PIECES: usize = 1;

    #[inline]
    fn surface(&self, i: usize, j: usize, x: f64, y: f64) -> (f64, u8) {
        (self.plane(i, j).height(x, y), 0)
    }

    #[inline]
    fn meet(&self, i: usize, j: usize, stretch: Stretch) -> Option<(f64, u8)> {
        self.plane(i, j).meet(stretch).map(|t| (t, 0))
    }

    #[inline]
    fn clears(&self, i: usize, j: usize, direction: DVec3) -> bool {
        self.plane(i, j).climb(direction) >= 0.0
    }

    #[inline]
    fn piece(&self, _i: usize, _j: usize, _share: DVec2) -> u8 {
        0
    }

    fn height_of(&self, i: usize, j: usize, _piece: u8, x: f64, y: f64) -> f64 {
        self.plane(i, j).height(x, y)
    }

    #[inline]
    fn gradient(&self, i: usize, j: usize, _piece: u8) -> (f64, f64) {
        let plane = self.plane(i, j);
        (plane.p, plane.q)
    }

    fn top(&self, i: usize, j: usize) -> f64 {
        f64::from(self.tops[j * self.columns + i])
    }

    fn bytes(&self) -> usize {
        size_of_val(self.planes.as_slice()) + size_of_val(self.tops.as_slice())
    }
}

/// Heights at the nodes of a grid; each square is two triangles, cut along either diagonal.
///
/// Piece 0 is the triangle below the cut, piece 1 the one above it.
#[derive(Clone, Debug)]
pub struct NodeTriangles {
    x: GridLines,
    y: GridLines,
    heights: Vec<f64>,
    /// Which squares are cut from lower left to upper right; a row of squares after the other.
    rising: Vec<bool>,
}

impl NodeTriangles {
    /// The triangles of `grid`.
    pub fn new(grid: &HeightGrid) -> Self {
        let HeightGrid { x, y, heights, rising } = grid;
        assert_eq!(heights.len(), x.len() * y.len(), "one height a node");
        assert_eq!(rising.len(), (x.len() - 1) * (y.len() - 1), "one cut a square");
        Self { x: GridLines::new(x), y: GridLines::new(y), heights: heights.clone(), rising: rising.clone() }
    }

    fn node(&self, i: usize, j: usize) -> f64 {
        self.heights[j * (self.x.intervals() + 1) + i]
    }

    fn rises(&self, i: usize, j: usize) -> bool {
        self.rising[j * self.x.intervals() + i]
    }

    #[inline]
    fn triangle(&self, i: usize, j: usize, piece: u8) -> Plane {
        // Its right angle is at the left below a cut that falls and above one that rises, else at the right.
        let (a, b) = (i + usize::from((piece == 1) != self.rises(i, j)), j + usize::from(piece));
        let (width, depth) = (self.x.at(i + 1) - self.x.at(i), self.y.at(j + 1) - self.y.at(j));
        let p = (self.node(i + 1, b) - self.node(i, b)) / width;
        let q = (self.node(a, j + 1) - self.node(a, j)) / depth;
        Plane { z0: self.node(a, b) - p * self.x.at(a) - q * self.y.at(b), p, q }
    }

    /// Where (x, y) lies in the square, as shares of its width and depth.
    #[inline]
    fn share(&self, i: usize, j: usize, x: f64, y: f64) -> DVec2 {
        let (x0, x1, y0, y1) = (self.x.at(i), self.x.at(i + 1), self.y.at(j), self.y.at(j + 1));
        DVec2::new((x - x0) / (x1 - x0), (y - y0) / (y1 - y0))
    }

    /// How far above the cut a point lies, from -1 at the right angle of piece 0 to 1 at that of piece 1.
    #[inline]
    fn above_cut(&self, i: usize, j: usize, share: DVec2) -> f64 {
        share.y - if self.rises(i, j) { share.x } else { 1.0 - share.x }
    }
}

impl HeightField for NodeTriangles {
    const PIECES: usize = 2;

    #[inline]
    fn surface(&self, i: usize, j: usize, x: f64, y: f64) -> (f64, u8) {
        let piece = self.piece(i, j, self.share(i, j, x, y));
        (self.triangle(i, j, piece).height(x, y), piece)
    }

    #[inline]
    fn meet(&self, i: usize, j: usize, stretch: Stretch) -> Option<(f64, u8)> {
        let Stretch { from, direction, entered, left } = stretch;
        let share = |t: f64| self.share(i, j, from.x + t * direction.x, from.y + t * direction.y);
        let side = |t: f64| self.above_cut(i, j, share(t));
        let s0 = side(entered);
        // A vertical ray never leaves and never crosses the cut.
        let s1 = if left.is_finite() { side(left) } else { s0 };
        let (first, second) = (u8::from(s0 > 0.0 || (s0 == 0.0 && s1 > 0.0)), u8::from(s1 > 0.0));
        let meet = |piece, entered, left| {
            let t = self.triangle(i, j, piece).meet(Stretch { entered, left, ..stretch })?;
            Some((t, piece))
        };
        if first == second {
            return meet(first, entered, left);
        }
        let cut = (entered + (left - entered) * s0 / (s0 - s1)).clamp(entered, left);
        meet(first, entered, cut).or_else(|| meet(second, cut, left))
    }

    #[inline]
    fn clears(&self, i: usize, j: usize, direction: DVec3) -> bool {
        [0, 1].into_iter().all(|piece| self.triangle(i, j, piece).climb(direction) >= 0.0)
    }

    #[inline]
    fn piece(&self, i: usize, j: usize, share: DVec2) -> u8 {
        u8::from(self.above_cut(i, j, share) > 0.0)
    }

    #[inline]
    fn height_of(&self, i: usize, j: usize, piece: u8, x: f64, y: f64) -> f64 {
        self.triangle(i, j, piece).height(x, y)
    }

    #[inline]
    fn gradient(&self, i: usize, j: usize, piece: u8) -> (f64, f64) {
        let plane = self.triangle(i, j, piece);
        (plane.p, plane.q)
    }

    fn top(&self, i: usize, j: usize) -> f64 {
        let corners = [(0, 0), (1, 0), (0, 1), (1, 1)];
        corners.into_iter().map(|(a, b)| self.node(i + a, j + b)).fold(f64::NEG_INFINITY, f64::max)
    }

    fn bytes(&self) -> usize {
        let squares = size_of_val(self.heights.as_slice()) + size_of_val(self.rising.as_slice());
        squares + self.x.bytes() + self.y.bytes()
    }
}
