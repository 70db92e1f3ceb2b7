//! Files changed at random, such as bad disks and bad programs leave them, and worse.

use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;

/// Longest mutant, bytes.
const LONGEST: usize = 1 << 16;

/// Numbers at which sums overflow and signs turn.
const EDGES: [u32; 12] = [0, 1, 2, 0x7f, 0x80, 0xff, 0x100, 0x7fff, 0xffff, 0x1_0000, 0x7fff_ffff, 0xffff_ffff];

/// Words of text formats that mean something to somebody.
const WORDS: &[&str] = &[
    "nan",
    "-inf",
    "1e999",
    "-0",
    "9223372036854775808",
    "1e-320",
    "0x10",
    "[",
    "]",
    "[[",
    "{",
    "}",
    "\"",
    "'",
    "=",
    "\n",
    "null",
    "true",
    "solid",
    "endsolid",
    "facet",
    "vertex",
    "[plate]\n",
    "\\u0000",
    "\u{feff}",
    "é",
];

/// One of `corpus` after one to eight changes.
pub fn mutant(corpus: &[Vec<u8>], rng: &mut Xoshiro256PlusPlus) -> Vec<u8> {
    let mut bytes = corpus[rng.random_range(0..corpus.len())].clone();
    for _ in 0..rng.random_range(1..=8) {
        change(&mut bytes, corpus, rng);
    }
    bytes.truncate(LONGEST);
    // Without right checksums hardly a mutant comes past a PNG's first chunk.
    if bytes.starts_with(b"\x89PNG\r\n\x1a\n") && rng.random_bool(0.75) {
        mend_checksums(&mut bytes);
    }
    bytes
}

fn change(bytes: &mut Vec<u8>, corpus: &[Vec<u8>], rng: &mut Xoshiro256PlusPlus) {
    // Headers lie near the start: half of the changes go there.
    let reach = if rng.random_bool(0.5) { bytes.len().min(96) } else { bytes.len() };
    let at = rng.random_range(0..=reach);
    let end = (at + rng.random_range(1..=32)).min(bytes.len());
    match rng.random_range(0..10) {
        0 | 1 if at < bytes.len() => bytes[at] ^= 1 << rng.random_range(0..8),
        2 if at < bytes.len() => bytes[at] = rng.random(),
        3 | 4 => {
            let edge = EDGES[rng.random_range(0..EDGES.len())];
            let edge = if rng.random_bool(0.5) { edge.to_be_bytes() } else { edge.to_le_bytes() };
            let size = [1, 2, 4][rng.random_range(0..3)];
            for (byte, new) in bytes[at..].iter_mut().zip(&edge[..size]) {
                *byte = *new;
            }
        }
        5 => drop(bytes.drain(at..end)),
        6 => {
            let piece = bytes[at..end].to_vec();
            let to = rng.random_range(0..=bytes.len());
            let times = if rng.random_bool(0.1) { 200 } else { 1 };
            bytes.splice(to..to, piece.repeat(times));
        }
        7 => {
            let word = WORDS[rng.random_range(0..WORDS.len())];
            let end = if rng.random_bool(0.5) { at } else { end };
            bytes.splice(at..end, word.bytes());
        }
        8 => {
            let other = &corpus[rng.random_range(0..corpus.len())];
            let from = rng.random_range(0..=other.len());
            bytes.splice(at.., other[from..].iter().copied());
        }
        _ => bytes.truncate(rng.random_range(0..=bytes.len())),
    }
    bytes.truncate(LONGEST);
}

/// Gives every whole chunk of a PNG its right checksum.
fn mend_checksums(bytes: &mut [u8]) {
    let mut at = 8;
    while let Some(length) = bytes.get(at..at + 4).map(|b| u32::from_be_bytes([b[0], b[1], b[2], b[3]]) as usize) {
        let end = at + 8 + length;
        let Some(body) = bytes.get(at + 4..end) else { return };
        let sum = crc32(body).to_be_bytes();
        let Some(place) = bytes.get_mut(end..end + 4) else { return };
        place.copy_from_slice(&sum);
        at = end + 4;
    }
}

/// PNG specification, annex D.
pub fn crc32(data: &[u8]) -> u32 {
    let mut sum = u32::MAX;
    for byte in data {
        sum ^= u32::from(*byte);
        for _ in 0..8 {
            sum = if sum & 1 == 1 { 0xedb8_8320 ^ sum >> 1 } else { sum >> 1 };
        }
    }
    !sum
}
