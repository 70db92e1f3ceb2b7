use std::sync::atomic::{AtomicUsize, Ordering};

use tempfile::TempDir;

use super::claim::LOCK;
use super::*;

const OWN: &[&str] = &["a", "b", "c", "d"];

/// Names and contents of the files in a folder; folders with a slash.
type Listing = Vec<(String, String)>;

fn listing(folder: &Path) -> Listing {
    let mut all: Listing = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap())
        .map(|entry| {
            let name = entry.file_name().into_string().unwrap();
            if entry.path().is_dir() {
                (name + "/", String::new())
            } else {
                (name, fs::read_to_string(entry.path()).unwrap())
            }
        })
        .collect();
    all.sort();
    all
}

fn files(all: &[(&str, &str)]) -> Listing {
    all.iter().map(|(name, content)| ((*name).to_owned(), (*content).to_owned())).collect()
}

fn old() -> Listing {
    files(&[("a", "old"), ("b", "old"), ("d", "old"), ("other", "mine")])
}

fn new() -> Listing {
    files(&[("a", "new"), ("c", "new"), ("d", "new"), ("other", "mine")])
}

/// A folder of an earlier run, with a file of somebody else.
fn earlier() -> TempDir {
    let home = tempfile::tempdir().unwrap();
    for (name, content) in old() {
        fs::write(home.path().join(name), content).unwrap();
    }
    home
}

/// A run that writes a, c and d into `folder`.
fn write(disk: Disk, folder: &Path) -> Result<(), OutputError> {
    let mut staged = Staged::on(disk, &Place::new(folder, true, OWN, &[]), &Arc::default())?;
    for name in ["a", "c", "d"] {
        staged.write_bytes(name, b"new")?;
    }
    staged.publish()
}

/// What the next run finds.
fn next_run(folder: &Path) -> Listing {
    drop(Claim::take(&Disk::default(), folder).unwrap());
    listing(folder)
}

/// A file system that fails from the call number `first` of a `kind` on, counted from 0, if `lasting`, else only then;
/// and how many such calls there were.
fn failing(kind: Option<&'static str>, first: usize, lasting: bool) -> (Disk, Arc<AtomicUsize>) {
    let calls = Arc::new(AtomicUsize::new(0));
    let counted = calls.clone();
    let disk = Disk::with(move |call| {
        if kind.is_some_and(|kind| kind != call) {
            return Ok(());
        }
        let number = counted.fetch_add(1, Ordering::Relaxed);
        if number == first || (lasting && number > first) {
            return Err(io::Error::other(format!("{call} fails")));
        }
        Ok(())
    });
    (disk, calls)
}

/// A file system on which the call number `last` is the last: whatever is called then does nothing, as after a kill.
fn killed(last: usize) -> (Disk, Arc<AtomicUsize>) {
    failing(None, last, true)
}

#[test]
fn a_run_killed_at_any_call_leaves_its_folder_wholly_old_or_wholly_new() {
    let (mut olds, mut news) = (0, 0);
    for last in 0.. {
        let home = earlier();
        let (disk, calls) = killed(last);
        let _ = write(disk, home.path());
        let found = next_run(home.path());
        assert!(found == old() || found == new(), "killed at call {last}: {found:?}");
        olds += usize::from(found == old());
        news += usize::from(found == new());
        if calls.load(Ordering::Relaxed) <= last {
            break;
        }
    }
    // Renames, and what is removed afterwards, fall on the side of the new.
    assert!(olds > 15 && news > 10, "{olds} {news}");
}

#[test]
fn a_next_run_that_is_killed_too_leaves_it_wholly_old_or_wholly_new() {
    let mut twice = 0;
    for last in 0.. {
        let mut is_over = false;
        for second in 0.. {
            let home = earlier();
            let (disk, calls) = killed(last);
            let _ = write(disk, home.path());
            is_over = calls.load(Ordering::Relaxed) <= last;
            let (disk, calls) = killed(second);
            drop(Claim::take(&disk, home.path()));
            let found = next_run(home.path());
            assert!(found == old() || found == new(), "killed at call {last}, then at {second}: {found:?}");
            twice += 1;
            if calls.load(Ordering::Relaxed) <= second {
                break;
            }
        }
        if is_over {
            break;
        }
    }
    assert!(twice > 100, "{twice}");
}

