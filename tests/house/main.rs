//! The house rules of CONTRIBUTING.md, read off the sources: what may import what, names, sizes, the guide's file lists,
//! the minimum Rust.

mod guide;
mod imports;
mod names;
mod sizes;
mod source;
mod toolchain;

/// Fails with all offences.
fn none(offences: Vec<String>) {
    assert!(offences.is_empty(), "{} of\n{}", offences.len(), offences.join("\n"));
}
