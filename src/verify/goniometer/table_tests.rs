use std::f64::consts::{FRAC_1_PI, PI, TAU};

use super::*;
use crate::slope::{direction, mirror};

/// GGX with Smith's separable shadowing and no absorption (Walter et al. 2007), the roughness per axis.
fn ggx(wi: DVec3, wo: DVec3, ax: f64, ay: f64) -> f64 {
    let m = (wi + wo).normalize();
    let stretched = (m.x / ax).powi(2) + (m.y / ay).powi(2) + m.z * m.z;
    let d = 1.0 / (PI * ax * ay * stretched * stretched);
    let g1 = |w: DVec3| 2.0 / (1.0 + (1.0 + ((ax * w.x).powi(2) + (ay * w.y).powi(2)) / (w.z * w.z)).sqrt());
    d * g1(wi) * g1(wo) / (4.0 * wi.z * wo.z)
}

fn axes(isotropic: bool) -> BrdfAxes {
    let polar = BrdfAxes::polar_nodes(10, f64::to_radians(85.0));
    if isotropic {
        BrdfAxes::isotropic(polar, 64, 32).unwrap()
    } else {
        BrdfAxes::anisotropic(polar, 8, 64, 32).unwrap()
    }
}

#[test]
fn the_cells_tile_the_hemisphere_of_viewers() {
    // The projected solid angle of a hemisphere is π: all cells above the horizon together, under any light.
    for axes in [axes(true), axes(false)] {
        for slice in [0, 3, 9, axes.slices() - 1] {
            let sum: f64 = (0..axes.cells()).map(|cell| axes.projected(slice, cell)).sum();
            assert!((sum / PI - 1.0).abs() < 1e-4, "{slice} {sum}");
        }
    }
}

#[test]
fn a_lambertian_table_is_flat_reciprocal_and_as_white_as_it_should_be() {
    let table = BrdfTable::from_fn(axes(false), |_, _| 0.5 * FRAC_1_PI);
    let laws = table.laws();
    assert!((laws.least - 0.5 * FRAC_1_PI).abs() < 1e-7 && laws.reciprocity_error < 0.01, "{laws:?}");
    assert!((laws.greatest_albedo.0 - 0.5).abs() < 1e-4);
    let value = table.at(direction(0.7, 1.0), direction(1.2, -3.0));
    // Between polar nodes f cosθ is linear, not f: a flat BRDF is the worst case, and good to a percent.
    assert!((value / (0.5 * FRAC_1_PI) - 1.0).abs() < 0.02, "{value}");
    assert_eq!(table.at(direction(2.0, 0.0), DVec3::Z), 0.0);
    assert_eq!(table.at(DVec3::Z, direction(2.0, 0.0)), 0.0);
}

#[test]
fn counted_light_becomes_the_brdf_that_sent_it() {
    // The flux of a known BRDF through every cell, counted: the table must be that of the BRDF.
    let f = |wi, wo| ggx(wi, wo, 0.3, 0.2);
    let truth = BrdfTable::from_fn(axes(false), f);
    let mut counted = BrdfTable::new(axes(false));
    let axes = truth.axes();
    for slice in 0..axes.slices() {
        let flux: Vec<f64> = (0..axes.cells())
            .map(|cell| {
                let mut sum = 0.0;
                axes.quadrature(slice, cell, |o, weight| sum += weight * f(axes.incident(slice), o));
                sum
            })
            .collect();
        let error: Vec<f64> = flux.iter().map(|v| 0.01 * v).collect();
        assert_eq!(counted.set_flux(slice, &flux, &error).unwrap(), 0.0);
        let (albedo, apart) = counted.albedo(slice);
        assert!((albedo - flux.iter().sum::<f64>()).abs() < 1e-6 && albedo <= 1.0 && apart < 0.01 * albedo);
        for ((a, b), e) in truth.slice(slice).iter().zip(counted.slice(slice)).zip(counted.slice_error(slice)) {
            assert!(a.is_nan() && b.is_nan() || (a - b).abs() <= 1e-6 * a && (e - 0.01 * a).abs() <= 1e-6 * a);
        }
    }
    assert_eq!(counted.set_flux(0, &[0.0], &[0.0]), Err(TableError::Shape));
    let cells = axes.cells();
    assert_eq!(counted.set_flux(0, &vec![f64::NAN; cells], &vec![0.0; cells]), Err(TableError::NotFinite));
}

