//! Situations of public reports on neighbouring programs, tried on ours; `docs/field-reports.md` has the list.
//!
//! Those that stand beside the code already are not repeated here.

use std::io::Cursor;

use facetmill::export::mesh_files::{ReadMesh, read_mesh};
use facetmill::picture::{Picture, Reading, from_bytes};
use image::{DynamicImage, GrayImage, ImageFormat, Luma};

use super::hostile_pictures::{png, stored};

fn picture(bytes: &[u8]) -> Picture {
    from_bytes(bytes, "report", &Reading::default()).unwrap()
}

fn mesh(text: impl AsRef<[u8]>) -> ReadMesh {
    read_mesh(&mut Cursor::new(text.as_ref())).unwrap()
}

/// A PNG of 2 × 2 pixels, grey of 8 bits or with opacity, with chunks before its data.
fn small(opacity: bool, before: &[(&[u8; 4], &[u8])], rows: &[u8]) -> Vec<u8> {
    let kind = if opacity { 4 } else { 0 };
    let header = [0, 0, 0, 2, 0, 0, 0, 2, 8, kind, 0, 0, 0];
    let data = stored(rows);
    let mut chunks: Vec<(&[u8; 4], &[u8])> = vec![(b"IHDR", &header)];
    chunks.extend(before);
    chunks.extend([(b"IDAT", &data[..]), (b"IEND", &[][..])]);
    png(&chunks)
}

fn srgb(step: u8) -> f64 {
    ((f64::from(step) / 255.0 + 0.055) / 1.055).powf(2.4)
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-6
}

#[test]
fn of_png_statements_the_stronger_is_believed_and_opacity_is_never_touched() {
    let gamma = |value: u32| value.to_be_bytes();
    let rows = [0, 188, 188, 0, 255, 0];
    // ImageGlass 377: sRGB beside a gamma that says otherwise.
    let both = picture(&small(false, &[(b"gAMA", &gamma(100_000)), (b"sRGB", &[0])], &rows)).light;
    assert!(near(both.at(0, 0), srgb(188)));
    // Go 20613, zune-image 54: a strong gamma alone is obeyed.
    let strong = picture(&small(false, &[(b"gAMA", &gamma(22_727))], &rows)).light;
    assert!(near(strong.at(0, 0), (188.0f64 / 255.0).powf(1.0 / 0.22727)));
    // Image (Dart) 35: what gamma does to grey, it does not do to opacity.
    let clear = picture(&small(true, &[(b"gAMA", &gamma(100_000))], &[0, 255, 192, 255, 0, 0, 0, 0, 0, 0])).light;
    assert!(near(clear.at(0, 0), 192.0 / 255.0));
    // image-png 629: a gamma of zero is nothing.
    let none = picture(&small(false, &[(b"gAMA", &gamma(0))], &rows));
    assert!(near(none.light.at(0, 0), srgb(188)) && none.notes.is_empty());
}

#[test]
fn what_stands_behind_the_end_of_a_png_is_nobodys_business() {
    let whole = small(false, &[], &[0, 9, 200, 0, 100, 50]);
    let want = picture(&whole);
    // png-decoder 19, SerenityOS 4984, libjxl 4383, zopfli 132: a byte, a block of zeros, another end, rubbish.
    for behind in
        [&[0u8][..], &[0; 4096], &[0, 0, 0, 0, b'I', b'E', b'N', b'D', 0xae, 0x42, 0x60, 0x82, 7], &[0xff; 99]]
    {
        assert_eq!(picture(&[&whole, behind].concat()), want);
    }
    // tinia 57, sane-airscan 60: the end itself is missing.
    let open = picture(&whole[..whole.len() - 12]);
    assert_eq!(open.light, want.light);
    assert!(open.notes[0].contains("end of the file is missing"), "{:?}", open.notes);
}

#[test]
fn jpegs_that_end_as_cameras_and_their_makers_like_are_read() {
    let grey = GrayImage::from_fn(40, 40, |x, y| Luma([(5 * x + y) as u8]));
    let mut whole = Cursor::new(Vec::new());
    DynamicImage::from(grey).write_to(&mut whole, ImageFormat::Jpeg).unwrap();
    let whole = whole.into_inner();
    let want = picture(&whole).light;
    let open = &whole[..whole.len() - 2];
    // libyami 801, ruffle 8820, jpeg-decoder 262: no end marker.
    let read = picture(open);
    assert_eq!(read.light, want);
    assert!(read.notes[0].contains("end of the file is missing"), "{:?}", read.notes);
}

