//! What is said of a plate of patches, and its files.

use super::exports::{HEIGHT_MAP_SIDE, RELIEF_PICTURE_SIDE};
use super::patches::{PatchProduct, PatchProof, SeenPatches};
use super::product::{Content, png};
use crate::export::heightmap::height_map;
use crate::export::patch_page::{PatchPage, patch_picture};
use crate::export::rendered_view::{Exposure, view_page};
use crate::export::shading::ReliefPicture;
use crate::export::stl::{stl_bytes, write_stl};
use crate::picture::Picture;
use crate::progress::{Cancelled, Progress, Stage};
use crate::relief::open::NodeGrid;
use crate::report::patches::*;
use crate::report::{MeshFacts, Named, PROGRAM, PictureFacts, text};
use crate::sculpt::detail::WAVELENGTH;

/// Width of a patch, mm, below which diffraction is told.
const SMALL: f64 = 1.0;

/// Likeness below which a person is told that the picture will not be taken for the wanted one.
const ALIKE: f64 = 0.9;

impl PatchProduct {
    /// Everything that is known of it; `picture` is that of a portrait.
    pub fn report(&self, picture: Option<&Picture>) -> PatchesReport {
        let Self { recipe, proof, .. } = self;
        let total = ("total", self.seconds.iter().map(|(_, seconds)| seconds).sum::<f64>());
        let patches = self.patch_facts();
        let advice = self.advice(&patches);
        PatchesReport {
            program: PROGRAM,
            picture: picture.map(|picture| PictureFacts::new(picture, recipe.patches.portrait.clone())),
            recipe: recipe.clone(),
            patches,
            viewer: self.viewer_facts(),
            reachable: self.reachable(),
            stl: PatchStlFacts {
                units: "mm",
                triangles: self.mesh.triangles.len(),
                bytes: stl_bytes(self.mesh.triangles.len()),
            },
            designed: proof.as_ref().map(|proof| proof.scored(&proof.written, None)),
            as_milled: proof.as_ref().and_then(PatchProof::scored_cut),
            verdict: self.verdict(),
            advice,
            cpu_seconds: Named::from_iter(self.seconds.iter().copied().chain([total])),
        }
    }

    /// What is known of it if it was found in the file of `plate`, and whether no more than `at_most` of the light is in other
    /// patches than it should; `picture` is that of a portrait.
    pub fn verified(&self, plate: MeshFacts, picture: Option<&Picture>, at_most: Option<f64>) -> PatchesVerifyReport {
        let Self { recipe, proof, .. } = self;
        let mut advice = self.advice(&self.patch_facts());
        if recipe.design.sheet.cutter.is_some() && proof.as_ref().is_some_and(|proof| proof.cut.is_none()) {
            advice
                .push("The plate in the file is none of its recipe's: it was not milled again, only looked at.".into());
        }
        let allowed = |share: f64| {
            let proof = proof.as_ref()?;
            let tv = proof.decisive().scores.tv;
            Some(AllowedInPatches { share, tv, as_milled: proof.cut.is_some(), kept: tv <= share })
        };
        PatchesVerifyReport {
            program: PROGRAM,
            plate,
            picture: picture.map(|picture| PictureFacts::new(picture, recipe.patches.portrait.clone())),
            recipe: recipe.clone(),
            viewer: self.viewer_facts(),
            reachable: self.reachable(),
            measured: proof.as_ref().map(|proof| proof.scored(&proof.written, None)),
            as_milled: proof.as_ref().and_then(PatchProof::scored_cut),
            at_most: at_most.and_then(allowed),
            verdict: self.verdict(),
            advice,
        }
    }

    fn viewer_facts(&self) -> ViewerFacts {
        let [theta, phi] = self.recipe.viewer().0;
        ViewerFacts { theta, phi, distance_mm: self.recipe.viewer_distance() }
    }

