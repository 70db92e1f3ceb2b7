//! What a file that should be a mesh is, by its first bytes.

/// This many bytes are enough to tell.
pub(crate) const ENOUGH: u64 = 1 << 16;

/// What is read, for messages.
pub(crate) const READ: &str = if cfg!(feature = "meshes") { "STL, OBJ, PLY, 3MF and OFF" } else { "STL and OFF" };

/// A kind of file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// STL, or nothing that is known: STL says what is wrong with it.
    Stl,
    /// Object File Format.
    Off,
    /// Wavefront.
    #[cfg(feature = "meshes")]
    Obj,
    /// Polygon File Format.
    #[cfg(feature = "meshes")]
    Ply,
    /// A zip archive, which a 3MF file is.
    #[cfg(feature = "meshes")]
    Zip,
    /// Something else: what, and what would do.
    Other(&'static str, &'static str),
}

const MESH: &str = "export the plate as binary STL";
const MODEL: &str = "export it from CAD as binary STL, with fine facets";
const PATH: &str = "name the mesh that it was made from";
const PICTURE: &str = "name the plate's mesh; a picture goes with --against";
const UNPACK: &str = "unpack it and name the mesh in it";

/// Beginnings of what people take for a mesh: offset, bytes, what it is, what would do.
const OTHERS: [(usize, &[u8], &str, &str); 34] = [
    (0, b"\x89PNG", "a PNG picture", PICTURE),
    (0, b"\xff\xd8\xff", "a JPEG picture", PICTURE),
    (0, b"GIF8", "a GIF picture", PICTURE),
    (0, b"II*\0", "a TIFF picture", PICTURE),
    (0, b"MM\0*", "a TIFF picture", PICTURE),
    (8, b"WEBP", "a WebP picture", PICTURE),
    (0, b"\x76\x2f\x31\x01", "an OpenEXR picture", PICTURE),
    (0, b"8BPS", "a Photoshop document", PICTURE),
    (4, b"ftyp", "a picture or a film", PICTURE),
    (0, b"%PDF", "a PDF document", MESH),
    (0, b"ISO-10303-21", "a STEP model", MODEL),
    (0, b"DBRep_DrawableShape", "a B-rep model", MODEL),
    (0, b"CASCADE Topology", "a B-rep model", MODEL),
    (0, b"3D Geometry File Format", "a Rhino model", MODEL),
    (0, b"\xd0\xcf\x11\xe0", "a CAD or office document", MODEL),
    (0, b"AC10", "a DWG drawing", MODEL),
    (0, b"AutoCAD Binary DXF", "a DXF drawing", MODEL),
    (0, b"glTF", "a glTF model", MESH),
    (0, b"Kaydara FBX", "an FBX model", MESH),
    (0, b"BLENDER", "a Blender file", MESH),
    (0, b"\x28\xb5\x2f\xfd", "a compressed file, such as of Blender", MESH),
    (0, b"#VRML", "a VRML model", MESH),
    (0, b"# vtk DataFile", "a VTK file", MESH),
    (0, b"MM", "a 3DS model", MESH),
    (0, b"\x93NUMPY", "a NumPy array", "make a closed mesh of it and save that as STL"),
    (0, b"\x1f\x8b", "a gzip archive", UNPACK),
    (0, b"7z\xbc\xaf", "a 7z archive", UNPACK),
    (0, b"Rar!", "a RAR archive", UNPACK),
    (0, b"BZh", "a bzip2 archive", UNPACK),
    (0, b"\xfd7zXZ", "an xz archive", UNPACK),
    (0, b"\x7fELF", "a program", MESH),
    (0, b"MZ", "a program", MESH),
    (0, b"SQLite", "a database", MESH),
    (0, b"GCDE", "G-code", PATH),
];

/// What stands early in texts that people take for a mesh.
const TEXTS: [(&str, &str, &str); 14] = [
    ("<html", "a web page", "download the mesh itself"),
    ("<!doctype html", "a web page", "download the mesh itself"),
    ("<svg", "an SVG drawing", PICTURE),
    ("<collada", "a COLLADA model", MESH),
    ("<x3d", "an X3D model", MESH),
    ("<amf", "an AMF model", MESH),
    ("<model", "the model part of a 3MF file", "name the 3MF file itself"),
    ("\"asset\"", "a glTF model", MESH),
    ("openscad", "an OpenSCAD script", MESH),
    ("linear_extrude", "an OpenSCAD script", MESH),
    ("section\r\n", "a DXF drawing", MODEL),
    ("section\n", "a DXF drawing", MODEL),
    ("\ng21", "G-code", PATH),
    ("\ng90", "G-code", PATH),
];

