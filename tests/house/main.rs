//! The house rules of CONTRIBUTING.md, read off the sources: what may import what, names, sizes, the guide's file lists,
//! the minimum Rust.

mod imports;
mod names;
mod sizes;
mod source;
mod toolchain;
