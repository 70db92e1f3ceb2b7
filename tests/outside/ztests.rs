//! Highlight images held against the independent referee's, pixel by pixel.
//!
//! Five plates × three incidences × a mirror and rough aluminium × a point lamp and the sun. Each pixel of ours and of
//! theirs is an estimate with a variance; their difference over the root of both is a z, and at the 1 % level, Šidák's
//! correction for the number of pixels of all images made, 99.75 % of pixels have to pass, as in the render tests of Mitsuba 3
//! (`src/render/tests/test_renders.py`). Both sides trace the very triangles of one STL file.
//!
//! What is needed, and what happens without it, is told in `referee/mod.rs`.

use std::fs::File;
use std::path::{Path, PathBuf};

use facetmill::brdf::material::{Material, Substance};
use facetmill::brdf::metals::Metal;
use facetmill::export::stl::write_stl;
use facetmill::job::design::design;
use facetmill::lamp::Extent;
use facetmill::picture::read;
use facetmill::progress::Progress;
use facetmill::projection::Projection;
use facetmill::recipe::Recipe;
use facetmill::relief::mesh::Mesh;
use facetmill::setup::Setup;
use facetmill::trace::mesh::MeshSurface;
use facetmill::verify::experiment::{Experiment, Measuring};
use facetmill::verify::measure::measure;
use facetmill::verify::tally::{Measurement, Tally};
use serde_json::{Value, json};

use crate::plates::waves::waves;
use crate::referee;

/// Rays on either side, about; pixels a side; half field, degrees; roughness of the aluminium.
const RAYS: u64 = 400_000;
const RESOLUTION: usize = 64;
const HALF_FIELD: f64 = 40.0;
const ALPHA: f64 = 0.2;
const SUN: f64 = 0.2665;

/// Share of pixels that must pass, the level of the test, and expected rays below which pixels are pooled.
const PASSING: f64 = 0.9975;
const LEVEL: f64 = 0.01;
const LEAST_EXPECTED: f64 = 10.0;

fn designed(picture: &str, recipe: &str) -> Mesh {
    let recipe = Recipe::from_toml(recipe).unwrap();
    let path = format!("{}/examples/highlights/{picture}.png", env!("CARGO_MANIFEST_DIR"));
    let light = read(path.as_ref(), &recipe.reading()).unwrap().light;
    design(&recipe, &light, &Progress::silent()).unwrap().mesh
}

const FACETS: &str = "plate = { facets = [30, 30] }";

fn plates() -> Vec<(&'static str, Mesh)> {
    vec![
        ("ring", designed("ring", FACETS)),
        ("portrait", designed("portrait", "plate = { facets = [30, 30], cells = 2 }")),
        ("letter", designed("letter", FACETS)),
        ("tall_walls", designed("letter", "highlight = { half-field = 40 }\ndesign = { arrange = 'random' }")),
        ("waves", waves()),
    ]
}

/// One of the sixty.
#[derive(Clone, Copy)]
struct Case {
    plate: usize,
    theta: f64,
    rough: bool,
    radius: f64,
}

impl Case {
    fn all(plates: usize) -> Vec<Self> {
        let mut cases = Vec::new();
        for plate in 0..plates {
            for theta in [0.0, 30.0, 60.0] {
                for (rough, radius) in [(false, 0.0), (false, SUN), (true, 0.0), (true, SUN)] {
                    cases.push(Self { plate, theta, rough, radius });
                }
            }
        }
        cases
    }

    fn name(&self) -> String {
        let material = if self.rough { "rough aluminium" } else { "mirror" };
        format!("{} at {}°, {material}, lamp of {}°", plate_name(self.plate), self.theta, self.radius)
    }

    fn azimuth(&self) -> f64 {
        25.0 + 70.0 * self.plate as f64
    }

