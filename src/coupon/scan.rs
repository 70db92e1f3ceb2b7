//! Scans of a test piece: points x, y, z in a text file, as lines across the passes.

/// Points of a scan whose x lies no farther apart belong to one line, mm.
const SAME: f64 = 1e-3;

/// A line that wanders farther than this along x is none across the passes, mm.
const STRAIGHT: f64 = 0.1;

/// Fewer points are no line.
const FEWEST: usize = 100;

/// Units that a column may be in, with what they are in mm.
const UNITS: [(&str, f64); 6] = [("mm", 1.0), ("um", 1e-3), ("µm", 1e-3), ("nm", 1e-6), ("inch", 25.4), ("in", 25.4)];

/// Heights along a line across the passes.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Its place along the passes, mm.
    pub x: f64,
    /// Place across the passes and height of each point, mm, by ascending place.
    pub points: Vec<[f64; 2]>,
}

/// Where a column of numbers stands, and its unit in mm.
type Column = (usize, f64);

/// Lines across the passes, by ascending x, of text with the columns x, y and z; a first line may name them with their units.
///
/// # Errors
/// A word is no number, columns are missing, or there is no line across the passes.
pub fn read(bytes: &[u8]) -> Result<Vec<Line>, ScanError> {
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim_start_matches('\u{feff}');
    if text.contains('\0') {
        return Err(ScanError::Binary);
    }
    let mut points: Vec<[f64; 3]> = Vec::new();
    let mut columns: Option<[Column; 3]> = None;
    for (k, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with(['#', '%']) {
            continue;
        }
        let words = words(line);
        let first = columns.is_none();
        let of = match columns {
            Some(columns) => columns,
            None => named(&words, k as u32 + 1)?,
        };
        columns = Some(of);
        if first && words.iter().any(|word| number(word).is_none() && !word.is_empty()) {
            continue;
        }
        points.extend(point(&words, &of, k as u32 + 1)?);
    }
    if points.is_empty() {
        return Err(ScanError::Empty);
    }
    lines(points)
}

/// The words of a line, whichever separates them; with semicolons a comma may be the decimal one.
fn words(line: &str) -> Vec<String> {
    let split = |by: char| line.split(by).map(|word| word.trim().to_owned()).collect();
    if line.contains(';') {
        let words: Vec<String> = split(';');
        words.into_iter().map(|word| word.replace(',', ".")).collect()
    } else if line.contains(',') {
        split(',')
    } else if line.contains('\t') {
        split('\t')
    } else {
        line.split_whitespace().map(str::to_owned).collect()
    }
}

fn number(word: &str) -> Option<f64> {
    word.parse().ok()
}

/// Where x, y and z stand: as the first line says, else in this order and in mm.
fn named(words: &[String], line: u32) -> Result<[Column; 3], ScanError> {
    if words.iter().all(|word| number(word).is_some()) {
        return match words.len() {
            3.. => Ok([(0, 1.0), (1, 1.0), (2, 1.0)]),
            columns => Err(ScanError::Columns { line, columns }),
        };
    }
    let find = |name: char| {
        words.iter().enumerate().find_map(|(k, word)| {
            let word = word.trim_matches('"').to_lowercase();
            let unit = word.strip_prefix(name)?.trim_matches(|c: char| !c.is_alphanumeric());
            let unit = if unit.is_empty() { "mm" } else { unit };
            UNITS.iter().find(|(own, _)| *own == unit).map(|(_, mm)| (k, *mm))
        })
    };
    match [find('x'), find('y'), find('z')] {
        [Some(x), Some(y), Some(z)] => Ok([x, y, z]),
        _ => Err(ScanError::Names(words.join(", "))),
    }
}

/// One point; none where the instrument saw nothing.
fn point(words: &[String], columns: &[Column; 3], line: u32) -> Result<Option<[f64; 3]>, ScanError> {
    let mut point = [0.0; 3];
    for ((k, unit), value) in columns.iter().zip(&mut point) {
        let Some(word) = words.get(*k) else { return Err(ScanError::Columns { line, columns: words.len() }) };
        match number(word) {
            Some(number) if number.is_finite() => *value = number * unit,
            Some(_) => return Ok(None),
            None if word.is_empty() => return Ok(None),
            None => return Err(ScanError::Word { line, word: word.clone() }),
        }
    }
    Ok(Some(point))
}

