use super::*;
use crate::progress::{CancelToken, Event};
use crate::projection::{Projection, View};
use crate::setup::Setup;

/// Radians.
const HALF_FIELD: f64 = 0.35;

fn setup(theta: f64, radius: f64, projection: Projection) -> Setup {
    Setup::new(theta, 0.4, radius.to_radians(), projection, HALF_FIELD)
}

/// A blob of standard deviation `sigma` radians around the image's centre.
fn blob(side: usize, sigma: f64) -> Raster {
    let width = sigma / HALF_FIELD;
    let at = |x, y| View::pixel_centre(x, y, side, side).length_squared();
    Raster::from_fn(side, side, |x, y| (-0.5 * at(x, y) / (width * width)).exp()).normalised()
}

/// Variance of light per axis, radians².
fn variance(light: &Raster) -> f64 {
    let sum: f64 = light
        .values
        .iter()
        .enumerate()
        .map(|(k, value)| {
            let uv = View::pixel_centre(k % light.width, k / light.width, light.width, light.height);
            value * uv.length_squared()
        })
        .sum();
    0.5 * sum / light.sum() * HALF_FIELD * HALF_FIELD
}

fn ring(side: usize) -> Raster {
    let lit = |x, y| (0.45..0.7).contains(&View::pixel_centre(x, y, side, side).length());
    Raster::from_fn(side, side, |x, y| f64::from(u8::from(lit(x, y)))).normalised()
}

#[test]
fn a_gaussian_sharpened_by_a_narrower_one_is_the_gaussian_of_the_difference_of_variances() {
    let (wide, narrow) = (f64::to_radians(2.5), f64::to_radians(1.5));
    let blur = BlurKernel::new(&setup(0.0, 0.0, Projection::Equidistant), narrow).unwrap();
    let mut light = blob(128, wide);
    let worth = sharpen(&mut light, &blur, &Progress::silent());
    let expected = blob(128, (wide * wide - (AGAINST * narrow).powi(2)).sqrt());
    let ratio = variance(&light) / variance(&expected);
    assert!((ratio - 1.0).abs() < 0.02, "{ratio}");
    let off: f64 = 0.5 * light.values.iter().zip(&expected.values).map(|(a, b)| (a - b).abs()).sum::<f64>();
    assert!(off < 0.02, "{off}");
    assert!(worth.before > 0.1 && worth.after < 0.25 * worth.before, "{worth:?}");
}

#[test]
fn sharpened_light_is_positive_as_much_as_before_dark_where_it_was_and_seen_no_worse() {
    let uneven = Raster::from_fn(70, 50, |x, y| if x * y % 13 < 6 { 0.0 } else { (x + y) as f64 }).normalised();
    let mut point = Raster::zeros(40, 40);
    point.values[41] = 0.5;
    for picture in [ring(300), ring(24), uneven, point, Raster::from_fn(1, 1, |_, _| 2.0)] {
        for (theta, radius, lobe, projection) in [
            (0.0, 0.2665, 0.0, Projection::Orthographic),
            (0.0, 1.0, 0.0, Projection::Screen),
            (1.0, 0.5, 0.7, Projection::Orthographic),
            (0.6, 0.0, 2.0, Projection::Equidistant),
            (0.0, 0.001, 0.0, Projection::Equidistant),
            (0.0, 60.0, 10.0, Projection::Equidistant),
        ] {
            let blur = BlurKernel::new(&setup(theta, radius, projection), f64::to_radians(lobe)).unwrap();
            let mut light = picture.clone();
            let worth = sharpen(&mut light, &blur, &Progress::silent());
            let what = format!("{} pixels, {radius}°, {lobe}°: {worth:?}", picture.width);
            assert!((light.sum() / picture.sum() - 1.0).abs() < 1e-11, "{what}");
            let drawn = picture.resampled(light.width, light.height);
            let sound =
                |(sharp, drawn): (&f64, &f64)| *sharp >= 0.0 && sharp.is_finite() && (*drawn > 0.0 || *sharp == 0.0);
            assert!(light.width % picture.width == 0, "{what}");
            assert!(light.values.iter().zip(&drawn.values).all(sound), "{what}");
            assert!((0.0..=1.0).contains(&worth.after) && worth.after <= worth.before, "{what}");
            assert!(worth.steps > 0 || light == picture, "{what}");
        }
    }
}

