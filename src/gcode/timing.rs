//! How long a program takes, and how fast its lines come.
//!
//! Every piece speeds up and slows down at a constant acceleration, within the feed and every axis's greatest speed. At
//! corners the speed is that of GRBL's rule: as on a small arc that strays from the corner by the junction deviation. The
//! control looks a stated number of moves ahead, and is ready to stop behind them.

use glam::DVec3;

use super::program::{Kind, Move, Program};

/// What a machine can do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kinematics {
    /// Greatest speed of each axis, mm/min; that of rapids.
    pub speed: DVec3,
    /// Acceleration of each axis, mm/s².
    pub acceleration: DVec3,
    /// How far the path may stray at a corner, as the control reckons its speed there, mm.
    pub junction_deviation: f64,
    /// Moves that the control looks ahead.
    pub look_ahead: usize,
}

impl Kinematics {
    /// A small machine: 1500 mm/min, 300 mm/s², and what GRBL is shipped with, a deviation of 0.01 mm and 16 moves.
    pub fn small() -> Self {
        Self {
            speed: DVec3::splat(1500.0),
            acceleration: DVec3::splat(300.0),
            junction_deviation: 0.01,
            look_ahead: 16,
        }
    }
}

/// What a program takes on a machine.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timing {
    /// All of it, s.
    pub seconds: f64,
    /// Cuts, s.
    pub cutting: f64,
    /// Rapids, s; dwelling is the rest.
    pub rapids: f64,
    /// Most lines a second over as many moves as the control looks ahead.
    pub line_rate: f64,
    /// Line at which that is reached.
    pub busiest_line: u32,
}

/// A move as it is driven.
#[derive(Clone, Copy)]
struct Piece {
    length: f64,
    /// Direction at its ends.
    along: [DVec3; 2],
    /// Greatest speed, mm/s, and acceleration, mm/s².
    speed: f64,
    acceleration: f64,
    line: u32,
    cuts: bool,
    /// Square of the speed at its start.
    entry: f64,
}

/// Memory for a program of `moves`, bytes.
pub fn bytes_for(moves: usize) -> f64 {
    (2 * size_of::<Piece>() * moves) as f64
}

/// What `program` takes on a machine.
pub fn timing(program: &Program, machine: &Kinematics) -> Timing {
    let mut pieces: Vec<Piece> = program.moves().filter_map(|one| piece(program, &one, machine)).collect();
    enter(&mut pieces, machine);
    let mut timing = Timing { seconds: program.dwell, ..Timing::default() };
    let window = machine.look_ahead.max(1);
    let mut times = vec![0.0; pieces.len()];
    let mut recent = 0.0;
    for k in 0..pieces.len() {
        let exit = pieces.get(k + 1).map_or(0.0, |next| next.entry);
        let seconds = pieces[k].seconds(exit);
        times[k] = seconds;
        timing.seconds += seconds;
        *(if pieces[k].cuts { &mut timing.cutting } else { &mut timing.rapids }) += seconds;
        recent += seconds;
        if k >= window {
            recent -= times[k - window];
        }
        // Rounding of the sums must not make a rate out of nothing.
        let rate = window as f64 / recent.max(1e-6);
        if k + 1 >= window && rate > timing.line_rate {
            (timing.line_rate, timing.busiest_line) = (rate, pieces[k].line);
        }
    }
    timing
}

/// A move of some length, as it is driven.
fn piece(program: &Program, one: &Move, machine: &Kinematics) -> Option<Piece> {
    let arc = program.arc(&one.motion);
    let way = one.motion.to - one.from;
    let (length, along) = match arc {
        None => (way.length(), [way.normalize_or_zero(); 2]),
        Some(arc) => (arc.length(), arc.directions()),
    };
    if length <= 0.0 {
        return None;
    }
    // Along an arc every axis may have to bear all of it.
    let share = if arc.is_some() { DVec3::ONE } else { along[0].abs().max(DVec3::splat(1e-9)) };
    let acceleration = (machine.acceleration / share).min_element();
    let mut speed = (machine.speed / share).min_element();
    if one.motion.kind != Kind::Rapid {
        speed = speed.min(one.motion.feed);
    }
    speed /= 60.0;
    if let Some(arc) = arc {
        let radius = arc.radii()[0];
        speed = speed.min((acceleration * radius).sqrt());
    }
    Some(Piece { length, along, speed, acceleration, line: one.motion.line, cuts: one.cuts(), entry: 0.0 })
}

