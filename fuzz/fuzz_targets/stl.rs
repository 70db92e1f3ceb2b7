#![no_main]

#[allow(dead_code, reason = "each program fuzzes one of the targets")]
#[path = "../../tests/library/mutants/targets.rs"]
mod targets;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    targets::mesh(bytes);
});
