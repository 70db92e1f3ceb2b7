use super::*;
use std::collections::HashMap;

/// Every field of a tensor file as shape and numbers, read the way the format is documented.
fn fields(bytes: &[u8]) -> HashMap<String, (Vec<usize>, Vec<f64>)> {
    assert_eq!(&bytes[..14], b"tensor_file\0\x01\x00");
    let count = u32::from_le_bytes(bytes[14..18].try_into().unwrap());
    let mut at = 18;
    let mut take = |n: usize| {
        at += n;
        &bytes[at - n..at]
    };
    let mut found = HashMap::new();
    for _ in 0..count {
        let length = u16::from_le_bytes(take(2).try_into().unwrap()) as usize;
        let name = String::from_utf8(take(length).to_vec()).unwrap();
        let rank = u16::from_le_bytes(take(2).try_into().unwrap()) as usize;
        let kind = take(1)[0];
        let offset = u64::from_le_bytes(take(8).try_into().unwrap()) as usize;
        let shape: Vec<usize> = (0..rank).map(|_| u64::from_le_bytes(take(8).try_into().unwrap()) as usize).collect();
        let n: usize = shape.iter().product();
        assert_eq!(offset % 8, 0);
        let values = match kind {
            1 => bytes[offset..offset + n].iter().map(|b| f64::from(*b)).collect(),
            10 => {
                let floats = bytes[offset..offset + 4 * n].chunks_exact(4);
                floats.map(|b| f64::from(f32::from_le_bytes(b.try_into().unwrap()))).collect()
            }
            _ => panic!("{kind}"),
        };
        found.insert(name, (shape, values));
    }
    found
}

fn table(azimuths: usize, f: impl Fn(glam::DVec3, glam::DVec3) -> f64 + Sync) -> BrdfTable {
    let polar = BrdfAxes::polar_nodes(6, 1.4);
    let axes = if azimuths == 1 {
        BrdfAxes::isotropic(polar, 48, 16).unwrap()
    } else {
        BrdfAxes::anisotropic(polar, azimuths, 48, 16).unwrap()
    };
    BrdfTable::from_fn(axes, f)
}

fn written(colour: BsdfColour, samples: usize) -> Vec<u8> {
    let mut out = Vec::new();
    write_bsdf(colour, &BsdfSettings { samples, ..BsdfSettings::default() }, &mut out).unwrap();
    out
}

/// A lobe of no particular model, not symmetric in any way.
fn lobe(wi: glam::DVec3, wo: glam::DVec3) -> f64 {
    let m = (wi + wo).normalize();
    (-((m.x - 0.1).powi(2) / 0.08 + (m.y + 0.05).powi(2) / 0.03)).exp() * (2.0 + wi.x * wo.x)
}

#[test]
fn the_fields_have_the_shapes_readers_check() {
    for (azimuths, nodes) in [(1, 1), (5, 6)] {
        let table = table(azimuths, lobe);
        let found = fields(&written(BsdfColour::Grey(&table), 12));
        let shape = |name: &str| found[name].0.clone();
        assert_eq!(shape("theta_i"), [6]);
        assert_eq!(shape("phi_i"), [nodes]);
        assert_eq!(shape("ndf"), [17, 49]);
        assert_eq!(shape("vndf"), [nodes, 6, 17, 49]);
        assert_eq!(shape("luminance"), [nodes, 6, 12, 12]);
        assert_eq!(shape("rgb"), [nodes, 6, 3, 12, 12]);
        assert_eq!(found["jacobian"].1, [1.0]);
        assert!(found.values().all(|(_, values)| values.iter().all(|v| v.is_finite())));
        // Every direction is its own distribution, and the circle of azimuths is closed.
        let vndf = &found["vndf"].1;
        assert!(vndf.iter().all(|v| *v >= 0.0));
        if nodes > 1 {
            assert_eq!(vndf[..6 * 17 * 49], vndf[5 * 6 * 17 * 49..]);
            assert!((found["phi_i"].1[5] - PI).abs() < 1e-6);
        }
    }
    let one = table(1, lobe);
    let found = fields(&written(BsdfColour::Spectral(&[(400.0, &one), (700.0, &one)]), 12));
    assert_eq!(found["wavelengths"].1, [400.0, 700.0]);
    assert_eq!(found["spectra"].0, [1, 6, 2, 12, 12]);
    assert!(!found.contains_key("rgb"));
}

