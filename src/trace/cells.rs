//! Which triangles a ray may meet, asked of a grid over x and y: each cell lists the triangles that reach over it.
//!
//! Plates are height fields, whoever wrote their triangles: over most places stands one triangle that faces up, and walls
//! are lines seen from above. A ray straight down then finds its triangle under its own cell, others walk from cell to
//! cell, and most that leave the surface are known to meet nothing more ([`horizon`]). Nothing is left to chance for other
//! triangles: all that reach over a cell stand in its list, so that a walk misses none; lists are only longer then.

use glam::{DVec2, DVec3};

use super::horizon::{Block, horizon};
use super::line::{areas_under, double};

/// Cells for each triangle, about.
const CELLS: f64 = 2.0;

/// Entries of all lists together, for each triangle, at the most; a wall from one side of a plate to the other is in many.
/// A height grid in right-angled triangles has 4.
const MOST_ENTRIES: usize = 24;

/// Mean length of a list, as its triangles see it, at the most: what is more crowded is served better by a tree.
const MOST_CROWDED: f64 = 64.0;

/// What cells are widened by, as a share of their side, so that rounding leaves no triangle out.
const SLACK: f64 = 1e-6;

/// A side of a block of cells whose horizon is known together.
const BLOCK: usize = 2;

/// A triangle as the grid wants to know it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// It faces up, and all its edges are shared with others that do.
    Inner,
    /// It faces up, and the surface may end or step at one of its corners.
    Rim,
    /// It is vertical.
    Wall,
}

/// What is known of one cell.
#[derive(Clone, Copy, Debug)]
struct Cell {
    /// Where its list begins; it ends where the next one begins.
    start: u32,
    /// No ray that stays above this, mm, meets anything of the list.
    high: f32,
    /// Over the cell stands one surface without steps.
    plain: bool,
}

/// A grid of lists.
#[derive(Clone, Debug)]
pub(super) struct Cells {
    columns: usize,
    rows: usize,
    low: DVec2,
    side: DVec2,
    density: DVec2,
    /// Row after row, and one more for the end of the last list.
    cells: Vec<Cell>,
    entries: Vec<u32>,
    /// Squares of the least climbs that escape, for each block of cells.
    horizon: Vec<f32>,
    highest: f64,
}

impl Cells {
    /// A grid over triangles in the box from `low` to `high`, and the triangles' numbers in the order in which they are
    /// named from then on. `None` if they stand so crowded, seen from above, that a tree serves better.
    pub fn new(triangles: &[[[f32; 3]; 3]], parts: &[Part], low: DVec3, high: DVec3) -> Option<(Self, Vec<u32>)> {
        let size = (high - low).truncate();
        let pitch = (size.element_product() / (CELLS * triangles.len() as f64)).sqrt();
        let fit = |length: f64| (length / pitch).ceil().clamp(1.0, (CELLS * triangles.len() as f64).ceil()) as usize;
        let (columns, rows) = (fit(size.x), fit(size.y));
        let side = size / DVec2::new(columns as f64, rows as f64);
        if !(side.is_finite() && side.min_element() > 0.0) || triangles.len() > MOST_TRIANGLES {
            return None;
        }
        let mut grid = Self {
            columns,
            rows,
            low: low.truncate(),
            side,
            density: 1.0 / side,
            cells: Vec::new(),
            entries: Vec::new(),
            horizon: Vec::new(),
            highest: high.z,
        };
        let pairs = grid.pairs(triangles)?;
        let order = grid.fill(pairs, triangles.len())?;
        grid.look_over(&order, triangles, parts);
        Some((grid, order))
    }

    /// The cells over which each triangle reaches, with its number; triangle after triangle.
    fn pairs(&self, triangles: &[[[f32; 3]; 3]]) -> Option<Vec<(u32, u32)>> {
        let most = MOST_ENTRIES * triangles.len() + self.columns + self.rows;
        let mut pairs = Vec::with_capacity(4 * triangles.len());
        for (k, corners) in triangles.iter().enumerate() {
            let at = corners.map(|[x, y, _]| (DVec2::new(f64::from(x), f64::from(y)) - self.low) * self.density);
            let (south, north) = (at[0].y.min(at[1].y).min(at[2].y), at[0].y.max(at[1].y).max(at[2].y));
            for row in index(south - SLACK, self.rows)..=index(north + SLACK, self.rows) {
                let (west, east) = width_within(&at, row as f64 - SLACK, (row + 1) as f64 + SLACK);
                for column in index(west - SLACK, self.columns)..=index(east + SLACK, self.columns) {
                    pairs.push(((row * self.columns + column) as u32, k as u32));
                }
            }
            if pairs.len() > most {
                return None;
            }
        }
        Some(pairs)
    }

