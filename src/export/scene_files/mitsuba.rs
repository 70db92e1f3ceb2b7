//! The scene for Mitsuba 3: XML beside the meshes that it names, in mm.

use std::io::{self, Write};

use glam::DVec3;

use super::{Beam, LitPlate};

/// Names of the meshes.
pub const MIRROR: &str = "scene_mirror.ply";
/// The rest of the plate.
pub const BODY: &str = "scene_body.ply";
/// What the light falls on.
pub const SCREEN: &str = "scene_screen.ply";
/// What parallel light comes from.
pub const LAMP: &str = "scene_lamp.ply";

/// Pixels along a side of the image: those of the proof.
const PIXELS: usize = 256;

/// Particles for each pixel unless `-D spp=N` says otherwise.
const PARTICLES: usize = 256;

/// Meetings of a particle with anything at the most: eight bounces on the plate, the lamp's sheet, the screen.
const DEPTH: usize = 12;

impl LitPlate {
    /// Writes the scene; `about` says what it is, for people.
    ///
    /// # Errors
    /// When writing fails.
    pub fn write_mitsuba(&self, about: &str, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, r#"<?xml version="1.0" encoding="UTF-8"?>"#)?;
        // Two dashes would end the comment.
        writeln!(out, "<!-- facetmill {}: {}", env!("CARGO_PKG_VERSION"), about.replace("--", "- -"))?;
        writeln!(out, "     Render with a variant of one colour or three:  mitsuba -m llvm_mono scene.xml")?;
        writeln!(
            out,
            "     Each pixel is its share of the light that meets the plate, times the number of pixels. -->"
        )?;
        writeln!(out, r#"<scene version="3.0.0">"#)?;
        writeln!(out, r#"  <default name="spp" value="{PARTICLES}"/>"#)?;
        writeln!(out, r#"  <default name="resolution" value="{PIXELS}"/>"#)?;
        writeln!(out, r#"  <integrator type="ptracer">"#)?;
        writeln!(out, r#"    <integer name="max_depth" value="{DEPTH}"/>"#)?;
        writeln!(out, r#"    <integer name="rr_depth" value="1000"/>"#)?;
        writeln!(out, r#"    <boolean name="hide_emitters" value="true"/>"#)?;
        writeln!(out, "  </integrator>")?;
        self.write_sensor(out)?;
        shape(out, MIRROR, &[&self.metal()])?;
        shape(out, BODY, &[DULL])?;
        shape(out, SCREEN, &[PAINTED])?;
        self.write_lamp(out)?;
        writeln!(out, "</scene>")
    }

    fn write_sensor(&self, out: &mut dyn Write) -> io::Result<()> {
        let camera = &self.camera;
        writeln!(out, r#"  <sensor type="perspective">"#)?;
        writeln!(out, r#"    <float name="fov" value="{}"/>"#, camera.field.to_degrees())?;
        writeln!(out, r#"    <float name="near_clip" value="{}"/>"#, camera.clip[0])?;
        writeln!(out, r#"    <float name="far_clip" value="{}"/>"#, camera.clip[1])?;
        writeln!(out, r#"    <transform name="to_world">"#)?;
        if camera.mirrored {
            // The highlight image is a map of viewers, seen from above the plate.
            writeln!(out, r#"      <scale x="-1" y="1" z="1"/>"#)?;
        }
        let [eye, target, up] = [camera.eye, camera.target, camera.up].map(words);
        writeln!(out, r#"      <lookat origin="{eye}" target="{target}" up="{up}"/>"#)?;
        writeln!(out, "    </transform>")?;
        writeln!(out, r#"    <sampler type="independent"><integer name="sample_count" value="$spp"/></sampler>"#)?;
        writeln!(out, r#"    <film type="hdrfilm">"#)?;
        writeln!(out, r#"      <integer name="width" value="$resolution"/>"#)?;
        writeln!(out, r#"      <integer name="height" value="$resolution"/>"#)?;
        writeln!(out, r#"      <string name="pixel_format" value="luminance"/>"#)?;
        writeln!(out, r#"      <string name="component_format" value="float32"/>"#)?;
        writeln!(out, r#"      <rfilter type="box"/>"#)?;
        writeln!(out, "    </film>")?;
        writeln!(out, "  </sensor>")
    }

    /// The plate's metal: it takes no light.
    fn metal(&self) -> String {
        let none = r#"<string name="material" value="none"/>"#;
        if self.roughness > 0.0 {
            let alpha = format!(r#"<float name="alpha" value="{}"/>"#, self.roughness);
            let law = r#"<string name="distribution" value="beckmann"/>"#;
            format!(r#"<bsdf type="roughconductor">{none}{law}{alpha}</bsdf>"#)
        } else {
            format!(r#"<bsdf type="conductor">{none}</bsdf>"#)
        }
    }

    fn write_lamp(&self, out: &mut dyn Write) -> io::Result<()> {
        match &self.beam {
            Beam::Parallel(sheet) => {
                let light = format!(
                    r#"<emitter type="directionalarea"><rgb name="radiance" value="{}"/></emitter>"#,
                    sheet.irradiance
                );
                shape(out, LAMP, &[r#"<bsdf type="null"/>"#, &light])
            }
            Beam::Spots { places, cone, intensity, .. } => {
                let target = words(self.middle);
                for place in places {
                    let up = if (self.middle - *place).cross(DVec3::Y).length() > 1e-3 * place.length() {
                        DVec3::Y
                    } else {
                        DVec3::X
                    };
                    writeln!(out, r#"  <emitter type="spot">"#)?;
                    writeln!(out, r#"    <rgb name="intensity" value="{intensity}"/>"#)?;
                    writeln!(out, r#"    <float name="beam_width" value="{}"/>"#, cone.to_degrees())?;
                    writeln!(out, r#"    <float name="cutoff_angle" value="{}"/>"#, 1.001 * cone.to_degrees())?;
                    writeln!(out, r#"    <transform name="to_world">"#)?;
                    let [at, up] = [*place, up].map(words);
                    writeln!(out, r#"      <lookat origin="{at}" target="{target}" up="{up}"/>"#)?;
                    writeln!(out, "    </transform>")?;
                    writeln!(out, "  </emitter>")?;
                }
                Ok(())
            }
        }
    }
}

/// What takes all light.
const DULL: &str = r#"<bsdf type="diffuse"><rgb name="reflectance" value="0"/></bsdf>"#;

/// What each vertex throws back is its colour.
const PAINTED: &str = r#"<bsdf type="diffuse"><texture type="mesh_attribute" name="reflectance"><string name="name" value="vertex_color"/></texture></bsdf>"#;

/// A mesh as it is, each triangle with its own normal.
fn shape(out: &mut dyn Write, file: &str, within: &[&str]) -> io::Result<()> {
    writeln!(out, r#"  <shape type="ply">"#)?;
    writeln!(out, r#"    <string name="filename" value="{file}"/>"#)?;
    writeln!(out, r#"    <boolean name="face_normals" value="true"/>"#)?;
    for words in within {
        writeln!(out, "    {words}")?;
    }
    writeln!(out, "  </shape>")
}

fn words(at: DVec3) -> String {
    format!("{}, {}, {}", at.x, at.y, at.z)
}
