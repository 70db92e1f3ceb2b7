//! Draws the sample highlights in `examples/highlights`: `cargo run --release --example draw_highlights [FOLDER]`.
//!
//! Each is a function of the image plane (u right, v up, both from -1 to 1) that says how much light there shall be.
//! It is averaged over each of 256 × 256 pixels and written sRGB-encoded, as any picture program would.

use std::error::Error;
use std::f64::consts::{PI, TAU};
use std::path::{Path, PathBuf};

use facetmill::raster::Raster;
use glam::{DMat3, DVec2, DVec3};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use rayon::prelude::*;
use skrifa::instance::{LocationRef, Size};
use skrifa::outline::{DrawSettings, OutlinePen};
use skrifa::{FontRef, MetadataProvider};

const SIZE: usize = 256;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("examples/highlights"), PathBuf::from);
    std::fs::create_dir_all(&folder)?;
    let letter = Lettering::new("R", 1.45)?;
    let word = Lettering::new("glint", 1.72)?;
    save(&folder, "ring", &drawn(8, ring))?;
    save(&folder, "star", &drawn(8, star))?;
    save(&folder, "spiral", &drawn(8, spiral))?;
    save(&folder, "letter", &drawn(8, |p| letter.light(p, 0.045)))?;
    save(&folder, "word", &drawn(8, |p| word.light(p, 0.022)))?;
    save(&folder, "portrait", &drawn(4, portrait))?;
    Ok(())
}

/// The mean of `light` over `samples` × `samples` points of each pixel.
fn drawn(samples: usize, light: impl Fn(DVec2) -> f64 + Sync) -> Raster {
    let fine = (SIZE * samples) as f64;
    let mut out = Raster::zeros(SIZE, SIZE);
    out.values.par_chunks_mut(SIZE).enumerate().for_each(|(row, line)| {
        for (column, value) in line.iter_mut().enumerate() {
            let points = (0..samples * samples).map(|i| {
                let x = (column * samples + i % samples) as f64 + 0.5;
                let y = (row * samples + i / samples) as f64 + 0.5;
                light(DVec2::new(x / fine * 2.0 - 1.0, 1.0 - y / fine * 2.0))
            });
            *value = points.sum::<f64>() / (samples * samples) as f64;
        }
    });
    out
}

/// As 8-bit grey PNG, sRGB-encoded (IEC 61966-2-1).
fn save(folder: &Path, name: &str, light: &Raster) -> Result<(), Box<dyn Error>> {
    let encode = |v: &f64| {
        let v = v.clamp(0.0, 1.0);
        let encoded = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
        (encoded * 255.0).round() as u8
    };
    let bytes: Vec<u8> = light.values.iter().map(encode).collect();
    let mut file = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut file, CompressionType::Best, FilterType::Adaptive);
    encoder.write_image(&bytes, SIZE as u32, SIZE as u32, ExtendedColorType::L8)?;
    std::fs::write(folder.join(format!("{name}.png")), file)?;
    Ok(())
}

fn lit(inside: bool) -> f64 {
    if inside { 1.0 } else { 0.0 }
}

fn ring(p: DVec2) -> f64 {
    lit((0.58..0.8).contains(&p.length()))
}

/// Five points, one of them up; the inner corners are those of a pentagram.
fn star(p: DVec2) -> f64 {
    let (outer, inner) = (0.88, 0.88 * 0.381_966);
    // Folded into one tenth of the star: between a point (angle 0) and its neighbouring inner corner.
    let angle = (p.x.atan2(p.y).rem_euclid(TAU / 5.0) - TAU / 10.0).abs();
    let p = p.length() * DVec2::from_angle(TAU / 10.0 - angle);
    let (tip, corner) = (DVec2::X * outer, inner * DVec2::from_angle(TAU / 10.0));
    lit((corner - tip).perp_dot(p - tip) > 0.0)
}

/// Archimedean, widening outward, with round ends.
fn spiral(p: DVec2) -> f64 {
    // Its outline is not centred on its pole.
    let p = p - DVec2::new(0.08, 0.08);
    let (turns, reach) = (2.75, 0.84);
    let pitch = reach / turns;
    let width = |r: f64| 0.035 + 0.045 * r / reach;
    let angle = p.y.atan2(p.x) / TAU;
    let arms = (-1..4).map(|k| angle + f64::from(k)).filter(|t| (0.12..=turns).contains(t));
    let on_an_arm = arms.clone().any(|t| (p.length() - t * pitch).abs() < width(t * pitch));
    let ends = [0.12, turns].map(|t| (t * pitch * DVec2::from_angle(t * TAU), width(t * pitch)));
    lit(on_an_arm || ends.iter().any(|(end, radius)| p.distance(*end) < *radius))
}

