//! Any plate, by whichever tracer serves it best.

use crate::progress::{Cancelled, Progress};
use crate::relief::mesh::Mesh;
use crate::relief::recognise::{Recognised, recognise};

use super::Surface;
use super::grid::GridSurface;
use super::height_field::{FacetPlanes, NodeTriangles};
use super::mesh::{MeshSurface, MeshSurfaceError};

/// A plate ready for rays: on its grid if its relief stands on one, else as triangles in a tree.
#[derive(Clone)]
#[non_exhaustive]
pub enum TracedPlate {
    /// A plane over each rectangle of a grid.
    Facets(GridSurface<FacetPlanes>),
    /// Two triangles over each rectangle of a grid.
    Heights(GridSurface<NodeTriangles>),
    /// Any triangles.
    Mesh(Box<MeshSurface>),
}

/// Work that is done on a surface, whatever it is.
pub trait Task {
    /// What comes of it.
    type Output;

    /// Does the work.
    fn on<S: Surface>(self, surface: &S) -> Self::Output;
}

impl TracedPlate {
    /// The plate that stands in `mesh`; its optical area is the xy bounding box less `margin` mm on each side.
    ///
    /// Fails as [`MeshSurface::new`] does.
    pub fn new(mesh: &Mesh, margin: f64, progress: &Progress) -> Result<Self, TracedPlateError> {
        let (low, high) = mesh.bounds();
        let optical = (low.truncate() + margin, high.truncate() - margin);
        if margin >= 0.0 && optical.0.cmplt(optical.1).all() {
            match recognise(mesh, progress)? {
                Some(Recognised::Facets(relief)) => {
                    return Ok(Self::Facets(GridSurface::new(&relief, progress)?.lit_within(optical)));
                }
                Some(Recognised::Heights(grid)) => {
                    return Ok(Self::Heights(GridSurface::continuous(&grid, progress)?.lit_within(optical)));
                }
                None => {}
            }
        }
        Ok(Self::Mesh(Box::new(MeshSurface::new(mesh, margin)?)))
    }

    /// The optical area of the plate in `mesh` alone, if that stands on a grid and a rim of `margin` mm around it shades
    /// nothing: its light is then known piece by piece.
    pub fn without_rim(mesh: &Mesh, margin: f64, progress: &Progress) -> Result<Option<Self>, Cancelled> {
        let Some(bare) = mesh.without_rim(margin) else { return Ok(None) };
        Ok(match recognise(&bare, progress)? {
            Some(Recognised::Facets(relief)) => Some(Self::Facets(GridSurface::new(&relief, progress)?)),
            Some(Recognised::Heights(grid)) => Some(Self::Heights(GridSurface::continuous(&grid, progress)?)),
            None => None,
        })
    }

    /// The same relief repeated without end; `None` if it stands on no grid.
    pub fn endless(self, progress: &Progress) -> Result<Option<Self>, Cancelled> {
        Ok(match self {
            Self::Facets(surface) => Some(Self::Facets(surface.endless(progress)?)),
            Self::Heights(surface) => Some(Self::Heights(surface.endless(progress)?)),
            Self::Mesh(_) => None,
        })
    }

    /// Does `task` on the surface.
    pub fn run<T: Task>(&self, task: T) -> T::Output {
        match self {
            Self::Facets(surface) => task.on(surface),
            Self::Heights(surface) => task.on(surface),
            Self::Mesh(surface) => task.on(surface.as_ref()),
        }
    }

    /// What the plate was found to be, for reports.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Facets(_) => "a plane over each rectangle of a grid",
            Self::Heights(_) => "two triangles over each rectangle of a grid",
            Self::Mesh(surface) if surface.is_field() => "triangles in the cells of a grid",
            Self::Mesh(_) => "triangles in a tree of boxes",
        }
    }
}

