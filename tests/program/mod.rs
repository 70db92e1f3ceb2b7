//! The built program, run as a user runs it: in a folder of its own, with a watch beside it.

use std::ffi::OsStr;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use image::{GrayImage, Luma};
use tempfile::TempDir;

/// After this long a run counts as hung.
const PATIENCE: Duration = Duration::from_secs(60);

/// What a run left behind.
#[derive(Debug)]
pub struct Outcome {
    /// Exit code; none after a signal.
    pub code: Option<i32>,
    pub stdout: String,
    /// Without the lines that tell of stages.
    pub stderr: String,
    /// The lines that tell of stages: those that begin with a blank.
    pub stages: Vec<String>,
}

impl Outcome {
    /// What a person was told, as if the terminal were endlessly wide.
    #[allow(dead_code)]
    pub fn told(&self) -> String {
        self.stdout.split_whitespace().collect::<Vec<_>>().join(" ")
    }
}

/// The program, not started yet.
pub fn facetmill() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_facetmill"));
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Runs the program in `home` to its end.
pub fn run<S: AsRef<OsStr>>(home: &Path, args: impl IntoIterator<Item = S>) -> Outcome {
    finish(facetmill().current_dir(home).args(args).spawn().expect("the program starts"))
}

/// Runs the program in `home` with the words of a line.
pub fn run_line(home: &Path, line: &str) -> Outcome {
    run(home, line.split_whitespace())
}

/// Waits for a run that was started; kills what does not end.
pub fn finish(child: Child) -> Outcome {
    finish_within(child, PATIENCE)
}

/// Waits for a run that was started; kills what does not end by then.
pub fn finish_within(mut child: Child, patience: Duration) -> Outcome {
    let slurp = |pipe: Option<Box<dyn Read + Send>>| {
        std::thread::spawn(move || {
            let mut bytes = Vec::new();
            if let Some(mut pipe) = pipe {
                let _ = pipe.read_to_end(&mut bytes);
            }
            String::from_utf8_lossy(&bytes).into_owned()
        })
    };
    let stdout = slurp(child.stdout.take().map(|pipe| Box::new(pipe) as _));
    let stderr = slurp(child.stderr.take().map(|pipe| Box::new(pipe) as _));
    let start = Instant::now();
    let status = loop {
        match child.try_wait().expect("the program can be waited for") {
            Some(status) => break status,
            None if start.elapsed() > patience => {
                let _ = child.kill();
                panic!("the program hangs: {:?}", child.wait());
            }
            None => std::thread::sleep(Duration::from_millis(3)),
        }
    };
    let all = stderr.join().unwrap();
    let (stages, stderr): (Vec<&str>, Vec<&str>) = all.split_inclusive('\n').partition(|line| line.starts_with(' '));
    let stages = stages.into_iter().map(|line| line.trim().to_owned()).collect();
    Outcome { code: status.code(), stdout: stdout.join().unwrap(), stderr: stderr.concat(), stages }
}

/// An empty folder with `ring.png`, a ring of light of 48 x 48 pixels.
pub fn home() -> TempDir {
    let home = tempfile::tempdir().unwrap();
    ring().save(home.path().join("ring.png")).unwrap();
    home
}

/// A ring of light.
pub fn ring() -> GrayImage {
    GrayImage::from_fn(48, 48, |x, y| {
        let radius = f64::from(x).mul_add(2.0, -47.0).hypot(f64::from(y).mul_add(2.0, -47.0)) / 48.0;
        Luma([if (0.35..0.65).contains(&radius) { 255 } else { 0 }])
    })
}

/// Everything below `folder`, sorted.
pub fn listing(folder: &Path) -> Vec<PathBuf> {
    let mut all = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(next) = open.pop() {
        for entry in std::fs::read_dir(&next).unwrap().map(Result::unwrap) {
            all.push(entry.path());
            if entry.file_type().unwrap().is_dir() {
                open.push(entry.path());
            }
        }
    }
    all.sort();
    all
}
