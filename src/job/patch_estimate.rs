//! What a plate of patches would be, from its sizes alone.

use super::patches::{need, paths};
use crate::export::stl::stl_bytes;
use crate::recipe::Recipe;
use crate::report::estimate::{EstimateReport, Parts};
use crate::verify::patch_view::resolution;

/// CPU seconds of finding one patch's bowl, on the machine of [`estimate`](super::estimate::estimate)'s times. Plates of 100 to
/// 3600 patches took between 1.2 and 1.7 ms each.
const BOWL: f64 = 1.44e-3;

/// CPU seconds of looking at a plate: each path from the camera, and each node, whose triangles are looked for in the mesh.
const VIEW: (f64, f64) = (6.1e-7, 9.3e-7);

/// CPU seconds of looking at the plate as cut: each path, and each node, over which the cutter is led at four places.
const CUT_VIEW: (f64, f64) = (6.1e-7, 1.35e-6);

/// CPU seconds of the files: of any plate, and for each node.
const FILES: (f64, f64) = (0.34, 1e-6);

/// What the plate of patches of `recipe` will be; `proved` if it is to be looked at. Times are as exact as those of
/// [`estimate`](super::estimate::estimate), and triangles are exact but for a border.
pub fn estimate_patches(recipe: &Recipe, proved: bool) -> EstimateReport {
    let patches = recipe.patches();
    let nodes = patches.count.map(|count| count * patches.nodes);
    let (all, along_rim) = ((nodes[0] * nodes[1]) as f64, nodes[0] + nodes[1]);
    let triangles = 2 * nodes[0] * nodes[1] + 6 * along_rim;
    let side = resolution(&patches);
    let sent = paths(recipe, side) * (side * side) as f64;
    let looks = match (proved, recipe.design.sheet.cutter) {
        (false, _) => 0.0,
        (true, None) => VIEW.0 * sent + VIEW.1 * all,
        (true, Some(_)) => (VIEW.0 + CUT_VIEW.0) * sent + (VIEW.1 + CUT_VIEW.1) * all,
    };
    let rim = 2.0 * recipe.plate.border;
    let about = EstimateReport {
        dry_run: true,
        plate_mm: recipe.plate.size.map(|side| side + rim),
        pitch_mm: patches.step().to_array(),
        parts: Parts::Patches { patches: patches.count, grid: patches.nodes },
        stl_triangles_about: triangles,
        stl_bytes_about: stl_bytes(triangles),
        design_cpu_seconds_about: BOWL * patches.len() as f64,
        verify_cpu_seconds_about: looks,
        comparison_cpu_seconds_about: 0.0,
        files_cpu_seconds_about: FILES.0 + FILES.1 * all,
        wall_seconds_about: 0.0,
        threads: 1,
        machine_speed: 1.0,
        memory_bytes_about: need(&patches).bytes,
        least_stray_share: None,
    };
    about.on_machine(1.0, 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cutter::Cutter;

    #[test]
    fn varied_plates_take_what_their_dry_runs_say() {
        // Side in mm, patches a side, ball in mm, rays; CPU seconds of a release build on a machine of speed 0.93, files and
        // all, times that.
        for (side, count, ball, rays, measured) in [
            (60.0, 60, Some(0.5), 2_000_000, 16.7),
            (30.0, 30, Some(0.3), 500_000, 7.5),
            (40.0, 20, Some(0.5), 2_000_000, 9.8),
            (60.0, 60, None, 2_000_000, 9.7),
            (100.0, 60, None, 4_000_000, 14.8),
            (60.0, 30, Some(1.0), 2_000_000, 11.1),
            (20.0, 10, None, 100_000, 0.89),
        ] {
            let mut recipe = Recipe::default();
            recipe.plate.size = [side; 2];
            recipe.patches.portrait = Some("face.png".into());
            recipe.patches.count = Some([count; 2]);
            recipe.verify.rays = rays;
            recipe.design.sheet.cutter = ball.map(Cutter::ball);
            let about = estimate_patches(&recipe, true);
            let told = about.cpu_seconds();
            assert!((measured / 1.5..measured * 1.5).contains(&told), "{side} mm: {told} told, {measured} measured");
            assert!(about.stl_bytes_about > 0 && about.memory_bytes_about > 0);
        }
    }
}