#[test]
fn what_is_claimed_is_what_is_seen() {
    let blur = BlurKernel::new(&setup(0.0, 1.0, Projection::Equidistant), f64::to_radians(0.5)).unwrap();
    let drawn = ring(256);
    let mut light = drawn.clone();
    let worth = sharpen(&mut light, &blur, &Progress::silent());
    // Through a blur of the judge's width, by other means: a Gaussian summed in space.
    let judge = |light: &Raster| {
        let sigma = f64::to_radians(SCORED_AT) / HALF_FIELD * light.width as f64 / 2.0;
        let weights: Vec<f64> = (-40..=40).map(|k| (-0.5 * f64::from(k * k) / (sigma * sigma)).exp()).collect();
        let whole: f64 = weights.iter().sum();
        let along = |light: &Raster| {
            Raster::from_fn(light.height, light.width, |y, x| {
                let reach = (0..81).filter(|k| (40..light.width + 40).contains(&(x + k)));
                reach.map(|k| weights[k] / whole * light.at(x + k - 40, y)).sum()
            })
        };
        along(&along(light))
    };
    for (sent, claimed) in [(&drawn, worth.before), (&light, worth.after)] {
        let through = seen(sent, &blur);
        assert!((through.sum() - 1.0).abs() < 1e-3);
        let (seen, wanted) = (judge(&through), judge(&drawn.resampled(through.width, through.height)));
        let off = 0.5 * seen.values.iter().zip(&wanted.values).map(|(a, b)| (a - b).abs()).sum::<f64>();
        assert!((off - claimed).abs() < 0.02 * worth.before, "{off} {claimed}");
    }
    assert!(worth.after < 0.6 * worth.before, "{worth:?}");
}

#[test]
fn a_known_sharp_picture_is_recovered_from_its_blur() {
    // Drawn is what a sharp picture looks like through the blur: what shall be sent is that picture.
    let planted = Raster::from_fn(200, 200, |x, y| {
        let at = View::pixel_centre(x, y, 200, 200);
        let waves = 1.0 + (9.0 * at.x).sin() * (7.0 * at.y).cos();
        (0.7 - at.length_squared()).max(0.0) * waves + 3.0 * (0.4 - at.length()).max(0.0)
    });
    let distance = |light: &Raster| {
        let apart = light.values.iter().zip(&planted.values).map(|(a, b)| (a - b).abs()).sum::<f64>();
        0.5 * apart / planted.sum()
    };
    for (radius, lobe) in [(1.0, 0.0), (0.0, 0.7), (0.7, 0.5)] {
        let blur = BlurKernel::new(&setup(0.0, radius, Projection::Equidistant), f64::to_radians(lobe)).unwrap();
        let drawn = seen(&planted, &blur);
        let mut light = drawn.clone();
        let worth = sharpen(&mut light, &blur, &Progress::silent());
        let (before, after) = (distance(&drawn), distance(&light.resampled(200, 200)));
        assert!(after < 0.75 * before && worth.after < 0.25 * worth.before, "{before} {after} {worth:?}");
    }
}

#[test]
fn threads_change_no_byte() {
    let blur = BlurKernel::new(&setup(0.3, 1.0, Projection::Screen), 0.01).unwrap();
    let sharpened = || {
        let mut light = ring(200);
        let worth = sharpen(&mut light, &blur, &Progress::silent());
        (light, worth)
    };
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(sharpened(), alone.install(sharpened));
}

#[test]
fn pictures_finer_than_the_blur_keep_their_detail() {
    // Blocks of pixels are brightened as wholes; within them neighbours keep their ratios.
    let blur = BlurKernel::new(&setup(0.0, 0.0, Projection::Equidistant), f64::to_radians(2.0)).unwrap();
    let drawn = Raster::from_fn(600, 600, |x, y| if (x / 150 + y / 150) % 2 == 0 { 1.0 + (x % 2) as f64 } else { 0.2 });
    let mut light = drawn.clone();
    let worth = sharpen(&mut light, &blur, &Progress::silent());
    assert!(worth.steps > 0 && (light.width, light.height) == (600, 600));
    let kept = (0..599).filter(|x| {
        let ratio = |of: &Raster| of.at(x + 1, 75) / of.at(*x, 75);
        (ratio(&light) / ratio(&drawn) - 1.0).abs() < 1e-9
    });
    let kept = kept.count();
    assert!(kept > 500, "{kept}");
}

#[test]
fn darkness_and_cancelled_work_are_left_alone() {
    let blur = BlurKernel::new(&setup(0.0, 1.0, Projection::Screen), 0.01).unwrap();
    let mut dark = Raster::zeros(20, 20);
    assert_eq!(sharpen(&mut dark, &blur, &Progress::silent()), Sharpening::default());
    assert_eq!(dark, Raster::zeros(20, 20));
    let cancelled = CancelToken::default();
    cancelled.finish();
    let mut light = ring(40);
    let worth = sharpen(&mut light, &blur, &Progress::new(&|_: Event<'_>| (), &cancelled));
    assert_eq!((worth.steps, light), (0, ring(40)));
}
