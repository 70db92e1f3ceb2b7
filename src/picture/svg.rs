//! Drawings in SVG, rasterised.
//!
//! The crate `resvg` draws them. No file and no address that a drawing names is opened; text and pictures within it are
//! not drawn, and notes count them. What a drawing may make the crate set aside (layers within layers, patterns) is
//! summed up before anything is drawn.

use std::thread;

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Group, ImageHrefResolver, Node, Options, Paint, Tree, roxmltree};

use super::pixels::{MAX_MEMORY, Pixels, Samples, check_size};
use super::{PictureError, one_line};
use crate::fence::fenced;

/// Pixels along the longer side. A design tells slopes apart by an eighth of a degree, so that this is finer than any
/// design is for half fields of up to 60°.
const SIDE: f32 = 1024.0;

/// Stack for reading and drawing, bytes: elements within elements 1024 deep, which is the crate's own limit.
const STACK: usize = 64 << 20;

/// A layer is at most as large as this many canvases: the crate cuts it there.
const LARGEST_LAYER: f64 = 25.0;

/// Layers within layers.
const DEEPEST: usize = 200;

/// Draws a file that looks like SVG.
pub(crate) fn decode(bytes: &[u8], name: &str) -> Result<Pixels, PictureError> {
    let corrupt = |reason: &dyn std::fmt::Display| PictureError::Corrupt {
        name: name.into(),
        format: "SVG",
        reason: one_line(reason),
    };
    let text = text(bytes).ok_or_else(|| corrupt(&"its text is neither UTF-8 nor UTF-16"))?;
    let drawn = thread::scope(|scope| {
        let work = || fenced(|| drawn(&text, name)).unwrap_or_else(|panicked| Err(corrupt(&panicked)));
        let thread = thread::Builder::new().stack_size(STACK).spawn_scoped(scope, work);
        thread.map(|thread| thread.join())
    });
    match drawn {
        Ok(Ok(result)) => result,
        Ok(Err(_)) => Err(corrupt(&"its decoder failed on them")),
        Err(_) => Err(PictureError::Memory { name: name.into() }),
    }
}

/// UTF-8, or UTF-16 by its mark.
fn text(bytes: &[u8]) -> Option<String> {
    let wide = |from: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes[2..].chunks_exact(2).map(|pair| from([pair[0], pair[1]])).collect();
        String::from_utf16(&units).ok()
    };
    match bytes {
        [0xff, 0xfe, ..] => wide(u16::from_le_bytes),
        [0xfe, 0xff, ..] => wide(u16::from_be_bytes),
        [0xef, 0xbb, 0xbf, rest @ ..] => String::from_utf8(rest.to_vec()).ok(),
        _ => String::from_utf8(bytes.to_vec()).ok(),
    }
}

fn drawn(text: &str, name: &str) -> Result<Pixels, PictureError> {
    let corrupt = |reason: &dyn std::fmt::Display| PictureError::Corrupt {
        name: name.into(),
        format: "SVG",
        reason: one_line(reason),
    };
    let parsing = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
    let document = roxmltree::Document::parse_with_options(text, parsing).map_err(|error| corrupt(&error))?;
    let notes = not_drawn(&document);
    let options = Options {
        image_href_resolver: ImageHrefResolver {
            resolve_data: Box::new(|_, _, _| None),
            resolve_string: Box::new(|_, _| None),
        },
        ..Options::default()
    };
    let tree = Tree::from_xmltree(&document, &options).map_err(|error| corrupt(&error))?;
    let size = tree.size();
    let scale = SIDE / size.width().max(size.height());
    let [width, height] = [size.width(), size.height()].map(|side| (side * scale).round().clamp(0.0, SIDE) as u32);
    check_size(width.into(), height.into(), name)?;
    let canvas = f64::from(width) * f64::from(height);
    let measure = Measure { canvas, scale: f64::from(scale) };
    if measure.group(tree.root(), 0).is_none_or(|pixels| 4.0 * (pixels + canvas) > MAX_MEMORY as f64) {
        return Err(PictureError::Memory { name: name.into() });
    }
    let mut canvas = Pixmap::new(width, height).ok_or_else(|| PictureError::Memory { name: name.into() })?;
    let [x, y] = [width as f32 / size.width(), height as f32 / size.height()];
    resvg::render(&tree, Transform::from_scale(x, y), &mut canvas.as_mut());
    let samples = Samples::U8(canvas.take());
    let pixels = Pixels::plain((width as usize, height as usize), 4, samples);
    Ok(Pixels { premultiplied: true, notes, ..pixels })
}

