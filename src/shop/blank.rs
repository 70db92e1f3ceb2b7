//! The stock before it is cut, and the zero of its programs.

use glam::{DVec2, DVec3};

use crate::relief::mesh::Mesh;

/// A plate within its stock. Programs count from the stock's lower left corner in x and y, and from its upper face in z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blank {
    /// The box around the plate in its own frame, mm.
    low: DVec3,
    high: DVec3,
    /// Rim around the optical area, mm.
    pub margin: f64,
    /// How far the stock's upper face lies above the plate's highest point, mm.
    pub over: f64,
}

impl Blank {
    /// Around `mesh`, whose rim of `margin` mm is no optical area.
    pub fn new(mesh: &Mesh, margin: f64, over: f64) -> Self {
        let (low, high) = mesh.bounds();
        Self { low, high, margin, over }
    }

    /// Size of the stock, mm.
    pub fn size(&self) -> DVec3 {
        self.high - self.low + DVec3::Z * self.over
    }

    /// Size of the optical area, mm.
    pub fn optical_size(&self) -> DVec2 {
        (self.high - self.low).truncate() - 2.0 * self.margin
    }

    /// Lower left and upper right corner of the optical area in the plate's own frame, mm.
    pub fn optical(&self) -> [DVec2; 2] {
        [self.low.truncate() + self.margin, self.high.truncate() - self.margin]
    }

    /// Lower left and upper right corner of the plate in its own frame, mm.
    pub fn corners(&self) -> [DVec2; 2] {
        [self.low.truncate(), self.high.truncate()]
    }

    /// The programs' zero in the plate's own frame, mm.
    pub fn zero(&self) -> DVec3 {
        DVec3::new(self.low.x, self.low.y, self.top())
    }

    /// Height of the stock's upper face in the plate's own frame, mm.
    pub fn top(&self) -> f64 {
        self.high.z + self.over
    }

    /// The optical area's lower left corner, at the plate's height zero, as programs count, mm.
    pub fn origin_of_optical(&self) -> DVec3 {
        DVec3::new(self.margin, self.margin, -self.top())
    }

    /// Where the zero is, in words for whoever sets it.
    pub fn zero_in_words(&self) -> String {
        format!(
            "x and y at the lower left corner of the stock, z at its upper face, which lies {} mm above the finished \
             plate's highest point",
            self.over
        )
    }
}
