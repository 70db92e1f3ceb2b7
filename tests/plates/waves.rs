//! A sheet as a closed solid.

use facetmill::relief::mesh::Mesh;

/// A closed solid under a sheet of waves, 48 × 48 squares of two triangles each.
pub fn waves() -> Mesh {
    let n = 49u32;
    let height = |x: f32, y: f32| 0.6 * (0.7 * x).sin() * (0.45 * y + 0.3).cos() + 0.1 * (1.9 * x - 1.3 * y).sin();
    let mut mesh = Mesh::default();
    for level in [false, true] {
        for (j, i) in (0..n).flat_map(|j| (0..n).map(move |i| (j, i))) {
            let (x, y) = (0.25 * i as f32, 0.25 * j as f32);
            mesh.vertices.push([x, y, if level { height(x, y) } else { -3.0 }]);
        }
    }
    let at = |i: u32, j: u32, up: u32| up * n * n + j * n + i;
    let mut square = |[a, b, c, d]: [u32; 4]| mesh.triangles.extend([[a, b, d], [b, c, d]]);
    for (j, i) in (0..n - 1).flat_map(|j| (0..n - 1).map(move |i| (j, i))) {
        square([at(i, j, 1), at(i + 1, j, 1), at(i + 1, j + 1, 1), at(i, j + 1, 1)]);
        square([at(i, j, 0), at(i, j + 1, 0), at(i + 1, j + 1, 0), at(i + 1, j, 0)]);
    }
    for k in 0..n - 1 {
        let sides =
            [[(k, 0), (k + 1, 0)], [(n - 1, k), (n - 1, k + 1)], [(k + 1, n - 1), (k, n - 1)], [(0, k + 1), (0, k)]];
        for [a, b] in sides {
            square([at(a.0, a.1, 0), at(b.0, b.1, 0), at(b.0, b.1, 1), at(a.0, a.1, 1)]);
        }
    }
    mesh
}