/// Notes on what a drawing holds that is not drawn.
fn not_drawn(document: &roxmltree::Document) -> Vec<String> {
    let count = |name: &str| {
        let named = document.descendants().filter(|node| node.tag_name().name() == name);
        named.filter(|node| name != "text" || node.descendants().any(|part| part.is_text())).count()
    };
    let mut notes = Vec::new();
    match count("text") {
        0 => {}
        1 => notes.push("One text of the drawing is not drawn: convert it to paths.".into()),
        texts => notes.push(format!("{texts} texts of the drawing are not drawn: convert them to paths.")),
    }
    match count("image") {
        0 => {}
        1 => notes.push("One picture within the drawing is not drawn: export the whole as PNG.".into()),
        images => notes.push(format!("{images} pictures within the drawing are not drawn: export the whole as PNG.")),
    }
    notes
}

/// How many pixels drawing takes beside the canvas, at most.
struct Measure {
    /// Pixels of the canvas.
    canvas: f64,
    /// Pixels to a unit of the drawing.
    scale: f64,
}

impl Measure {
    /// Pixels of a group's own layer with all that is drawn into it, at one time; `None` if it is nested too deeply.
    fn group(&self, group: &Group, depth: usize) -> Option<f64> {
        if depth > DEEPEST {
            return None;
        }
        let area =
            f64::from(group.abs_layer_bounding_box().width()) * f64::from(group.abs_layer_bounding_box().height());
        let layer = (area * self.scale * self.scale).min(LARGEST_LAYER * self.canvas);
        // A filter has its input, its result and those of its steps.
        let filters = if group.filters().is_empty() { 0.0 } else { 4.0 * LARGEST_LAYER * self.canvas };
        let mut own = if group.should_isolate() { layer + filters } else { 0.0 };
        if let Some(mask) = group.mask() {
            own += 2.0 * layer + self.group(mask.root(), depth + 1)?;
        }
        let mut clip = group.clip_path();
        let mut clips = 0;
        while let Some(path) = clip {
            clips += 1;
            if clips > DEEPEST {
                return None;
            }
            own += layer + self.group(path.root(), depth + 1)?;
            clip = path.clip_path();
        }
        let mut most: f64 = 0.0;
        for node in group.children() {
            most = most.max(match node {
                Node::Group(inner) => self.group(inner, depth + 1)?,
                Node::Path(path) => {
                    let scale = path.abs_transform().get_scale();
                    let paints = [path.fill().map(|fill| fill.paint()), path.stroke().map(|stroke| stroke.paint())];
                    let mut sum = 0.0;
                    for paint in paints.into_iter().flatten() {
                        sum += self.paint(paint, scale, depth)?;
                    }
                    sum
                }
                _ => 0.0,
            });
        }
        Some(own + most)
    }

