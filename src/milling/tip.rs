//! How low a cutter can stand over triangles: its tip's height at a place when it rests on them.
//!
//! Over one triangle the height of its plane less the underside of a (convex) cutter is a concave function of the place. So
//! a cutter that rests on the triangle touches it either where its underside is as steep as the plane, if that place lies
//! in the triangle, or on an edge beyond which it lies. Heights are not rounded to a grid: the answer is that of the
//! triangles as they stand in the file.
//!
//! Most triangles are never looked at: blocks of them, and blocks of blocks, each lie below a plane and within a box, over
//! both of which the tip stands no lower than over the triangles themselves.

mod blocks;

use glam::{DVec2, DVec3};

use crate::cutter::Profile;
use crate::relief::mesh::Mesh;
use blocks::{Block, Level, Plane, SIDE};

/// Triangles in a block. Of 2, 4, 8, 16 and 32, 2 and 4 were fastest over the default sheet, 16 took 2.3 times as long.
const IN_BLOCK: f64 = 4.0;

/// Triangles that face up, sorted for the question how low a cutter can stand at a place.
pub struct TipHeights {
    profile: Profile,
    /// Half of the underside's least curvature, 1/mm.
    bend: f64,
    /// Square of the reach, mm².
    reach2: f64,
    low: DVec2,
    /// Blocks per mm.
    per_mm: f64,
    /// From the blocks of triangles up to one that holds all.
    levels: Vec<Level>,
    /// Where each block's triangles begin.
    starts: Vec<u32>,
    faces: Vec<Face>,
}

/// A triangle that faces up.
struct Face {
    corners: [[f32; 3]; 3],
    /// Where the tip stands that touches its plane.
    tips: Plane,
    /// Where the tip stands, in the plane of the plate, that touches the triangle's middle, mm.
    middle: DVec2,
    /// From its middle to its farthest corner, mm.
    radius: f64,
    /// From the tip to where it touches the plane, mm.
    touch: DVec2,
}

impl Face {
    /// A wall has none: its edges belong to the triangles beside it as well.
    fn new(corners: [[f32; 3]; 3], profile: &Profile) -> Option<Self> {
        let [a, b, c] = corners.map(wide);
        let normal = (b - a).cross(c - a);
        (normal.z > 1e-9 * normal.length()).then(|| {
            let slope = -normal.truncate() / normal.z;
            let touch = profile.touch(slope);
            let tips = Plane::through(a, slope).raised(profile.lift(slope.length()));
            let middle = (a + b + c).truncate() / 3.0;
            let radius = [a, b, c].iter().map(|v| v.truncate().distance(middle)).fold(0.0, f64::max);
            Self { corners, tips, middle: middle - touch, radius, touch }
        })
    }

    /// Its middle, mm.
    fn centre(&self) -> DVec2 {
        self.middle + self.touch
    }

    /// Its slope.
    fn slope(&self) -> DVec2 {
        self.tips.slope
    }

    fn points(&self) -> impl Iterator<Item = DVec3> + Clone + use<> {
        self.corners.map(wide).into_iter()
    }
}

