//! The same block in every format, as programs of all kinds write it, and what is no mesh by its name.

use std::io::Cursor;
use std::io::Write as _;

use glam::DVec3;

use super::*;
use crate::export::obj::write_obj;
use crate::export::ply::write_ply;
use crate::export::three_mf::write_three_mf;

/// Corners of a block of 2 × 3 × 4 mm, and its faces, outward.
const CORNERS: [[f32; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [2.0, 0.0, 0.0],
    [0.0, 3.0, 0.0],
    [2.0, 3.0, 0.0],
    [0.0, 0.0, 4.0],
    [2.0, 0.0, 4.0],
    [0.0, 3.0, 4.0],
    [2.0, 3.0, 4.0],
];
const FACES: [[usize; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

fn read(bytes: impl AsRef<[u8]>) -> Result<ReadMesh, MeshFileError> {
    read_mesh(&mut Cursor::new(bytes.as_ref()))
}

/// Reads the block, and makes sure that it is the block.
fn block(bytes: impl AsRef<[u8]>, format: &str) -> ReadMesh {
    let read = read(bytes).unwrap();
    assert_eq!((read.format, read.mesh.triangles.len(), read.mesh.vertices.len()), (format, 12, 8));
    assert_eq!((read.mesh.open_edges(), read.mesh.degenerate()), (0, 0));
    assert_eq!(read.mesh.bounds(), (DVec3::ZERO, DVec3::new(2.0, 3.0, 4.0)));
    let volume = |k: usize| {
        let [a, b, c] = read.mesh.corners(k);
        a.dot(b.cross(c)) / 6.0
    };
    assert!(((0..12).map(volume).sum::<f64>() - 24.0).abs() < 1e-9);
    read
}

#[test]
fn what_is_written_in_every_format_is_read_to_the_last_digit() {
    // Heights that need all their digits, and a vertex after the others' order.
    let vertices = vec![[0.1, 0.0, 1.0e-7], [2.0 / 3.0, 0.0, -1.0e9], [0.0, 1.0 / 3.0, 2.5], [0.0, 0.0, 16_777_217.0]];
    let mesh = Mesh { vertices, triangles: vec![[0, 1, 2], [0, 2, 3], [1, 0, 3], [2, 1, 3]] };
    let mut files = [("OBJ", Vec::new()), ("PLY", Vec::new()), ("3MF", Vec::new())];
    write_obj(&mesh, &mut files[0].1).unwrap();
    write_ply(&mesh, &mut files[1].1).unwrap();
    let about = [("Title", "a < b & \"c\"".to_owned())];
    write_three_mf(&mesh, &about, &mut files[2].1).unwrap();
    for (format, bytes) in &files {
        let read = read(bytes).unwrap();
        assert_eq!((read.format, read.mesh == mesh), (*format, true), "{:?}", read.mesh);
        assert_eq!((read.has_unit, read.notes.len()), (*format == "3MF", 0));
    }
    let stray = Mesh { triangles: vec![[0, 1, 4]], ..mesh.clone() };
    let mut nothing = Vec::new();
    for error in
        [write_obj(&stray, &mut nothing), write_ply(&stray, &mut nothing), write_three_mf(&stray, &about, &mut nothing)]
    {
        assert_eq!(error.unwrap_err().kind(), io::ErrorKind::InvalidInput);
    }
    assert!(nothing.is_empty());
}

/// The block as text STL.
fn text_stl() -> String {
    let mut text = String::from("solid block\n");
    for [a, b, c, d] in FACES {
        for corners in [[a, b, c], [a, c, d]] {
            text += " facet normal 0 0 0\n  outer loop\n";
            for [x, y, z] in corners.map(|k| CORNERS[k]) {
                text += &format!("   vertex {x} {y} {z}\n");
            }
            text += "  endloop\n endfacet\n";
        }
    }
    text + "endsolid block\n"
}

/// The block as binary STL.
fn binary_stl() -> Vec<u8> {
    let mut bytes = b"block".to_vec();
    bytes.resize(80, 0);
    bytes.extend(12u32.to_le_bytes());
    for [a, b, c, d] in FACES {
        for corners in [[a, b, c], [a, c, d]] {
            bytes.extend([0; 12]);
            bytes.extend(corners.map(|k| CORNERS[k]).as_flattened().iter().flat_map(|c| c.to_le_bytes()));
            bytes.extend([0; 2]);
        }
    }
    bytes
}

#[test]
fn bytes_behind_a_binary_stl_are_left_out_with_a_note() {
    for behind in [vec![7], b"made by a vendor with a lot to say ".repeat(8), vec![0; 200], vec![0xff; 149]] {
        let read = block([binary_stl(), behind.clone()].concat(), "STL");
        assert_eq!(read.notes, [format!("{} bytes behind the file's last triangle were left out.", behind.len())]);
    }
    assert!(block(binary_stl(), "STL").notes.is_empty());
}

#[test]
fn a_count_that_is_wrong_is_not_taken_for_rubbish_behind() {
    for count in [0u32, 11, 6] {
        let mut bytes = binary_stl();
        bytes[80..84].copy_from_slice(&count.to_le_bytes());
        let message = read(&bytes).unwrap_err().to_string();
        assert!(message.contains(&format!("the {count} triangles it promises")), "{message}");
    }
}

#[test]
fn data_behind_each_triangle_is_named() {
    let plain = binary_stl();
    let mut bytes = plain[..84].to_vec();
    for (k, record) in plain[84..].chunks(50).enumerate() {
        bytes.extend(&record[..48]);
        bytes.extend((k as u16).to_le_bytes());
        bytes.extend(vec![7; k]);
    }
    let message = read(&bytes).unwrap_err().to_string();
    assert!(message.contains("other data behind each triangle"), "{message}");
    // A colour in that field, and nothing behind it, is what most programs mean by it.
    let mut coloured = plain;
    coloured[84 + 48..84 + 50].copy_from_slice(&[0x1f, 0x80]);
    assert!(block(coloured, "STL").notes.is_empty());
}

#[test]
fn comments_marks_and_ends_of_line_of_any_system_are_read_in_a_text_stl() {
    assert!(block(text_stl(), "STL").notes.is_empty());
    for end in ["\r\n", "\r"] {
        assert!(block(text_stl().replace('\n', end), "STL").notes.is_empty());
    }
    let commented = format!("; made by hand\n# twice\n\n{}", text_stl().replace(" facet", " // a facet\n facet"));
    assert_eq!(block(commented, "STL").notes, ["14 lines of comment in the text STL were passed over."]);
    let marked = block([b"\xef\xbb\xbf", text_stl().as_bytes()].concat(), "STL");
    assert!(marked.notes[0].contains("mark of encoding"));
    let behind = block([text_stl().as_bytes(), b"\x1a\0\0\0"].concat(), "STL");
    assert_eq!(behind.notes, ["1 line behind the text STL's last solid were left out."]);
    for (joined, apart) in [("endloop", "end loop"), ("endfacet", "END  FACET"), ("endsolid", "end solid")] {
        block(text_stl().replace(joined, apart), "STL");
    }
    assert!(read(text_stl().replace("endsolid block\n", "")).is_err());
}

#[test]
fn an_off_is_read_however_its_header_is_written() {
    let vertices: String = CORNERS.iter().map(|[x, y, z]| format!("{x} {y} {z}\n")).collect();
    let faces: String = FACES.iter().map(|[a, b, c, d]| format!("4 {a} {b} {c} {d} 255 0 0 # red\n")).collect();
    for header in [
        "OFF\n8 6 12\n",
        "OFF 8 6 0\n",
        "# by hand\n\nOFF\n# counts\n8 6\n",
        "NOFF\n8 6 0\n",
        "OFF8 6 0\n",
        "off\r\n8 6 12\r\n",
    ] {
        block(format!("{header}{vertices}{faces}"), "OFF");
    }
    for (text, word) in [
        (format!("OFF\n8 6 0\n{vertices}"), "after 0 of 6 faces"),
        ("OFF\n8 6 0\n0 0 0\n".to_owned(), "after 1 of 8 vertices"),
        ("OFF\nmany\n".to_owned(), "how many"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n".to_owned(), "vertex 8 of 3"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1\n".to_owned(), "corners"),
        ("OFF\n99999999999 1 0\n".to_owned(), "after 0 of 99999999999"),
    ] {
        let message = read(text).unwrap_err().to_string();
        assert!(message.contains(word) && message.contains("OFF"), "{message}");
    }
}

#[cfg(feature = "meshes")]
mod with_the_crates_of_others {
    use super::*;

    #[test]
    fn an_obj_is_read_with_quads_normals_groups_and_indices_from_the_end() {
        let vertices: String = CORNERS.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
        let plain: String =
            FACES.iter().map(|[a, b, c, d]| format!("f {} {} {} {}\n", a + 1, b + 1, c + 1, d + 1)).collect();
        block(format!("# by a program of caustics\n{vertices}{plain}"), "OBJ");
        let normals = FACES.iter().enumerate().map(|(k, face)| {
            let corners: String = face.iter().map(|v| format!(" {}//1", v + 1)).collect();
            format!("g part{k}\nusemtl none\ns off\nf{corners}\n")
        });
        let normals: String = normals.collect();
        block(format!("mtllib missing.mtl\no block\nvn 0 0 1\n{vertices}{normals}"), "OBJ");
        let back: String = FACES
            .iter()
            .map(|face| {
                let corners: String = face.iter().map(|v| format!(" {}", *v as i32 - 8)).collect();
                format!("f{corners}\n")
            })
            .collect();
        block(format!("{vertices}{back}").replace('\n', "\r\n"), "OBJ");
        // Rhino breaks long lines.
        let broken = plain.replace("f 1 ", "f 1 \\\n  ");
        block(format!("{}{broken}", vertices.replace("v 2 3 ", "v 2 3 \\\r\n")), "OBJ");
        assert!(read(format!("{vertices}f 1 2 99\n")).unwrap_err().to_string().contains("OBJ data are damaged"));
        assert!(read(&vertices).unwrap_err().to_string().contains("no faces"));
    }

    /// Header of a PLY file of the block.
    fn header(format: &str) -> String {
        format!(
            "ply\nformat {format} 1.0\ncomment by hand\nelement vertex 8\nproperty double x\nproperty float y\n\
             property float z\nproperty uchar red\nelement face 6\nproperty list uchar int vertex_indices\nend_header\n"
        )
    }

    #[test]
    fn a_ply_is_read_as_text_and_in_both_byte_orders() {
        let vertices: String = CORNERS.iter().map(|[x, y, z]| format!("{x} {y} {z} 9\n")).collect();
        let faces: String = FACES.iter().map(|[a, b, c, d]| format!("4 {a} {b} {c} {d}\n")).collect();
        block(format!("{}{vertices}{faces}", header("ascii")), "PLY");
        for big in [true, false] {
            let mut bytes = header(if big { "binary_big_endian" } else { "binary_little_endian" }).into_bytes();
            for [x, y, z] in CORNERS {
                bytes.extend(if big { f64::from(x).to_be_bytes() } else { f64::from(x).to_le_bytes() });
                for c in [y, z] {
                    bytes.extend(if big { c.to_be_bytes() } else { c.to_le_bytes() });
                }
                bytes.push(9);
            }
            for face in FACES {
                bytes.push(4);
                bytes.extend(
                    face.iter().flat_map(|v| if big { (*v as i32).to_be_bytes() } else { (*v as i32).to_le_bytes() }),
                );
            }
            block(&bytes, "PLY");
            for length in (0..bytes.len()).step_by(7) {
                assert!(read(&bytes[..length]).is_err(), "{length}");
            }
        }
        let endless = "ply\nformat binary_little_endian 1.0\nelement nothing 4000000000\nend_header\n";
        assert!(read(endless).unwrap_err().to_string().contains("promises"));
        let cloud = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
                     end_header\n1 2 3\n";
        assert!(read(cloud).unwrap_err().to_string().contains("no faces"));
    }

    /// A 3MF file of these entries.
    fn packed(entries: &[(&str, String)]) -> Vec<u8> {
        let mut writer = zip::ZipWriter::new(Cursor::new(Vec::new()));
        for (name, text) in entries {
            writer.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap();
            writer.write_all(text.as_bytes()).unwrap();
        }
        writer.finish().unwrap().into_inner()
    }

    fn mesh() -> String {
        let vertices: String =
            CORNERS.iter().map(|[x, y, z]| format!("<vertex x=\"{x}\" y=\"{y}\" z=\"{z}\"/>")).collect();
        let triangles = FACES.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
        let triangles: String =
            triangles.map(|[a, b, c]| format!("<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"/>")).collect();
        format!("<mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh>")
    }

    fn model(unit: &str, resources: &str, build: &str) -> String {
        format!(
            "<?xml version=\"1.0\"?><model unit=\"{unit}\" xmlns:p=\"production\"><resources>{resources}</resources>\
             <build>{build}</build></model>"
        )
    }

    #[test]
    fn a_3mf_is_read_in_place_and_in_millimetres() {
        let object = format!("<object id=\"1\" type=\"model\">{}</object>", mesh());
        let plain = model("millimeter", &object, "<item objectid=\"1\"/>");
        assert!(block(packed(&[("3D/3dmodel.model", plain)]), "3MF").has_unit);
        // Moved away and back, within another object; in inches, of a 25.4th.
        let moved = format!(
            "{object}<object id=\"2\"><components><component objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 1 -5 0 9\"/>\
             </components></object>"
        );
        let back = "<item objectid=\"2\" transform=\"1 0 0 0 1 0 0 0 1 5 0 -9\"/>";
        block(packed(&[("3D/3dmodel.model", model("millimeter", &moved, back))]), "3MF");
        let small = "<item objectid=\"1\" transform=\"0.0001 0 0 0 0.0001 0 0 0 0.0001 0 0 0\"/>";
        let read = read(packed(&[("3D/3dmodel.model", model("meter", &object, small))])).unwrap();
        assert!((read.mesh.bounds().1 - DVec3::new(0.2, 0.3, 0.4)).length() < 1e-6);
        assert!(read.notes[0].contains("1000 mm"), "{:?}", read.notes);
        // Mirrored, its faces still look outward: the block at negative x.
        let mirrored = "<item objectid=\"1\" transform=\"-1 0 0 0 1 0 0 0 1 2 0 0\"/>";
        block(packed(&[("3D/3dmodel.model", model("millimeter", &object, mirrored))]), "3MF");
    }

    #[test]
    fn a_3mf_in_several_models_as_slicers_write_it_is_read() {
        let part = model("millimeter", &format!("<object id=\"7\">{}</object>", mesh()), "");
        let whole = model(
            "millimeter",
            "<object id=\"1\"><components><component p:path=\"/3D/Objects/part.model\" objectid=\"7\"/></components></object>",
            "<item objectid=\"1\"/>",
        );
        block(packed(&[("3D/Objects/part.model", part), ("3D/3dmodel.model", whole)]), "3MF");
    }

    #[test]
    fn a_3mf_that_leads_nowhere_or_everywhere_is_refused() {
        let itself = "<object id=\"1\"><components><component objectid=\"1\"/></components></object>";
        let many: String = (2..12)
            .map(|k| {
                let parts = format!("<component objectid=\"{}\"/>", k - 1).repeat(9);
                format!("<object id=\"{k}\"><components>{parts}</components></object>")
            })
            .collect();
        let many = format!("<object id=\"1\">{}</object>{many}", mesh());
        for (resources, build, word) in [
            (itself, "<item objectid=\"1\"/>", "too deeply"),
            (&many, "<item objectid=\"11\"/>", "too many"),
            (itself, "<item objectid=\"9\"/>", "missing"),
            ("", "", "no faces"),
        ] {
            let bytes = packed(&[("3D/3dmodel.model", model("millimeter", resources, build))]);
            let message = read(&bytes).unwrap_err().to_string();
            assert!(message.contains(word), "{message}");
            for length in (4..bytes.len()).step_by(bytes.len() / 20 + 1) {
                assert!(read(&bytes[..length]).is_err());
            }
        }
        let other = read(packed(&[("word/document.xml", "<w/>".into())])).unwrap_err().to_string();
        assert!(other.contains("zip archive without a 3D model"), "{other}");
    }
}

#[test]
fn what_is_no_mesh_is_called_by_its_name_and_nothing_is_said_of_triangles() {
    let long = |start: &[u8]| [start, &[0x5a; 400]].concat();
    for (bytes, word) in [
        (long(b"\x89PNG\r\n\x1a\n"), "a PNG picture"),
        (long(b"\xff\xd8\xff\xe0"), "a JPEG picture"),
        (b"ISO-10303-21;\nHEADER;\n".to_vec(), "a STEP model"),
        (long(b"glTF\x02\0\0\0"), "a glTF model"),
        (b"{ \"asset\": { \"version\": \"2.0\" } }".to_vec(), "a glTF model"),
        (b"  0\nSECTION\n  2\nHEADER\n".to_vec(), "a DXF drawing"),
        (b"%PDF-1.4\n".to_vec(), "a PDF document"),
        (b"<!DOCTYPE html><html>404</html>".to_vec(), "a web page"),
        (b"<?xml version='1.0'?><COLLADA>".to_vec(), "a COLLADA model"),
        (b"(plate)\nG21\nG90\nG0 Z5\n".to_vec(), "G-code"),
        (b"0 0 0\n1 2 3\n4 5 6\n".to_vec(), "a list of numbers"),
        (b"Dear mill, please cut this.\n".to_vec(), "a text file"),
        (b"\xff\xfes\0o\0l\0i\0d\0".to_vec(), "UTF-16"),
        (long(b"Kaydara FBX Binary  \0"), "an FBX model"),
        (long(b"\x01\x02\x03\x04"), "neither a binary nor a text STL"),
        (b"".to_vec(), "neither a binary nor a text STL"),
    ] {
        let message = read(&bytes).unwrap_err().to_string();
        assert!(message.contains(word) && !message.contains("promises"), "{message}");
    }
}
