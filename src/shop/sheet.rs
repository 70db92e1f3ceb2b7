//! The setup sheet: one page of HTML with everything that a person at the machine needs, pictures included.

use std::fmt::Write;

use super::feeds::SOURCE;
use super::programs::{Part, Shop, ShopFile, duration};
use crate::gcode::check::Bounds;

/// What the page tells beside programs.
pub struct Sheet<'a> {
    /// The shop.
    pub shop: &'a Shop,
    /// Its programs, in the order of running.
    pub files: &'a [ShopFile],
    /// What becomes of the rim, in words, if there is one.
    pub rim: Option<String>,
    /// How the light comes out, in a sentence, if that is known.
    pub verdict: Option<String>,
    /// What is to be polished, in words, where it is not all of it evenly.
    pub polish: Option<String>,
    /// Further sections, each with its heading and its paragraphs.
    pub more: Vec<(String, Vec<String>)>,
    /// Pictures, each with what it shows and its address: `data:` for one that is to be within the page.
    pub pictures: Vec<(String, String)>,
    /// What a person should know.
    pub advice: &'a [String],
}

/// Looks of the page, on a screen and on paper.
const STYLE: &str = "body{font:15px/1.45 system-ui,sans-serif;max-width:46em;margin:2em auto;padding:0 1em;color:#111}\
h1{font-size:1.6em;margin:0}h2{font-size:1.15em;margin:1.6em 0 .4em;border-bottom:1px solid #999}\
table{border-collapse:collapse;width:100%;font-size:.92em}td,th{border:1px solid #999;padding:.25em .5em;text-align:left}\
td.n{text-align:right;white-space:nowrap}svg{width:100%;height:auto}img{width:100%}figure{margin:1em 0}\
figcaption,.small{font-size:.85em;color:#444}.verdict{font-size:1.05em}li{margin:.25em 0}\
@page{size:A4;margin:14mm}@media print{body{margin:0;max-width:none;font-size:11pt}section,figure,table{break-inside:avoid}}";

