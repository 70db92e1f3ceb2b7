use glam::DVec2;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::*;
use crate::cutter::Cutter;
use crate::relief::periodic::drawn;
use crate::slope::Slope;

const CELL: DVec2 = DVec2::new(2.0, 1.0);

fn relief(nodes: usize, height: impl Fn(f64, f64) -> f64) -> PeriodicRelief {
    let heights = drawn(nodes, height);
    PeriodicRelief { nodes, heights, cell: CELL, cells: [1, 1], tilt: Slope::new(0.1, 0.0) }
}

#[test]
fn what_the_cutter_cannot_reach_is_filled() {
    let mut rough = relief(40, |x, y| 0.05 * (x - 0.5).abs() + 0.002 * (9.0 * y).sin().max(0.7));
    let tool = Tool::new(rough.cell, Cutter::ball(0.5));
    let before = rough.clone();
    assert!(tool.mill(&rough, &Progress::silent()).unwrap().most_left() > 2e-4);
    let raised = Filling::new(tool.clone(), Filled::whole(40), 2e-4).fill(&mut rough, &Progress::silent()).unwrap();
    assert!(tool.mill(&rough, &Progress::silent()).unwrap().most_left() <= 2e-4);
    let higher = |k: usize| rough.heights[k] > before.heights[k];
    assert!((0..1600).all(|k| higher(k) == raised.contains(&k) && rough.heights[k] >= before.heights[k]));
}

/// Waves with pits that overlap and stand across rims; of a plate that does not take the whole cell nothing is beside it.
fn pitted(nodes: usize, squares: [usize; 2], rng: &mut Xoshiro256PlusPlus) -> PeriodicRelief {
    let mut pits: Vec<[f64; 4]> = (0..rng.random_range(1..6))
        .map(|_| [rng.random(), rng.random(), 0.02 + 0.06 * rng.random::<f64>(), 0.008 * rng.random::<f64>()])
        .collect();
    pits.push([pits[0][0] + 0.03, pits[0][1] - 0.04, 0.05, 0.004]);
    pits.push([0.0, rng.random(), 0.03, 0.005]);
    let around = |d: f64| d - d.round();
    let mut relief = relief(nodes, |x, y| {
        let deep = |[u, v, wide, deep]: &[f64; 4]| deep * (1.0 - around(x - u).hypot(around(y - v)) / wide).max(0.0);
        0.015 * (std::f64::consts::TAU * (x + 2.0 * y)).sin() - pits.iter().map(deep).sum::<f64>()
    });
    let beside = |k: usize| squares.iter().zip([k % nodes, k / nodes]).any(|(n, i)| i > *n);
    (0..nodes * nodes).filter(|k| beside(*k)).for_each(|k| relief.heights[k] = -40.0);
    relief
}

#[test]
fn where_nothing_changed_nothing_need_be_milled_again() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
    let (mut rounds, mut anew) = (0, 0);
    for case in 0..12 {
        let nodes = rng.random_range(20..40);
        let part = Filled { squares: [nodes - 6, nodes - 9], cliff: 20.0, hurries: false };
        let filled = if case % 2 == 0 { Filled::whole(nodes) } else { part };
        let start = pitted(nodes, filled.squares, &mut rng);
        let cutter = Cutter::ball([0.3, 0.6][case / 2 % 2]);
        // On places that nodes are among, and on others.
        let tools = [Tool::without_steps(CELL, nodes, cutter), Tool { cutter, places: 7 * nodes + 3 }];
        let mut local = tools.clone().map(|tool| Filling::new(tool, filled, CLEARANCE));
        let (mut ours, mut whole) = (start.clone(), start);
        for turn in 0..4 {
            let (tool, us) = (&tools[turn % 2], turn % 2);
            for _ in 0..6 {
                anew += usize::from(local[us].stale(&ours).is_none());
                local[us].raise(&mut ours, 1.0, &Progress::silent()).unwrap();
                let mut again = Filling::new(tool.clone(), filled, CLEARANCE);
                again.raise(&mut whole, 1.0, &Progress::silent()).unwrap();
                assert_eq!(local[us].raised, again.raised, "case {case}");
                assert!(ours.heights == whole.heights, "case {case}");
                rounds += 1;
                if again.raised.is_empty() {
                    break;
                }
                let raised = local[us].raised.clone();
                local[1 - us].note(&raised);
            }
        }
    }
    // Each of 24 tools once, and where the steepest rises change or so small a grid is pitted all over.
    assert!(anew > 24 && 2 * anew < rounds, "{anew} of {rounds}");
}
