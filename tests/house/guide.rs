//! ARCHITECTURE.md names files and what stands in them: both are there.

use std::fs;

use crate::source::root;

/// Words in backticks.
fn quoted(line: &str) -> Vec<&str> {
    line.split('`').skip(1).step_by(2).collect()
}

#[test]
fn every_step_of_the_guide_names_a_file_that_holds_what_it_says() {
    let guide = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let mut steps = 0;
    for section in guide.split("\n## ").filter(|section| section.starts_with("To add")) {
        let title = section.lines().next().unwrap();
        // A step is an item of a list that begins with its file.
        for step in section.lines().filter(|line| line.starts_with("- `")) {
            let names = quoted(step);
            let text = fs::read_to_string(root().join(names[0]));
            let text = text.unwrap_or_else(|why| panic!("'{title}' names {}: {why}", names[0]));
            for name in &names[1..] {
                assert!(text.contains(name), "'{title}': {} does not mention {name}", names[0]);
            }
            steps += 1;
        }
        let titles =
            ["To add a setting", "To add a cutter", "To add a substance", "To add a goal", "To add an exporter"];
        let known = titles
            .iter()
            .chain(&["To add a lamp", "To add a model of reflectance"])
            .any(|known| title.starts_with(known));
        assert!(known && section.contains("\n- `"), "{title}");
    }
    assert_eq!(guide.matches("\n## To add").count(), 7, "one section for each");
    assert!(steps >= 12, "{steps}");
}

#[test]
fn the_map_names_every_module_of_the_library_in_its_order() {
    let guide = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let library = fs::read_to_string(root().join("src/lib.rs")).unwrap();
    let map = guide.split("\n## ").find(|section| section.starts_with("Map")).unwrap();
    let rows: Vec<&str> = map
        .lines()
        .filter(|line| line.starts_with("| `"))
        .flat_map(|row| quoted(&row[..row[2..].find('|').unwrap() + 2]))
        .collect();
    let modules: Vec<&str> =
        library.lines().filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';')).collect();
    assert_eq!(rows, modules);
}