    /// Pixels of one piece of a pattern at that scale, with all that is drawn into it.
    fn paint(&self, paint: &Paint, (x, y): (f32, f32), depth: usize) -> Option<f64> {
        let Paint::Pattern(pattern) = paint else { return Some(0.0) };
        let (own_x, own_y) = pattern.transform().get_scale();
        let piece = pattern.rect();
        let sides = [piece.width() * x * own_x, piece.height() * y * own_y].map(|side| f64::from(side) * self.scale);
        Some(sides[0] * sides[1] + self.group(pattern.root(), depth + 1)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn complaint(text: &str) -> PictureError {
        decode(text.as_bytes(), "a.svg").map(|_| ()).unwrap_err()
    }

    fn svg(inner: &str) -> String {
        format!("<svg xmlns='http://www.w3.org/2000/svg' width='200' height='100'>{inner}</svg>")
    }

    #[test]
    fn a_drawing_fills_the_longer_side_and_keeps_its_proportions() {
        let pixels = decode(svg("<rect width='100' height='100' fill='#fff'/>").as_bytes(), "a").unwrap();
        assert_eq!((pixels.width, pixels.height, pixels.channels), (1024, 512, 4));
        let opacity = |x: usize, y: usize| pixels.samples.at(4 * (x + 1024 * y) + 3);
        assert_eq!((opacity(510, 256), opacity(514, 256)), (1.0, 0.0));
        assert!(pixels.premultiplied && pixels.notes.is_empty());
    }

    #[test]
    fn texts_and_pictures_that_are_not_drawn_are_counted() {
        let inner = "<text x='9' y='9'>two</text><g><text>three</text></g><text/><image href='/etc/passwd'/><rect/>";
        let pixels = decode(svg(inner).as_bytes(), "a").unwrap();
        assert!(pixels.notes[0].starts_with("2 texts"), "{:?}", pixels.notes);
        assert!(pixels.notes[1].starts_with("One picture"), "{:?}", pixels.notes);
    }

    #[test]
    fn text_in_utf_16_is_read() {
        let text = svg("<rect width='9' height='9'/>");
        let wide: Vec<u8> = [0xfeff].into_iter().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
        assert_eq!(decode(&wide, "a").unwrap().width, 1024);
    }

    #[test]
    fn layers_and_patterns_that_would_take_all_memory_are_refused() {
        let nested = |depth: usize| {
            let open = "<g opacity='0.5'><rect width='200' height='100'/>".repeat(depth);
            svg(&format!("{open}{}", "</g>".repeat(depth)))
        };
        assert!(decode(nested(20).as_bytes(), "a").is_ok());
        assert!(matches!(complaint(&nested(250)), PictureError::Memory { .. }));
        let pattern = "<pattern id='p' width='1e6' height='1e6' patternUnits='userSpaceOnUse'><rect width='9' height='9'/>\
                       </pattern><rect width='200' height='100' fill='url(#p)'/>";
        assert!(matches!(complaint(&svg(pattern)), PictureError::Memory { .. }));
        let open = "<g filter='url(#f)'>".repeat(9);
        let filters = format!(
            "<filter id='f'><feGaussianBlur stdDeviation='9'/></filter>{open}<rect width='9' height='9'/>{}",
            "</g>".repeat(9)
        );
        assert!(matches!(complaint(&svg(&filters)), PictureError::Memory { .. }));
    }

    #[test]
    fn what_is_no_drawing_is_refused_in_one_sentence() {
        for text in ["<svg", "<svg xmlns='http://www.w3.org/2000/svg'><g></svg>", "<a><svg/></a>"] {
            assert!(complaint(text).to_string().starts_with("a.svg: the SVG data are damaged"), "{text}");
        }
        let deep = format!("{}{}", "<g>".repeat(100_000), "</g>".repeat(100_000));
        assert!(decode(svg(&deep).as_bytes(), "a").is_err());
        let twice = "<!DOCTYPE svg [<!ENTITY a 'aaaaaaaaaa'><!ENTITY b '&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;'>\
                     <!ENTITY c '&b;&b;&b;&b;&b;&b;&b;&b;&b;&b;'><!ENTITY d '&c;&c;&c;&c;&c;&c;&c;&c;&c;&c;'>]>";
        let bomb = format!("{twice}{}", svg("<desc>&d;&d;&d;&d;&d;&d;&d;&d;&d;&d;</desc>"));
        let _ = decode(bomb.as_bytes(), "a");
    }
}