#[test]
fn a_direction_falls_into_the_cell_its_half_vector_names() {
    for axes in [axes(true), axes(false)] {
        for slice in [0, 5, axes.slices() - 1] {
            for cell in (0..axes.cells()).step_by(7) {
                let (column, row) = (cell % 64, cell / 64);
                let m = axes.half_vector(slice, (column as f64 + 0.3) / 64.0, (row as f64 + 0.6) / 32.0);
                let o = mirror(axes.incident(slice), m);
                // A half vector turned away from the light is the bisector of nothing.
                if o.z > 0.0 && m.dot(axes.incident(slice)) > 0.0 {
                    assert_eq!(axes.cell(slice, o), Some(cell), "{slice}");
                }
            }
            assert_eq!(axes.cell(slice, -DVec3::Z), None);
        }
    }
}

#[test]
fn between_its_nodes_a_table_follows_the_lobe_and_keeps_reciprocity() {
    for (ax, ay) in [(0.2, 0.2), (0.15, 0.3)] {
        let polar = BrdfAxes::polar_nodes(12, f64::to_radians(87.0));
        let axes = if ax == ay {
            BrdfAxes::isotropic(polar, 128, 48).unwrap()
        } else {
            BrdfAxes::anisotropic(polar, 16, 128, 48).unwrap()
        };
        let table = BrdfTable::from_fn(axes, |wi, wo| ggx(wi, wo, ax, ay));
        let (mut apart, mut count, mut worst) = (0.0, 0.0, 0.0f64);
        for k in 0..500 {
            let k = f64::from(k);
            let wi = direction(1.2 * (0.618 * k).fract(), TAU * (0.755 * k).fract());
            let m = direction(0.4 * (0.324 * k).fract(), TAU * (0.211 * k).fract());
            let wo = mirror(wi, m);
            if wo.z < 0.1 {
                continue;
            }
            let (found, wanted) = (table.at(wi, wo), ggx(wi, wo, ax, ay));
            let error = (found / wanted - 1.0).abs();
            (apart, count, worst) = (apart + error, count + 1.0, worst.max(error));
        }
        assert!(count > 300.0 && apart / count < 0.015 && worst < 0.1, "{} {worst} of {count}", apart / count);
        if ax != ay {
            continue;
        }
        let laws = table.laws();
        assert!(laws.reciprocity_error < 0.01, "{laws:?}");
        assert!(laws.least >= 0.0 && laws.greatest_albedo.0 <= 1.0 && laws.greatest_albedo.0 > 0.9, "{laws:?}");
    }
}

#[test]
fn a_brdf_that_breaks_the_laws_is_found_out() {
    let lopsided = BrdfTable::from_fn(axes(true), |wi, _| wi.z);
    assert!(lopsided.reciprocity_error() > 0.1);
    assert!(lopsided.laws().greatest_albedo.0 > 1.0);
    assert!(BrdfTable::from_fn(axes(true), |_, wo| wo.z - 0.5).laws().least < 0.0);
}

#[test]
fn axes_that_are_none_are_refused() {
    let polar = || BrdfAxes::polar_nodes(5, 1.5);
    assert_eq!(BrdfAxes::isotropic(vec![0.0, 1.6], 8, 8), Err(TableError::Polar));
    assert_eq!(BrdfAxes::isotropic(vec![0.1, 1.0], 8, 8), Err(TableError::Polar));
    assert_eq!(BrdfAxes::isotropic(vec![0.0, f64::NAN], 8, 8), Err(TableError::Polar));
    assert_eq!(BrdfAxes::anisotropic(polar(), 3, 8, 8), Err(TableError::Azimuths(3)));
    let cells = TableError::Cells { columns: 8, rows: usize::MAX };
    assert_eq!(BrdfAxes::isotropic(polar(), 8, usize::MAX), Err(cells));
}

#[test]
fn what_is_kept_of_turned_light_is_what_each_slice_has_of_its_own() {
    for (azimuths, rows) in [(4, 12), (5, 12), (6, 12)] {
        let axes = BrdfAxes::anisotropic(vec![0.0, 0.4, 1.3], azimuths, 10, rows).unwrap();
        let table = BrdfTable::new(axes.clone());
        for slice in 0..axes.slices() {
            for (cell, &kept) in table.slice_projected(slice).iter().enumerate() {
                assert!((f64::from(kept) - axes.projected(slice, cell)).abs() < 2e-5, "{azimuths} {slice} {cell}");
            }
        }
    }
}
