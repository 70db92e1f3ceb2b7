//! Triangles as they stand in an STL file: single precision, vertices shared exactly.

use glam::DVec3;

/// An indexed triangle mesh, mm. Triangles turn counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions as they are written.
    pub vertices: Vec<[f32; 3]>,
    /// Vertex indices of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Corners of triangle `k`, in double precision.
    pub fn corners(&self, k: usize) -> [DVec3; 3] {
        self.triangles[k].map(|v| {
            let [x, y, z] = self.vertices[v as usize];
            DVec3::new(f64::from(x), f64::from(y), f64::from(z))
        })
    }

    /// The box around all vertices (inverted if there are none), mm.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        self.vertices.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &[x, y, z]| {
            let v = DVec3::new(f64::from(x), f64::from(y), f64::from(z));
            (low.min(v), high.max(v))
        })
    }

    /// The same with the lower left corner of its optical area, which begins `margin` mm inside its box, at x = y = 0.
    pub fn at_optical_corner(&self, margin: f64) -> Self {
        let (low, _) = self.bounds();
        let [x, y] = [low.x + margin, low.y + margin];
        let moved = |[a, b, c]: &[f32; 3]| [(f64::from(*a) - x) as f32, (f64::from(*b) - y) as f32, *c];
        Self { vertices: self.vertices.iter().map(moved).collect(), triangles: self.triangles.clone() }
    }

    /// The part that stands on the box around all vertices less `margin` mm on each side, if no other part that faces up
    /// is higher than the lowest of it: nothing is then left out that could shade it. It is open where it was cut off.
    pub fn without_rim(&self, margin: f64) -> Option<Self> {
        let (low, high) = self.bounds();
        // Single precision of a rim's width.
        let slack = 1e-6 * (high - low).truncate().max_element();
        let (from, to) = (low.truncate() + margin - slack, high.truncate() - margin + slack);
        let within = |corner: DVec3| (corner.truncate().cmpge(from) & corner.truncate().cmple(to)).all();
        let (mut lowest, mut beside) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut part = Self::default();
        let mut names = vec![u32::MAX; self.vertices.len()];
        for (k, triangle) in self.triangles.iter().enumerate() {
            let corners = self.corners(k);
            let up = (corners[1] - corners[0]).cross(corners[2] - corners[0]).z > 0.0;
            if !up {
                continue;
            }
            if !corners.into_iter().all(within) {
                beside = corners.iter().fold(beside, |most, corner| most.max(corner.z));
                continue;
            }
            lowest = corners.iter().fold(lowest, |least, corner| least.min(corner.z));
            part.triangles.push(triangle.map(|v| {
                if names[v as usize] == u32::MAX {
                    names[v as usize] = part.vertices.len() as u32;
                    part.vertices.push(self.vertices[v as usize]);
                }
                names[v as usize]
            }));
        }
        (beside <= lowest + slack && !part.triangles.is_empty()).then_some(part)
    }

    /// Triangles without area.
    pub fn degenerate(&self) -> usize {
        let flat = |k: &usize| {
            let [a, b, c] = self.corners(*k);
            (b - a).cross(c - a).length() == 0.0
        };
        (0..self.triangles.len()).filter(flat).count()
    }

    /// Number of directed edges without a partner that runs the opposite way; 0 for a closed mesh.
    ///
    /// An edge of four triangles, two each way, counts as closed; a triangle turned over leaves all its edges open.
    pub fn open_edges(&self) -> usize {
        let (rising, falling) = (edges(self, true), edges(self, false));
        (0..self.vertices.len()).map(|v| unpaired(rising.of(v), falling.of(v))).sum()
    }
}

/// The edges of a mesh that run one way, by their lower vertex.
struct Edges {
    starts: Vec<usize>,
    others: Vec<u32>,
}

impl Edges {
    /// The upper vertices, ascending, of the edges whose lower one is `v`.
    fn of(&self, v: usize) -> &[u32] {
        &self.others[self.starts[v]..self.starts[v + 1]]
    }
}

/// The edges from lower to higher vertex (`rising`) or the others; linear but for the sorting of each short list.
fn edges(mesh: &Mesh, rising: bool) -> Edges {
    let one_way = || {
        let all = mesh.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
        all.filter_map(move |(a, b)| (a != b && (a < b) == rising).then_some((a.min(b) as usize, a.max(b))))
    };
    // Each list's end is found by filling it, and is the next one's start.
    let mut starts = vec![0; mesh.vertices.len() + 2];
    one_way().for_each(|(v, _)| starts[v + 2] += 1);
    for v in 1..starts.len() {
        starts[v] += starts[v - 1];
    }
    let mut others = vec![0; starts[starts.len() - 1]];
    for (v, other) in one_way() {
        others[starts[v + 1]] = other;
        starts[v + 1] += 1;
    }
    for v in 0..mesh.vertices.len() {
        others[starts[v]..starts[v + 1]].sort_unstable();
    }
    Edges { starts, others }
}

/// How many entries of two ascending lists have no equal in the other.
fn unpaired(mut a: &[u32], mut b: &[u32]) -> usize {
    let mut count = 0;
    while let ([x, rest_a @ ..], [y, rest_b @ ..]) = (a, b) {
        count += usize::from(x != y);
        (a, b) = (if x <= y { rest_a } else { a }, if y <= x { rest_b } else { b });
    }
    count + a.len() + b.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn open_edges_are_those_of_holes_and_turned_triangles() {
        let whole = Mesh {
            vertices: vec![[0.0, 0.0, 0.0], [0.0, 2.5, 0.0], [1.5, 0.0, 0.0], [0.0, 0.0, 3.25]],
            triangles: vec![[0, 1, 2], [0, 2, 3], [2, 1, 3], [1, 0, 3]],
        };
        assert_eq!(whole.open_edges(), 0);
        let holed = Mesh { triangles: whole.triangles[1..].to_vec(), ..whole.clone() };
        assert_eq!(holed.open_edges(), 3);
        let mut turned = whole.clone();
        turned.triangles[2].swap(0, 1);
        assert_eq!(turned.open_edges(), 6);
        let mut doubled = whole.clone();
        doubled.triangles.extend(whole.triangles.iter());
        assert_eq!(doubled.open_edges(), 0);
        assert_eq!(Mesh::default().open_edges(), 0);
    }
}
