//! Recipes that are none, or ask for what cannot be.

use std::fs;

use super::Trials;

/// Recipe after `picture = "ring.png"`, exit code, what the sentence must name besides the file.
const RECIPES: &[(&str, i32, &str)] = &[
    ("[light]\nthata = 3\n", 3, "line 3"),
    ("[lamp]\ntheta = 3\n", 3, "lamp"),
    ("colour = 'red'\n", 3, "colour"),
    ("[highlight]\nhalf-field = 'twenty'\n", 3, "line 3"),
    ("[highlight]\nhalf-field = nan\n", 3, "half-field"),
    ("[highlight]\nhalf-field = 0\n", 3, "half-field"),
    ("[highlight]\nprojection = 'fish-eye'\n", 3, "fish-eye"),
    ("[highlight]\nencoding = 'cmyk'\n", 3, "cmyk"),
    ("[highlight]\ninvert = 1\n", 3, "line 3"),
    ("[highlight]\nrotate = inf\n", 3, "rotate"),
    ("[light]\ntheta = 90\n", 3, "light"),
    ("[light]\ntheta = -1e-9\n", 3, "light"),
    ("[light]\nradius = 89.5\n", 3, "light-radius"),
    ("[plate]\nsize = 30\n", 3, "line 3"),
    ("[plate]\nsize = [30]\n", 3, "line 3"),
    ("[plate]\nsize = [30, 30, 30]\n", 3, "two numbers"),
    ("[plate]\nsize = ['30', '30']\n", 3, "line 3"),
    ("[plate]\nsize = [nan, 30]\n", 3, "size"),
    ("[plate]\nsize = [30, -30]\n", 3, "size"),
    ("[plate]\nfacets = [-1, 3]\n", 3, "line 3"),
    ("[plate]\nfacets = [1.5, 2]\n", 3, "line 3"),
    ("[plate]\nfacets = [0, 2]\n", 3, "facets"),
    ("[plate]\nfacets = [99999999999999999999, 2]\n", 3, "line 3"),
    ("[plate]\nfacets = [9223372036854775807, 9223372036854775807]\n", 3, "facets"),
    ("[plate]\nfacets = [4000, 4000]\n", 4, "4000x4000"),
    ("[plate]\ncells = 7\nfacets = [30, 30]\n", 4, "7x7"),
    ("[plate]\ncells = 9223372036854775807\n", 3, "cells"),
    ("[plate]\nthickness = 0\n", 3, "thickness"),
    ("[plate]\nlobe = -1\n", 3, "lobe"),
    ("[plate]\nsurface = 'curved'\n", 3, "curved"),
    ("[plate]\nsurface = {}\n", 3, "line 3"),
    ("[plate]\nsurface = 'flat'\ngrid = 64\n", 3, "grid is for a sheet"),
    ("[plate]\nfacets = [20, 20]\n[design]\nmax-depth = 1\n", 3, "max-depth is for a sheet"),
    ("[plate]\nsurface = 'continuous'\nfacets = [30, 30]\n", 3, "facets is for flat facets"),
    ("[plate]\nsurface = 'continuous'\n[design.annealing]\nswaps = 5\n", 3, "annealing is for flat facets"),
    ("[design]\nseed = -1\n", 3, "line 3"),
    ("[design]\nseed = 18446744073709551616\n", 3, "line 3"),
    ("[design]\nseed = 18446744073709551615\n", 3, "recipe.toml"),
    ("[design]\nheights = 'none'\n", 3, "none"),
    ("[design.distribution]\nslope-cap = nan\n", 3, "slope-cap"),
    ("[design.annealing]\nvalleys = nan\n", 3, "annealing.valleys"),
    ("[design.annealing]\nswaps = 9000000000000000000\n", 3, "annealing.swaps"),
    ("[design.annealing]\nstarts = 0\n", 3, "annealing.starts"),
    ("[verify]\nrays = 0\n", 3, "rays"),
    ("[verify]\nrays = 1979-05-27\n", 3, "line 3"),
    ("picture = 'star.png'\n", 3, "line 2"),
    ("[plate\n", 3, "line 2"),
    ("plate = [[[[\n", 3, "recipe.toml"),
    ("\0", 3, "line 2"),
];

/// Whole files.
const FILES: &[(&str, &[u8], i32, &str)] = &[
    ("empty", b"", 3, "names no picture"),
    ("no picture", b"[plate]\ncells = 2\n", 3, "names no picture"),
    ("missing picture", b"picture = 'star.png'\n", 3, "star.png"),
    ("picture without name", b"picture = ''\n", 3, "names no picture"),
    ("picture with a zero byte", b"picture = \"a\\u0000b\"\n", 3, "a"),
    ("a directory as picture", b"picture = '.'\n", 3, "directory"),
    ("a number as picture", b"picture = 5\n", 3, "line 1"),
    ("recipe as picture", b"picture = 'recipe.toml'\n", 3, "text"),
    ("not UTF-8", b"picture = 'r\xffng.png'\n", 3, "recipe.toml"),
    ("a PNG", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 3, "recipe.toml"),
    ("JSON", b"{\"picture\": \"ring.png\"}\n", 3, "line 1"),
];

#[test]
fn recipes_without_meaning_are_named() {
    let mut trials = Trials::new();
    let file = trials.home().join("recipe.toml");
    let args = ["design", "--recipe", "recipe.toml", "-o", "out/deep"];
    for (text, code, name) in RECIPES {
        fs::write(&file, format!("picture = 'ring.png'\n{text}")).unwrap();
        trials.refused(&args, *code, &["recipe.toml", name]);
    }
    for (_, bytes, code, name) in FILES {
        fs::write(&file, bytes).unwrap();
        trials.refused(&args, *code, &[name]);
    }
    trials.judge();
}

#[test]
fn recipes_made_to_exhaust_are_refused() {
    let mut trials = Trials::new();
    let file = trials.home().join("recipe.toml");
    let args = ["design", "--recipe", "recipe.toml", "-o", "out"];
    let nested = format!("a = {}", "[".repeat(500_000));
    let dotted = format!("{}b = 1", "a.".repeat(200_000));
    let tables = "[[a]]\n".repeat(100_000);
    let large = "# nothing\n".repeat(200_000);
    for text in [nested, dotted, tables, large] {
        fs::write(&file, text).unwrap();
        trials.refused(&args, 3, &["recipe.toml"]);
    }
    for path in ["missing.toml", ".", "ring.png/recipe.toml", "/dev/zero", "/dev/null"] {
        if !path.starts_with("/dev") || cfg!(unix) {
            trials.refused(&["design", "--recipe", path, "-o", "out"], 3, &[path]);
        }
    }
    // What a flag spoils is the flag's fault.
    fs::write(&file, "picture = 'ring.png'\n").unwrap();
    trials.refused(&[&args[..], &["--light", "89,0"]].concat(), 2, &["--light"]);
    trials.judge();
}
