//! What is to be said of a plate in one sentence, to whoever cuts it.

use crate::verify::verdict::{MAIN_BLUR, Verdict};

/// Share of light that must stray from which on it is told: half of what is hard to see.
pub(super) const WORTH_TELLING: f64 = 0.005;

/// How far the light is as it was drawn, and whether an eye will notice. `how` is the plate's state, such as
/// `Cut by ball:0.5`; empty for the plate as it was written.
pub fn in_a_sentence(verdict: &Verdict, how: &str) -> String {
    let scores = verdict.decisive();
    let wrong = scores.tv_incident.value.clamp(0.0, 1.0);
    // Never rounded up to all of it.
    let right = (1000.0 * (1.0 - wrong)).floor().min(999.0) / 10.0;
    // Total variations below 0.01 are hard to see even side by side, and above 0.05 detail is missing (README.md).
    let judged = match wrong {
        0.0..0.01 => "the rest is hard to see",
        0.01..0.05 => "the rest shows beside the drawing",
        0.05..0.2 => "the rest is plain to see",
        _ => "it does not look like the drawing",
    };
    let how = if how.is_empty() { String::new() } else { format!("{how}, ") };
    let seen =
        if scores.blur == MAIN_BLUR { String::new() } else { format!(", seen through a blur of {}°", scores.blur) };
    format!("{how}{right:.1} % of the light falls where it was drawn{seen}; {judged}.")
}

/// That a drawing is finer than the main blur, so that scores at it say little.
pub fn finer_than_the_blur(verdict: &Verdict) -> Option<String> {
    let (main, judged) = (verdict.main(), verdict.decisive());
    verdict.blurs_the_drawing_away().then(|| {
        format!(
            "The drawing is finer than what polished metal shows: a blur of {MAIN_BLUR}° leaves {:.0} % of its contrast, \
             and a likeness of {:.3} at it says little. At {}° the likeness is {:.3}; look at the upper row of the \
             comparison. Coarser detail or a larger --half-field would be seen.",
            100.0 * main.kept,
            main.ssim.value,
            judged.blur,
            judged.ssim.value
        )
    })
}

/// That light must stray, in a sentence.
pub(super) fn stray_sentence(share: f64) -> String {
    format!(
        "At least {:.1} % of the light falls between the parts of the drawing, since the cutter must turn there: a \
         smaller cutter leaves less.",
        100.0 * share
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Progress;
    use crate::projection::{Projection, View};
    use crate::raster::Raster;
    use crate::verify::tally::{Measurement, Tally};
    use glam::DVec3;

    /// The verdict on light that is as drawn but for a share of it, which falls evenly over the image. The drawing is of
    /// stripes so many pixels wide, over 20° either way.
    fn verdict(stripes: usize, astray: f64) -> Verdict {
        let side = 64;
        let view = View::new(Projection::Equidistant, f64::to_radians(20.0), DVec3::Z);
        let target =
            Raster::from_fn(side, side, |x, _| f64::from(u8::from((x / stripes).is_multiple_of(2)))).normalised();
        let even = astray / (side * side) as f64;
        let mut part = Tally::empty((side, side));
        part.image.values.iter_mut().zip(&target.values).for_each(|(v, t)| *v = (1.0 - astray) * t + even);
        (part.incident, part.up_single) = (1.0, 1.0);
        let measurement = Measurement::of_parts(vec![part; 16]).unwrap();
        Verdict::new(&measurement, &target, &view, &Progress::silent()).unwrap()
    }

    #[test]
    fn a_verdict_is_one_sentence_that_never_says_all_of_the_light() {
        let said = |astray| in_a_sentence(&verdict(16, astray), "Cut by ball:0.5");
        assert_eq!(
            said(0.0),
            "Cut by ball:0.5, 99.9 % of the light falls where it was drawn; the rest is hard to see."
        );
        for (astray, judged) in [(0.05, "shows beside"), (0.2, "plain to see"), (0.9, "does not look like")] {
            assert!(said(astray).contains(judged), "{}", said(astray));
        }
        assert!(in_a_sentence(&verdict(16, 0.0), "").starts_with("99.9 % of the light"));
        assert_eq!(finer_than_the_blur(&verdict(16, 0.0)), None);
    }

    #[test]
    fn a_drawing_that_the_main_blur_wipes_out_is_judged_sharper_and_says_so() {
        // Stripes of 1.25°: at 1° they melt, at 0.5° they are seen.
        let fine = verdict(2, 0.3);
        assert!(fine.main().kept < 0.1 && fine.at(0.27).kept > 0.6, "{fine:?}");
        assert!(fine.decisive().blur < 1.0 && fine.main().ssim.value > fine.decisive().ssim.value);
        let said = in_a_sentence(&fine, "");
        assert!(said.contains("seen through a blur of 0.") && !said.contains("99.9"), "{said}");
        let note = finer_than_the_blur(&fine).unwrap();
        assert!(note.contains("finer than") && note.contains("upper row"), "{note}");
    }
}
