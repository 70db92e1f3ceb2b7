//! The mirror share of a smooth face in air, for unpolarised light: Fresnel's equations, exact.

/// Reflectance of a conductor of complex index of refraction `eta` + i `k` (both relative to air) for light at `cosine`
/// to the normal. Any number is taken as a cosine in [0, 1]; `eta` > 0, `k` >= 0.
///
/// Born & Wolf, Principles of Optics, 7th ed., section 14.2, with a + i b = √((eta + i k)² − sin²).
pub fn conductor(cosine: f64, eta: f64, k: f64) -> f64 {
    let cosine = within_unit(cosine);
    if cosine < 1e-150 {
        return 1.0; // also where the formula is 0/0, an index of 1
    }
    let (c2, s2) = (cosine * cosine, 1.0 - cosine * cosine);
    let real = (eta - 1.0) * (eta + 1.0) + c2 - k * k; // eta² - k² - sin², exact near an index of 1
    let modulus = real.hypot(2.0 * eta * k); // a² + b²
    // 2a² = modulus + real, without the difference of near numbers that it is for good conductors.
    let twice_a2 = if real < 0.0 { (2.0 * eta * k).powi(2) / (modulus - real) } else { modulus + real };
    let a = (0.5 * twice_a2).sqrt();

    let cross_s = 2.0 * a * cosine;
    let across = (modulus + c2 - cross_s) / (modulus + c2 + cross_s);
    let (even_p, cross_p) = (modulus * c2 + s2 * s2, cross_s * s2);
    let along = across * (even_p - cross_p) / (even_p + cross_p);
    (0.5 * (across + along)).clamp(0.0, 1.0)
}

/// Reflectance of a dielectric of index of refraction `eta` > 0 relative to air for light at `cosine` to the normal,
/// total reflection included where `eta` < 1. Any number is taken as a cosine in [0, 1].
///
/// Born & Wolf, Principles of Optics, 7th ed., section 1.5.2.
pub fn dielectric(cosine: f64, eta: f64) -> f64 {
    let cosine = within_unit(cosine);
    let inside2 = ((eta - 1.0) * (eta + 1.0) + cosine * cosine) / (eta * eta);
    if inside2 <= 0.0 || cosine < 1e-150 {
        return 1.0;
    }
    let inside = inside2.sqrt();
    let across = (cosine - eta * inside) / (cosine + eta * inside);
    let along = (eta * cosine - inside) / (eta * cosine + inside);
    0.5 * (across * across + along * along)
}

/// Schlick's approximation of both ("An inexpensive BRDF model for physically-based rendering", 1994): F0 straight on, and
/// the rest of 1 times (1 − cosine)⁵. Any number is taken as a cosine in [0, 1].
pub fn schlick(cosine: f64, straight_on: f64) -> f64 {
    straight_on + (1.0 - straight_on) * (1.0 - within_unit(cosine)).powi(5)
}

/// NaN counts as grazing.
fn within_unit(cosine: f64) -> f64 {
    if cosine > 0.0 { cosine.min(1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const INDICES: [(f64, f64); 6] = [(0.96, 6.69), (0.05, 3.59), (1.5, 0.0), (3.2, 3.3), (1e-3, 100.0), (1.0, 1e-9)];

    #[test]
    fn straight_down_is_the_textbook_ratio() {
        for (eta, k) in INDICES {
            let expected = ((eta - 1.0f64).powi(2) + k * k) / ((eta + 1.0f64).powi(2) + k * k);
            assert!((conductor(1.0, eta, k) - expected).abs() < 1e-12, "{eta} {k}");
        }
        assert!((dielectric(1.0, 1.5) - 0.04).abs() < 1e-15);
    }

    #[test]
    fn grazing_light_is_all_reflected() {
        for (eta, k) in INDICES {
            assert_eq!(conductor(0.0, eta, k), 1.0);
        }
        for eta in [0.5, 1.0, 1.5] {
            assert_eq!(dielectric(0.0, eta), 1.0);
        }
        assert!(conductor(1e-9, 3.2, 3.3) > 1.0 - 1e-7);
        assert!(dielectric(1e-9, 1.5) > 1.0 - 1e-7);
    }

    #[test]
    fn a_conductor_that_absorbs_nothing_is_a_dielectric() {
        for eta in [0.4, 0.9, 1.3, 1.5, 2.4] {
            for step in 0..=100 {
                let cosine = f64::from(step) / 100.0;
                let (c, d) = (conductor(cosine, eta, 0.0), dielectric(cosine, eta));
                assert!((c - d).abs() < 1e-12, "{eta} {cosine}: {c} {d}");
            }
        }
    }

    #[test]
    fn at_brewsters_angle_half_of_one_polarisation_is_left() {
        // tan θ = η: nothing of the p part; the s part is ((1 − η²)/(1 + η²))².
        let eta = 1.5f64;
        let expected = 0.5 * ((1.0 - eta * eta) / (1.0 + eta * eta)).powi(2);
        assert!((dielectric(eta.atan().cos(), eta) - expected).abs() < 1e-15);
    }

    #[test]
    fn a_conductor_at_45_degrees_obeys_rp_is_rs_squared() {
        // At 45° the p reflectance is the square of the s reflectance (Abelès' condition), for any index.
        for (eta, k) in INDICES {
            let cosine = 0.5f64.sqrt();
            let (re, im) = (eta * eta - k * k - 0.5, 2.0 * eta * k);
            let r = re.hypot(im);
            let (a, b) = (((r + re) / 2.0).max(0.0).sqrt(), ((r - re) / 2.0).max(0.0).sqrt());
            let s = ((cosine - a).powi(2) + b * b) / ((cosine + a).powi(2) + b * b);
            assert!((conductor(cosine, eta, k) - 0.5 * (s + s * s)).abs() < 1e-6, "{eta} {k}");
        }
    }

    #[test]
    fn schlick_is_near_a_dielectric() {
        for step in 0..=100 {
            let cosine = f64::from(step) / 100.0;
            assert!((schlick(cosine, 0.04) - dielectric(cosine, 1.5)).abs() < 0.04, "{cosine}");
        }
        assert_eq!((schlick(0.0, 0.04), schlick(1.0, 0.04)), (1.0, 0.04));
    }

    #[test]
    fn every_input_gives_a_share() {
        let cosines = [f64::NAN, -1.0, 0.0, 5e-324, 1e-300, 1e-9, 0.3, 1.0, 2.0, f64::INFINITY];
        for cosine in cosines {
            for eta in [1e-3, 0.05, 1.0, 1.49, 100.0] {
                for k in [0.0, 1e-12, 1.0, 100.0] {
                    assert!((0.0..=1.0).contains(&conductor(cosine, eta, k)), "{cosine} {eta} {k}");
                }
                assert!((0.0..=1.0).contains(&dielectric(cosine, eta)), "{cosine} {eta}");
            }
        }
        // Nothing is there to reflect, to grazing.
        for cosine in [1e-9, 1e-3, 1.0] {
            assert!(dielectric(cosine, 1.0) < 1e-15 && conductor(cosine, 1.0, 0.0) < 1e-15, "{cosine}");
        }
    }
}
