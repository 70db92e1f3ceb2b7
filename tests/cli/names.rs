//! Names of files and folders.

use std::fs;

use super::program::{home, run};
use super::{assert_done, assert_refused, assert_same_plate};

#[test]
fn unusual_names_are_names() {
    let home = home();
    fs::create_dir(home.path().join("mes dessins")).unwrap();
    fs::copy(home.path().join("ring.png"), home.path().join("mes dessins/Кольцо ✨.png")).unwrap();
    let quick = ["--facets", "4x4", "--no-verify"];
    let done =
        run(home.path(), ["design", "mes dessins/Кольцо ✨.png", "-o", "résultat du jour/1"].iter().chain(&quick));
    assert_done(&done);
    assert!(done.told().contains("résultat du jour/1"), "{}", done.stdout);
    // The recipe's picture is looked for beside the recipe, then from the working folder.
    let again = ["design", "--recipe", "résultat du jour/1/recipe.toml", "-o", "-dash", "--no-verify"];
    assert_done(&run(home.path(), again.map(|word| word.replace("-dash", "./-dash"))));
    assert_same_plate(
        &home.path().join("résultat du jour/1"),
        &home.path().join("-dash"),
        &["simulated.png", "comparison.png"],
    );
    fs::create_dir(home.path().join("elsewhere")).unwrap();
    let lost = run(&home.path().join("elsewhere"), ["design", "--recipe", "../-dash/recipe.toml", "-o", "x"]);
    assert_refused(
        &lost,
        3,
        &["../-dash/recipe.toml", "names the picture", "../-dash/mes dessins/Кольцо", "nor mes dessins"],
    );
    fs::create_dir(home.path().join("-dash/mes dessins")).unwrap();
    fs::copy(home.path().join("ring.png"), home.path().join("-dash/mes dessins/Кольцо ✨.png")).unwrap();
    let beside = ["design", "--recipe", "../-dash/recipe.toml", "-o", "x", "--no-verify"];
    assert_done(&run(&home.path().join("elsewhere"), beside));
    // A name cannot write to the terminal or break the line.
    assert_refused(&run(home.path(), ["design", "no\n\u{1b}[31msuch.png", "-o", "x"]), 3, &["such.png"]);
}

#[cfg(unix)]
#[test]
fn names_that_are_not_unicode_are_names_too() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;

    let home = home();
    let (picture, folder) = (OsStr::from_bytes(b"r\xffng.png"), OsStr::from_bytes(b"f\xfelder"));
    if let Err(error) = fs::copy(home.path().join("ring.png"), home.path().join(picture)) {
        eprintln!("skipped: this file system takes no such names ({error})");
        return;
    }
    let [design, o, facets, four, no_verify] = ["design", "-o", "--facets", "4x4", "--no-verify"].map(OsStr::new);
    assert_done(&run(home.path(), [design, picture, o, folder, facets, four, no_verify]));
    // The recipe holds the name, byte by byte.
    let recipe = home.path().join(folder).join("recipe.toml");
    let again = [design, OsStr::new("--recipe"), recipe.as_os_str(), o, OsStr::new("again"), no_verify];
    assert_done(&run(home.path(), again));
    let plate = |folder: &OsStr| fs::read(home.path().join(folder).join("plate.stl")).unwrap();
    assert!(plate(folder) == plate(OsStr::new("again")));
}