fn lines(mut points: Vec<[f64; 3]>) -> Result<Vec<Line>, ScanError> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut lines = Vec::new();
    for group in points.chunk_by(|a, b| b[0] - a[0] <= SAME) {
        let (first, last) = (group[0][0], group[group.len() - 1][0]);
        if group.len() < FEWEST || last - first > STRAIGHT {
            continue;
        }
        let mut points: Vec<[f64; 2]> = group.iter().map(|[_, y, z]| [*y, *z]).collect();
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        lines.push(Line { x: 0.5 * (first + last), points });
    }
    if lines.is_empty() { Err(ScanError::NoLine(points.len())) } else { Ok(lines) }
}

/// Not a scan.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ScanError {
    /// No text at all.
    #[error("this is no text: write the scan as CSV with the columns x, y, z in mm")]
    Binary,
    /// Nothing in it.
    #[error("there is no point in it: write the columns x, y, z in mm, a line for each point")]
    Empty,
    /// The first line names other columns.
    #[error(
        "its first line says '{0}': it should name the columns x, y and z, each with its unit if that is not mm, such as \
         x_mm,y_mm,z_um"
    )]
    Names(String),
    /// Too few columns.
    #[error("line {line} has {columns} columns: x, y and z are needed, also of a scan along a line")]
    Columns {
        /// Its number, from 1.
        line: u32,
        /// How many there are.
        columns: usize,
    },
    /// A word that is no number.
    #[error("line {line}: '{word}' is no number: leave out what is none, or begin its line with #")]
    Word {
        /// Its number, from 1.
        line: u32,
        /// The word.
        word: String,
    },
    /// No line across the passes.
    #[error(
        "none of its {0} points are a line across the passes: {FEWEST} points and more with the same x (to 1 µm) were \
         looked for; scan along y, not along x"
    )]
    NoLine(usize),
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(head: &str, separator: &str, unit: f64) -> String {
        let mut text = format!("# a remark\n{head}\n");
        for k in 0..240 {
            let (x, y) = (4.0 + f64::from(k % 2), f64::from(k / 2) * 0.002);
            text += &format!("{}{separator}{}{separator}{}\n", x, y, (0.001 * y) / unit);
        }
        text
    }

    #[test]
    fn columns_units_and_separators_are_as_the_file_says() {
        let plain = read(table("", ",", 1.0).as_bytes()).unwrap();
        assert_eq!((plain.len(), plain[0].x, plain[1].x, plain[0].points.len()), (2, 4.0, 5.0, 120));
        for (head, separator, unit) in
            [("x_mm,y_mm,z_um", ",", 1e-3), ("x [mm]\ty\tz (µm)", "\t", 1e-3), ("x y z", " ", 1.0)]
        {
            let same = read(table(head, separator, unit).as_bytes()).unwrap();
            assert!((same[1].points[7][1] - plain[1].points[7][1]).abs() < 1e-12, "{head}");
        }
        let german = table("x;y;z", ";", 1.0).replace('.', ",");
        assert_eq!(read(german.as_bytes()).unwrap()[0].points.len(), 120);
    }

    #[test]
    fn what_is_no_scan_is_told_with_its_line() {
        let said = |text: &str| read(text.as_bytes()).unwrap_err().to_string();
        assert!(said("").contains("no point"));
        assert!(said("1,2\n").contains("line 1 has 2 columns"));
        assert!(said("x,y,z\n1,2,3\n1,2,oops\n").contains("line 3: 'oops'"));
        assert!(said("height,width,depth\n1,2,3\n").contains("height, width, depth"));
        assert!(said("1,2,3\n2,2,3\n").contains("scan along y"));
        assert!(said("\0\0\u{1}").contains("no text"));
    }
}
