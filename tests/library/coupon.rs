//! Test pieces of machines that are not what they are thought to be.

use facetmill::coupon::dry_run::{Instrument, Piece};
use facetmill::coupon::findings::Findings;
use facetmill::coupon::layout::{Coupon, Place};
use facetmill::coupon::{Told, lines, scan};
use facetmill::cutter::Cutter;
use facetmill::milling::machine::Machine;
use facetmill::progress::Progress;

const UM: f64 = 1e-3;

#[test]
fn a_scan_tells_what_the_machine_does_and_what_it_cannot_tell_is_said() {
    let thought = Machine::preset("vmc").unwrap();
    let is = Machine {
        track_scatter: 0.8 * UM,
        tooth_scatter: 0.4 * UM,
        backlash_z: 2.0 * UM,
        backlash_xy: 12.0 * UM,
        tip_flat: 10.0 * UM,
        ..thought.clone()
    };
    let polish = 40.0 * UM;
    let coupon = Coupon::new(&thought, Cutter::ball(0.5), 480.0).unwrap();
    let piece = Piece::new(&coupon, &is, (polish, 7), &Progress::silent()).unwrap();
    // A few of the lines, coarsely: a beginning ramp of each kind, two level places of each, one polished.
    let mut places: Vec<(f64, Place)> = coupon.lines();
    places.dedup_by(|a, b| a.1 == b.1);
    places.retain(|line| line.0 < 23.0);
    let instrument = Instrument { spacing: 3.0 * UM, noise: 0.05 * UM, aside: -0.3, climb: 0.05, seed: 3 };
    let at: Vec<f64> = places.iter().map(|line| line.0).collect();
    let text = piece.scan(&at, &instrument);
    let read = |text: &str| lines::found(&coupon, &scan::read(text.as_bytes()).unwrap());
    let found = Findings::of(&coupon, &read(&text).unwrap());
    for (told, is, name) in [
        (&found.track_scatter, is.track_scatter, "track"),
        (&found.tooth_scatter, is.tooth_scatter, "tooth"),
        (&found.backlash_z, is.backlash_z, "play z"),
        (&found.backlash_xy, is.backlash_xy, "play xy"),
        (&found.tip_flat, is.tip_flat, "flat"),
        (&found.polish, polish, "polish"),
    ] {
        let Told::Measured { value, error } = told else { panic!("{name}: {told:?}") };
        assert!((value / is - 1.0).abs() < 0.2, "{name}: {value} of {is}");
        assert!((value - is).abs() < 4.5 * error && *error < 0.15 * is, "{name}: {value} ± {error} of {is}");
    }
    let machine = Machine::from_toml(&found.file(&thought, "a test")).unwrap();
    assert_eq!((machine.name.as_str(), machine.step), ("vmc-measured", thought.step));
    assert!((machine.track_scatter / is.track_scatter - 1.0).abs() < 0.2 && machine.polish.is_some());

    // One level line: neither scatter nor play, and the file keeps what was assumed.
    let one: String = text
        .lines()
        .filter(|line| line.starts_with("x_") || line.starts_with("4,"))
        .map(|l| format!("{l}\n"))
        .collect();
    let few = Findings::of(&coupon, &read(&one).unwrap());
    for told in [&few.track_scatter, &few.tooth_scatter, &few.backlash_z, &few.backlash_xy, &few.polish] {
        assert!(matches!(told, Told::Untold(why) if why.contains("line")), "{told:?}");
    }
    let kept = Machine::from_toml(&few.file(&thought, "a test")).unwrap();
    assert_eq!((kept.track_scatter, kept.polish), (thought.track_scatter, None));

    // Other units, another surface, another place.
    let said = |text: &str| read(text).err().unwrap().to_string();
    let changed = |change: &dyn Fn([f64; 3]) -> [f64; 3]| {
        let row = |line: &str| {
            let values: Vec<f64> = line.split(',').map(|word| word.parse().unwrap()).collect();
            let [x, y, z] = change([values[0], values[1], values[2]]);
            format!("{x},{y},{z}\n")
        };
        one.lines().skip(1).map(row).collect::<String>()
    };
    assert!(said(&changed(&|[x, y, z]| [x, y, 1000.0 * z])).contains("looks like µm"));
    assert!(said(&changed(&|[x, y, z]| [x, y, z / 25.4])).contains("looks like inches"));
    assert!(said(&changed(&|[x, y, z]| [1000.0 * x, 1000.0 * y, z])).contains("looks like µm"));
    assert!(said(&changed(&|[x, y, _]| [x, y, 0.01 * (37.0 * y).sin()])).contains("the piece is not found"));
    assert!(said(&changed(&|[x, y, z]| [x + 40.0, y, z])).contains("lines at x ="));
}