    /// Makes the lists; the triangles in the order of the first cell of each, so that neighbours stand together.
    fn fill(&mut self, pairs: Vec<(u32, u32)>, triangles: usize) -> Option<Vec<u32>> {
        let count = self.columns * self.rows;
        let mut starts = vec![0u32; count + 2];
        pairs.iter().for_each(|(cell, _)| starts[*cell as usize + 2] += 1);
        let squares: f64 = starts.iter().map(|&length| f64::from(length).powi(2)).sum();
        if squares > MOST_CROWDED * pairs.len() as f64 {
            return None;
        }
        (1..starts.len()).for_each(|k| starts[k] += starts[k - 1]);
        self.entries = vec![0; pairs.len()];
        for (cell, k) in pairs {
            let place = &mut starts[cell as usize + 1];
            self.entries[*place as usize] = k;
            *place += 1;
        }
        let (mut order, mut names) = (Vec::with_capacity(triangles), vec![u32::MAX; triangles]);
        for entry in &mut self.entries {
            let name = &mut names[*entry as usize];
            if *name == u32::MAX {
                *name = order.len() as u32;
                order.push(*entry);
            }
            *entry = *name;
        }
        let cell = |&start: &u32| Cell { start, high: f32::NEG_INFINITY, plain: false };
        self.cells = starts[..=count].iter().map(cell).collect();
        Some(order)
    }

    /// Finds out how high each cell reaches, where one surface stands alone, and what escapes from there.
    fn look_over(&mut self, order: &[u32], triangles: &[[[f32; 3]; 3]], parts: &[Part]) {
        let wide = self.columns.div_ceil(BLOCK);
        let mut blocks = vec![Block::EMPTY; wide * self.rows.div_ceil(BLOCK)];
        let seen: Vec<Seen> = order.iter().map(|&k| Seen::new(&triangles[k as usize], parts[k as usize])).collect();
        let half = 0.5 * (1.0 + 2.0 * SLACK) * self.side;
        for cell in 0..self.columns * self.rows {
            let (i, j) = (cell % self.columns, cell / self.columns);
            let corner = self.low + DVec2::new(i as f64, j as f64) * self.side;
            let (middle, probe) = (corner + 0.5 * self.side, corner + PROBE * self.side);
            let mut block = Block::EMPTY;
            let mut over = 0;
            let list = self.cells[cell].start as usize..self.cells[cell + 1].start as usize;
            for &name in &self.entries[list] {
                let one = &seen[name as usize];
                block.join(&one.within(middle, half));
                let corners = &triangles[order[name as usize] as usize];
                over += usize::from(one.faces_up && areas_under(corners, probe.x, probe.y).min_element() >= 0.0);
            }
            self.cells[cell].high = block.high;
            self.cells[cell].plain = over == 1 && block.steepest < f32::INFINITY;
            if over != 1 && block.high > f32::NEG_INFINITY {
                block.steepest = f32::INFINITY;
            }
            blocks[j / BLOCK * wide + i / BLOCK].join(&block);
        }
        self.horizon = horizon(blocks, wide, (BLOCK as f64 * self.side).to_array());
        self.horizon.iter_mut().for_each(|climb| *climb *= *climb);
    }

    #[inline]
    fn cell(&self, x: f64, y: f64) -> (usize, usize) {
        let at = (DVec2::new(x, y) - self.low) * self.density;
        // A cast takes what is negative or no number to 0.
        ((at.x as usize).min(self.columns - 1), (at.y as usize).min(self.rows - 1))
    }

    #[inline]
    fn list(&self, cell: usize) -> &[u32] {
        &self.entries[self.cells[cell].start as usize..self.cells[cell + 1].start as usize]
    }

    /// The triangles over the cell of (x, y), if one surface without steps stands there alone.
    #[inline]
    pub fn plain(&self, x: f64, y: f64) -> Option<&[u32]> {
        let (i, j) = self.cell(x, y);
        let cell = j * self.columns + i;
        self.cells[cell].plain.then(|| self.list(cell))
    }

    /// Whether a ray from a point of the surface that faces up is known to meet nothing.
    #[inline]
    pub fn escapes(&self, from: DVec3, direction: DVec3) -> bool {
        let (i, j) = self.cell(from.x, from.y);
        let flat = direction.x * direction.x + direction.y * direction.y;
        let climb = f64::from(self.horizon[j / BLOCK * self.columns.div_ceil(BLOCK) + i / BLOCK]);
        // Not true for an infinite climb, whatever the way is.
        direction.z > 0.0 && direction.z * direction.z > climb * flat
    }