impl Sheet<'_> {
    /// The page.
    pub fn page(&self) -> String {
        let name = escaped(&self.shop.name);
        let mut page = format!(
            "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" \
             content=\"width=device-width\"><title>Setup: {name}</title><style>{STYLE}</style></head>\n<body>\n\
             <h1>Setup: {name}</h1>\n"
        );
        if let Some(verdict) = &self.verdict {
            let _ = writeln!(page, "<p class=\"verdict\">{}</p>", escaped(verdict));
        }
        for (title, content) in [
            ("Stock and zero", self.stock()),
            ("Programs and tools, in this order", self.programs()),
            ("Step by step", self.steps()),
            ("Clamping and rim", self.clamping()),
            ("Polish", self.polish()),
        ] {
            let _ = writeln!(page, "<section><h2>{title}</h2>\n{content}</section>");
        }
        for (title, paragraphs) in &self.more {
            let paragraphs: String = paragraphs.iter().map(|text| format!("<p>{}</p>", escaped(text))).collect();
            let _ = writeln!(page, "<section><h2>{}</h2>\n{paragraphs}</section>", escaped(title));
        }
        if !self.advice.is_empty() {
            let items: String = self.advice.iter().map(|line| format!("<li>{}</li>", escaped(line))).collect();
            let _ = writeln!(page, "<section><h2>To be known</h2><ul>{items}</ul></section>");
        }
        for (caption, address) in &self.pictures {
            let (caption, address) = (escaped(caption), escaped(address));
            let _ = writeln!(
                page,
                "<figure><img alt=\"{caption}\" src=\"{address}\"><figcaption>{caption}</figcaption></figure>"
            );
        }
        let _ = writeln!(
            page,
            "<p class=\"small\">{}</p>\n</body></html>",
            escaped(&format!("facetmill {}", env!("CARGO_PKG_VERSION")))
        );
        page
    }

    fn stock(&self) -> String {
        let blank = &self.shop.blank;
        let size = blank.size();
        format!(
            "<p>{} {:.2} × {:.2} × {:.2} mm. Zero: {}.</p>\n{}{}",
            capital(self.shop.stock.name),
            size.x,
            size.y,
            size.z,
            escaped(&blank.zero_in_words()),
            self.view_from_above(),
            self.view_from_the_side()
        )
    }

    /// The stock from above: optical area, rim, zero and axes.
    fn view_from_above(&self) -> String {
        let blank = &self.shop.blank;
        let (size, rim) = (blank.size(), blank.margin);
        let unit = size.x.max(size.y) / 100.0;
        let [x, y, w, h] = [-14.0 * unit, -8.0 * unit, size.x + 28.0 * unit, size.y + 26.0 * unit];
        let mut svg = format!(
            "<svg viewBox=\"{x:.3} {y:.3} {w:.3} {h:.3}\" style=\"max-width:26em\" font-size=\"{:.3}\" stroke-width=\"{:.3}\">",
            4.0 * unit,
            0.4 * unit
        );
        let rectangle = |x: f64, y: f64, w: f64, h: f64, fill: &str| {
            format!(
                "<rect x=\"{x:.3}\" y=\"{y:.3}\" width=\"{w:.3}\" height=\"{h:.3}\" fill=\"{fill}\" stroke=\"#111\"/>"
            )
        };
        svg += &rectangle(0.0, 0.0, size.x, size.y, if rim > 0.0 { "#ddd" } else { "#f4efe2" });
        if rim > 0.0 {
            svg += &rectangle(rim, rim, size.x - 2.0 * rim, size.y - 2.0 * rim, "#f4efe2");
        }
        // Rows of the page go down, y of the machine up.
        let (zero, arm) = (size.y, 12.0 * unit);
        let _ = write!(
            svg,
            "<g stroke=\"#c00\" fill=\"#c00\"><circle cx=\"0\" cy=\"{zero:.3}\" r=\"{:.3}\"/>\
             <path d=\"M0 {zero:.3}h{arm:.3}M0 {zero:.3}v-{arm:.3}\" fill=\"none\"/><g stroke=\"none\">\
             <text x=\"{:.3}\" y=\"{:.3}\">x</text><text x=\"{:.3}\" y=\"{:.3}\">y</text>\
             <text x=\"{:.3}\" y=\"{:.3}\">zero X0 Y0</text></g></g>",
            1.2 * unit,
            arm + unit,
            zero + 1.5 * unit,
            -4.0 * unit,
            zero - arm,
            -10.0 * unit,
            zero + 7.0 * unit
        );
        let text = |[x, y]: [f64; 2], turn: f64, what: String| {
            format!("<text text-anchor=\"middle\" transform=\"translate({x:.3} {y:.3}) rotate({turn})\">{what}</text>")
        };
        let optical = blank.optical_size();
        svg += &text([0.5 * size.x, size.y + 13.0 * unit], 0.0, format!("{:.2} mm", size.x));
        svg += &text([size.x + 7.0 * unit, 0.5 * size.y], -90.0, format!("{:.2} mm", size.y));
        svg += &text([0.5 * size.x, 0.5 * size.y], 0.0, format!("relief {:.2} × {:.2} mm", optical.x, optical.y));
        svg += "</svg>\n";
        svg
    }

    /// Heights of the stock, of the finished plate and of what is cut.
    fn view_from_the_side(&self) -> String {
        let blank = &self.shop.blank;
        let deepest = self.files.iter().filter_map(|file| file.judgement.extent.cuts).map(|bounds| bounds.low.z);
        let deepest = deepest.fold(0.0, f64::min);
        let rows = [
            (0.0, "stock's upper face: zero of z"),
            (-blank.over, "highest point of the finished plate"),
            (deepest, "deepest point of a tool"),
            (-blank.size().z, "stock's lower face"),
        ];
        let rows: String =
            rows.iter().map(|(z, what)| format!("<tr><td class=\"n\">Z {z:.3}</td><td>{what}</td></tr>")).collect();
        format!("<table>{rows}</table>\n")
    }

    fn programs(&self) -> String {
        let mut table = String::from(
            "<table><tr><th>program</th><th>tool</th><th>feed, mm/min</th><th>turns a minute</th><th>time</th>\
             <th>lines</th></tr>",
        );
        for file in self.files {
            let (tool, feed, turns) = match file.part {
                Part::AirCut => ("any, the spindle standing".to_owned(), "–".to_owned(), "0".to_owned()),
                _ => (file.cutter.to_string(), format!("{:.0}", file.pace.feed), format!("{:.0}", file.pace.speed)),
            };
            let _ = write!(
                table,
                "<tr><td>{}</td><td>{tool}</td><td class=\"n\">{feed}</td><td class=\"n\">{turns}</td><td class=\"n\">{}</td>\
                 <td class=\"n\">{}</td></tr>",
                file.name,
                duration(file.judgement.timing.seconds),
                file.judgement.lines
            );
        }
        let seconds: f64 = self.files.iter().map(|file| file.judgement.timing.seconds).sum();
        format!(
            "{table}</table>\n<p>{} in all on {}. Feeds and speeds are {}.</p>\n",
            duration(seconds),
            escaped(&self.shop.machining.machine.name),
            escaped(SOURCE)
        )
    }

    fn steps(&self) -> String {
        let file = |part: Part| part.file(self.shop.dialect);
        let machining = self.shop.finishing();
        let steps = [
            "Clamp the stock flat; nothing of the clamps may stand within the bounds of the programs (below)."
                .to_owned(),
            "Set zero: x and y at the lower left corner, z at the upper face.".to_owned(),
            format!(
                "Run {}: the outline, its diagonals and three passes go by above the stock. Stop if anything is in the way.",
                file(Part::AirCut)
            ),
            format!("Put in {}, set z to the upper face, run {}.", self.shop.roughing.cutter, file(Part::Roughing)),
            format!(
                "Put in {}, new and clean. The upper face is gone: set z over something whose height above the table is \
                 known from before, such as a gauge block, to a few micrometres. Too high leaves roughing's steps standing, \
                 too low costs nothing but depth.",
                machining.cutter
            ),
            format!(
                "Let the spindle warm up for a quarter of an hour, then run {} without a break: what the machine drifts in \
                 a break is a step in the mirror.",
                file(Part::Finishing)
            ),
        ];
        let items: String = steps.iter().map(|step| format!("<li>{}</li>", escaped(step))).collect();
        format!("<ol>{items}</ol>\n")
    }

    fn clamping(&self) -> String {
        let bounds = self.files.iter().filter_map(|file| file.judgement.extent.all);
        let bounds = bounds.reduce(|a, b| Bounds { low: a.low.min(b.low), high: a.high.max(b.high) });
        let reach = self.shop.roughing.cutter.reach().max(self.shop.machining.cutter.reach());
        let mut text = String::new();
        if let Some(bounds) = bounds {
            let _ = writeln!(
                text,
                "<p>Tools go from X {:.2} to {:.2} and from Y {:.2} to {:.2}, measured at their axes, and are up to {reach:.2} \
                 mm wide on each side of them. Beside the stock they go down to Z {:.2}: clamp from below, glue, or leave a \
                 rim of stock outside.</p>",
                bounds.low.x, bounds.high.x, bounds.low.y, bounds.high.y, bounds.low.z
            );
        }
        match &self.rim {
            Some(rim) => text + &format!("<p>{}.</p>\n", escaped(&capital(rim))),
            None => text + "<p>There is no rim: the relief goes to the stock's edges.</p>\n",
        }
    }

    fn polish(&self) -> String {
        if let Some(polish) = &self.polish {
            return format!("<p>{}</p>\n", escaped(polish));
        }
        let machining = self.shop.finishing();
        let cusps = 1000.0 * machining.cusp_height();
        match machining.polish {
            Some(sigma) => format!(
                "<p>The relief is to be smoothed evenly by {:.0} µm: as far as a Gaussian of that standard deviation rounds \
                 heights. Cusps of {cusps:.2} µm, {:.0} µm apart, are then gone to the eye, and edges are rounded by about \
                 {:.0} µm. Polish all of it the same, with something soft that follows the relief; stop when no lines of the \
                 passes can be seen. More rounds the light itself.</p>\n",
                1000.0 * sigma,
                1000.0 * machining.passes.stepover,
                2000.0 * sigma
            ),
            None => format!(
                "<p>The relief is not polished: cusps of {cusps:.2} µm stay. Do not touch the surface; clean it with a \
                 solvent and air.</p>\n"
            ),
        }
    }
}

/// The same text with what HTML would take for its own.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The same with a capital at its start.
fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}
