//! Plates of facets as a cutter leaves them.

use super::program::{home, run_line};
use super::{assert_done, assert_refused, assert_same_plate, json};

#[test]
fn facets_stay_as_they_are_and_the_proof_says_what_a_ball_makes_of_them() {
    let home = home();
    let line = |folder: &str, flags: &str| {
        format!("design ring.png -o {folder} --facets 12x12 --size 12x12 --arrange random --rays 20000 {flags}")
    };
    assert_done(&run_line(home.path(), &line("bare", "")));
    let told = run_line(home.path(), &line("fine", "--for-cutter ball:0.2 --verbose"));
    assert_done(&told);
    assert!(told.told().contains("misplaced as milled"), "{}", told.stdout);
    assert!(
        told.stdout.starts_with("Cut by ball:0.2, ") && told.told().contains("at fine/comparison_milled.png first")
    );
    assert_done(&run_line(home.path(), &line("blunt", "--for-cutter ball:1 --threads 1")));
    assert_done(&run_line(home.path(), &line("blunt2", "--for-cutter ball:1 --threads 2")));
    let folder = |name: &str| home.path().join(name);
    assert_same_plate(&folder("bare"), &folder("fine"), &["recipe.toml", "report.json"]);
    assert_same_plate(&folder("blunt"), &folder("blunt2"), &[]);
    assert!(!folder("bare").join("comparison_milled.png").exists());
    assert!(folder("fine").join("comparison_milled.png").exists());

    let [bare, fine, blunt] = ["bare", "fine", "blunt"].map(|name| json(folder(name).join("report.json")));
    assert!(bare.get("as_milled").is_none());
    assert_eq!(bare["designed"], fine["designed"]);
    let misplaced = |figures: &serde_json::Value| figures["tv_incident"]["1"].as_f64().unwrap();
    // Walls of a random order are hardly a tenth of a millimetre high: the blunter the ball, the more of a facet is lost.
    let [designed, fine, blunt] = [&fine["designed"], &fine["as_milled"], &blunt["as_milled"]].map(misplaced);
    assert!(fine > designed + 0.02 && blunt > fine + 0.05, "{designed} {fine} {blunt}");

    let refused = run_line(home.path(), &line("none", "--for-cutter ball:0.001"));
    assert_refused(&refused, 4, &["--for-cutter", "0.001", "--size"]);
}