#[test]
fn calls_that_fail_once_or_for_ever_lose_nothing() {
    let kinds = ["mkdir", "create", "open", "write", "fsync", "rename", "unlink", "rmdir"].map(Some);
    let mut halfway = 0;
    for (kind, lasting) in kinds.iter().chain(&[None]).flat_map(|kind| [(*kind, false), (*kind, true)]) {
        for first in 0.. {
            let home = earlier();
            let (disk, calls) = failing(kind, first, lasting);
            let told = write(disk, home.path());
            let (here, found) = (listing(home.path()), next_run(home.path()));
            let context = format!("{kind:?} {first} {lasting}: {told:?} {found:?}");
            match told {
                Ok(()) => assert_eq!(found, new(), "{context}"),
                // Everything is there, and the message names the place.
                Err(OutputError::Halfway(_, place, _)) => {
                    assert!(place.ends_with(HIDDEN) && found == new(), "{context}");
                    halfway += 1;
                }
                Err(_) => {
                    // The old files never left, or are back already.
                    assert!(old().iter().all(|file| here.contains(file)), "{context}: {here:?}");
                    assert_eq!(found, old(), "{context}");
                }
            }
            if calls.load(Ordering::Relaxed) <= first {
                assert!(first > 0, "{kind:?} is never called");
                break;
            }
        }
    }
    assert!(halfway > 0);
}

#[test]
fn a_run_killed_before_it_publishes_leaves_no_mark_that_lasts() {
    let home = tempfile::tempdir().unwrap();
    let folder = home.path().join("deep/er");
    // The last call is the first fsync: a lock and a hidden folder are there.
    let calls = AtomicUsize::new(0);
    let disk = Disk::with(move |call| {
        let is_dead = calls.load(Ordering::Relaxed) > 0 || call == "fsync";
        calls.fetch_add(usize::from(is_dead), Ordering::Relaxed);
        if is_dead { Err(io::Error::other("dead")) } else { Ok(()) }
    });
    assert!(write(disk, &folder).is_err());
    assert_eq!(listing(&folder), files(&[(LOCK, ""), (&format!("{HIDDEN}/"), "")]));
    // Not taken for somebody's, without force.
    let place = Place::new(&folder, false, OWN, &[]);
    let staged = Staged::new(&place, &Arc::default()).unwrap();
    drop(staged);
    assert_eq!(listing(&folder), []);
}

#[test]
fn a_folder_belongs_to_one_run_at_a_time() {
    let home = tempfile::tempdir().unwrap();
    let place = Place::new(home.path(), false, OWN, &[]);
    let staged = Staged::new(&place, &Arc::default()).unwrap();
    assert!(matches!(Staged::new(&place, &Arc::default()), Err(OutputError::Busy(_))));
    drop(staged);
    drop(Staged::new(&place, &Arc::default()).unwrap());
}

#[test]
fn what_comes_in_during_the_work_is_left_alone_without_force() {
    for (force, inner) in [(false, &[][..]), (true, &[]), (false, &["kept"])] {
        let home = tempfile::tempdir().unwrap();
        let folder = home.path().join("plate");
        let place = Place { inner, ..Place::new(&folder, force, OWN, &[]) };
        let mut staged = Staged::new(&place, &Arc::default()).unwrap();
        staged.write_bytes("a", b"new").unwrap();
        if inner.is_empty() {
            fs::write(folder.join("a"), "mine").unwrap();
        } else {
            fs::create_dir(folder.join("kept")).unwrap();
        }
        match staged.publish() {
            Err(OutputError::CameIn(_)) => {
                assert!(!force && inner.is_empty());
                assert_eq!(listing(&folder), files(&[("a", "mine")]));
            }
            done => {
                done.unwrap();
                assert!(force || !inner.is_empty());
                assert_eq!(fs::read(folder.join("a")).unwrap(), b"new");
            }
        }
        // Nor is a folder replaced that has come in under the name of a file.
        let mut staged = Staged::new(&Place::new(&folder, true, OWN, &[]), &Arc::default()).unwrap();
        staged.write_bytes("b", b"new").unwrap();
        fs::create_dir(folder.join("d")).unwrap();
        assert!(matches!(staged.publish(), Err(OutputError::AFolder(_))));
        assert!(folder.join("d").is_dir() && !folder.join("b").exists());
    }
}

