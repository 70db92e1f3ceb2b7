//! A solid of planar faces as the text of ISO 10303-21, entity by entity.

use std::io::{self, BufWriter, Write};

use glam::DVec3;

use super::ACCURACY;
use super::brep::{Brep, Face};
use crate::progress::Progress;

/// The first entity that is no part of the frame below.
const FIRST: usize = 30;

/// Entities of a face beside its border.
const OF_FACE: usize = 8;

/// Entities of an edge.
const OF_EDGE: usize = 4;

/// Entities of a vertex.
const OF_VERTEX: usize = 2;

/// Product, representation, units: what every file of a part says.
const FRAME: &str = "\
#1=APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2000,#2);
#2=APPLICATION_CONTEXT('core data for automotive mechanical design processes');
#3=SHAPE_DEFINITION_REPRESENTATION(#4,#10);
#4=PRODUCT_DEFINITION_SHAPE('','',#5);
#5=PRODUCT_DEFINITION('design','',#6,#9);
#6=PRODUCT_DEFINITION_FORMATION('','',#7);
#7=PRODUCT('plate','plate','',(#8));
#8=PRODUCT_CONTEXT('',#2,'mechanical');
#9=PRODUCT_DEFINITION_CONTEXT('part definition',#2,'design');
#10=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#11,#15),#17);
#11=AXIS2_PLACEMENT_3D('',#12,#13,#14);
#12=CARTESIAN_POINT('',(0.,0.,0.));
#13=DIRECTION('',(0.,0.,1.));
#14=DIRECTION('',(1.,0.,0.));
#15=MANIFOLD_SOLID_BREP('plate',#16);
#17=(GEOMETRIC_REPRESENTATION_CONTEXT(3) GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#21)) \
GLOBAL_UNIT_ASSIGNED_CONTEXT((#18,#19,#20)) REPRESENTATION_CONTEXT('plate','3D'));
#18=(LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.));
#19=(NAMED_UNIT(*) PLANE_ANGLE_UNIT() SI_UNIT($,.RADIAN.));
#20=(NAMED_UNIT(*) SI_UNIT($,.STERADIAN.) SOLID_ANGLE_UNIT());
#22=PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,(#7));
";

pub(super) fn write(solid: &Brep, about: &str, out: &mut dyn Write, progress: &Progress) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 16, out);
    let program = concat!("facetmill ", env!("CARGO_PKG_VERSION"));
    writeln!(out, "ISO-10303-21;\nHEADER;")?;
    writeln!(out, "FILE_DESCRIPTION(('{}'),'2;1');", text(about))?;
    // No time: the same plate is the same bytes.
    writeln!(out, "FILE_NAME('plate.step','',(''),(''),'{program}','{program}','');")?;
    writeln!(out, "FILE_SCHEMA(('AUTOMOTIVE_DESIGN {{ 1 0 10303 214 1 1 1 1 }}'));\nENDSEC;\nDATA;")?;
    out.write_all(FRAME.as_bytes())?;
    let accuracy = format!("LENGTH_MEASURE({}),#18,'distance_accuracy_value','confusion accuracy'", real(ACCURACY));
    writeln!(out, "#21=UNCERTAINTY_MEASURE_WITH_UNIT({accuracy});")?;
    let edges = FIRST + OF_VERTEX * solid.vertices.len();
    for (k, vertex) in solid.vertices.iter().enumerate() {
        let id = point(k as u32);
        writeln!(out, "#{id}=CARTESIAN_POINT('',{});\n#{}=VERTEX_POINT('',#{id});", triple(*vertex), id + 1)?;
    }
    for (k, &[from, to]) in solid.edges.iter().enumerate() {
        let id = edges + OF_EDGE * k;
        let way = (solid.vertices[to as usize] - solid.vertices[from as usize]).normalize_or_zero();
        let [a, b] = [point(from) + 1, point(to) + 1];
        writeln!(out, "#{id}=EDGE_CURVE('',#{a},#{b},#{},.T.);", id + 1)?;
        writeln!(out, "#{}=LINE('',#{},#{});", id + 1, point(from), id + 2)?;
        writeln!(out, "#{}=VECTOR('',#{},1.);\n#{}=DIRECTION('',{});", id + 2, id + 3, id + 3, triple(way))?;
    }
    let mut next = edges + OF_EDGE * solid.edges.len();
    let mut faces = Vec::with_capacity(solid.faces.len());
    for (k, face) in solid.faces.iter().enumerate() {
        if k % 1024 == 0 {
            progress.check().map_err(io::Error::other)?;
        }
        write_face(face, next, edges, &mut out)?;
        faces.push(format!("#{next}"));
        next += OF_FACE + face.border.len();
    }
    writeln!(out, "#16=CLOSED_SHELL('',({}));\nENDSEC;\nEND-ISO-10303-21;", faces.join(",\n"))?;
    out.flush()
}

