use super::super::program::{Kind, Seal};
use super::super::read::read;
use super::*;

fn cutting(dialect: Dialect, decimals: u8) -> Cutting {
    Cutting { dialect, decimals, feed: 600.0, plunge: 200.0, speed: 18_000.0, safe: 5.0, travel: 1.0 }
}

/// Tracks of places that no decimals hold.
fn tracks() -> Vec<Vec<DVec3>> {
    let point = |row: usize, k: usize| {
        let x = 0.1 * k as f64 + 1e-3 * (row as f64).sin();
        DVec3::new(x, 0.37 * row as f64, -0.2 - 0.1 * (3.0 * x + row as f64).sin())
    };
    (0..20).map(|row| (0..50).map(|k| point(row, k)).collect()).collect()
}

#[test]
fn what_is_written_is_read_back_within_its_rounding_in_every_dialect() {
    for dialect in Dialect::ALL {
        for decimals in [3, 4, 5, 6] {
            let (tracks, cutting) = (tracks(), cutting(dialect, decimals));
            let text =
                sealed(dialect, &["Cutter ball:0.5 (new), stepover 10 µm".into()], &body(&tracks, &cutting).unwrap());
            let read = read(text.as_bytes(), Some(dialect)).unwrap();
            assert_eq!((read.fault_count, &read.notes[..]), (0, &[][..]), "{dialect}: {:?}", read.faults);
            assert_eq!(read.program.seal, Seal::Whole);
            let mut moves = read.program.motions.iter();
            assert_eq!(moves.next().unwrap().to.z, 5.0, "first up");
            for (row, track) in tracks.iter().enumerate() {
                let rapids = [moves.next().unwrap(), moves.next().unwrap()].map(|rapid| (rapid.kind, rapid.to.z));
                assert_eq!(rapids, [(Kind::Rapid, if row == 0 { 5.0 } else { 1.0 }), (Kind::Rapid, 1.0)]);
                for (k, point) in track.iter().enumerate() {
                    let made = moves.next().unwrap();
                    assert_eq!((made.kind, made.feed), (Kind::Line, if k == 0 { 200.0 } else { 600.0 }));
                    let off = (made.to - *point).abs().max_element();
                    assert!(off <= 0.5000001 * 10_f64.powi(-i32::from(decimals)), "{off}");
                }
            }
            assert_eq!(moves.next().unwrap().to.z, 5.0);
            assert!(moves.next().is_none());
            assert_eq!(read.program.speeds, Some((18_000.0, 18_000.0)));
        }
    }
}

#[test]
fn a_dialect_holds_what_its_control_wants_and_nothing_that_stops_it() {
    let text = |dialect: Dialect| sealed(dialect, &[], &body(&tracks(), &cutting(dialect, 4)).unwrap());
    let grbl = text(Dialect::Grbl);
    for word in ["%", "M6", "G64", "G61", "T1"] {
        assert!(!grbl.contains(word), "{word}");
    }
    assert_eq!((grbl.matches('S').count(), grbl.matches("F600").count()), (1, 20), "after every plunge");
    assert!(text(Dialect::LinuxCnc).contains("\nG64 P0.0005 Q0\n"));
    let iso = text(Dialect::Iso);
    assert!(iso.starts_with("%\nO0001\n(facetmill checksum ") && iso.ends_with("M30\n%\n"));
    assert!(iso.contains("Z5.\n") && iso.contains("S18000. M3\nG4 X4.\n"), "{iso}");
    // Words in force are not said again.
    let two = [vec![DVec3::ZERO, DVec3::X, DVec3::new(2.0, 0.0, 0.00004)]];
    let text = body(&two, &cutting(Dialect::Grbl, 4)).unwrap();
    assert!(text.ends_with("X0Y0\nZ1\nG1Z0F200\nX1F600\nX2\nG0Z5\nM5\nM2\n"), "{text}");
    let air = Cutting { speed: 0.0, ..cutting(Dialect::Grbl, 4) };
    assert!(!body(&two, &air).unwrap().contains("M3"));
}

#[test]
fn comments_fit_their_lines_and_hold_nothing_that_ends_them() {
    let long = format!("Stock {} mm; zero (lower left) of µ° {}", "word ".repeat(40), "x".repeat(200));
    let text = sealed(Dialect::Grbl, &[long, String::new()], "M2\n");
    for line in text.lines() {
        assert!(line.len() <= 80 && line.is_ascii(), "{line}");
    }
    let read = read(text.as_bytes(), Some(Dialect::Grbl)).unwrap();
    assert_eq!((read.fault_count, read.program.seal), (0, Seal::Whole), "{text}");
}

#[test]
fn what_no_line_can_say_is_refused() {
    let good = cutting(Dialect::Grbl, 4);
    let one = [vec![DVec3::ZERO]];
    assert_eq!(body(&[], &good), Err(WriteError::Nothing));
    assert_eq!(body(&[vec![]], &good), Err(WriteError::Nothing));
    assert_eq!(body(&[vec![DVec3::NAN]], &good), Err(WriteError::Far));
    assert_eq!(body(&[vec![DVec3::splat(1e6)]], &good), Err(WriteError::Far));
    assert_eq!(body(&one, &Cutting { decimals: 2, ..good }), Err(WriteError::Decimals(2)));
    assert_eq!(body(&one, &Cutting { feed: 0.0, ..good }), Err(WriteError::Feed));
    assert_eq!(body(&one, &Cutting { speed: -1.0, ..good }), Err(WriteError::Speed(-1.0)));
    let low = Cutting { travel: 6.0, ..good };
    assert_eq!(body(&one, &low), Err(WriteError::Heights { safe: 5.0, travel: 6.0 }));
}

/// One digit of the moves changed to another: without the checksum what it does shows in the moves or not at all, with it
/// always.
#[test]
fn a_changed_digit_breaks_the_seal() {
    let text = sealed(Dialect::Grbl, &[], &body(&tracks(), &cutting(Dialect::Grbl, 5)).unwrap());
    let from = text.find("G21").unwrap();
    let mut state = 1_u64;
    for _ in 0..300 {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        let mut changed = text.clone().into_bytes();
        let digits: Vec<usize> = (from..changed.len()).filter(|at| changed[*at].is_ascii_digit()).collect();
        let at = digits[(state >> 33) as usize % digits.len()];
        changed[at] = b'0' + (changed[at] - b'0' + 1 + (state >> 20) as u8 % 9) % 10;
        if changed != text.as_bytes() {
            assert_eq!(read(&changed, None).unwrap().program.seal, Seal::Broken);
        }
    }
}