#[test]
fn what_a_run_reads_is_never_replaced() {
    let home = earlier();
    let at = |name: &str| home.path().join(name);
    fs::create_dir(at("kept")).unwrap();
    fs::write(at("kept/state"), "").unwrap();
    let mut inputs = vec![at("a"), at("./kept/../a"), at("kept/state")];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(at("b"), at("link")).unwrap();
        fs::hard_link(at("d"), at("twin")).unwrap();
        inputs.extend([at("link"), at("twin")]);
    }
    let before = listing(home.path());
    for input in &inputs {
        let read = [input.as_path()];
        let place = Place { inner: &["kept"], ..Place::new(home.path(), true, OWN, &read) };
        let refused = Staged::new(&place, &Arc::default()).err();
        assert!(matches!(refused, Some(OutputError::OwnInput(..))), "{}: {refused:?}", input.display());
        assert_eq!(listing(home.path()), before);
    }
    // A file beside ours may be read.
    let (read, force) = ([&*at("other")], true);
    assert!(Staged::new(&Place::new(home.path(), force, OWN, &read), &Arc::default()).is_ok());
}

#[test]
fn leftovers_of_earlier_versions_are_swept_unless_they_hold_the_only_copy() {
    let home = tempfile::tempdir().unwrap();
    for (name, replaced) in [(".facetmill-aB3dE6", None), (".facetmill-000000", Some("plate.stl"))] {
        let hidden = home.path().join(name);
        fs::create_dir_all(hidden.join("replaced")).unwrap();
        fs::write(hidden.join("report.json"), "").unwrap();
        if let Some(replaced) = replaced {
            fs::write(hidden.join("replaced").join(replaced), "old").unwrap();
        }
    }
    fs::create_dir(home.path().join(".facetmill-notes")).unwrap();
    let left = next_run(home.path());
    assert_eq!(left, files(&[(".facetmill-000000/", ""), (".facetmill-notes/", "")]));
    assert!(home.path().join(".facetmill-000000/replaced/plate.stl").exists());
}

#[test]
fn a_broken_or_forged_journal_moves_nothing() {
    for names in ["", r#"{"new":["../stolen"],"removed":[]}"#, r#"{"new":[],"removed":["../mine"]}"#] {
        let outer = tempfile::tempdir().unwrap();
        let home = outer.path().join("home");
        fs::write(outer.path().join("mine"), "mine").unwrap();
        fs::create_dir_all(home.join(HIDDEN).join("new")).unwrap();
        fs::create_dir_all(home.join(HIDDEN).join("old")).unwrap();
        fs::write(home.join(HIDDEN).join("stolen"), "").unwrap();
        for sum in [0, journal::checksum(names)] {
            fs::write(home.join(HIDDEN).join("journal"), format!("{sum:016x}\n{names}\n")).unwrap();
            let told = settle(&[&home]).unwrap_err().to_string();
            assert!(told.contains("is broken") && told.contains(HIDDEN), "{told}");
            assert_eq!(listing(outer.path()), files(&[("home/", ""), ("mine", "mine")]));
            assert!(home.join(HIDDEN).join("stolen").exists());
        }
    }
}

#[test]
fn own_files_are_replaced_or_removed_and_others_stay() {
    let home = earlier();
    write(Disk::default(), home.path()).unwrap();
    assert_eq!(listing(home.path()), new());
}

#[test]
fn made_folders_go_unless_published() {
    let home = tempfile::tempdir().unwrap();
    let deep = home.path().join("one/two/three");
    drop(Claim::take(&Disk::default(), &deep).unwrap());
    assert!(!home.path().join("one").exists());
    let too_long = home.path().join("one").join("n".repeat(300));
    assert!(Claim::take(&Disk::default(), &too_long).is_err());
    assert!(!home.path().join("one").exists());
    write(Disk::default(), &deep).unwrap();
    assert_eq!(listing(&deep), files(&[("a", "new"), ("c", "new"), ("d", "new")]));
}