#[test]
fn read_back_as_documented_the_file_gives_the_brdf() {
    for azimuths in [1, 8] {
        let f = |wi: glam::DVec3, wo: glam::DVec3| {
            let m = (wi + wo).normalize();
            let wide = if azimuths == 1 { 0.1 } else { 0.16 };
            (-(m.x * m.x / 0.1 + m.y * m.y / wide)).exp() * (0.5 + wi.z * wo.z)
        };
        let table = table(azimuths, f);
        let found = fields(&written(BsdfColour::Grey(&table), 48));
        let back = read_bsdf(&written(BsdfColour::Grey(&table), 48)).unwrap();
        for (wi, wo) in [((0.3, 0.5), (0.4, 3.3)), ((0.9, -1.0), (0.8, 2.0)), ((0.1, 0.0), (0.2, 1.0))] {
            let (wi, wo) = (crate::slope::direction(wi.0, wi.1), crate::slope::direction(wo.0, wo.1));
            let (got, wanted) = (back.at(wi, wo), table.at(wi, wo));
            assert!((got / wanted - 1.0).abs() < 0.05, "{azimuths}: {got} {wanted}");
        }
        let axes = table.axes();
        for slice in [1, 4, axes.slices() - 2] {
            let vndf = &found["vndf"].1[slice * 17 * 49..][..17 * 49];
            let warp = Warp::new(vndf, 49);
            let (theta, phi) = axes.incident_angles(slice);
            let l = axes.incident(slice);
            let sigma = bilinear(&found["sigma"].1, SIGMA_NODES, (theta * 2.0 / PI).sqrt(), (phi + PI) / TAU);
            let (mut apart, mut count) = (0.0, 0.0);
            for k in 0..48 * 48 {
                let (u, v) = warp.sample((k % 48) as f64 / 47.0, (k / 48) as f64 / 47.0);
                let m = axes.half_vector(slice, u, v);
                let o = mirror(l, m);
                if o.z < 0.1 || !(0.02..=0.45).contains(&u) {
                    continue;
                }
                let colour = found["rgb"].1[slice * 3 * 48 * 48 + k];
                let value = colour * bilinear(&found["ndf"].1, 49, u, v) / (4.0 * sigma);
                // What is left is the bilinear step of the 48 × 16 cells themselves.
                let error = (value / (f(l, o) * o.z) - 1.0).abs();
                assert!(error < 0.15, "{slice} {u} {v} {value} {}", f(l, o) * o.z);
                apart += error;
                count += 1.0;
            }
            assert!(count > 100.0 && apart / count < 0.02, "{slice} {} of {count}", apart / count);
        }
    }
}

#[test]
fn the_density_is_normalised_and_nowhere_zero() {
    let table = table(8, lobe);
    let normals = Normals::new(&[&table], &[1.0], 0.02);
    assert!((normals.integral(|m| m.z) - 1.0).abs() < 0.01);
    assert!(normals.density.iter().all(|d| *d >= 0.02 * FRAC_1_PI * 0.99));
    // Light from straight above meets the whole plate, once; that of a diffuse plate's normals slightly more aslant.
    let sigma = normals.sigma();
    assert!((sigma.at(0.0, 1.0) - 1.0).abs() < 0.01);
    assert!(sigma.at(1.0, 1.0) >= f64::cos(1.0) * 0.99);
    let black = self::table(1, |_, _| 0.0);
    let found = fields(&written(BsdfColour::Grey(&black), 4));
    assert!(found["rgb"].1.iter().all(|v| *v == 0.0) && found["luminance"].1.iter().all(|v| *v == 1.0));
}

#[test]
fn corners_are_exact_for_smooth_cells_and_never_overshoot() {
    let smooth = table(1, |wi, wo| {
        let m = (wi + wo).normalize();
        1.0 + m.z.acos()
    });
    let corners = corner_values(&[&smooth], &[1.0], 1);
    for column in 8..20 {
        let theta = PI / 2.0 * (column as f64 / 48.0).powi(2);
        assert!((corners[column + 49 * 3] - 1.0 - theta).abs() < 1e-3, "{column}");
    }
    let step = table(1, |wi, wo| f64::from(u8::from((wi + wo).normalize().z > 0.97)));
    assert!(corner_values(&[&step], &[1.0], 1).iter().all(|v| (0.0..=1.0).contains(v)));
}

#[test]
fn what_cannot_be_written_is_refused() {
    let (one, other) = (table(1, lobe), table(4, lobe));
    let refused = |colour, samples| {
        let settings = BsdfSettings { samples, ..BsdfSettings::default() };
        write_bsdf(colour, &settings, &mut Vec::new()).unwrap_err()
    };
    assert!(matches!(refused(BsdfColour::Spectral(&[]), 8), BsdfError::NoTable));
    assert!(matches!(refused(BsdfColour::Rgb([&one, &one, &other]), 8), BsdfError::Axes));
    let twice = [(500.0, &one), (500.0, &one)];
    assert!(matches!(refused(BsdfColour::Spectral(&twice), 8), BsdfError::Wavelengths));
    assert!(matches!(refused(BsdfColour::Grey(&one), 1), BsdfError::Settings));
}

#[test]
fn no_colour_is_negative_however_noisy_the_table_and_all_light_is_kept() {
    for azimuths in [1, 5] {
        // Few rays: most directions hold nothing, some a lot.
        let noisy = table(azimuths, |wi, wo| {
            let bits = (wo.x.to_bits() ^ wo.y.to_bits().rotate_left(17) ^ wi.x.to_bits().rotate_left(31))
                .wrapping_mul(0x9e37_79b9_7f4a_7c15);
            if bits >> 60 == 0 { 16.0 * lobe(wi, wo) } else { 0.0 }
        });
        let mut out = Vec::new();
        let facts = write_bsdf(BsdfColour::Grey(&noisy), &BsdfSettings::measured(), &mut out).unwrap();
        assert!(facts.least_value >= 0.0 && (facts.light - 1.0).abs() < 1e-5, "{facts:?}");
        let found = fields(&out);
        for name in ["rgb", "luminance", "vndf", "ndf", "sigma"] {
            assert!(found[name].1.iter().all(|v| *v >= 0.0), "{name}");
        }
    }
}
