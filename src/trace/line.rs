//! Where a ray meets a triangle, so that nothing slips between triangles that share corners.

use glam::{DVec2, DVec3};

/// A ray in the frame in which it is the third axis: the one along which it is longest, the others sheared.
pub(super) struct Line {
    origin: [f64; 3],
    axes: [usize; 3],
    shear: DVec2,
    stretch: f64,
}

impl Line {
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        let w = direction.abs().max_position();
        // Turned axes in place of mirrored ones keep the sense of rotation.
        let (u, v) = if direction[w] < 0.0 { ((w + 2) % 3, (w + 1) % 3) } else { ((w + 1) % 3, (w + 2) % 3) };
        let stretch = 1.0 / direction[w];
        Self {
            origin: origin.to_array(),
            axes: [u, v, w],
            shear: DVec2::new(direction[u], direction[v]) * stretch,
            stretch,
        }
    }

    /// Distance, weights of the corners, and whether it is the front that is met.
    pub fn meet(&self, corners: &[[f32; 3]; 3]) -> Option<(f64, DVec3, bool)> {
        let [a, b, c] = corners.map(|corner| {
            let [u, v, w] = self.axes.map(|axis| f64::from(corner[axis]) - self.origin[axis]);
            DVec3::new(u - self.shear.x * w, v - self.shear.y * w, w)
        });
        let edges = DVec3::new(c.x * b.y - c.y * b.x, a.x * c.y - a.y * c.x, b.x * a.y - b.y * a.x);
        if edges.min_element() < 0.0 && edges.max_element() > 0.0 {
            return None;
        }
        let sum = edges.element_sum();
        if sum == 0.0 {
            return None;
        }
        let weights = edges / sum;
        Some((weights.dot(DVec3::new(a.z, b.z, c.z)) * self.stretch, weights, sum > 0.0))
    }
}

/// Twice the areas, seen from above, of the triangles that (x, y) forms with the edges across from each corner; none of
/// them is negative if the triangle, which faces up, lies under the point. As in [`Line::meet`] of a ray straight down.
#[inline]
pub(super) fn areas_under(corners: &[[f32; 3]; 3], x: f64, y: f64) -> DVec3 {
    let [a, b, c] = corners;
    let (ax, ay) = (f64::from(a[0]) - x, f64::from(a[1]) - y);
    let (bx, by) = (f64::from(b[0]) - x, f64::from(b[1]) - y);
    let (cx, cy) = (f64::from(c[0]) - x, f64::from(c[1]) - y);
    DVec3::new(bx * cy - by * cx, cx * ay - cy * ax, ax * by - ay * bx)
}

#[inline]
pub(super) fn double([x, y, z]: [f32; 3]) -> DVec3 {
    DVec3::new(f64::from(x), f64::from(y), f64::from(z))
}

/// All corners in double precision.
#[inline]
pub(super) fn doubles([a, b, c]: &[[f32; 3]; 3]) -> [DVec3; 3] {
    [double(*a), double(*b), double(*c)]
}
