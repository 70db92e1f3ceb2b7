use super::*;
use crate::milling::machine::Machine;
use crate::recipe::{Cutter, MachiningSettings};

#[test]
fn a_sheet_of_few_nodes_takes_as_long_as_its_tool_has_places() {
    let mut recipe = Recipe::default();
    (recipe.plate.grid, recipe.plate.cells) = (Some(16), Some(1.into()));
    let seconds = |ball: f64| {
        let mut recipe = recipe.clone();
        recipe.design.sheet.cutter = Some(Cutter::ball(ball));
        estimate(&recipe, 256, false).design_cpu_seconds_about
    };
    // 6.7 s were measured.
    assert!((4.5..10.0).contains(&seconds(1.0)), "{}", seconds(1.0));
    assert!(seconds(0.25) > 2.0 * seconds(1.0));
}

/// A sheet of `cells` and `grid`, for a ball of so many mm if it is more than 0.
fn sheet(cells: usize, grid: usize, ball: f64) -> Recipe {
    let mut recipe = Recipe::default();
    (recipe.plate.cells, recipe.plate.grid) = (Some(cells.into()), Some(grid));
    recipe.design.sheet.cutter = Some(ball).filter(|ball| *ball > 0.0).map(Cutter::ball);
    recipe
}

/// The same with the lamp at 400 mm and the wall at 500 mm.
fn in_room(near: NearMethod, grid: usize, ball: f64) -> Recipe {
    let mut recipe = sheet(3, grid, ball);
    (recipe.scene.lamp_distance, recipe.scene.wall, recipe.scene.near) = (Some(400.0), Some(500.0), Some(near));
    recipe.with_implied()
}

#[test]
fn varied_designs_take_what_their_dry_runs_say() {
    let mut milled = sheet(3, 128, 1.0);
    milled.machining =
        MachiningSettings { machine: Machine::preset("vmc"), stepover: Some(0.05), ..MachiningSettings::default() };
    let mut polished = milled.clone();
    polished.design.sheet.polish = Some(0.04);
    // CPU seconds of release builds (the last two of optimised development builds), files and all, on a busy machine:
    // proved, and beside facets, or not.
    for (name, recipe, proved, measured) in [
        ("facets", Recipe::default().only_for(SurfaceKind::Facets), true, 2.4),
        ("facets without proof", Recipe::default().only_for(SurfaceKind::Facets), false, 1.1),
        ("weyrich2009", Recipe::weyrich2009(), true, 3.5),
        ("sheet", sheet(3, 400, 0.0), true, 10.7),
        ("ball 0.5", sheet(3, 400, 0.5), false, 13.5),
        ("ball 1", sheet(3, 400, 1.0), true, 17.9),
        ("one cell", sheet(1, 400, 0.0), false, 6.0),
        ("one cell, ball 0.5", sheet(1, 400, 0.5), true, 28.4),
        ("as made", milled, true, 48.1),
        ("polished", polished, true, 18.6),
        ("base", in_room(NearMethod::Base, 64, 0.0), true, 3.7),
        ("warp", in_room(NearMethod::Warp, 128, 0.0), true, 5.6),
        ("exact", in_room(NearMethod::Exact, 64, 0.0), true, 7.5),
        ("exact on finer nodes", in_room(NearMethod::Exact, 128, 0.0), false, 12.4),
        ("exact, ball 1", in_room(NearMethod::Exact, 64, 1.0), true, 26.3),
        ("exact, ball 2", in_room(NearMethod::Exact, 64, 2.0), false, 17.4),
    ] {
        let about = estimate(&recipe, 256, proved);
        let told = about.cpu_seconds() + about.comparison_cpu_seconds_about;
        assert!((measured / 1.5..measured * 1.5).contains(&told), "{name}: {told} told, {measured} measured");
    }
}

#[test]
fn times_are_told_for_the_machine_they_are_told_on() {
    let about = estimate(&sheet(3, 128, 0.0), 256, true);
    let slower = about.clone().on_machine(0.5, 2);
    assert_eq!((slower.machine_speed, slower.threads), (0.5, 2));
    assert!((slower.cpu_seconds() / about.cpu_seconds() - 2.0).abs() < 1e-12);
    assert_eq!(about.wall_seconds_about, about.cpu_seconds());
    assert!(slower.wall_seconds_about < slower.cpu_seconds());
    assert_eq!(slower.on_machine(1.0, 1), about);
}

#[test]
fn between_measurements_is_a_power_law_and_beyond_them_proportion() {
    let square: Measured = &[(1.0, 1.0), (10.0, 100.0), (20.0, 400.0)];
    for (size, seconds) in [(1.0, 1.0), (3.0, 9.0), (10.0, 100.0), (15.0, 225.0), (40.0, 800.0), (0.5, 0.5)] {
        assert!((interpolated(square, size) / seconds - 1.0).abs() < 1e-12, "{size}");
    }
}

#[test]
fn a_sheet_takes_about_as_long_as_its_plan_and_its_tool_say() {
    // CPU seconds of designs of the example pictures, one thread of a release build, beside other work.
    for (grid, side, ball, measured) in [
        (64, 10.0, None, 0.93),
        (64, 10.0, Some(0.5), 2.4),
        (64, 30.0, Some(0.3), 5.7),
        (128, 10.0, None, 2.49),
        (128, 10.0, Some(0.5), 3.7),
        (128, 30.0, Some(0.5), 7.8),
        (128, 30.0, Some(1.0), 5.8),
        (400, 10.0, None, 6.5),
        (400, 10.0, Some(0.5), 15.0),
        (400, 30.0, Some(0.5), 17.3),
    ] {
        let mut recipe = Recipe::default();
        (recipe.plate.size, recipe.plate.cells, recipe.plate.grid) = ([side; 2], Some(1.into()), Some(grid));
        recipe.design.sheet.cutter = ball.map(Cutter::ball);
        let told = estimate(&recipe, 256, false).design_cpu_seconds_about;
        assert!((measured / 1.5..measured * 1.5).contains(&told), "{grid} {side} {ball:?}: {told} {measured}");
    }
}
