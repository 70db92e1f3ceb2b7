//! The house rules of CONTRIBUTING.md, read off the sources: what may import what, names, sizes, the guide's file lists,
//! the minimum Rust.

mod guide;
mod imports;
mod names;
mod sizes;
mod source;
mod toolchain;

/// What is still to be mended: beginnings of offences that the rules let pass.
const OPEN: &[&str] = &[
    "job::report refers to job::product",
    "job::product refers to job::exports",
    "src/bin/facetmill/design.rs",
    "src/bin/facetmill/measure/",
    "src/bin/facetmill/verify.rs",
    "src/job/",
    "src/sculpt/",
];

/// Fails with all offences but those that are known to be open.
fn none(offences: Vec<String>) {
    let new: Vec<_> = offences.into_iter().filter(|one| !OPEN.iter().any(|open| one.starts_with(open))).collect();
    assert!(new.is_empty(), "{} of\n{}", new.len(), new.join("\n"));
}
