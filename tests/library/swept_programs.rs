//! A program that was written, read back and swept leaves the surface that the simulation of its machine leaves.

use facetmill::gcode::dialect::Dialect;
use facetmill::gcode::read::read;
use facetmill::glam::DVec2;
use facetmill::milling::swept::{Stroke, Swept};
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
        // Along the passes before they became a program: rounding to decimals is all that is between.
        let tracks = ways.programs(&machining.machine);
        let pairs = tracks.iter().flat_map(|track| track.windows(2));
        let passes: Vec<Stroke> = pairs.map(|pair| Stroke { from: pair[0], to: pair[1], line: 0 }).collect();
        let passed = Swept::new(&passes, machining.cutter.profile());
        let even = |k: usize, step: f64| (k as f64 * step).fract();
        for k in 0..5000 {
            let place = shop.blank.optical_size() * DVec2::new(even(k, 0.618_033_988_7), even(k, 0.754_877_666_2));
            let [a, b] = [&swept, &passed].map(|surface| surface.height(place).unwrap());
            assert!((a - b).abs() < 1e-4, "{degrees}: {place}: {a} {b}");
        }
        // The machine's own sweep, on samples of its own: over cusps of 0.2 µm they differ by a part of these.
        let simulated = machining.polished(&ways, 0, &progress).unwrap().unwrap();
        let written = swept.polished(shop.blank.optical_size(), 0.05, 0.0, &progress).unwrap();
        assert_eq!(simulated.nodes, written.nodes);
        let off = simulated.heights.iter().zip(&written.heights).map(|(a, b)| f64::from((a - b).abs()));
        let most = off.fold(0.0, f64::max);
        assert!(most < 1.5e-4, "{degrees}: {most} mm");
    }
}
