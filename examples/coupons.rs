//! Test pieces of ten machines that are not what they are thought to be, made, scanned and read:
//! `cargo run --release --example coupons`.

use facetmill::coupon::dry_photo::{Camera, linear, taken};
use facetmill::coupon::dry_run::{Instrument, Piece};
use facetmill::coupon::findings::Findings;
use facetmill::coupon::layout::Coupon;
use facetmill::coupon::{Told, lines, photograph, scan};
use facetmill::cutter::Cutter;
use facetmill::golden::golden;
use facetmill::milling::machine::Machine;
use facetmill::progress::Progress;
use facetmill::raster::Raster;

/// Between two ends, evenly in its logarithm, by a share that follows from machine and quantity.
fn drawn([low, high]: [f64; 2], machine: usize, quantity: usize) -> f64 {
    low * (high / low).powf(golden(machine + 17 * quantity + 5))
}

/// Machine number `k`: the preset that it is taken for, and what it is.
fn machine(k: usize) -> (Machine, Machine, f64) {
    let thought = Machine::preset(["desktop-good", "vmc"][k % 2]).unwrap_or_else(Machine::ideal);
    let um = |low: f64, high: f64, quantity: usize| 1e-3 * drawn([low, high], k, quantity);
    let [low, high] = if k.is_multiple_of(2) { [0.5, 2.0] } else { [0.25, 1.0] };
    let is = Machine {
        track_scatter: um(low, high, 1),
        tooth_scatter: um(0.6 * low, 0.6 * high, 2),
        backlash_z: um(2.0 * low, 4.0 * high, 3),
        backlash_xy: um(4.0, 16.0, 4),
        tip_flat: um(5.0, 15.0, 5),
        radius_error: um(2.0, 8.0, 6) - 0.004,
        ..thought.clone()
    };
    (thought, is, um(20.0, 90.0, 7))
}

/// A photograph of the piece, its camera turned and askew, the lamp's edge not quite where it should be.
fn photo(coupon: &Coupon, piece: &Piece, k: usize) -> Raster {
    let [a, b, c] = [1, 2, 3].map(|quantity| 2.0 * golden(3 * k + 11 * quantity) - 1.0);
    let camera = Camera {
        pixel: 0.01,
        blur: 0.8,
        noise: 0.01,
        askew: [0.03 * a, 0.02 * b],
        edge: 0.005 * c,
        seed: 77 + k as u64,
    };
    let (numbers, size) = taken(coupon, piece, &camera);
    linear(&numbers, size)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let photographed = std::env::args().any(|word| word == "photographs");
    let count = std::env::args().nth(1).map_or(Ok(10), |n| n.parse())?;
    let first = std::env::args().nth(2).map_or(Ok(0), |n| n.parse())?;
    let names = ["track", "tooth", "play z", "play xy", "tip flat", "radius", "polish"];
    println!("{:>16}{}", "machine", names.map(|name| format!("{name:>32}")).concat());
    let mut scores: Vec<Vec<f64>> = vec![Vec::new(); names.len()];
    for k in first..first + count {
        let (thought, is, polish) = machine(k);
        let coupon = Coupon::new(&thought, Cutter::ball(0.5), thought.feed)?;
        let piece = Piece::new(&coupon, &is, (polish, 1000 + k as u64), &Progress::silent())?;
        let instrument = Instrument { spacing: 1e-3, noise: 5e-5, aside: 0.21, climb: 0.02, seed: k as u64 };
        let places: Vec<f64> = coupon.lines().iter().map(|line| line.0 + 0.1).collect();
        let text = if photographed { String::new() } else { piece.scan(&places, &instrument) };
        let found = match photographed {
            false => Findings::of(&coupon, &lines::found(&coupon, &scan::read(text.as_bytes())?)?),
            true => photograph::findings(&coupon, &[photo(&coupon, &piece, k)])?,
        };
        let all = [
            (found.track_scatter, is.track_scatter),
            (found.tooth_scatter, is.tooth_scatter),
            (found.backlash_z, is.backlash_z),
            (found.backlash_xy, is.backlash_xy),
            (found.tip_flat, is.tip_flat),
            (found.radius_error, is.radius_error),
            (found.polish, polish),
        ];
        let mut row = String::new();
        for ((told, is), scores) in all.iter().zip(&mut scores) {
            row += &match told {
                Told::Measured { value, error } => {
                    scores.push((value - is) / error);
                    format!("{:>12.3} {:>8.3} ± {:<8.3}", 1000.0 * is, 1000.0 * value, 1000.0 * error)
                }
                Told::Untold(_) => format!("{:>12.3} {:>19}", 1000.0 * is, "not told"),
            };
        }
        println!("{:>16}{row}", thought.name);
    }
    for (name, scores) in names.iter().zip(&scores) {
        let n = scores.len() as f64;
        let mean = scores.iter().sum::<f64>() / n;
        let rms = (scores.iter().map(|z| z * z).sum::<f64>() / n).sqrt();
        println!("{name:>10}: (found - is) / error: mean {mean:.2}, root mean square {rms:.2}, of {n}");
    }
    Ok(())
}
