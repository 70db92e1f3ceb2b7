//! Normal deviates of a stream that belongs to one thing alone, so that bytes do not depend on threads.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// The stream of thing number `index`.
pub(crate) fn stream(seed: u64, index: u64) -> Xoshiro256PlusPlus {
    // An odd factor keeps neighbouring seeds and indices apart before the generator's own mixing.
    Xoshiro256PlusPlus::seed_from_u64(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(index))
}

/// One normal deviate of mean 0 and variance 1 (Box and Muller 1958).
pub(crate) fn normal(random: &mut Xoshiro256PlusPlus) -> f64 {
    let [radius, turn] = [random.random::<f64>(), random.random::<f64>()];
    (-2.0 * (1.0 - radius).ln()).sqrt() * (std::f64::consts::TAU * turn).cos()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deviates_have_the_moments_of_the_normal_law() {
        let mut random = stream(7, 3);
        let values: Vec<f64> = (0..40_000).map(|_| normal(&mut random)).collect();
        let moment = |power: i32| values.iter().map(|v| v.powi(power)).sum::<f64>() / values.len() as f64;
        // Four standard errors: √(1, 2, 96 / 40000).
        assert!(moment(1).abs() < 0.02 && (moment(2) - 1.0).abs() < 0.028 && (moment(4) - 3.0).abs() < 0.2);
        assert_ne!(normal(&mut stream(7, 3)), normal(&mut stream(7, 4)));
    }
}