/// Why a mesh is no plate ready for rays.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TracedPlateError {
    /// Its triangles cannot be traced.
    #[error(transparent)]
    Mesh(#[from] MeshSurfaceError),
    /// The caller wanted nothing more.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

#[cfg(test)]
mod tests {
    use glam::DVec2;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use crate::relief::height_grid::HeightGrid;

    /// A closed box under four random squares, its triangles turned inside out or not.
    fn block(inside_out: bool) -> Mesh {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(8);
        let mut mesh = Mesh::default();
        for z in [0.0, 1.0] {
            for k in 0..9 {
                mesh.vertices.push([(k % 3) as f32, (k / 3) as f32, z * (1.0 + random.random::<f32>())]);
            }
        }
        let mut quad = |[a, b, c, d]: [u32; 4]| mesh.triangles.extend([[a, b, d], [b, c, d]]);
        for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let a = 3 * j + i;
            quad([a + 9, a + 10, a + 13, a + 12]);
            quad([a, a + 3, a + 4, a + 1]);
        }
        for (a, b) in [(0, 1), (1, 2), (2, 5), (5, 8), (8, 7), (7, 6), (6, 3), (3, 0)] {
            quad([a, b, b + 9, a + 9]);
        }
        if inside_out {
            mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        }
        mesh
    }

    fn traced(inside_out: bool, margin: f64) -> Result<TracedPlate, TracedPlateError> {
        TracedPlate::new(&block(inside_out), margin, &Progress::silent())
    }

    #[test]
    fn a_relief_on_a_grid_is_traced_as_one_unless_it_is_inside_out() {
        assert!(matches!(traced(false, 0.0), Ok(TracedPlate::Heights(_))));
        assert!(matches!(traced(true, 0.0), Ok(TracedPlate::Mesh(_))));
        assert!(traced(false, 1.0).is_err());
        assert!(traced(true, 0.0).unwrap().endless(&Progress::silent()).unwrap().is_none());
    }

    #[test]
    fn a_relief_is_found_within_a_rim_that_shades_nothing() {
        use crate::export::sheet::sheet_solid;
        use crate::relief::periodic::PeriodicRelief;
        use crate::slope::Slope;
        let heights = (0..64).map(|k| (k * k % 11) as f32 * 0.01).collect();
        let relief = PeriodicRelief {
            nodes: 8,
            heights,
            cell: DVec2::new(7.3, 5.1),
            cells: [2, 1],
            tilt: Slope::new(0.01, 0.0),
        };
        let silent = Progress::silent();
        let bare = recognise(&sheet_solid(&relief, 2.0, 0.0, &silent).unwrap(), &silent).unwrap();
        let mut rimmed = sheet_solid(&relief, 2.0, 1.7, &Progress::silent()).unwrap();
        assert!(matches!(
            TracedPlate::without_rim(&rimmed, 1.7, &Progress::silent()).unwrap(),
            Some(TracedPlate::Heights(_))
        ));
        assert_eq!(recognise(&rimmed.without_rim(1.7).unwrap(), &Progress::silent()).unwrap(), bare);
        // A rim that stands higher shades.
        let highest = rimmed.bounds().1.z as f32;
        let rim = (0..rimmed.vertices.len()).filter(|&v| rimmed.vertices[v][0] < -0.1).collect::<Vec<_>>();
        rim.into_iter().for_each(|v| rimmed.vertices[v][2] = highest);
        assert!(TracedPlate::without_rim(&rimmed, 1.7, &Progress::silent()).unwrap().is_none());
    }

    #[test]
    fn a_margin_narrows_the_optical_area_of_any_plate() {
        struct Area;
        impl Task for Area {
            type Output = (DVec2, DVec2);
            fn on<S: Surface>(self, surface: &S) -> Self::Output {
                surface.optical_area()
            }
        }
        for inside_out in [false, true] {
            let area = traced(inside_out, 0.25).unwrap().run(Area);
            assert_eq!(area, (DVec2::splat(0.25), DVec2::splat(1.75)));
        }
        let grid = HeightGrid::new(vec![0.0, 1.0], vec![0.0, 2.0], vec![0.0; 4], &Progress::silent()).unwrap();
        assert_eq!(grid.area(), (DVec2::ZERO, DVec2::new(1.0, 2.0)));
    }
}