#[test]
fn a_bitmap_whose_fourth_byte_is_always_zero_is_not_clear() {
    // image 539, ImageSharp 732, Go 54368: 32 bits a pixel, no masks.
    let mut bytes = b"BM".to_vec();
    bytes.extend(70u32.to_le_bytes());
    bytes.extend([0; 4]);
    bytes.extend(54u32.to_le_bytes());
    for value in [40u32, 2, 2, 1 | 32 << 16, 0, 16, 0, 0, 0, 0] {
        bytes.extend(value.to_le_bytes());
    }
    bytes.extend([[9u8, 9, 9, 0], [200, 200, 200, 0], [188, 188, 188, 0], [255, 255, 255, 0]].concat());
    let light = picture(&bytes).light;
    // The lowest row comes first.
    assert!(near(light.at(0, 0), srgb(188)) && near(light.at(1, 0), 1.0) && near(light.at(1, 1), srgb(200)));
}

#[test]
fn white_of_a_netpbm_is_what_its_header_says() {
    // image 1558, Pillow 6107: 15 and 1023; FLIF 112: comments wherever they may stand.
    let light = picture(b"P5\n# by hand\n2 # wide\n2 15\n\x0f\x00\x05\x0f").light;
    assert!(near(light.at(0, 0), 1.0) && near(light.at(0, 1), srgb(85)));
    let words = [1023u16, 0, 341, 1023].map(u16::to_be_bytes).concat();
    let light = picture(&[&b"P5 2 2 1023\n"[..], &words].concat()).light;
    assert!(near(light.at(0, 0), 1.0) && (light.at(0, 1) - 1.0 / 3.0).abs() < 1e-4);
    let light = picture(b"P2 2 2 3\n3 0\n1 3\n").light;
    assert!(near(light.at(0, 0), 1.0) && near(light.at(0, 1), srgb(85)));
    let light = picture(b"P1 2 2\n0 1\n1 0\n").light;
    assert!(near(light.at(0, 0), 1.0) && light.at(1, 0) == 0.0);
}

#[test]
fn an_off_with_colours_at_its_vertices_is_read_though_its_header_hides_them() {
    // MeshLab 292: OFF where COFF should stand.
    let text = "OFF\n4 4 0\n0 0 0 255 0 0 255\n2 0 0 0 255 0 255\n0 2 0 0 0 255 255\n0 0 2 9 9 9 255\n\
                3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";
    let read = mesh(text);
    assert_eq!((read.mesh.triangles.len(), read.mesh.vertices.len(), read.mesh.open_edges()), (4, 4, 0));
}

#[cfg(feature = "meshes")]
mod meshes {
    use super::*;

    const CORNERS: &str = "0 0 0\n2 0 0\n0 2 0\n0 0 2\n";

    fn ply(list: &str) -> String {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
             element face 4\nproperty list {list}\nend_header\n{CORNERS}3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n"
        )
    }

    #[test]
    fn plys_of_all_habits_are_read() {
        let tetrahedron = |text: String| {
            let read = mesh(&text);
            assert_eq!((read.mesh.triangles.len(), read.mesh.open_edges()), (4, 0), "{text}");
        };
        // three.js 9338: the other name; meshlab 290, happly 4, mLib 15: other integers.
        for list in
            ["uchar int vertex_index", "ushort uint vertex_indices", "uint uint vertex_indices", "int int vertex_index"]
        {
            tetrahedron(ply(list));
        }
        // assimp 2534: ends of line of Windows.
        tetrahedron(ply("uchar int vertex_indices").replace('\n', "\r\n"));
    }

    #[test]
    fn a_3mf_in_inches_is_moved_in_inches() {
        // PrusaSlicer 15545 and 15031: places count in the unit of the model, as vertices do.
        let vertices = ["0 0 0", "2 0 0", "0 2 0", "0 0 2"].map(|v| {
            let [x, y, z] = [0, 1, 2].map(|k| v.split(' ').nth(k).unwrap());
            format!("<vertex x=\"{x}\" y=\"{y}\" z=\"{z}\"/>")
        });
        let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
            .map(|[a, b, c]| format!("<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"/>"));
        let model = format!(
            "<model unit=\"inch\"><resources><object id=\"1\"><mesh><vertices>{}</vertices><triangles>{}</triangles></mesh>\
             </object></resources><build><item objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 1 2 0 0\"/></build></model>",
            vertices.concat(),
            triangles.concat()
        );
        let mut writer = zip::ZipWriter::new(Cursor::new(Vec::new()));
        writer.start_file("3D/3dmodel.model", zip::write::SimpleFileOptions::default()).unwrap();
        std::io::Write::write_all(&mut writer, model.as_bytes()).unwrap();
        let read = mesh(writer.finish().unwrap().into_inner());
        let (low, high) = read.mesh.bounds();
        assert!((low.x - 50.8).abs() < 1e-4 && (high.x - 101.6).abs() < 1e-4, "{low} {high}");
        assert!(read.has_unit && read.notes[0].contains("25.4 mm"), "{:?}", read.notes);
    }
}
