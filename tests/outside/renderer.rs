//! Exported BRDFs rendered by Mitsuba 3, beside materials of its own.
//!
//! FACETMILL_PYTHON names a Python that has Mitsuba, `python3` if unset. Where it has none the tests are skipped,
//! visibly; with FACETMILL_REQUIRE_CHECKERS=1 that is a failure.

use std::f64::consts::PI;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use facetmill::brdf::material::Material;
use facetmill::export::bsdf::{BsdfColour, BsdfSettings, write_bsdf};
use facetmill::progress::Progress;
use facetmill::relief::faceted::{Facet, FacetedRelief};
use facetmill::slope::Slope;
use facetmill::trace::grid::GridSurface;
use facetmill::verify::experiment::Measuring;
use facetmill::verify::goniometer::sweep::sweep;
use facetmill::verify::goniometer::table::{BrdfAxes, BrdfTable};
use glam::{DVec2, DVec3};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde_json::Value;

use crate::asking;

/// GGX with Smith's separable shadowing and no absorption (Walter et al. 2007), the roughness per axis.
fn ggx(wi: DVec3, wo: DVec3, [ax, ay]: [f64; 2]) -> f64 {
    let m = (wi + wo).normalize();
    let stretched = (m.x / ax).powi(2) + (m.y / ay).powi(2) + m.z * m.z;
    let d = 1.0 / (PI * ax * ay * stretched * stretched);
    let g1 = |w: DVec3| 2.0 / (1.0 + (1.0 + ((ax * w.x).powi(2) + (ay * w.y).powi(2)) / (w.z * w.z)).sqrt());
    d * g1(wi) * g1(wo) / (4.0 * wi.z * wo.z)
}

/// What Mitsuba says of a file that should be GGX of this roughness, or why it says nothing.
fn figures(file: &Path, [ax, ay]: [f64; 2]) -> Result<Value, String> {
    let mut arguments = vec![file.as_os_str().to_owned(), ax.to_string().into(), ay.to_string().into()];
    if let Ok(folder) = std::env::var("FACETMILL_KEEP_PICTURES") {
        arguments.push(Path::new(&folder).join(format!("bsdf_{ax}_{ay}.png")).into());
    }
    let said = asking::ask("bsdf_in_mitsuba.py", &arguments)?;
    Ok(serde_json::from_str(said.lines().last().unwrap_or_default()).unwrap())
}

/// Exports GGX on `axes`, has it judged, and demands that eval() and the sphere are within `most` on average.
fn rendered_alike(alpha: [f64; 2], axes: BrdfAxes, most: f64) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ggx.bsdf");
    let table = BrdfTable::from_fn(axes, |wi, wo| ggx(wi, wo, alpha));
    let mut file = BufWriter::new(File::create(&path).unwrap());
    write_bsdf(BsdfColour::Grey(&table), &BsdfSettings::default(), &mut file).unwrap();
    file.flush().unwrap();
    let report = match figures(&path, alpha) {
        Ok(report) => report,
        Err(why) => return asking::skip("Mitsuba", &why),
    };
    println!("{alpha:?} {report}");
    let number = |a: &str, b: &str| report[a][b].as_f64().unwrap();
    assert!(number("eval", "pairs") > 20_000.0, "{report}");
    assert!(number("eval", "mean") <= most && number("eval", "p99") <= 8.0 * most, "{report}");
    assert!(number("sphere", "mean") <= most && number("sphere", "p99") <= 10.0 * most, "{report}");
    assert!(report["gathered"].as_f64().unwrap() <= 0.02, "{report}");
    assert_eq!(report["warnings"], 0, "{report}");
}

/// A plate of facets in random order, measured with few rays: as noisy a table as anybody will write.
#[test]
fn a_measured_plate_of_random_order_renders_without_a_warning_or_a_negative_value() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(5);
    let facets = (0..900).map(|_| {
        let mut slope = || 0.2 * (random.random::<f64>() - 0.5);
        Facet { height: 1.0, slope: Slope::new(slope(), slope()) }
    });
    let relief = FacetedRelief::uniform(30, 30, DVec2::splat(30.0), facets.collect());
    let surface = GridSurface::new(&relief, &Progress::silent()).unwrap().endless(&Progress::silent()).unwrap();
    let material: Material = "aluminium:ggx:0.05".parse().unwrap();
    let axes = BrdfAxes::anisotropic(polar(8), 4, 64, 64).unwrap();
    let measuring = Measuring { rays: 20_000, ..Measuring::default() };
    let swept = sweep(&surface, &material, axes, &measuring, &Progress::silent()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plate.bsdf");
    let mut file = BufWriter::new(File::create(&path).unwrap());
    let facts = write_bsdf(BsdfColour::Grey(&swept.table), &BsdfSettings::measured(), &mut file).unwrap();
    file.flush().unwrap();
    assert!(facts.least_value >= 0.0 && (facts.light - 1.0).abs() < 1e-4, "{facts:?}");
    let arguments = [path.into_os_string(), "-".into()];
    let said = match asking::ask("bsdf_in_mitsuba.py", &arguments) {
        Ok(said) => said,
        Err(why) => return asking::skip("Mitsuba", &why),
    };
    let report: Value = serde_json::from_str(said.lines().last().unwrap_or_default()).unwrap();
    assert_eq!((&report["alone"]["odd"], &report["warnings"]), (&0.into(), &0.into()), "{report}");
    assert!(report["alone"]["lit"].as_u64().unwrap() > 1000, "{report}");
}

fn polar(count: usize) -> Vec<f64> {
    BrdfAxes::polar_nodes(count, f64::to_radians(88.0))
}

#[test]
fn a_round_lobe_renders_as_mitsubas_own() {
    rendered_alike([0.2, 0.2], BrdfAxes::isotropic(polar(16), 128, 64).unwrap(), 0.01);
}

#[test]
fn a_narrow_lobe_renders_as_mitsubas_own() {
    rendered_alike([0.03, 0.03], BrdfAxes::isotropic(polar(16), 256, 32).unwrap(), 0.01);
}

#[test]
fn a_stretched_lobe_renders_as_mitsubas_own() {
    rendered_alike([0.15, 0.3], BrdfAxes::anisotropic(polar(12), 16, 128, 128).unwrap(), 0.02);
}