fn wide(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

impl TipHeights {
    /// The triangles of `mesh` that face up, for a cutter of `profile`.
    pub fn new(mesh: &Mesh, profile: Profile) -> Self {
        let corners = |t: &[u32; 3]| t.map(|v| mesh.vertices[v as usize]);
        let faces: Vec<Face> = mesh.triangles.iter().filter_map(|t| Face::new(corners(t), &profile)).collect();
        let (low, high) = faces.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), face| {
            (low.min(face.centre()), high.max(face.centre()))
        });
        let size = (high - low).max(DVec2::ZERO);
        let wanted = (IN_BLOCK * size.x * size.y / faces.len().max(1) as f64).sqrt();
        // No more blocks than triangles, even if these stand in a row.
        let side = wanted.max(size.max_element() / faces.len().max(1) as f64).max(1e-9);
        let per_mm = side.recip();
        let [columns, rows] = [size.x, size.y].map(|s| if s > 0.0 { (s * per_mm) as usize + 1 } else { 1 });
        let reach2 = profile.reach * profile.reach * (1.0 + 1e-12);
        let mut this = Self {
            profile,
            bend: 0.5 * profile.least_curvature(),
            reach2,
            low,
            per_mm,
            levels: Vec::new(),
            starts: Vec::new(),
            faces: Vec::new(),
        };
        if !faces.is_empty() {
            this.sort(faces, columns, rows);
        }
        this
    }

    fn sort(&mut self, faces: Vec<Face>, columns: usize, rows: usize) {
        let block_of = |face: &Face| {
            let place = (face.centre() - self.low) * self.per_mm;
            ((place.y as usize).min(rows - 1) * columns + (place.x as usize).min(columns - 1)) as u32
        };
        let mut keyed: Vec<(u32, Face)> = faces.into_iter().map(|face| (block_of(&face), face)).collect();
        keyed.sort_by_key(|(block, _)| *block);
        self.starts =
            (0..=(columns * rows) as u32).map(|block| keyed.partition_point(|(b, _)| *b < block) as u32).collect();
        self.faces = keyed.into_iter().map(|(_, face)| face).collect();
        let blocks = (0..columns * rows).map(|b| {
            let own = &self.faces[self.starts[b] as usize..self.starts[b + 1] as usize];
            let slope = own.iter().map(Face::slope).sum::<DVec2>() / own.len().max(1) as f64;
            Block::around(own.iter().flat_map(Face::points), slope, &self.profile)
        });
        self.levels.push(Level { columns, rows, blocks: blocks.collect() });
        while let Some(level) = self.levels.last().filter(|level| level.blocks.len() > 1) {
            let next = level.merged(&self.profile);
            self.levels.push(next);
        }
    }

    /// The curve of the cutter's underside.
    pub fn profile(&self) -> &Profile {
        &self.profile
    }

    /// Height of the tip at `at` (mm, in the mesh's frame) when the cutter rests on the triangles, mm; -∞ where it meets
    /// none.
    pub fn at(&self, at: DVec2) -> f64 {
        let mut best = f64::NEG_INFINITY;
        let Some(Level { columns, rows, blocks }) = self.levels.first() else { return best };
        // A first guess, so that bounds have something to be below: the block that is touched if it is as steep as the
        // one under the tip.
        let under = |place: DVec2| {
            let place = ((place - self.low) * self.per_mm).max(DVec2::ZERO);
            (place.y as usize).min(rows - 1) * columns + (place.x as usize).min(columns - 1)
        };
        let first = under(at + blocks[under(at)].touch());
        self.rest_on_block(first, at, &mut best);
        self.descend(self.levels.len() - 1, [0, 0], at, first, &mut best);
        best
    }

    fn descend(&self, level: usize, [i, j]: [usize; 2], at: DVec2, done: usize, best: &mut f64) {
        let Level { columns, rows, blocks } = &self.levels[level];
        for row in j..(j + SIDE).min(*rows) {
            for column in i..(i + SIDE).min(*columns) {
                let k = row * columns + column;
                if blocks[k].cannot_carry(at, *best, &self.profile, [self.bend, self.reach2]) {
                    continue;
                }
                if level > 0 {
                    self.descend(level - 1, [SIDE * column, SIDE * row], at, done, best);
                } else if k != done {
                    self.rest_on_block(k, at, best);
                }
            }
        }
    }

    fn rest_on_block(&self, block: usize, at: DVec2, best: &mut f64) {
        for face in &self.faces[self.starts[block] as usize..self.starts[block + 1] as usize] {
            let over = face.tips.at(at) - *best;
            if over > 0.0 {
                // Beside the place that touches its plane the tip stands lower, by the underside's bend at the least.
                let beside = (at.distance(face.middle) - face.radius).max(0.0);
                if beside * beside * self.bend < over {
                    self.rest_on(face, at, best);
                }
            }
        }
    }

    fn rest_on(&self, face: &Face, at: DVec2, best: &mut f64) {
        let corners = face.corners.map(wide);
        let [a, b, c] = corners.map(|c| c.truncate() - at);
        let outside = |a: DVec2, b: DVec2| (b - a).perp_dot(face.touch - a) < 0.0;
        let outside = [outside(a, b), outside(b, c), outside(c, a)];
        if outside == [false; 3] {
            *best = face.tips.at(at);
            return;
        }
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let d = low.max(-high).max(DVec2::ZERO).length_squared();
        let top = corners[0].z.max(corners[1].z).max(corners[2].z);
        if d > self.reach2 || top - self.profile.underside(d.sqrt()) <= *best {
            return;
        }
        for (from, _) in outside.into_iter().enumerate().filter(|(_, outside)| *outside) {
            *best = best.max(self.on_edge(corners[from], corners[(from + 1) % 3], at));
        }
    }

    /// Height of the tip when the cutter rests on the edge from `a` to `b`, mm.
    fn on_edge(&self, a: DVec3, b: DVec3, at: DVec2) -> f64 {
        let way = (b - a).truncate();
        let length = way.length();
        let along = way / length;
        let from = a.truncate() - at;
        // Places along the edge are counted from the point nearest to the axis.
        let (near, start) = (along.perp_dot(from), along.dot(from));
        let rest = self.reach2 - near * near;
        if rest < 0.0 {
            return f64::NEG_INFINITY;
        }
        let chord = rest.sqrt();
        let (low, high) = (start.max(-chord), (start + length).min(chord));
        if low > high {
            return f64::NEG_INFINITY;
        }
        let rise = (b.z - a.z) / length;
        let t = self.profile.rest(near.abs(), rise, [low, high]);
        a.z + rise * (t - start) - self.profile.underside(t.hypot(near).min(self.profile.reach))
    }
}

#[cfg(test)]
mod tests;
