//! OFF (Object File Format, as of Geomview): a count, vertices, faces.
//!
//! Read word by word: the crate that parses it wants the word "OFF" alone on its line and colours of one kind, and writers
//! do as they like with both.

use super::{MergedTriangles, MeshFileError, add_polygon};

/// A polygon of more corners than this is none.
const MOST_CORNERS: usize = 100_000;

/// Reads a whole file.
pub(crate) fn read(text: &str) -> Result<MergedTriangles, MeshFileError> {
    let damaged = |reason: String| MeshFileError::Damaged { format: "OFF", reason };
    let lines =
        text.trim_start_matches('\u{feff}').split(['\n', '\r']).map(|line| line.split('#').next().unwrap_or(""));
    let mut lines = lines.map(str::trim).filter(|line| !line.is_empty()).peekable();
    // Counts may stand behind the word, even right behind it.
    let first = lines.next().unwrap_or_default();
    let end = first.to_ascii_uppercase().find("OFF").map_or(first.len(), |at| at + 3);
    let (header, rest) = (first[..end].to_ascii_uppercase(), &first[end..]);
    // Of four numbers the last is what the others are to be divided by.
    let divided = header.contains('4');
    let mut counts: Vec<&str> = rest.split_whitespace().collect();
    if counts.is_empty() {
        counts = lines.next().unwrap_or_default().split_whitespace().collect();
    }
    let count = |k: usize| counts.get(k).and_then(|word| word.parse::<usize>().ok());
    let (Some(vertex_count), Some(face_count)) = (count(0), count(1)) else {
        return Err(damaged("it does not say how many vertices and faces it has".into()));
    };
    let mut vertices = Vec::new();
    for k in 0..vertex_count {
        let line = lines.next().ok_or_else(|| damaged(format!("it ends after {k} of {vertex_count} vertices")))?;
        let mut numbers = line.split_whitespace().map_while(|word| word.parse::<f64>().ok());
        let mut number = || numbers.next();
        let (Some(x), Some(y), Some(z)) = (number(), number(), number()) else {
            return Err(damaged(format!("vertex {} is not three numbers", k + 1)));
        };
        let by = if divided { number().unwrap_or(1.0) } else { 1.0 };
        vertices.push([x, y, z].map(|c| (c / by) as f32));
    }
    let mut triangles = MergedTriangles::default();
    for k in 0..face_count {
        let line = lines.next().ok_or_else(|| damaged(format!("it ends after {k} of {face_count} faces")))?;
        let mut numbers = line.split_whitespace().map_while(|word| word.parse::<usize>().ok());
        let corners = numbers.next().filter(|corners| *corners <= MOST_CORNERS);
        let polygon: Vec<usize> = numbers.take(corners.unwrap_or(0)).collect();
        if corners != Some(polygon.len()) {
            return Err(damaged(format!("face {} has not as many corners as it says", k + 1)));
        }
        add_polygon(&mut triangles, &vertices, &polygon, "OFF")?;
    }
    Ok(triangles)
}
