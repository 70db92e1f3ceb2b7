use super::super::arc::ArcFault;
use super::super::words::WordFault;
use super::*;

/// Moves as `rapid x,y,z` and such, rounded to 0.1 µm.
fn moves(text: &str) -> Vec<String> {
    let read = read(text.as_bytes(), None).unwrap();
    assert_eq!(read.fault_count, 0, "{text}: {:?}", read.faults);
    let round = |value: f64| (value * 1e4).round() / 1e4 + 0.0;
    let said = |motion: &Motion| {
        let kind = match motion.kind {
            Kind::Rapid => "rapid",
            Kind::Line => "line",
            Kind::Arc(_) => "arc",
        };
        format!("{kind} {},{},{}", round(motion.to.x), round(motion.to.y), round(motion.to.z))
    };
    read.program.motions.iter().map(said).collect()
}

fn fault(text: &str) -> (u32, Fault) {
    let read = read(text.as_bytes(), None).unwrap();
    assert!(!read.faults.is_empty(), "{text}");
    (read.faults[0].line, read.faults[0].what.clone())
}

fn notes(text: &str, dialect: Option<Dialect>) -> Vec<(u32, Note)> {
    read(text.as_bytes(), dialect).unwrap().notes.iter().map(|note| (note.line, note.what)).collect()
}

#[test]
fn words_in_force_steps_units_and_zeros_are_followed() {
    assert_eq!(moves("G21 G90 G0 X1 Y2\nZ3\nG1 F100 X0"), ["rapid 1,2,0", "rapid 1,2,3", "line 0,2,3"]);
    assert_eq!(
        moves("g20g90g0x1y-.5\ng91x1\r\ny.5\rg90x0"),
        ["rapid 25.4,-12.7,0", "rapid 50.8,-12.7,0", "rapid 50.8,0,0", "rapid 0,0,0"]
    );
    assert_eq!(moves("%\nN1 G21\nN2 G54 G0 X1\n%\nG0 X9"), ["rapid 1,0,0"]);
    assert_eq!(moves("G21\nG0 X1\nM30\nG0 X9"), ["rapid 1,0,0"]);
    assert_eq!(moves("O0001\nG21 G49\nG43 H0 G40 G80 G94 G98\nG0 X1\nX1\n"), ["rapid 1,0,0"], "nowhere is no move");
    assert_eq!(moves("G21 G4 P2\nG4 X1.5\nG0 X1 G4 P1"), ["rapid 1,0,0"]);
    let program = read(b"G21 G4 P2\nG4 X1.5\nG0 X1 G4 P1", None).unwrap().program;
    assert_eq!(program.dwell, 4.5);
}

#[test]
fn arcs_keep_their_centres() {
    let arc = |text: &str| {
        let read = read(text.as_bytes(), None).unwrap();
        assert_eq!(read.fault_count, 0, "{text}: {:?}", read.faults);
        read.program.arcs[0]
    };
    let close = |a: [f64; 2], b: [f64; 2]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9);
    let quarter = arc("G21 G90 G1 F100 X10 Y0\nG3 X0 Y10 I-10 J0");
    assert!(close(quarter.centre, [0.0; 2]) && (quarter.turn - std::f64::consts::FRAC_PI_2).abs() < 1e-9);
    assert!(close(arc("G21G90.1G90G1F100X10Y0\nG3X0Y10I0J0").centre, [0.0; 2]));
    assert!(close(arc("G20G90G1F10X1Y0\nG2X-1R1").centre, [0.0; 2]), "a half circle");
    let helix = arc("G21 G91 G1 F100 Z0\nG2 I5 Z-1 P3");
    assert!((helix.turn + 6.0 * std::f64::consts::PI).abs() < 1e-9 && helix.end.z == -1.0);
    let side = arc("G21 G18 G90 G1 F100 X0 Z0\nG2 X2 Z0 I1 K0");
    assert_eq!((side.plane, side.centre), (Plane::Zx, [0.0, 1.0]));
    assert!(
        (side.at(0.5).z.abs() - 1.0).abs() < 1e-12 && side.at(0.5).z < 0.0,
        "G18 G2 from -x to +x goes below, as seen against y"
    );
    let other = arc("G21 G19 G90 G1 F100 Y0 Z0\nG3 Y2 Z0 J1");
    assert!(other.at(0.5).z < 0.0, "G19 G3 from -y to +y goes below");
}

