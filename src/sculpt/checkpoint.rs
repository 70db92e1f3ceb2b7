//! The state of a design of a sheet between two steps of its plan, and the file that holds it, so that a long design can
//! be resumed.
//!
//! The file is one line of JSON (what it is, the recipe that it belongs to, the steps done), then the heights as 32-bit
//! floats, little-endian: exactly those of the running design, so that a resumed one ends in the same bytes.

use std::io::{self, BufRead, Read, Write};

use serde::{Deserialize, Serialize};

use super::plan::{SheetSpec, plan};
use super::start::Start;

/// What the first line says the file is.
const FORMAT: &str = "facetmill state";

/// Raised whenever older files would be misunderstood.
const VERSION: u32 = 1;

/// Longest first line, bytes.
const LONGEST_HEADER: u64 = 1 << 20;

/// Most nodes a side: more than any recipe may ask for.
const MOST_NODES: usize = 4096;

/// Heights beyond this are no plate's, mm.
const HIGHEST: f32 = 1e5;

/// A relief after some steps of its plan: all that is needed to resume from there.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// Steps of the plan that are done.
    pub done: usize,
    /// What was started from.
    pub start: Start,
    /// Nodes along each side of the cell, so far.
    pub nodes: usize,
    /// Heights of the cell about its mean plane, mm, rows of constant y.
    pub heights: Vec<f32>,
    /// Total variation between the relief's light as modelled and the wanted light, at a blur of 0.5°, after each step.
    pub misplaced: Vec<f64>,
}

impl Checkpoint {
    /// Whether it comes from the plan of `sculpting`.
    pub fn suits(&self, sculpting: &SheetSpec) -> bool {
        let steps = plan(sculpting);
        let last = self.done.checked_sub(1).and_then(|k| steps.get(k));
        last.is_some_and(|step| step.nodes() == self.nodes) && self.heights.len() == self.nodes * self.nodes
    }
}

/// What a design belongs to, as text that is written beside its state and compared when it is resumed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    /// The recipe, as TOML.
    pub recipe: String,
    /// A fingerprint of the picture's light.
    pub picture: String,
}

/// The first line of the file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Header {
    format: String,
    version: u32,
    done: usize,
    start: Start,
    nodes: usize,
    misplaced: Vec<f64>,
    origin: Origin,
}

/// Writes `at` and what it belongs to.
pub fn write_state(at: &Checkpoint, origin: &Origin, out: &mut impl Write) -> io::Result<()> {
    let Checkpoint { done, start, nodes, ref misplaced, .. } = *at;
    let (misplaced, origin) = (misplaced.clone(), origin.clone());
    let header = Header { format: FORMAT.into(), version: VERSION, done, start, nodes, misplaced, origin };
    serde_json::to_writer(&mut *out, &header)?;
    out.write_all(b"\n")?;
    at.heights.iter().try_for_each(|z| out.write_all(&z.to_le_bytes()))
}

/// Reads what [`write_state`] wrote; whatever else it is, is refused.
pub fn read_state(from: &mut impl BufRead) -> Result<(Checkpoint, Origin), StateError> {
    let mut line = Vec::new();
    from.by_ref().take(LONGEST_HEADER).read_until(b'\n', &mut line)?;
    // Before the rest is understood: another version's line may hold other things.
    let kind: serde_json::Value = serde_json::from_slice(&line).map_err(|_| StateError::Foreign)?;
    if kind["format"] != FORMAT {
        return Err(StateError::Foreign);
    }
    if kind["version"] != VERSION {
        return Err(StateError::Version(kind["version"].to_string()));
    }
    let header: Header = serde_json::from_value(kind).map_err(|error| StateError::Broken(error.to_string()))?;
    let Header { done, start, nodes, misplaced, origin, .. } = header;
    let broken = |what: &str| Err(StateError::Broken(what.into()));
    if !(2..=MOST_NODES).contains(&nodes) || done == 0 || misplaced.len() != done {
        return broken("its first line contradicts itself");
    }
    let mut bytes = Vec::new();
    let size = 4 * nodes * nodes;
    from.take(size as u64 + 1).read_to_end(&mut bytes)?;
    if bytes.len() < size {
        return broken("it ends too early");
    }
    if bytes.len() > size {
        return broken("it is longer than it should be");
    }
    let heights: Vec<f32> = bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    // What is not a number is not small either.
    if !heights.iter().all(|z| z.abs() < HIGHEST) {
        return broken("it holds heights that are none");
    }
    Ok((Checkpoint { done, start, nodes, heights, misplaced }, origin))
}