/// Glyph outlines as line segments, centred and scaled to the image plane.
struct Lettering {
    segments: Vec<(DVec2, DVec2)>,
}

impl Lettering {
    /// `extent` is the longer side of the text's box on the image plane.
    fn new(text: &str, extent: f64) -> Result<Self, Box<dyn Error>> {
        let font = FontRef::new(epaint_default_fonts::UBUNTU_LIGHT)?;
        let (size, plain) = (Size::unscaled(), LocationRef::default());
        let metrics = font.glyph_metrics(size, plain);
        let mut pen = Pen::default();
        for letter in text.chars() {
            let id = font.charmap().map(letter).ok_or("the font lacks a letter")?;
            pen.right += 18.0;
            font.outline_glyphs().get(id).ok_or("no outline")?.draw(DrawSettings::unhinted(size, plain), &mut pen)?;
            pen.right += f64::from(metrics.advance_width(id).unwrap_or(0.0));
        }
        let segments = pen.segments;
        let ends = || segments.iter().map(|s| s.0);
        let (low, high) = ends().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        let scale = extent / (high - low).max_element();
        let place = |p: DVec2| (p - (low + high) / 2.0) * scale;
        Ok(Self { segments: segments.iter().map(|(a, b)| (place(*a), place(*b))).collect() })
    }

    /// Inside the outline, or within `bold` of it: the font's strokes are thin.
    fn light(&self, p: DVec2, bold: f64) -> f64 {
        let mut winding = 0;
        for (a, b) in &self.segments {
            let along = *b - *a;
            let t = ((p - *a).dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
            if p.distance(*a + along * t) < bold {
                return 1.0;
            }
            if (a.y <= p.y) != (b.y <= p.y) && (along.perp_dot(p - *a) > 0.0) == (b.y > a.y) {
                winding += if b.y > a.y { 1 } else { -1 };
            }
        }
        lit(winding != 0)
    }
}

/// Takes outlines in font units and cuts their curves into segments.
#[derive(Default)]
struct Pen {
    /// Where the glyph begins.
    right: f64,
    first: DVec2,
    last: DVec2,
    segments: Vec<(DVec2, DVec2)>,
}

impl Pen {
    fn at(&self, x: f32, y: f32) -> DVec2 {
        DVec2::new(f64::from(x) + self.right, f64::from(y))
    }

    /// A Bézier curve from the last point on.
    fn curve(&mut self, onward: &[DVec2], steps: u32) {
        let points = [&[self.last], onward].concat();
        // de Casteljau: repeated halfway points, here at `t`.
        let point = |t: f64| {
            let mut row = points.clone();
            while row.len() > 1 {
                row = row.windows(2).map(|pair| pair[0].lerp(pair[1], t)).collect();
            }
            row[0]
        };
        let step = |k: u32| point(f64::from(k) / f64::from(steps));
        self.segments.extend((0..steps).map(|k| (step(k), step(k + 1))));
        self.last = points[points.len() - 1];
    }
}

impl OutlinePen for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        self.first = self.at(x, y);
        self.last = self.first;
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.curve(&[self.at(x, y)], 1);
    }

    fn quad_to(&mut self, cx0: f32, cy0: f32, x: f32, y: f32) {
        self.curve(&[self.at(cx0, cy0), self.at(x, y)], 10);
    }

    fn curve_to(&mut self, cx0: f32, cy0: f32, cx1: f32, cy1: f32, x: f32, y: f32) {
        self.curve(&[self.at(cx0, cy0), self.at(cx1, cy1), self.at(x, y)], 10);
    }

    fn close(&mut self) {
        self.curve(&[self.first], 1);
    }
}

