//! A designed plate as a machine makes it, by our simulation and by one that shares nothing with it.
//!
//! The finishing program is read by LinuxCNC's own interpreter, whose positions nobody has rounded. A sweep in Python takes
//! them from there: what the control does to ends and corners, the drives' whole steps and their lag, and the ball over all
//! of it. Ours does the same by other means; heights and light of the two are compared. Where LinuxCNC or NumPy is missing
//! the tests are skipped, visibly.

use std::fmt::Write;
use std::fs;

use facetmill::cutter::Cutter;
use facetmill::gcode::dialect::Dialect;
use facetmill::job::design::design;
use facetmill::milling::machine::Machine;
use facetmill::milling::made::BareSurface;
use facetmill::picture::read;
use facetmill::progress::Progress;
use facetmill::recipe::Recipe;
use facetmill::relief::mesh::Mesh;
use facetmill::shop::programs::Shop;
use glam::{DVec2, DVec3, Vec3Swizzles};
use serde_json::json;

use crate::asking::{ask, skip};
use crate::shop::{finishing, shop};

/// Diameter of the ball, and the side of the plate, mm.
const BALL: f64 = 1.0;
const SIDE: f64 = 6.0;

/// Rows of places at which light is compared, and every how many of a row's places.
const ROWS: usize = 200;
const EVERY: usize = 11;

/// Places at which heights are compared beside those, and how far from the plate's rim, mm: over the rim itself the ball
/// rolls down into the air, on an arc of its own radius that no control reads in segments short enough.
const HEIGHTS: usize = 400;
const RIM: f64 = 0.02;

/// Pixels of an image of directions, a side, and of a degree; the blur through which two are compared, degrees.
const PIXELS: usize = 480;
const A_DEGREE: f64 = 4.0;
const BLUR: f64 = 1.0;

/// How far the two may be apart: heights at the most and, rim and all, as a root mean square, mm; the share of light that
/// is elsewhere.
const APART: f64 = 1e-4;
const MEAN_APART: f64 = 2e-5;
const ELSEWHERE: f64 = 0.002;

/// A plate of one small cell.
fn portrait() -> Mesh {
    let recipe = format!(
        "plate = {{ surface = 'continuous', size = [{SIDE}, {SIDE}], cells = 1, grid = 100 }}\n\
         design = {{ cutter = 'ball:{BALL}' }}"
    );
    let recipe = Recipe::from_toml(&recipe).unwrap();
    let picture = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/highlights/portrait.png");
    let light = read(picture.as_ref(), &recipe.reading()).unwrap().light;
    design(&recipe, &light, &Progress::silent()).unwrap().mesh.at_optical_corner(0.0)
}

/// A preset that errs as its program and its drives make it, and not at random.
fn steady(name: &str) -> Machine {
    Machine {
        backlash_xy: 0.0,
        backlash_z: 0.0,
        track_scatter: 0.0,
        tooth_scatter: 0.0,
        feed_per_tooth: 0.0,
        ..Machine::preset(name).unwrap()
    }
}

/// Where light from straight above goes off `slopes`, blurred; the sum is 1.
fn light(slopes: &[DVec2]) -> Vec<f64> {
    let mut image = vec![0.0; PIXELS * PIXELS];
    for slope in slopes {
        let normal = DVec3::new(-slope.x, -slope.y, 1.0).normalize();
        let way = 2.0 * normal.z * normal - DVec3::Z;
        let angle = way.z.acos().to_degrees() * way.truncate().normalize_or_zero();
        let at = (0.5 * PIXELS as f64 + A_DEGREE * angle - 0.5).clamp(DVec2::ZERO, DVec2::splat(PIXELS as f64 - 2.0));
        let (low, share) = (at.floor(), at - at.floor());
        for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let weight = [1.0 - share.x, share.x][i] * [1.0 - share.y, share.y][j];
            image[(low.y as usize + j) * PIXELS + low.x as usize + i] += weight / slopes.len() as f64;
        }
    }
    // Along rows, turned over, and along rows again.
    for _ in 0..2 {
        image = turned(&blurred_rows(&image));
    }
    image
}

fn blurred_rows(image: &[f64]) -> Vec<f64> {
    let sigma = BLUR * A_DEGREE;
    let reach = (5.0 * sigma) as isize;
    let taps: Vec<f64> = (-reach..=reach).map(|k| (-0.5 * (k as f64 / sigma).powi(2)).exp()).collect();
    let sum: f64 = taps.iter().sum();
    let mut blurred = vec![0.0; image.len()];
    for (row, out) in image.chunks(PIXELS).zip(blurred.chunks_mut(PIXELS)) {
        for (i, light) in row.iter().enumerate().filter(|(_, light)| **light > 0.0) {
            for (k, tap) in (i as isize - reach..).zip(&taps) {
                if let Some(out) = usize::try_from(k).ok().and_then(|k| out.get_mut(k)) {
                    *out += light * tap / sum;
                }
            }
        }
    }
    blurred
}

