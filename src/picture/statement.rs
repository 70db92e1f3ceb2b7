//! What a file states its numbers to mean as light: colour profiles, PNG's chunks, code points of video.
//!
//! Profiles of curves and a matrix, and grey ones, are obeyed: what light a number stands for, and how much each colour
//! weighs in Rec. 709 luminance once its primaries are expressed in those of Rec. 709. Profiles of tables (printers,
//! scanners) are passed over, and a note says so.

use moxcms::{
    CicpColorPrimaries, CicpProfile, ColorProfile, DataColorSpace, MatrixCoefficients, ProfileText, ToneReprCurve,
    TransferCharacteristics,
};

use super::one_line;

/// Luminance of linear red, green and blue: ITU-R BT.709-6, item 3.2.
pub(crate) const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Curves and weights nearer than this are the same. The profiles that programs write for sRGB differ by up to 1e-3.
const SAME: f64 = 2e-3;

/// What a file says, and where.
pub(crate) struct Statement {
    /// What in the file says so, as "its sRGB chunk".
    pub by: String,
    /// What it says.
    pub means: Means,
}

/// How an encoded number becomes light.
pub(crate) enum Means {
    /// By the curve of sRGB, primaries of Rec. 709.
    Srgb,
    /// Proportionally, primaries of Rec. 709.
    Linear,
    /// By a curve for each colour, and weights that make luminance of them.
    Curves([Curve; 3], [f64; 3]),
}

/// From an encoded number to light.
pub(crate) type Curve = Box<dyn Fn(f64) -> f64 + Send + Sync>;

impl Means {
    /// Light of a grey number or of red, green and blue, as encoded.
    pub(crate) fn light(&self, encoded: &[f64]) -> f64 {
        let curve = |k: usize, value: f64| match self {
            Self::Srgb => srgb(value),
            Self::Linear => value,
            Self::Curves(curves, _) => curves[k](value),
        };
        let weights = if let Self::Curves(_, weights) = self { weights } else { &LUMINANCE };
        match *encoded {
            // Green's is the curve that most of a grey's light would take.
            [grey] => curve(1, grey).max(0.0),
            _ => encoded.iter().zip(weights).enumerate().map(|(k, (v, w))| curve(k, *v) * w).sum::<f64>().max(0.0),
        }
    }

    /// `Srgb` or `Linear` where the curves are no others: the same light to the last bit, whoever states it.
    fn known(self) -> Self {
        let Self::Curves(curves, weights) = &self else { return self };
        let near = |a: f64, b: f64| (a - b).abs() < SAME;
        let are = |wanted: fn(f64) -> f64| {
            let steps = (0..=32).map(|k| f64::from(k) / 32.0);
            weights.iter().zip(LUMINANCE).all(|(a, b)| near(*a, b))
                && steps.into_iter().all(|v| curves.iter().all(|curve| near(curve(v), wanted(v))))
        };
        if are(srgb) {
            Self::Srgb
        } else if are(|v| v) {
            Self::Linear
        } else {
            self
        }
    }
}

