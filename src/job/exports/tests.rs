use std::path::Path;

use super::*;

fn repository(file: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(file)).unwrap()
}

#[test]
fn the_readme_lists_every_file_of_a_design_and_the_script_expects_them() {
    let (readme, script) = (repository("README.md"), repository(".ci/run"));
    let table = readme.split_once("| file | what it is |").unwrap().1;
    let table = table.split_once("\n\n").unwrap().0;
    let expected = script.lines().find_map(|line| line.trim().strip_prefix("for file in plate.stl ")).unwrap();
    let mut expected: Vec<&str> = expected.split(';').next().unwrap().split(' ').chain(["plate.stl"]).collect();
    let mut names = names();
    for name in &names {
        assert!(table.contains(&format!("`{name}`")), "README's table of files lacks {name}");
    }
    // The example is a sheet, has a cutter and is proved: it writes all there is but what only goals and facets have.
    let others = [When::Goal, When::Also(Format::Step)];
    let of_others = |name: &&str| DESIGN.iter().any(|export| export.name == *name && others.contains(&export.when));
    names.retain(|name| !of_others(name));
    names.sort_unstable();
    expected.sort_unstable();
    assert_eq!(names, expected, "the files that .ci/run looks for in its example");
}