/// Why a design cannot be resumed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StateError {
    /// The system refuses.
    #[error("the file cannot be read ({0})")]
    Unreadable(#[from] io::Error),
    /// Something else.
    #[error("this is no state of a design")]
    Foreign,
    /// Another facetmill's.
    #[error("this state is of format version {0}, and this program reads version {VERSION}")]
    Version(String),
    /// Cut off or tampered with.
    #[error("this state is broken: {0}")]
    Broken(String),
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sculpt::settings::SheetSettings;

    fn checkpoint() -> Checkpoint {
        let heights = (0..16).map(|k| 0.1 * k as f32 - 0.7).collect();
        // Digits that a careless reader would lose.
        let misplaced = vec![0.1 + 0.2, 1.0 / 3.0, 0.012_345_678_901_234_567];
        Checkpoint { done: 3, start: Start::Hills(4), nodes: 4, heights, misplaced }
    }

    fn origin() -> Origin {
        Origin { recipe: "[design]\nseed = 3\n".into(), picture: "00ff".into() }
    }

    fn written() -> Vec<u8> {
        let mut bytes = Vec::new();
        write_state(&checkpoint(), &origin(), &mut bytes).unwrap();
        bytes
    }

    #[test]
    fn what_is_written_is_read_to_the_last_digit() {
        assert_eq!(read_state(&mut written().as_slice()).unwrap(), (checkpoint(), origin()));
        for start in [Start::Cone, Start::Roof, Start::Hills(1)] {
            let at = Checkpoint { start, ..checkpoint() };
            let mut bytes = Vec::new();
            write_state(&at, &origin(), &mut bytes).unwrap();
            assert_eq!(read_state(&mut bytes.as_slice()).unwrap().0, at);
        }
    }

    #[test]
    fn files_cut_off_anywhere_are_refused() {
        let bytes = written();
        for end in 0..bytes.len() {
            assert!(read_state(&mut &bytes[..end]).is_err(), "{end}");
        }
        let longer = [bytes.as_slice(), &[0]].concat();
        assert!(matches!(read_state(&mut longer.as_slice()), Err(StateError::Broken(_))));
    }

    #[test]
    fn foreign_and_tampered_files_are_refused() {
        for foreign in ["", "\n", "{}", "[]\n", "null\n", "solid plate\n", "{\"format\":\"other\"}\n", "\u{0}\u{0}"] {
            assert!(matches!(read_state(&mut foreign.as_bytes()), Err(StateError::Foreign)), "{foreign:?}");
        }
        let endless = vec![b'['; 3 << 20];
        assert!(matches!(read_state(&mut endless.as_slice()), Err(StateError::Foreign)));
        let text = |from: &str, to: &str| {
            let bytes = written();
            let end = bytes.iter().position(|b| *b == b'\n').unwrap();
            let line = String::from_utf8(bytes[..end].to_vec()).unwrap();
            assert!(line.contains(from), "{from} in {line}");
            [line.replace(from, to).as_bytes(), &bytes[end..]].concat()
        };
        let newer = text("\"version\":1", "\"version\":2");
        assert!(matches!(read_state(&mut newer.as_slice()), Err(StateError::Version(v)) if v == "2"));
        for (from, to) in [
            ("\"nodes\":4", "\"nodes\":5"),
            ("\"nodes\":4", "\"nodes\":0"),
            ("\"nodes\":4", "\"nodes\":4294967296"),
            ("\"nodes\":4", "\"nodes\":18446744073709551615"),
            ("\"nodes\":4", "\"nodes\":-4"),
            ("\"nodes\":4", "\"nodes\":4096"),
            ("\"done\":3", "\"done\":0"),
            ("\"done\":3", "\"done\":900"),
            ("hills 4", "hills -4"),
            ("hills 4", "pyramid"),
            ("\"nodes\":4", "\"nodes\":4,\"knots\":4"),
        ] {
            assert!(matches!(read_state(&mut text(from, to).as_slice()), Err(StateError::Broken(_))), "{to}");
        }
        for height in [f32::NAN, f32::INFINITY, -1e30] {
            let mut bytes = written();
            let end = bytes.len();
            bytes[end - 4..].copy_from_slice(&height.to_le_bytes());
            assert!(matches!(read_state(&mut bytes.as_slice()), Err(StateError::Broken(_))), "{height}");
        }
    }

    #[test]
    fn a_state_suits_only_the_plan_it_comes_from() {
        let sculpting = |grid: usize| SheetSpec {
            cell: glam::DVec2::ONE,
            cells: [1, 1],
            grid,
            seed: 1,
            settings: SheetSettings::default(),
        };
        let of =
            |done: usize, nodes: usize| Checkpoint { done, nodes, heights: vec![0.0; nodes * nodes], ..checkpoint() };
        let all = plan(&sculpting(64)).len();
        assert!(of(1, 64).suits(&sculpting(64)) && of(all, 64).suits(&sculpting(64)));
        assert!(!of(0, 64).suits(&sculpting(64)) && !of(all + 1, 64).suits(&sculpting(64)));
        assert!(!of(1, 64).suits(&sculpting(80)));
        assert!(!Checkpoint { heights: vec![0.0; 9], ..of(1, 64) }.suits(&sculpting(64)));
    }
}
