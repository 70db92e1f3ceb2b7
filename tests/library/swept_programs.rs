//! A program that was written, read back and swept leaves the surface that the simulation of its machine leaves.

use facetmill::gcode::dialect::Dialect;
use facetmill::gcode::read::read;
use facetmill::milling::swept::Swept;
use facetmill::progress::Progress;
use facetmill::shop::surface::strokes;

use crate::shop::{finishing, shop, wavy};

#[test]
fn what_is_written_leaves_the_surface_that_was_simulated() {
    let (mesh, progress) = (wavy(), Progress::silent());
    for degrees in [0.0, 90.0] {
        let shop = shop(&mesh, degrees, Dialect::LinuxCnc);
        let (file, _, ways) = finishing(&shop, &mesh);
        let program = read(file.text.as_bytes(), Some(Dialect::LinuxCnc)).unwrap().program;
        let machining = shop.finishing();
        let swept = Swept::new(&strokes(&program, shop.blank.origin_of_optical()), machining.cutter.profile());
        let simulated = machining.polished(&ways, 0, &progress).unwrap();
        let written = swept.polished(shop.blank.optical_size(), 0.05, 0.0, &progress).unwrap();
        assert_eq!(simulated.nodes, written.nodes);
        let off = simulated.heights.iter().zip(&written.heights).map(|(a, b)| f64::from((a - b).abs()));
        let most = off.fold(0.0, f64::max);
        assert!(most < 1e-4, "{degrees}: {most} mm");
    }
}
