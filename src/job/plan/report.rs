//! What is said and shown of a plan.

use image::RgbImage;

use super::{Goal, Plan, Proved, Task};
use crate::export::plan_chart::PlanChart;
use crate::job::sentences::in_a_sentence;
use crate::milling::polish::in_words;
use crate::report::PROGRAM;
use crate::report::PictureFacts;
use crate::report::plan::{CutterLine, Parts, PlanReport, WayFacts};

impl Plan {
    /// Everything that is known of it, which was asked by `task` for the picture in `file`.
    pub fn report(&self, task: &Task, file: Option<String>) -> PlanReport {
        let verdict = self.best.first().map_or(String::new(), |best| {
            in_a_sentence(&best.made.verdict, &format!("As {}, in {:.1} h", best.made.how(), best.made.hours))
        });
        PlanReport {
            program: PROGRAM,
            picture: PictureFacts::new(task.picture, file),
            machine: task.machine.clone(),
            hours: self.hours,
            wanted: match task.goal {
                Goal::Within(_) => None,
                Goal::Wanted(wanted) => Some(wanted),
            },
            polish_tolerance: task.tolerance,
            best: self.best.iter().enumerate().map(|(k, proved)| way(proved, k + 1)).collect(),
            by_cutter: self
                .lines
                .iter()
                .map(|(cutter, points)| CutterLine { cutter: *cutter, hours_and_tv_1deg: points.clone() })
                .collect(),
            helps_most: self.help(),
            ended_early: self.ended_early,
            verdict,
        }
    }

    /// What would help most, in a sentence.
    fn help(&self) -> Option<String> {
        let (what, figure) = self.helps.as_ref()?;
        let now = self.best.first()?.choice.expected.mean();
        let [now, then] = [now, *figure].map(|share| format!("{:.2} %", 100.0 * share));
        Some(format!(
            "What would help most: {what}; about {then} would be misplaced in place of {now}, in the mean over polish that is not as meant."
        ))
    }

    /// `plan.png`: light over hours, a line a cutter.
    pub fn picture(&self, heading: &str) -> RgbImage {
        let lines: Vec<(String, Vec<[f64; 2]>)> =
            self.lines.iter().map(|(cutter, points)| (cutter.to_string(), points.clone())).collect();
        let proved: Vec<[f64; 2]> = self.best.iter().map(|best| [best.choice.hours, best.mean()]).collect();
        let note = self
            .best
            .first()
            .map_or(String::new(), |best| format!("{}: limited by {}", in_short(best), best.choice.expected.limit()));
        PlanChart { lines: &lines, proved: &proved, heading, note: &note }.picture()
    }
}

/// A way in a few words.
pub fn in_short(proved: &Proved) -> String {
    let way = &proved.choice.way;
    let [across, up] = way.cells;
    let cells = if across * up == 1 { "one cell".to_owned() } else { format!("{across} × {up} cells") };
    let polish = in_words(Some(way.polish).filter(|polish| *polish > 0.0));
    let (size, cutter) = (way.size, way.cutter);
    format!("{:.0} × {:.0} mm, {cells}, {cutter}, passes {} mm apart, {polish}", size.x, size.y, way.stepover)
}

fn way(proved: &Proved, number: usize) -> WayFacts {
    let expected = proved.choice.expected;
    WayFacts {
        recipe: format!("recipe-{number}.toml"),
        size_mm: proved.choice.way.size.to_array(),
        cells: proved.choice.way.cells,
        hours: proved.choice.hours,
        expected_tv_1deg: expected.misplaced,
        expected_tv_1deg_polish_off: expected.polish_off,
        expected_by: Parts { scatter: expected.scatter, cusps: expected.cusps, following: expected.following },
        limited_by: expected.limit(),
        as_made_tv_1deg_polish_off: proved.polish_off.clone(),
        as_made: proved.made.facts(),
    }
}