    fn patch_facts(&self) -> PatchFacts {
        let Self { recipe, patches, dimples, .. } = self;
        let shares: Vec<f64> = dimples.iter().map(|dimple| dimple.share()).collect();
        let mean = |shares: &[f64]| shares.iter().sum::<f64>() / shares.len().max(1) as f64;
        let spare = || mean(&dimples.iter().map(|dimple| dimple.spare_share()).collect::<Vec<f64>>());
        let sharpest = self.sharpest();
        let side = patches.patch().min_element();
        let smallest = shares.iter().copied().filter(|share| *share > 0.0).fold(1.0, f64::min);
        let spread = |width: f64| (WAVELENGTH / width).to_degrees();
        PatchFacts {
            count: patches.count,
            size_mm: patches.patch().to_array(),
            nodes: patches.nodes,
            walls_deg: self.walls.steep.atan().to_degrees(),
            lobe_deg: recipe.patch_lobes().map(|slope| slope.atan().to_degrees()),
            metal_lobe_deg: recipe.plate.lobe,
            most_share: self.most_share,
            bowls_share: mean(&shares),
            spare_share: self.walls.spare.map(|_| spare()),
            sharpest_bowl_mm: if sharpest > 0.0 { 1.0 / sharpest } else { 0.0 },
            relief_height_mm: self.relief.depth(),
            diffraction_deg: [spread(side), spread(side * smallest.sqrt())],
        }
    }

    /// Curvature of the sharpest bowl, 1/mm.
    fn sharpest(&self) -> f64 {
        let bowls = self.dimples.iter().filter_map(|dimple| dimple.bowl);
        bowls.map(|bowl| bowl.sharpest()).fold(0.0, f64::max)
    }

    fn reachable(&self) -> Option<ReachableFacts> {
        let [black, white] = self.range?;
        // A bowl of radius R sends R² of area per unit of slope squared.
        let round = self.recipe.design.sheet.cutter.map_or(0.0, |cutter| cutter.valley_radius().powi(2));
        let level = (self.recipe.viewer().0[0].to_radians().cos()).max(0.05);
        let pit = round / (4.0 * level * self.walls.area());
        // What is darker than a millionth counts as that: no proof resolves it.
        Some(ReachableFacts { white, black, contrast: white / black.max(pit).max(1e-6 * white) })
    }

    /// How it looks, in a sentence.
    pub fn verdict(&self) -> Option<String> {
        let proof = self.proof.as_ref()?;
        let scores = &proof.decisive().scores;
        let [theta, phi] = self.recipe.viewer().0;
        let how = match (&proof.cut, self.recipe.design.sheet.cutter) {
            (Some(_), Some(cutter)) => format!("Cut by {cutter}, the"),
            _ => "The".to_owned(),
        };
        let place = format!("from {} mm at {theta}°, {phi}°", self.recipe.viewer_distance());
        let contrast = self.reachable().map_or(String::new(), |reachable| {
            format!(", with a contrast of {:.0} to 1 within reach", reachable.contrast.min(1e6))
        });
        let seen = match scores.ssim {
            Some(ssim) => format!("likeness {ssim:.3}, {:.1} % of the light in other patches", 100.0 * scores.tv),
            None => format!("{:.1} % of the light in other patches", 100.0 * scores.tv),
        };
        Some(format!("{how} plate shows the picture {place}: {seen}{contrast}."))
    }

    /// What a person should know.
    fn advice(&self, facts: &PatchFacts) -> Vec<String> {
        let Self { recipe, patches, .. } = self;
        let mut said = Vec::new();
        if patches.patch().min_element() < SMALL {
            let [whole, smallest] = facts.diffraction_deg;
            said.push(format!(
                "Patches are smaller than {SMALL} mm: diffraction spreads the light of bright ones by {whole:.2}°, of the \
                 darkest by {smallest:.2}°, beside lobes of {:.1}° of light. Fewer --patches or a larger --size would not.",
                4.0 * facts.lobe_deg[0]
            ));
        }
        if facts.most_share[0] < 0.2 {
            said.push(format!(
                "Bowls take at most {:.0} % of a patch, since lamp and viewer are not opposite: with --viewer {},{} the \
                 picture would be brighter.",
                100.0 * facts.most_share[0],
                recipe.light.theta,
                (recipe.light.phi + 180.0).rem_euclid(360.0)
            ));
        }
        if let Some(cutter) = recipe.design.sheet.cutter.filter(|cutter| cutter.valley_radius() * self.sharpest() > 1.0)
        {
            said.push(format!(
                "The sharpest bowl has a radius of {:.3} mm, less than that of {cutter}: the darkest tones come out \
                 brighter.",
                facts.sharpest_bowl_mm
            ));
        }
        if let Some(proof) = &self.proof {
            let scores = &proof.decisive().scores;
            if scores.ssim.is_some_and(|ssim| ssim < ALIKE) {
                said.push(match scores.noise > 0.05 {
                    true => format!(
                        "A patch is known to {:.0} % of white only, which lowers the likeness: raise --rays.",
                        100.0 * scores.noise
                    ),
                    false => {
                        "The likeness is low: coarser detail, a larger --lobe or more nodes (--grid) would raise it."
                            .to_owned()
                    }
                });
            }
        }
        said
    }