    fn job(&self, plate: &Path, image: &Path) -> Value {
        let (eta, k) = Metal::Aluminium.at(Substance::WAVELENGTH);
        let (eta, k, alpha) = if self.rough { (Some(eta), Some(k), ALPHA) } else { (None, None, 0.0) };
        json!({
            "plate": plate, "image": image, "eta": eta, "k": k, "alpha": alpha,
            "theta": self.theta, "phi": self.azimuth(), "radius": self.radius, "projection": "equidistant",
            "half_field": HALF_FIELD, "res": RESOLUTION, "rays": RAYS, "seed": 7,
        })
    }

    fn ours(&self, surface: &MeshSurface) -> Measurement {
        let [theta, phi, radius, half_field] =
            [self.theta, self.azimuth(), self.radius, HALF_FIELD].map(f64::to_radians);
        let setup = Setup::new(theta, phi, radius, Projection::Equidistant, half_field);
        let material = if self.rough { format!("aluminium:ggx:{ALPHA}").parse().unwrap() } else { Material::MIRROR };
        let experiment = Experiment {
            surface,
            setup: &setup,
            material,
            lamp: setup.lamp().with_extent(Extent::round(radius)).into(),
        };
        let measuring = Measuring { rays: RAYS, resolution: RESOLUTION, seed: 3, ..Measuring::default() };
        measure(&experiment, &measuring, &Progress::silent()).unwrap()
    }
}

fn plate_name(plate: usize) -> &'static str {
    ["ring", "portrait", "letter", "tall walls", "waves"][plate]
}

/// The referee's image as shares of incident light, and its numbers.
struct Theirs {
    image: Vec<f64>,
    numbers: Value,
}

impl Theirs {
    fn number(&self, name: &str) -> f64 {
        self.numbers[name].as_f64().unwrap()
    }

    /// Variance of a share that they measured: a ray counts or not, or less where metal took some of it.
    fn variance(&self, share: f64) -> f64 {
        share * (1.0 - share).max(0.0) / self.number("rays_incident")
    }
}

/// z of every pixel or pool of pixels.
fn scores(ours: &Measurement, theirs: &Theirs) -> Vec<f64> {
    let rays = theirs.number("rays_incident").min(ours.whole.rays as f64);
    let errors = ours.pixel_errors();
    let (mut all, mut pool) = (Vec::new(), [0.0; 3]);
    let z = |[a, b, variance]: [f64; 3]| (a - b) / (variance + theirs.variance(0.5 * (a + b))).sqrt();
    for (pixel, &light) in ours.whole.image.values.iter().enumerate() {
        let (a, b) = (light / ours.whole.incident, theirs.image[pixel]);
        let one = [a, b, (errors.values[pixel] * ours.whole.up()).powi(2)];
        if 0.5 * (a + b) * rays >= LEAST_EXPECTED {
            all.push(z(one));
            continue;
        }
        pool = std::array::from_fn(|k| pool[k] + one[k]);
        if 0.5 * (pool[0] + pool[1]) * rays >= LEAST_EXPECTED {
            all.push(z(pool));
            pool = [0.0; 3];
        }
    }
    all
}

/// Share of scores within the two-sided level after Šidák's correction for their number, in sixty such images.
fn passing(scores: &[f64]) -> f64 {
    let each = 1.0 - (1.0 - LEVEL).powf(1.0 / (60 * scores.len()) as f64);
    let within = scores.iter().filter(|z| two_sided(z.abs()) >= each).count();
    within as f64 / scores.len() as f64
}

/// Chance that a standard normal number lies farther from 0 than `z`: its density summed by the midpoint rule.
fn two_sided(z: f64) -> f64 {
    let step = 1e-3;
    let density = |t: f64| (-0.5 * t * t).exp() * (2.0 / std::f64::consts::PI).sqrt();
    (0..8000).map(|k| step * density(z + (f64::from(k) + 0.5) * step)).sum()
}