fn turned(image: &[f64]) -> Vec<f64> {
    (0..image.len()).map(|k| image[k % PIXELS * PIXELS + k / PIXELS]).collect()
}

/// Share of light that lies elsewhere.
fn elsewhere(a: &[f64], b: &[f64]) -> f64 {
    0.5 * a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>()
}

/// Places of the plate, the first [`HEIGHTS`] of them for heights, the others with our slopes there.
fn places(ours: &BareSurface) -> (Vec<DVec2>, Vec<DVec2>) {
    let mut places: Vec<DVec2> = (0..HEIGHTS)
        .map(|k| DVec2::new((k as f64 * 0.618_033_988_7).fract(), (k as f64 * 0.754_877_666_2).fract()))
        .map(|share| RIM + (SIDE - 2.0 * RIM) * share)
        .collect();
    let mut slopes = Vec::new();
    for k in 0..ROWS {
        for (i, slope) in ours.slopes(k, ROWS).into_iter().enumerate().skip(k % EVERY).step_by(EVERY) {
            if slope.is_finite() {
                slopes.push(slope);
                places.push(ours.place(i, k, ROWS));
            }
        }
    }
    (places, slopes)
}

/// Heights and slopes as the machine in Python leaves them at `places`.
fn theirs(shop: &Shop, moves: &str, places: &[DVec2], machine: &serde_json::Value) -> Result<Vec<DVec3>, String> {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("moves"), moves).unwrap();
    let mut listed = String::new();
    for place in places {
        writeln!(listed, "{:?} {:?}", place.x, place.y).unwrap();
    }
    fs::write(at("places"), listed).unwrap();
    let arguments = [at("moves").into_os_string(), at("places").into_os_string(), machine.to_string().into()];
    let said = ask("machined_in_python.py", &arguments)?;
    let numbers = |line: &str| line.split(' ').map(|number| number.parse().unwrap()).collect::<Vec<f64>>();
    let spots: Vec<DVec3> = said.lines().map(|line| DVec3::from_slice(&numbers(line))).collect();
    assert_eq!(spots.len(), places.len(), "{}", shop.name);
    Ok(spots)
}

#[test]
fn a_designed_plate_is_made_as_by_linuxcnc_s_positions_and_a_machine_in_python() {
    let mesh = portrait();
    for (name, dialect) in [("desktop", Dialect::Grbl), ("desktop-good", Dialect::Grbl), ("vmc", Dialect::LinuxCnc)] {
        let mut shop = shop(&mesh, 0.0, dialect);
        shop.machining.machine = steady(name);
        shop.machining.cutter = Cutter::ball(BALL);
        // Not whole steps of any of the machines, nor half of them.
        shop.machining.passes.stepover = 0.0307;
        shop.machining.polish = None;
        let (file, _, ways) = finishing(&shop, &mesh);
        let folder = tempfile::tempdir().unwrap();
        let program = folder.path().join("finishing.ngc");
        fs::write(&program, &file.text).unwrap();
        let moves = match ask("moves_of_linuxcnc.py", &[&program]) {
            Ok(said) => said,
            Err(why) => return skip("LinuxCNC", &why),
        };
        let machining = shop.finishing();
        let ours = machining.bare(&ways, 0);
        let (places, slopes) = places(&ours);
        let machine = &machining.machine;
        // The shop sets the zero to a whole unit of the program.
        let zero = (shop.blank.top() / machine.quantum()).round() * machine.quantum();
        let grbl = dialect == Dialect::Grbl;
        let machine = json!({
            "radius": 0.5 * BALL, "step": machine.step, "smoothing": machine.smoothing, "zero": [0.0, 0.0, zero],
            "ends": grbl, "blending": if grbl { 0.0 } else { 0.0005 },
        });
        let theirs = match theirs(&shop, &moves, &places, &machine) {
            Ok(spots) => spots,
            Err(why) => return skip("NumPy", &why),
        };
        let off: Vec<f64> = places.iter().zip(&theirs).map(|(place, spot)| ours.height(*place) - spot.x).collect();
        let most = off[..HEIGHTS].iter().fold(0.0, |most: f64, off| most.max(off.abs()));
        let mean = off.iter().sum::<f64>() / off.len() as f64;
        let rms = (off.iter().map(|off| off * off).sum::<f64>() / off.len() as f64).sqrt();
        let there: Vec<DVec2> = theirs[HEIGHTS..].iter().map(|spot| spot.yz()).collect();
        let tv = elsewhere(&light(&slopes), &light(&there));
        println!(
            "{name}: {} places, heights {:.3} um off at the most, {:.3} rms, {:.3} mean; light {tv:.5} elsewhere",
            places.len(),
            1e3 * most,
            1e3 * rms,
            1e3 * mean,
        );
        assert!(most < APART && rms < MEAN_APART, "{name}: {most} mm, {rms} rms");
        assert!(tv < ELSEWHERE, "{name}: {tv}");
    }
}
