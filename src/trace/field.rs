//! What stands over each rectangle of a grid: one plane, or two triangles between four nodes.

use glam::DVec3;

use crate::relief::faceted::FacetedRelief;
use crate::relief::heights::HeightGrid;

use super::lines::Lines;

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
pub trait Field: Sync {
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
pub struct Planes {
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

impl Planes {
    /// The facets of `relief`.
    pub fn new(relief: &FacetedRelief) -> Self {
        let columns = relief.columns();
        let cells = || (0..relief.facets.len()).map(|k| (k % columns, k / columns));
        let plane = |(i, j): (usize, usize)| {
            let (facet, middle) = (relief.facet(i, j), relief.middle(i, j));
            let (p, q) = (facet.slope.p, facet.slope.q);
            Plane { z0: facet.height - p * middle.x - q * middle.y, p, q }
        };
        let top = |(i, j)| relief.corner_heights(i, j).into_iter().fold(f64::NEG_INFINITY, f64::max);
        Self {
            planes: cells().map(plane).collect(),
            tops: cells().map(|cell| (top(cell) as f32).next_up()).collect(),
            columns,
        }
    }

    #[inline]
    fn plane(&self, i: usize, j: usize) -> Plane {
        self.planes[j * self.columns + i]
    }
}

impl Field for Planes {
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

/// Heights at the nodes of a grid; each square is two triangles, cut from its lower right to its upper left corner.
///
/// Piece 0 is the triangle at the lower left, piece 1 the one at the upper right.
#[derive(Clone, Debug)]
pub struct Nodes {
    x: Lines,
    y: Lines,
    heights: Vec<f64>,
}

impl Nodes {
    /// The triangles of `grid`.
    pub fn new(grid: &HeightGrid) -> Self {
        assert_eq!(grid.heights.len(), grid.x.len() * grid.y.len(), "one height a node");
        Self { x: Lines::new(&grid.x), y: Lines::new(&grid.y), heights: grid.heights.clone() }
    }

    fn node(&self, i: usize, j: usize) -> f64 {
        self.heights[j * (self.x.intervals() + 1) + i]
    }

    fn triangle(&self, i: usize, j: usize, piece: u8) -> Plane {
        // The corner at the right angle is (i, j) below and (i + 1, j + 1) above.
        let k = usize::from(piece);
        let (x, y) = (self.x.at(i + k), self.y.at(j + k));
        let (width, depth) = (self.x.at(i + 1) - self.x.at(i), self.y.at(j + 1) - self.y.at(j));
        let p = (self.node(i + 1, j + k) - self.node(i, j + k)) / width;
        let q = (self.node(i + k, j + 1) - self.node(i + k, j)) / depth;
        Plane { z0: self.node(i + k, j + k) - p * x - q * y, p, q }
    }

    /// How far beyond the cut a point lies, from -1 at the lower left corner to 1 at the upper right one.
    fn beyond_cut(&self, i: usize, j: usize, x: f64, y: f64) -> f64 {
        let (x0, x1, y0, y1) = (self.x.at(i), self.x.at(i + 1), self.y.at(j), self.y.at(j + 1));
        (x - x0) / (x1 - x0) + (y - y0) / (y1 - y0) - 1.0
    }
}

impl Field for Nodes {
    const PIECES: usize = 2;

    fn surface(&self, i: usize, j: usize, x: f64, y: f64) -> (f64, u8) {
        let piece = u8::from(self.beyond_cut(i, j, x, y) > 0.0);
        (self.triangle(i, j, piece).height(x, y), piece)
    }

    fn meet(&self, i: usize, j: usize, stretch: Stretch) -> Option<(f64, u8)> {
        let Stretch { from, direction, entered, left } = stretch;
        let side = |t: f64| self.beyond_cut(i, j, from.x + t * direction.x, from.y + t * direction.y);
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

    fn clears(&self, i: usize, j: usize, direction: DVec3) -> bool {
        [0, 1].into_iter().all(|piece| self.triangle(i, j, piece).climb(direction) >= 0.0)
    }

    fn height_of(&self, i: usize, j: usize, piece: u8, x: f64, y: f64) -> f64 {
        self.triangle(i, j, piece).height(x, y)
    }

    fn gradient(&self, i: usize, j: usize, piece: u8) -> (f64, f64) {
        let plane = self.triangle(i, j, piece);
        (plane.p, plane.q)
    }

    fn top(&self, i: usize, j: usize) -> f64 {
        let corners = [(0, 0), (1, 0), (0, 1), (1, 1)];
        corners.into_iter().map(|(a, b)| self.node(i + a, j + b)).fold(f64::NEG_INFINITY, f64::max)
    }

    fn bytes(&self) -> usize {
        size_of_val(self.heights.as_slice()) + self.x.bytes() + self.y.bytes()
    }
}