    /// Hands every file of the output folder, `report` among them, to `keep`, by name and content.
    pub fn write<E: From<Cancelled>>(
        &self,
        report: &PatchesReport,
        keep: &mut impl FnMut(&'static str, Content) -> Result<(), E>,
        progress: &Progress,
    ) -> Result<(), E> {
        progress.stage(Stage::Files);
        let faceted = self.relief.faceted();
        keep("plate.stl", &mut |mut out| write_stl(&self.mesh, &mut out))?;
        progress.check()?;
        let map = height_map(&faceted, HEIGHT_MAP_SIDE, progress)?;
        keep("heightmap.png", &mut |out| png(&map.image, out))?;
        keep("heightmap.json", &mut |out| out.write_all(text(&map.sidecar).as_bytes()))?;
        let made_of = self.made_of();
        let relief = ReliefPicture { relief: &faceted, continuous: true, made_of: &made_of };
        let relief = relief.picture(RELIEF_PICTURE_SIDE, progress)?;
        keep("relief.png", &mut |out| png(&relief, out))?;
        self.write_pictures(keep)?;
        keep("recipe.toml", &mut |out| out.write_all(self.recipe.to_toml().as_bytes()))?;
        progress.check()?;
        keep("report.json", &mut |out| out.write_all(text(report).as_bytes()))
    }

    /// Hands what is wanted and what is seen to `keep`, by name and content.
    pub fn write_pictures<E>(&self, keep: &mut impl FnMut(&'static str, Content) -> Result<(), E>) -> Result<(), E> {
        let made_of = self.made_of();
        keep("target.png", &mut |out| png(&patch_picture(&self.wanted, self.wanted.max()), out))?;
        if let Some(proof) = &self.proof {
            let view = &proof.decisive().view;
            let exposure = Exposure { heading: made_of.clone(), ..Exposure::default() };
            keep("simulated.png", &mut |out| png(&view_page(view, &proof.settings, &exposure), out))?;
            keep("comparison.png", &mut |out| png(&self.page(&proof.written, "as written"), out))?;
            if let Some((cut, _)) = &proof.cut {
                keep("comparison_milled.png", &mut |out| png(&self.page(cut, "as cut"), out))?;
            }
        }
        Ok(())
    }

    /// What the relief is made of, in words.
    pub fn made_of(&self) -> String {
        let [columns, rows] = self.patches.count;
        let cutter = self.recipe.design.sheet.cutter.map(|cutter| format!(" for {cutter}")).unwrap_or_default();
        format!("{columns} × {rows} patches{cutter}")
    }

    fn page(&self, seen: &SeenPatches, how: &str) -> image::RgbImage {
        let [width, height] = self.recipe.plate.size;
        let ([theta, phi], scores) = (self.recipe.viewer().0, &seen.scores);
        let likeness = scores.ssim.map(|ssim| format!("SSIM {ssim:.3} · ")).unwrap_or_default();
        let notes = [
            format!("{likeness}TV {:.3} · a patch is known to {:.1} % of white", scores.tv, 100.0 * scores.noise),
            format!(
                "seen {how} from {} mm at {theta}°, {phi}° · lamp at {}°, {}° · white is {:.3}/sr under a lamp of irradiance 1",
                self.recipe.viewer_distance(),
                self.recipe.light.theta,
                self.recipe.light.phi,
                self.wanted.max()
            ),
        ];
        let heading = format!("{width} × {height} mm, {}", self.made_of());
        PatchPage { wanted: &self.wanted, seen: &seen.seen.seen, heading: &heading, notes: &notes }.picture()
    }
}

impl PatchProof {
    fn scored(&self, seen: &SeenPatches, left_mm: Option<f64>) -> PatchScoreFacts {
        let (paths_a_pixel, resolution) = (self.settings.rays, seen.view.radiance.width);
        PatchScoreFacts { scores: seen.scores, left_mm, paths_a_pixel, resolution }
    }

    fn scored_cut(&self) -> Option<PatchScoreFacts> {
        let (seen, left) = self.cut.as_ref()?;
        Some(self.scored(seen, Some(*left)))
    }
}
