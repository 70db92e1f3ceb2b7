//! A small plate and the shop that makes it, for several test programs.

use facetmill::cutter::Cutter;
use facetmill::gcode::dialect::Dialect;
use facetmill::milling::machine::Machine;
use facetmill::milling::made::Machining;
use facetmill::milling::passes::Passes;
use facetmill::milling::passes::Ways;
use facetmill::milling::roughing::Roughing;
use facetmill::milling::tip::TipHeights;
use facetmill::progress::Progress;
use facetmill::relief::mesh::Mesh;
use facetmill::shop::blank::Blank;
use facetmill::shop::feeds::{STOCKS, Spindle};
use facetmill::shop::programs::{Part, Shop, ShopFile};

/// A wavy top of 6 × 4 mm on a box.
pub fn wavy() -> Mesh {
    let (nx, ny) = (121_u32, 81_u32);
    let at = |i: u32, j: u32| {
        let (x, y) = (0.05 * f64::from(i), 0.05 * f64::from(j));
        [x, y, 0.08 * (1.3 * x).sin() * (1.1 * y).cos() - 0.2].map(|v| v as f32)
    };
    let mut mesh = Mesh { vertices: (0..nx * ny).map(|k| at(k % nx, k / nx)).collect(), triangles: Vec::new() };
    for k in (0..(nx - 1) * (ny - 1)).map(|k| k / (nx - 1) * nx + k % (nx - 1)) {
        mesh.triangles.extend([[k, k + 1, k + nx + 1], [k, k + nx + 1, k + nx]]);
    }
    let base = mesh.vertices.len() as u32;
    mesh.vertices.extend([[0.0, 0.0, -2.0], [6.0, 0.0, -2.0], [0.0, 4.0, -2.0], [6.0, 4.0, -2.0]]);
    mesh.triangles.extend([[base, base + 3, base + 1], [base, base + 2, base + 3]]);
    mesh
}

/// A shop with a machine without faults that makes the plate with a ball of 1 mm, its passes `degrees` from x.
pub fn shop(mesh: &Mesh, degrees: f64, dialect: Dialect) -> Shop {
    // The machine's own rounding is finer than what is looked for.
    let machine = Machine { decimals: 6, ..Machine::ideal() };
    let passes = Passes { angle: degrees.to_radians(), stepover: 0.03, zigzag: false };
    let machining = Machining { machine, cutter: Cutter::ball(1.0), passes, polish: Some(0.05), seed: 1 };
    let roughing = Roughing { cutter: Cutter::Flat { diameter: 1.0 }, stepover: 0.4, step: 0.2, allowance: 0.1 };
    Shop {
        machining,
        dialect,
        stock: STOCKS[0],
        spindle: Spindle { fastest: 24_000.0, teeth: 2.0 },
        blank: Blank::new(mesh, 0.0, 0.2),
        roughing,
        name: "wavy".into(),
        passes: None,
    }
}

/// The finishing program, with where its cutter can stand and its passes.
pub fn finishing(shop: &Shop, mesh: &Mesh) -> (ShopFile, TipHeights, Ways) {
    let (machining, progress) = (shop.finishing(), Progress::silent());
    let tips = machining.tips(mesh);
    let ways = machining.ways_over(&tips, shop.blank.optical_size(), &progress).unwrap();
    let files = shop.programs(mesh, &tips, &ways, &progress).unwrap();
    (files.into_iter().find(|file| file.part == Part::Finishing).unwrap(), tips, ways)
}