/// Gives every piece the speed of its start.
fn enter(pieces: &mut [Piece], machine: &Kinematics) {
    for k in 1..pieces.len() {
        let (before, piece) = (pieces[k - 1], pieces[k]);
        let least = before.speed.min(piece.speed);
        pieces[k].entry = (least * least).min(corner(&before, &piece, machine.junction_deviation));
    }
    // From behind: every piece can slow down to the next one's start, and all can stop behind what is looked at.
    let mut next = 0.0;
    let mut ahead = 0.0;
    for k in (0..pieces.len()).rev() {
        ahead += pieces[k].length;
        if let Some(beyond) = pieces.get(k + machine.look_ahead.max(1)) {
            ahead -= beyond.length;
        }
        let piece = &mut pieces[k];
        let twice = 2.0 * piece.acceleration;
        piece.entry = piece.entry.min(next + twice * piece.length).min(twice * ahead.max(piece.length));
        next = piece.entry;
    }
    // From the front: and speed up to it.
    for k in 1..pieces.len() {
        let before = pieces[k - 1];
        pieces[k].entry = pieces[k].entry.min(before.entry + 2.0 * before.acceleration * before.length);
    }
}

/// Square of the greatest speed at the corner between two pieces.
fn corner(before: &Piece, piece: &Piece, deviation: f64) -> f64 {
    let cosine = -before.along[1].dot(piece.along[0]);
    if cosine > 0.999_999 {
        return 0.0;
    }
    let half = (0.5 * (1.0 - cosine)).max(0.0).sqrt();
    if half >= 1.0 - 1e-12 {
        return f64::INFINITY;
    }
    before.acceleration.min(piece.acceleration) * deviation * half / (1.0 - half)
}

impl Piece {
    /// Time along it, s, if it is left with the square `exit` of a speed.
    fn seconds(&self, exit: f64) -> f64 {
        let a = self.acceleration;
        let peak = (a * self.length + 0.5 * (self.entry + exit)).min(self.speed * self.speed).max(self.entry.max(exit));
        let (enter, top, leave) = (self.entry.sqrt(), peak.sqrt(), exit.sqrt());
        let even = self.length - (2.0 * peak - self.entry - exit) / (2.0 * a);
        (2.0 * top - enter - leave) / a + even.max(0.0) / top
    }
}

#[cfg(test)]
mod tests {
    use super::super::read::read;
    use super::*;

    fn timed(text: &str, machine: &Kinematics) -> Timing {
        timing(&read(text.as_bytes(), None).unwrap().program, machine)
    }

    fn machine() -> Kinematics {
        Kinematics { acceleration: DVec3::splat(100.0), ..Kinematics::small() }
    }

    #[test]
    fn a_single_move_speeds_up_and_slows_down() {
        // 600 mm/min = 10 mm/s, reached in 0.1 s over 0.5 mm: 10 mm take 0.2 s + 9 mm / 10 mm/s.
        let time = timed("G21G90G1F600X10", &machine());
        assert!((time.seconds - 1.1).abs() < 1e-9 && time.cutting == time.seconds, "{time:?}");
        // Too short to get there: √(4 L / a).
        let time = timed("G21G90G1F600X0.04", &machine());
        assert!((time.seconds - 0.04).abs() < 1e-9, "{time:?}");
        // A rapid of 25 mm/s along an axis, √2 as much along a diagonal; and a dwell.
        let time = timed("G21G90G0X30Y30\nG4P2", &machine());
        let (speed, a, length) = (25.0 * 2f64.sqrt(), 100.0 * 2f64.sqrt(), 30.0 * 2f64.sqrt());
        assert!(
            (time.rapids - length / speed - speed / a).abs() < 1e-9 && (time.seconds - time.rapids - 2.0).abs() < 1e-9
        );
    }

    #[test]
    fn pieces_of_a_line_are_driven_as_the_line_and_reversals_stop() {
        let whole = timed("G21G90G1F600X10", &machine()).seconds;
        let pieces: String = (1..=100).map(|k| format!("X{}\n", 0.1 * f64::from(k))).collect();
        let far = Kinematics { look_ahead: 1000, ..machine() };
        assert!((timed(&format!("G21G90G1F600\n{pieces}"), &far).seconds - whole).abs() < 1e-9);
        // Looking 2 moves of 0.1 mm ahead, a speed of √(2·100·0.2) = 6.3 mm/s is never passed at a joint.
        let near = Kinematics { look_ahead: 2, ..machine() };
        let slow = timed(&format!("G21G90G1F600\n{pieces}"), &near);
        assert!(slow.seconds > 10.0 / 7.4 && slow.seconds < 10.0 / 6.0, "{slow:?}");
        let back = timed("G21G90G1F600X10\nX0", &machine()).seconds;
        assert!((back - 2.0 * whole).abs() < 1e-9);
        // A square corner: v² = a d s / (1 - s) with s = √½.
        let corner = timed("G21G90G1F600X10\nY10", &machine()).seconds;
        assert!(corner < 2.0 * whole && corner > 2.0 * whole - 0.1);
    }

    #[test]
    fn lines_come_as_fast_as_they_are_short() {
        let pieces: String = (1..=2000).map(|k| format!("X{}\n", 0.025 * f64::from(k))).collect();
        let time = timed(&format!("G21G90G1F600\n{pieces}"), &Kinematics::small());
        // 25 µm at 10 mm/s.
        assert!((time.line_rate - 400.0).abs() < 1e-6, "{time:?}");
    }
}