/// A marble head with closed eyes, lit from the upper left: the distance to it is known everywhere, and rays march.
fn portrait(p: DVec2) -> f64 {
    let scale = 1.02;
    let from = DVec3::new(p.x * scale, p.y * scale - 0.16, 4.0);
    let ahead = -DVec3::Z;
    let Some(depth) = march(from, ahead, 6.0) else { return 0.0 };
    let hit = from + ahead * depth;
    let step = 2e-3;
    let slope = |axis: DVec3| head(hit + axis * step) - head(hit - axis * step);
    let normal = DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z)).normalize();
    let key = DVec3::new(-0.62, 0.55, 0.62).normalize();
    let rim = DVec3::new(0.9, 0.25, -0.3).normalize();
    let above = hit + normal * 0.01;
    let open = openness(above, normal);
    let direct = normal.dot(key).max(0.0) * shade(above, key);
    let edge = normal.dot(rim).max(0.0).powi(2) * shade(above, rim);
    let sky = 0.5 + 0.5 * normal.y;
    let gloss = normal.dot((key + DVec3::Z).normalize()).max(0.0).powi(24) * shade(above, key);
    let fade = ((hit.y + 1.15) / 0.5).clamp(0.0, 1.0);
    (0.80 * direct + 0.22 * edge + open * (0.035 + 0.045 * sky) + 0.12 * gloss) * fade * fade * (3.0 - 2.0 * fade)
}

fn march(from: DVec3, ahead: DVec3, far: f64) -> Option<f64> {
    let mut way = 0.0;
    for _ in 0..160 {
        let gap = head(from + ahead * way);
        if gap < 5e-4 {
            return Some(way);
        }
        way += gap * 0.8;
        if way > far {
            return None;
        }
    }
    None
}

/// How much of a wide lamp is seen from `from`.
fn shade(from: DVec3, toward: DVec3) -> f64 {
    let mut seen = 1.0f64;
    let mut way = 0.02;
    while way < 2.0 && seen > 0.0 {
        let gap = head(from + toward * way);
        seen = seen.min(0.5 + 0.5 * 7.0 * gap / way);
        way += gap.clamp(0.015, 0.15);
    }
    let seen = seen.clamp(0.0, 1.0);
    seen * seen * (3.0 - 2.0 * seen)
}

/// How little of the sky the neighbourhood hides.
fn openness(at: DVec3, normal: DVec3) -> f64 {
    let hidden: f64 = (1..6).map(|k| f64::from(k) * 0.06).map(|d| (d - head(at + normal * d)).max(0.0) * 0.9).sum();
    (1.0 - hidden).clamp(0.0, 1.0)
}

