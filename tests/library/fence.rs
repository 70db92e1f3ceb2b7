//! Panics of decoders are errors, and silent, whatever other threads of the process do.

use std::env;
use std::process::Command;
use std::thread;

use facetmill::fence::{Panicked, fenced};

/// Set for the process that panics.
const CHILD: &str = "FACETMILL_FENCE_CHILD";

#[test]
fn a_fenced_panic_is_silent_while_a_panic_beside_it_is_told() {
    let me = "fence::a_fenced_panic_is_silent_while_a_panic_beside_it_is_told";
    if env::var_os(CHILD).is_none() {
        let mut child = Command::new(env::current_exe().unwrap());
        let run = child.args([me, "--exact", "--nocapture"]).env(CHILD, "1").output().unwrap();
        let told = String::from_utf8_lossy(&run.stderr);
        assert!(run.status.success(), "{told}");
        assert_eq!(told.matches("panicked at").count(), 8, "{told}");
        assert!(!told.contains("within the fence"), "{told}");
        return;
    }
    thread::scope(|scope| {
        let threads: Vec<_> = (0..16)
            .map(|k| {
                scope.spawn(move || {
                    for _ in 0..50 {
                        assert_eq!(fenced(|| panic!("within the fence")).map(|()| 0), Err(Panicked));
                    }
                    assert!(k % 2 == 0, "beside the fence");
                })
            })
            .collect();
        for (k, thread) in threads.into_iter().enumerate() {
            assert_eq!(thread.join().is_ok(), k % 2 == 0);
        }
    });
}