fn figures_agree(name: &str, ours: &Measurement, theirs: &Theirs) -> f64 {
    type Figure = (&'static str, fn(&Tally) -> f64, &'static str);
    let figures: [Figure; 5] = [
        ("up", Tally::up, "up"),
        ("blocked", Tally::blocked, "blocked_total"),
        ("multi-bounce", |t| t.up_multi / t.incident, "up_multi"),
        ("taken by the material", |t| t.taken / t.incident, "absorbed_material"),
        ("wall first", |t| t.first_hit_wall / t.incident, "first_hit_wall"),
    ];
    let errors = ours.standard_errors(|tally| figures.map(|(_, figure, _)| figure(tally)));
    let mut worst = 0.0f64;
    for ((what, figure, theirs_name), error) in figures.into_iter().zip(errors) {
        let (a, b) = (figure(&ours.whole), theirs.number(theirs_name));
        let combined = (error * error + theirs.variance(b.clamp(0.0, 1.0))).sqrt();
        assert!((a - b).abs() <= 4.0 * combined + 1e-6, "{what} of {name}: {a} here, {b} there, error {combined}");
        worst = worst.max((a - b).abs() / combined.max(1e-6));
    }
    worst
}

#[test]
fn every_pixel_of_sixty_images_is_the_referees() {
    let Some(folder) = referee::folder() else { return };
    let home = tempfile::tempdir().unwrap();
    let plates = plates();
    let write = |(name, mesh): &(&str, Mesh)| {
        let path = home.path().join(format!("{name}.stl"));
        write_stl(mesh, &mut File::create(&path).unwrap()).unwrap();
        path
    };
    let written: Vec<PathBuf> = plates.iter().map(write).collect();
    let cases = Case::all(plates.len());
    let image = |k: usize| home.path().join(format!("{k}.f64"));
    let jobs: Vec<Value> = cases.iter().enumerate().map(|(k, c)| c.job(&written[c.plate], &image(k))).collect();
    let list = home.path().join("jobs.json");
    std::fs::write(&list, Value::from(jobs).to_string()).unwrap();
    let said = match referee::ask("referee_image.py", &[folder.as_path(), &list]) {
        Ok(said) => said,
        Err(why) => return referee::skip(&why),
    };
    let all: Vec<Theirs> = said
        .lines()
        .enumerate()
        .map(|(k, line)| {
            let bytes = std::fs::read(image(k)).unwrap();
            let image = bytes.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect();
            Theirs { image, numbers: serde_json::from_str(line).unwrap() }
        })
        .collect();
    assert_eq!(all.len(), cases.len());

    let surfaces: Vec<MeshSurface> = plates.iter().map(|(_, mesh)| MeshSurface::new(mesh, 0.0).unwrap()).collect();
    let mut failures = Vec::new();
    for (k, (case, theirs)) in cases.iter().zip(&all).enumerate() {
        let (name, ours) = (case.name(), case.ours(&surfaces[case.plate]));
        let scores = scores(&ours, theirs);
        let (passed, mean) = (passing(&scores), scores.iter().map(|z| z * z).sum::<f64>() / scores.len() as f64);
        let worst = figures_agree(&name, &ours, theirs);
        let farthest = scores.iter().fold(0.0f64, |most, z| most.max(z.abs()));
        println!(
            "{name}: farthest {farthest:.2}; {:.2} % of {} pass, mean z² {mean:.2}, figures z {worst:.1}",
            100.0 * passed,
            scores.len()
        );
        assert!(theirs.number("backface") <= 1e-4 && ours.whole.backface == 0.0, "{name} leaks");
        if passed < PASSING {
            failures.push(name.clone());
        }
        // The same test tells the mirror from the rough metal.
        let other = (k + 2) % cases.len();
        let mistaken = passing(&self::scores(&ours, &all[other]));
        assert!(mistaken < PASSING, "{name} passes for {}", cases[other].name());
    }
    assert!(failures.is_empty(), "{failures:?}");
}