/// Distance to the bust: the head turned to the left of the picture, on a neck and shoulders turned less.
fn head(world: DVec3) -> f64 {
    let turned = DMat3::from_rotation_y(0.42) * (DMat3::from_rotation_x(-0.06) * world);
    // One side is modelled; the other is its mirror image, without a crease between them.
    let p = DVec3::new(turned.x.hypot(0.014), turned.y, turned.z);
    let v = DVec3::new;
    let mut d = ellipsoid(p, v(0.0, 0.2, -0.08), v(0.47, 0.5, 0.56));
    d = union(d, ellipsoid(p, v(0.0, -0.2, 0.1), v(0.37, 0.5, 0.4)), 0.16);
    d = union(d, ellipsoid(p, v(0.0, -0.6, 0.3), v(0.13, 0.1, 0.12)), 0.16);
    d = union(d, ellipsoid(p, v(0.22, -0.42, 0.1), v(0.11, 0.14, 0.18)), 0.2);
    d = union(d, ellipsoid(p, v(0.225, -0.14, 0.29), v(0.12, 0.1, 0.13)), 0.2);
    d = union(d, capsule(p, v(0.05, 0.11, 0.465), v(0.25, 0.13, 0.37), 0.045, 0.03), 0.1);
    d = carve(d, ellipsoid(p, v(0.175, -0.01, 0.54), v(0.115, 0.075, 0.12)), 0.09);
    // Closed lids with the crease above them and the line of lashes below.
    d = union(d, ellipsoid(p, v(0.175, -0.02, 0.385), v(0.1, 0.082, 0.09)), 0.03);
    d = carve(d, arc(p, v(0.175, -0.005, 0.47), 0.085, -0.045, 0.006), 0.018);
    // Nose: bridge, tip, wing, nostril.
    d = union(d, capsule(p, v(0.0, 0.08, 0.47), v(0.0, -0.2, 0.6), 0.035, 0.058), 0.06);
    d = union(d, ellipsoid(p, v(0.058, -0.225, 0.54), v(0.042, 0.04, 0.06)), 0.04);
    d = carve(d, ellipsoid(p, v(0.034, -0.265, 0.575), v(0.016, 0.015, 0.03)), 0.02);
    // Mouth: a mound, the lips on it, the line between them, the dip under the nose.
    d = union(d, ellipsoid(p, v(0.0, -0.4, 0.38), v(0.17, 0.12, 0.12)), 0.1);
    d = union(d, capsule(p, v(0.03, -0.363, 0.508), v(0.13, -0.392, 0.47), 0.028, 0.012), 0.025);
    d = union(d, capsule(p, v(0.0, -0.436, 0.502), v(0.1, -0.415, 0.472), 0.036, 0.016), 0.025);
    d = carve(d, capsule(p, v(0.0, -0.395, 0.545), v(0.15, -0.4, 0.48), 0.009, 0.006), 0.02);
    d = carve(d, capsule(p, v(0.0, -0.285, 0.56), v(0.0, -0.33, 0.55), 0.012, 0.016), 0.03);
    d = carve(d, ellipsoid(p, v(0.0, -0.5, 0.52), v(0.1, 0.03, 0.05)), 0.06);
    let ear = carve(
        ellipsoid(p, v(0.435, -0.09, -0.04), v(0.05, 0.14, 0.1)),
        ellipsoid(p, v(0.485, -0.07, -0.02), v(0.03, 0.09, 0.055)),
        0.03,
    );
    d = union(d, ear, 0.03);
    d = union(d, hair(p, turned), 0.02);
    let body = DMat3::from_rotation_y(0.1) * world;
    let b = v(body.x.abs(), body.y, body.z);
    let neck = capsule(world, v(0.0, -0.45, -0.1), v(0.02, -1.15, -0.2), 0.24, 0.27);
    let chest = ellipsoid(b, v(0.0, -1.6, -0.2), v(0.95, 0.5, 0.42));
    union(d, union(neck, chest, 0.3), 0.06)
}

/// Waves combed back from a parting into a knot.
fn hair(p: DVec3, turned: DVec3) -> f64 {
    let v = DVec3::new;
    let cap = ellipsoid(p, v(0.0, 0.25, -0.12), v(0.53, 0.53, 0.6));
    let wave = 0.012 * (34.0 * (p.y - 0.35 * p.z) + 3.0 * (6.0 * p.x).sin()).sin();
    let face = ellipsoid(p, v(0.0, -0.22, 0.5), v(0.44, 0.64, 0.62));
    let knot = ellipsoid(turned, v(0.0, 0.2, -0.78), v(0.2, 0.2, 0.18));
    union(carve(cap + wave, face, 0.04), knot, 0.05)
}

/// Distance (a little too small away from the surface) to an ellipsoid.
fn ellipsoid(p: DVec3, centre: DVec3, radii: DVec3) -> f64 {
    let p = p - centre;
    let (near, far) = ((p / radii).length(), (p / (radii * radii)).length());
    near * (near - 1.0) / far.max(1e-9)
}

/// Distance to a rod from `a` to `b` whose radius goes from `ra` to `rb`.
fn capsule(p: DVec3, a: DVec3, b: DVec3, ra: f64, rb: f64) -> f64 {
    let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
    p.distance(a.lerp(b, t)) - (ra + (rb - ra) * t)
}

/// Distance to a thin rod across x, `half` to each side of `centre`, sagging by `sag` in the middle.
fn arc(p: DVec3, centre: DVec3, half: f64, sag: f64, radius: f64) -> f64 {
    let x = ((p.x - centre.x) / half).clamp(-1.0, 1.0);
    let bow = (x * PI / 2.0).cos();
    let nearest = centre + DVec3::new(x * half, sag * bow, -0.05 * (1.0 - bow));
    p.distance(nearest) - radius
}

/// Both bodies, blended over a distance of about `soft`.
fn union(a: f64, b: f64, soft: f64) -> f64 {
    let h = (soft - (a - b).abs()).max(0.0) / soft;
    a.min(b) - h * h * soft * 0.25
}

/// `a` without `b`, with an edge rounded over about `soft`.
fn carve(a: f64, b: f64, soft: f64) -> f64 {
    -union(-a, b, soft)
}