#[test]
fn what_is_not_carried_out_is_named_with_its_line_and_a_cure() {
    let refused = |word: &str| {
        let (line, fault) = fault(&format!("G21\n{word}\nM2"));
        assert_eq!(line, 2);
        fault.to_string()
    };
    for (line, names) in [
        ("G28", "G28"),
        ("G28.1", "G28.1"),
        ("G30 Z0", "G30"),
        ("G92 X0", "G92"),
        ("G43 H1", "G43"),
        ("G43", "G43"),
        ("G43.1 Z1", "G43.1"),
        ("G93", "G93"),
        ("G95", "G95"),
        ("G96 S100", "G96"),
        ("G41 D1", "G41"),
        ("G81 Z-1 R1", "G81"),
        ("G53 G0 X0", "G53"),
        ("G10 L20 P1 X0", "G10"),
        ("G38.2 Z-1", "G38.2"),
        ("G5.1", "G5.1"),
        ("G17.1", "G17.1"),
        ("G7", "G7"),
        ("G90.2", "G90.2"),
        ("G1.5", "G1.5"),
        ("M98 P1", "M98"),
        ("M62 P1", "M62"),
        ("M3.5", "M3.5"),
        ("A90", "A"),
        ("E5", "E"),
        ("G0 X1 D2", "D"),
        ("#1=2", "'#'"),
        ("G0 X[1+1]", "'['"),
        ("O100 sub", "'O'"),
        ("G0 X1 X2", "X"),
        ("G0 G1 X1", "two G"),
        ("G90 G91", "two G"),
        ("M3 M5", "two M"),
        ("G0 X1 P1", "P"),
        ("S100 Q1", "Q"),
        ("H1", "H"),
        ("F-1", "F"),
        ("T1.5 M6", "T1.5"),
        ("G4", "G4"),
        ("X1", "without G0"),
        ("G80 X1", "without G0"),
        ("G0 I1", "I"),
        ("G1 F1 X1 R2", "R"),
        ("G0 X1e3", "E"),
        ("$H", "'$'"),
        ("G0 X200000", "200000"),
        ("G", "G has no number"),
    ] {
        let said = refused(line);
        assert!(said.contains(names), "{line}: {said}");
        assert!(said.contains(": ") || said.contains("are"), "{line}: {said}");
    }
    assert_eq!(fault("G21 G1 X1"), (1, Fault::NoFeed));
    assert_eq!(fault("G21 F0\nG1 X1"), (2, Fault::ZeroFeed));
    assert_eq!(fault("G21 F1\nG2 X1 Y1"), (2, Fault::NoCentre));
    assert_eq!(fault("G21 F1\nG2 X1 Y1 I1 R1"), (2, Fault::Both));
    assert_eq!(fault("G21 F1\nG2 X1 Y1 K1"), (2, Fault::OtherPlane { letter: 'K', plane: "G17" }));
    assert_eq!(fault("G21 F1 G90.1\nG2 X1 Y1 I1"), (2, Fault::HalfCentre));
    assert_eq!(fault("G21 F1\nG2 X1 I.5 P1.5"), (2, Fault::Turns(1.5)));
    assert!(matches!(fault("G21 F1\nG2 X10 I5.01"), (2, Fault::Arc(ArcFault::Open { .. }))));
    assert_eq!(fault("G21\n(open"), (2, Fault::Word(WordFault::OpenComment)));
}