/// A face whose first entity is `id`; the first edge is `edges`.
fn write_face(face: &Face, id: usize, edges: usize, out: &mut impl Write) -> io::Result<()> {
    let border: Vec<String> = (0..face.border.len()).map(|k| format!("#{}", id + OF_FACE + k)).collect();
    writeln!(out, "#{id}=ADVANCED_FACE('',(#{}),#{},.T.);", id + 1, id + 3)?;
    writeln!(out, "#{}=FACE_OUTER_BOUND('',#{},.T.);", id + 1, id + 2)?;
    writeln!(out, "#{}=EDGE_LOOP('',({}));", id + 2, border.join(","))?;
    writeln!(out, "#{}=PLANE('',#{});", id + 3, id + 4)?;
    writeln!(out, "#{}=AXIS2_PLACEMENT_3D('',#{},#{},#{});", id + 4, id + 5, id + 6, id + 7)?;
    writeln!(out, "#{}=CARTESIAN_POINT('',{});", id + 5, triple(face.point))?;
    writeln!(out, "#{}=DIRECTION('',{});", id + 6, triple(face.normal))?;
    writeln!(out, "#{}=DIRECTION('',{});", id + 7, triple(face.along))?;
    for (k, (edge, forward)) in face.border.iter().enumerate() {
        let (id, edge) = (id + OF_FACE + k, edges + OF_EDGE * *edge as usize);
        writeln!(out, "#{id}=ORIENTED_EDGE('',*,*,#{edge},.{}.);", if *forward { 'T' } else { 'F' })?;
    }
    Ok(())
}

/// The place of a vertex.
fn point(vertex: u32) -> usize {
    FIRST + OF_VERTEX * vertex as usize
}

fn triple(v: DVec3) -> String {
    format!("({},{},{})", real(v.x), real(v.y), real(v.z))
}

/// A number as the standard wants it: with a point, and a capital before its exponent; by the fewest digits that read back
/// as the same.
fn real(number: f64) -> String {
    // Adding zero turns -0 into 0.
    let plain = format!("{:?}", number + 0.0);
    match plain.split_once('e') {
        None => plain,
        Some((digits, exponent)) if digits.contains('.') => format!("{digits}E{exponent}"),
        Some((digits, exponent)) => format!("{digits}.E{exponent}"),
    }
}

/// A string: apostrophes and backslashes doubled, all beyond ASCII by its code.
pub(super) fn text(plain: &str) -> String {
    let mut written = String::new();
    for c in plain.chars() {
        match c {
            '\'' => written += "''",
            '\\' => written += "\\\\",
            ' '..='~' => written.push(c),
            _ if u32::from(c) <= 0xffff => written += &format!("\\X2\\{:04X}\\X0\\", u32::from(c)),
            _ => written += &format!("\\X4\\{:08X}\\X0\\", u32::from(c)),
        }
    }
    written
}