/// What a file that begins so is.
pub(crate) fn kind(head: &[u8]) -> Kind {
    let head = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
    let begins = |at: usize, mark: &[u8]| head.get(at..).is_some_and(|rest| rest.starts_with(mark));
    if begins(0, b"PK\x03\x04") {
        #[cfg(feature = "meshes")]
        return Kind::Zip;
        #[cfg(not(feature = "meshes"))]
        return Kind::Other("a zip archive or a 3MF file", MESH);
    }
    if begins(0, b"ply\n") || begins(0, b"ply\r") {
        #[cfg(feature = "meshes")]
        return Kind::Ply;
        #[cfg(not(feature = "meshes"))]
        return Kind::Other("a PLY mesh", MESH);
    }
    if let Some((_, _, found, remedy)) = OTHERS.iter().find(|(at, mark, ..)| begins(*at, mark)) {
        return Kind::Other(found, remedy);
    }
    if begins(0, b"BM") && head.get(6..10) == Some(&[0; 4]) {
        return Kind::Other("a BMP picture", PICTURE);
    }
    if begins(0, b"\xff\xfe") || begins(0, b"\xfe\xff") {
        return Kind::Other("a text in UTF-16", "save it as UTF-8, or the mesh as binary STL");
    }
    match text(head) {
        Some(text) => of_text(&text.to_ascii_lowercase()),
        None => Kind::Stl,
    }
}

/// The head if it is text; bytes beyond ASCII are letters of some language.
fn text(head: &[u8]) -> Option<String> {
    let letter = |byte: &u8| *byte >= b' ' || byte.is_ascii_whitespace();
    (!head.is_empty() && head.iter().all(letter)).then(|| String::from_utf8_lossy(head).into_owned())
}

/// The kind of a text in small letters.
fn of_text(text: &str) -> Kind {
    let lines = || text.split(['\n', '\r']).map(str::trim).filter(|line| !is_comment(line));
    let first = lines().next().unwrap_or_default();
    let word = first.split_whitespace().next().unwrap_or_default();
    if word == "solid" {
        return Kind::Stl;
    }
    // Colours, normals, texture or a fourth coordinate may stand with the vertices.
    let number = |rest: &str| rest.chars().all(|c| c.is_ascii_digit());
    let off = word.split_once("off");
    if off.is_some_and(|(with, rest)| with.chars().all(|c| "stcn4".contains(c)) && number(rest)) {
        return Kind::Off;
    }
    // A library of materials or a name may stand first: a vertex decides.
    let vertex = |line: &str| line.starts_with("v ") && line.split_whitespace().skip(1).take(3).all(is_number);
    if lines().any(vertex) {
        #[cfg(feature = "meshes")]
        return Kind::Obj;
        #[cfg(not(feature = "meshes"))]
        return Kind::Other("an OBJ mesh", MESH);
    }
    let early: String = text.chars().take(4096).collect();
    if let Some((_, found, remedy)) = TEXTS.iter().find(|(mark, ..)| early.contains(mark)) {
        return Kind::Other(found, remedy);
    }
    // IGES has an S in column 73 of its first line.
    if text.lines().next().is_some_and(|line| line.as_bytes().get(72) == Some(&b's')) {
        return Kind::Other("an IGES model", MODEL);
    }
    if lines().take(9).all(|line| line.split([' ', ',', ';', '\t']).filter(|w| !w.is_empty()).all(is_number)) {
        return Kind::Other("a list of numbers, such as of points", "make a closed mesh of it and save that as STL");
    }
    Kind::Other("a text file", MESH)
}

/// A line that says nothing to a machine in any of the formats.
pub(crate) fn is_comment(line: &str) -> bool {
    let line = line.trim();
    line.is_empty() || line.starts_with(['#', ';', '!']) || line.starts_with("//")
}

fn is_number(word: &str) -> bool {
    word.parse::<f64>().is_ok()
}