#[test]
fn what_controls_differ_in_is_noted() {
    assert_eq!(notes("G0 X1\nM2", None), [(1, Note::NoUnit), (1, Note::NoDistance)]);
    assert_eq!(notes("G21G90G0X1\nG20\nM2", None), [(2, Note::UnitsSwitched)]);
    assert_eq!(notes("G20 F10\nM2", None), [(1, Note::FeedWithUnits)]);
    assert_eq!(notes("G21G90G0X1\nG55\nM2", None), [(2, Note::CoordinatesSwitched)]);
    assert_eq!(notes("G21G91G0X1\nM2", None), [(1, Note::NoPlace)]);
    assert_eq!(notes("/G21\nM2", None), [(1, Note::Deletable)]);
    assert_eq!(notes("%\nG21\nM2", Some(Dialect::Grbl)), [(1, Note::Tape)]);
    assert_eq!(notes("G21\nM2\nG0X1", None), [(3, Note::AfterEnd)]);
    assert_eq!(notes("G21", None), [(1, Note::NoEnd)]);
    assert_eq!(notes("G21G90G1X1F1\nM2", None), [(1, Note::SpindleStands)]);
    assert_eq!(notes("T1M6\nT2M6\nM2", None), [(2, Note::SecondTool)]);
    assert_eq!(notes("M6\nM2", None), [(1, Note::NamelessTool)]);
    let long = format!("({})\nM2", "x".repeat(90));
    assert_eq!(notes(&long, Some(Dialect::Grbl)), [(1, Note::LongLine(80))]);
    assert_eq!(notes(&long, Some(Dialect::Mach3)), []);
    let feed = |dialect| read(b"G20 F10\nG90 G1 X1\nM2", dialect).unwrap().program.motions[0].feed;
    assert_eq!((feed(None), feed(Some(Dialect::LinuxCnc))), (254.0, 10.0), "LinuxCNC obeys F first");
    for (dialect, word) in
        [(Dialect::Grbl, "G64"), (Dialect::Grbl, "M6"), (Dialect::Grbl, "G90.1"), (Dialect::Iso, "G61.1")]
    {
        let read = read(format!("T1\n{word}").as_bytes(), Some(dialect)).unwrap();
        assert!(read.faults[0].what.to_string().contains(&format!("{word} is unknown to {dialect}")));
    }
}

#[test]
fn bytes_that_are_no_program_are_refused() {
    assert_eq!(read(b"", None), Err(NotGcode::Empty));
    assert_eq!(read(b"\n(a comment)\n", None), Err(NotGcode::Empty));
    assert_eq!(read(b"G21\n\x89PNG\r\n\x1a\n\0\0", None), Err(NotGcode::Binary { line: 4, byte: 0 }));
    assert_eq!(read(b"\xff\xfeG\x002\x001\x00", None), Err(NotGcode::Utf16));
    assert_eq!(read(&[b'G'; 70_000], None), Err(NotGcode::EndlessLine(1)));
    assert!(read("\u{feff}G21\nM2\u{1a}".as_bytes(), None).is_ok_and(|read| read.fault_count == 0));
    let letter = read("Dear Sir,\nplease find enclosed\n".repeat(100).as_bytes(), None).unwrap();
    assert_eq!((letter.faults.len(), letter.fault_count), (MOST_FINDINGS, 200));
}

#[test]
fn no_bytes_make_the_reader_panic_or_grow() {
    let good =
        b"%\nN10 G21 G90 G17 (top)\nT1 M6 S9000 M3\nG0 Z5.\nX1.5 Y-2\nG1 Z-.25 F300 ; down\nG2 X3.5 I1 J0 Z-.5 P2\n\
                 G18 G3 X5.5 Z-.5 R1\nG91 G20 X.1\nG64 P.01 Q0\nG4 P.5\n/M8\nM5 M9\nM30\n%\n";
    let mut state = 7_u64;
    let mut random = move |n: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as usize % n
    };
    let letters = b"GMXYZIJKRFSTPQHNO0123456789.-+ \n\r(;)%/#[";
    for round in 0..20_000 {
        let mut bytes = good.to_vec();
        for _ in 0..1 + random(8) {
            let at = random(bytes.len());
            match random(4) {
                0 => bytes[at] = letters[random(letters.len())],
                1 => bytes[at] = random(256) as u8,
                2 => drop(bytes.remove(at)),
                _ => bytes.insert(at, letters[random(letters.len())]),
            }
        }
        let dialect = [None, Some(Dialect::Grbl), Some(Dialect::LinuxCnc), Some(Dialect::Iso)][round % 4];
        if let Ok(read) = read(&bytes, dialect) {
            assert!(read.program.motions.len() <= 20 && read.faults.len() <= 20);
            for motion in &read.program.motions {
                assert!(motion.to.is_finite() && motion.to.abs().max_element() <= FARTHEST && motion.feed.is_finite());
            }
            for arc in &read.program.arcs {
                assert!(arc.length().is_finite() && arc.chords(1e-4) >= 1);
            }
        }
    }
}