    /// Shows `test` all triangles near the ray, which starts over the grid, except those in cells beyond the distance that
    /// it returned last.
    pub fn walk(&self, origin: DVec3, direction: DVec3, mut test: impl FnMut(u32) -> f64) {
        let (mut i, mut j) = self.cell(origin.x, origin.y);
        let inverse = 1.0 / direction;
        let (east, north) = (usize::from(direction.x > 0.0), usize::from(direction.y > 0.0));
        let (mut entered, mut reach) = (0.0, f64::INFINITY);
        let mut z = origin.z;
        loop {
            let edge = self.low + DVec2::new((i + east) as f64, (j + north) as f64) * self.side;
            let to_x = if direction.x == 0.0 { f64::INFINITY } else { (edge.x - origin.x) * inverse.x };
            let to_y = if direction.y == 0.0 { f64::INFINITY } else { (edge.y - origin.y) * inverse.y };
            let left = to_x.min(to_y).max(entered);
            let next_z = if direction.z == 0.0 { origin.z } else { origin.z + left * direction.z };
            let cell = j * self.columns + i;
            if z.min(next_z) <= f64::from(self.cells[cell].high) {
                for &name in self.list(cell) {
                    reach = test(name);
                }
            }
            if reach <= left || (direction.z >= 0.0 && next_z > self.highest) {
                return;
            }
            if to_x <= to_y {
                i = if east == 1 { i + 1 } else { i.wrapping_sub(1) };
            } else {
                j = if north == 1 { j + 1 } else { j.wrapping_sub(1) };
            }
            if i >= self.columns || j >= self.rows || left == f64::INFINITY {
                return;
            }
            (entered, z) = (left, next_z);
        }
    }
}

/// More than these would overflow the numbers of entries.
const MOST_TRIANGLES: usize = 1 << 27;

/// Where a cell is asked how many triangles stand over it: not on the lines on which writers like to put edges.
const PROBE: DVec2 = DVec2::new(0.618_034, 0.414_214);

/// The whole number below `at`, as an index below `count`.
fn index(at: f64, count: usize) -> usize {
    (at.max(0.0) as usize).min(count - 1)
}

/// The least and the greatest x of a triangle between two heights of y.
fn width_within(at: &[DVec2; 3], south: f64, north: f64) -> (f64, f64) {
    let (mut west, mut east) = (f64::INFINITY, f64::NEG_INFINITY);
    for k in 0..3 {
        let (a, b) = (at[k], at[(k + 1) % 3]);
        let (a, b) = if a.y <= b.y { (a, b) } else { (b, a) };
        if b.y < south || a.y > north {
            continue;
        }
        let x_at = |y: f64| a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)).clamp(0.0, 1.0);
        let (from, to) = (if a.y < south { x_at(south) } else { a.x }, if b.y > north { x_at(north) } else { b.x });
        (west, east) = (west.min(from).min(to), east.max(from).max(to));
    }
    (west, east)
}

/// What the grid keeps of a triangle while it is made.
struct Seen {
    low: f64,
    high: f64,
    corner: DVec3,
    gradient: DVec2,
    steepest: f32,
    faces_up: bool,
}

impl Seen {
    fn new(corners: &[[f32; 3]; 3], part: Part) -> Self {
        let [a, b, c] = corners.map(double);
        let normal = (b - a).cross(c - a);
        let faces_up = part != Part::Wall;
        let gradient = if faces_up { -normal.truncate() / normal.z } else { DVec2::ZERO };
        let steepest = if part == Part::Inner { (gradient.length() as f32).next_up() } else { f32::INFINITY };
        let (low, high) = (a.z.min(b.z).min(c.z), a.z.max(b.z).max(c.z));
        Self { low, high, corner: a, gradient, steepest, faces_up }
    }

    /// What it is over a cell of this middle and half size.
    fn within(&self, middle: DVec2, half: DVec2) -> Block {
        let (mut low, mut high) = (self.low, self.high);
        if self.faces_up {
            let at = self.corner.z + self.gradient.dot(middle - self.corner.truncate());
            let reach = self.gradient.abs().dot(half);
            (low, high) = (low.max(at - reach), high.min(at + reach));
        }
        let low = if self.faces_up { (low as f32).next_down() } else { f32::INFINITY };
        Block { low, high: (high as f32).next_up(), steepest: self.steepest }
    }
}
