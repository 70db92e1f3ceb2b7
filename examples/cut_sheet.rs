//! The default product with progress and cancel: a sheet for a ball of 0.5 mm, its proof and all files, into a folder.
//!
//!     cargo run --release --example cut_sheet -- examples/highlights/ring.png /tmp/ring [SECONDS]
//!
//! After SECONDS, if given, the design is told to finish with the best so far.

use std::error::Error;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::PathBuf;
use std::time::Duration;

use facetmill::job::clock::on_own_threads;
use facetmill::job::{Job, Outcome};
use facetmill::memory::MemoryLimit;
use facetmill::picture::read;
use facetmill::progress::{CancelToken, Cancelled, Event, Listener, Progress, SheetSoFar};
use facetmill::recipe::Recipe;

/// Prints each stage, and how deep the sheet is as it forms.
struct Printer;

impl Listener for Printer {
    fn hear(&self, event: Event<'_>) {
        if let Event::Stage(stage, note) = event {
            println!("[{}] {} {}", stage.id(), stage.words(), note.unwrap_or_default());
        }
    }

    fn wants_relief(&self) -> bool {
        true
    }

    fn see(&self, relief: &SheetSoFar) {
        let (low, high) = relief.heights.iter().fold((0.0f32, 0.0f32), |(low, high), z| (low.min(*z), high.max(*z)));
        println!("    {0} × {0} nodes, {1:.3} mm deep so far", relief.nodes, high - low);
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1);
    let picture = arguments.next().map_or_else(|| "examples/highlights/ring.png".into(), PathBuf::from);
    let folder = arguments.next().map_or_else(|| "ring".into(), PathBuf::from);
    let patience: Option<f64> = arguments.next().map(|s| s.to_string_lossy().parse()).transpose()?;

    let mut recipe = Recipe::default();
    recipe.design.sheet.cutter = Some("ball:0.5".parse()?); // diameter, mm
    recipe.picture = picture.to_str().map(Into::into);
    let picture = read(&picture, &recipe.reading())?;
    let token = CancelToken::default();
    if let Some(seconds) = patience {
        let token = token.clone();
        std::thread::spawn(move || {
            std::thread::sleep(Duration::from_secs_f64(seconds.clamp(0.0, 1e6)));
            token.finish();
        });
    }

    let progress = Progress::new(&Printer, &token);
    let job = Job { recipe: &recipe, picture: &picture, proved: true, memory: MemoryLimit::of_system(1) };
    std::fs::create_dir_all(&folder)?;
    let mut save = |name: &'static str, content: facetmill::job::Content| -> Result<(), Stopped> {
        let mut out = BufWriter::new(File::create(folder.join(name))?);
        content(&mut out)?;
        Ok(out.flush()?)
    };
    let (done, spent) = on_own_threads(None, || {
        let outcome = job.run(None, &mut |_, _| {}, &progress).map_err(|error| error.to_string())?;
        let early = matches!(outcome, Outcome::FinishedEarly(_));
        let product = outcome.product().ok_or("abandoned")?;
        product.write(&picture, &mut save, &progress).map_err(|error| error.0)?;
        Ok::<_, String>((product, early))
    })?;
    let (product, early) = done?;
    if early {
        println!("Told to finish early.");
    }
    if let Some(proof) = &product.proof {
        let judged = proof.milled.as_ref().map_or(&proof.verdict, |milled| &milled.verdict).main();
        let misplaced = 100.0 * judged.tv_incident.value;
        println!("{}: {misplaced:.2} % of the light misplaced, likeness {:.3}", product.made_of(), judged.ssim.value);
    }
    println!("{:.1} s of CPU in {:.1} s", spent.cpu.as_secs_f64(), spent.wall.as_secs_f64());
    Ok(())
}

/// Why a file was not written.
struct Stopped(String);

impl From<io::Error> for Stopped {
    fn from(error: io::Error) -> Self {
        Self(error.to_string())
    }
}

impl From<Cancelled> for Stopped {
    fn from(error: Cancelled) -> Self {
        Self(error.to_string())
    }
}