/// sRGB-encoded value to linear light (IEC 61966-2-1).
pub(crate) fn srgb(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// What a PNG's gamma chunk states, in units of 1e-5 of the exponent with which light was encoded. The value for sRGB
/// is written by programs that mean sRGB and know of no better chunk.
pub(crate) fn of_gamma(chunk: u32) -> Option<Statement> {
    let exponent = f64::from(chunk) / 1e5;
    let means = match chunk {
        0 => return None,
        45_450..=45_460 => Means::Srgb,
        99_000..=101_000 => Means::Linear,
        _ => {
            let curve = || -> Curve { Box::new(move |v| v.powf(1.0 / exponent)) };
            Means::Curves([curve(), curve(), curve()], LUMINANCE)
        }
    };
    Some(Statement { by: format!("its gAMA chunk of {exponent}"), means })
}

/// What the four code points of ITU-T H.273 state: primaries, transfer, matrix, range.
pub(crate) fn of_code_points([primaries, transfer, _, full]: [u8; 4]) -> Option<Statement> {
    let color_primaries = CicpColorPrimaries::try_from(primaries).ok()?;
    let transfer_characteristics = TransferCharacteristics::try_from(transfer).ok()?;
    if full != 1 || ToneReprCurve::make_cicp_linear_evaluator(transfer_characteristics).is_err() {
        return None;
    }
    let matrix_coefficients = MatrixCoefficients::Identity;
    let space = CicpProfile { color_primaries, transfer_characteristics, matrix_coefficients, full_range: true };
    let weights = weights(&ColorProfile::new_from_cicp(space))?;
    let curve = || -> Curve { Box::new(move |v| transfer_characteristics.linearize(v)) };
    let means = Means::Curves([curve(), curve(), curve()], weights).known();
    Some(Statement { by: "its cICP chunk".into(), means })
}

/// What a colour profile (ICC.1) states of pixels with `colours` colours; a note if it cannot be obeyed.
pub(crate) fn of_profile(bytes: &[u8], colours: usize, notes: &mut Vec<String>) -> Option<Statement> {
    let mut pass_over = |why: &str| {
        notes.push(format!("Its colour profile was passed over: {why}."));
        None
    };
    let Ok(profile) = ColorProfile::new_from_slice(bytes) else { return pass_over("it is damaged") };
    let curves = match (profile.color_space, colours) {
        (DataColorSpace::Gray, 1) => profile.gray_trc.as_ref().map(|grey| [grey; 3]),
        (DataColorSpace::Rgb, _) => match (&profile.red_trc, &profile.green_trc, &profile.blue_trc) {
            (Some(red), Some(green), Some(blue)) => Some([red, green, blue]),
            _ => None,
        },
        _ => return pass_over("it is for pixels of another kind"),
    };
    let Some(curves) = curves else { return pass_over("only curves with a matrix are followed, and it has tables") };
    let [Some(red), Some(green), Some(blue)] = curves.map(curve) else { return pass_over("its curves are damaged") };
    let weights = if colours == 1 { Some(LUMINANCE) } else { weights(&profile) };
    let Some(weights) = weights else { return pass_over("its primaries are damaged") };
    let named = profile.description.as_ref().and_then(title).filter(|title| !title.trim().is_empty());
    let by = named.map_or("its colour profile".into(), |title| format!("its colour profile \"{}\"", title.trim()));
    Some(Statement { by, means: Means::Curves([red, green, blue], weights).known() })
}

/// A profile's curve; between 0 and 1, where it is a table.
fn curve(of: &ToneReprCurve) -> Option<Curve> {
    // A list of numbers that is no curve at all would be indexed as one.
    if matches!(of, ToneReprCurve::Parametric(numbers) if !matches!(numbers.len(), 1 | 3 | 4 | 5 | 7)) {
        return None;
    }
    let evaluator = of.make_linear_evaluator().ok()?;
    let finite = (0..=64).all(|k| evaluator.evaluate_value(k as f32 / 64.0).is_finite());
    let light = move |v: f64| f64::from(evaluator.evaluate_value(v as f32));
    finite.then(|| Box::new(light) as Curve)
}

/// How much each primary of `profile` weighs in Rec. 709 luminance; a white of three ones weighs 1.
fn weights(profile: &ColorProfile) -> Option<[f64; 3]> {
    let to_rec709 = profile.transform_matrix(&ColorProfile::new_srgb());
    let weight = |k: usize| (0..3).map(|row| LUMINANCE[row] * to_rec709.v[row][k]).sum::<f64>();
    let all = [weight(0), weight(1), weight(2)];
    let white: f64 = all.iter().sum();
    (all.iter().all(|w| w.is_finite()) && (0.5..2.0).contains(&white)).then(|| all.map(|w| w / white))
}

/// What a profile calls itself.
fn title(text: &ProfileText) -> Option<String> {
    let words = match text {
        ProfileText::PlainString(words) => words,
        ProfileText::Localizable(all) => &all.first()?.value,
        ProfileText::Description(description) => &description.ascii_string,
    };
    Some(one_line(&words.trim_end_matches('\0')).chars().take(60).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn profile(profile: &ColorProfile, colours: usize) -> (Option<Statement>, Vec<String>) {
        let mut notes = Vec::new();
        let statement = of_profile(&profile.encode().unwrap(), colours, &mut notes);
        (statement, notes)
    }

    #[test]
    fn a_profile_that_means_srgb_or_linear_light_is_taken_for_just_that() {
        for colours in [1, 3] {
            let (statement, notes) = profile(&ColorProfile::new_srgb(), colours);
            let statement = statement.unwrap();
            assert!(matches!(statement.means, Means::Srgb) && notes.is_empty(), "{colours}");
            assert!(statement.by.contains("sRGB"), "{}", statement.by);
        }
        let straight = ToneReprCurve::Lut(Vec::new());
        let mut linear = ColorProfile::new_srgb();
        for trc in [&mut linear.red_trc, &mut linear.green_trc, &mut linear.blue_trc] {
            *trc = Some(straight.clone());
        }
        assert!(matches!(profile(&linear, 3).0.unwrap().means, Means::Linear));
    }

    #[test]
    fn white_is_white_and_primaries_weigh_by_their_luminance_in_every_profile() {
        for wide in [ColorProfile::new_display_p3(), ColorProfile::new_adobe_rgb(), ColorProfile::new_bt2020()] {
            let statement = profile(&wide, 3).0.unwrap();
            let light = |rgb: [f64; 3]| statement.means.light(&rgb);
            assert!((light([1.0; 3]) - 1.0).abs() < 1e-4);
            // Wider primaries: green takes more of the light than that of Rec. 709, or less red leaves it more.
            let sum = light([1.0, 0.0, 0.0]) + light([0.0, 1.0, 0.0]) + light([0.0, 0.0, 1.0]);
            assert!((sum - 1.0).abs() < 1e-3 && !matches!(statement.means, Means::Srgb), "{sum}");
        }
        // Luminance of P3's primaries in light of D65, SMPTE EG 432-1.
        let p3 = profile(&ColorProfile::new_display_p3(), 3).0.unwrap();
        for (rgb, wanted) in [([1.0, 0.0, 0.0], 0.2290), ([0.0, 1.0, 0.0], 0.6917), ([0.0, 0.0, 1.0], 0.0793)] {
            assert!((p3.means.light(&rgb) - wanted).abs() < 1e-3, "{rgb:?} {}", p3.means.light(&rgb));
        }
    }

    #[test]
    fn a_grey_profile_is_followed_and_one_of_another_kind_passed_over() {
        let grey = ColorProfile::new_gray_with_gamma(1.8);
        let statement = profile(&grey, 1).0.unwrap();
        for v in [0.1f64, 0.5, 0.9] {
            assert!((statement.means.light(&[v]) - v.powf(1.8)).abs() < 1e-2);
        }
        let (none, notes) = profile(&grey, 3);
        assert!(none.is_none() && notes[0].contains("another kind"), "{notes:?}");
        let mut notes = Vec::new();
        assert!(of_profile(b"no profile", 3, &mut notes).is_none() && notes[0].contains("damaged"));
    }

    #[test]
    fn gamma_chunks_are_exponents() {
        assert!(matches!(of_gamma(45_455).unwrap().means, Means::Srgb));
        assert!(matches!(of_gamma(100_000).unwrap().means, Means::Linear));
        assert!(of_gamma(0).is_none());
        let mac = of_gamma(55_556).unwrap();
        assert!((mac.means.light(&[0.5]) - 0.5f64.powf(1.8)).abs() < 1e-5);
        assert!((mac.means.light(&[0.5, 0.0, 0.0]) - LUMINANCE[0] * 0.5f64.powf(1.8)).abs() < 1e-5);
    }

    #[test]
    fn code_points_tell_curve_and_primaries() {
        assert!(matches!(of_code_points([1, 13, 0, 1]).unwrap().means, Means::Srgb));
        assert!(matches!(of_code_points([1, 8, 0, 1]).unwrap().means, Means::Linear));
        let wide = of_code_points([12, 13, 0, 1]).unwrap();
        assert!((wide.means.light(&[1.0, 0.0, 0.0]) - 0.2290).abs() < 1e-3);
        // Narrow range, unspecified transfer, unknown primaries: nothing is stated that could be obeyed.
        for points in [[1, 13, 0, 0], [1, 2, 0, 1], [200, 13, 0, 1]] {
            assert!(of_code_points(points).is_none(), "{points:?}");
        }
    }
}
