//! facetmill turns a drawn highlight into a relief that can be milled and that really reflects it.
//!
//! A picture says how bright a piece of metal shall look from each direction. The crate finds a relief whose reflection
//! is that picture, one continuous sheet shaped for its cutter, or a plate of small planar mirrors; follows light over the
//! exact relief and over what the cutter leaves, to prove it; and closes it into a solid for milling. It comes from
//! Weyrich, Peers, Matusik, Rusinkiewicz, "Fabricating Microgeometry for Custom Surface Reflectance" (SIGGRAPH 2009);
//! `docs/method.md` and `docs/relief.md` in the repository have the mathematics.
//!
//! # From a drawing to a verdict
//!
//! ```
//! use facetmill::picture::{Reading, from_raster};
//! use facetmill::progress::Progress;
//! use facetmill::projection::View;
//! use facetmill::raster::Raster;
//! use facetmill::cutter::Cutter;
//! use facetmill::job::design::design;
//! use facetmill::job::proof::prove;
//! use facetmill::recipe::Recipe;
//!
//! // A ring of light: numbers proportional to brightness, row 0 on top.
//! let ring = Raster::from_fn(64, 64, |column, row| {
//!     let uv = View::pixel_centre(column, row, 64, 64);
//!     f64::from(u8::from((0.5..0.8).contains(&uv.length())))
//! });
//! let picture = from_raster(ring, &Reading::default())?;
//!
//! // Every setting has a default; lengths are mm, angles in a recipe degrees.
//! let mut recipe = Recipe::default();
//! recipe.highlight.half_field = 10.0.into();
//! recipe.plate.size = [12.0, 12.0];
//! recipe.plate.cells = Some(1.into());
//! recipe.plate.grid = Some(64); // nodes a side; as suits cutter and picture if not given
//! recipe.design.sheet.cutter = Some(Cutter::ball(0.5));
//! recipe.verify.rays = 100_000;
//!
//! let plate = design(&recipe, &picture.light, &Progress::silent())?;
//! assert!(plate.sheet.is_some()); // unless something asks for facets
//!
//! let proof = prove(&recipe, &picture.light, &plate, &Progress::silent())?;
//! let main = proof.verdict.main(); // seen through a blur of 1°
//! assert!(main.tv_incident.value < 0.02); // 98 % of all light is where the ring is
//! assert!(main.ssim.value > 0.98);
//! let cut = proof.milled.as_ref().unwrap(); // the same plate as the ball leaves it
//! assert!(cut.verdict.main().tv_incident.value < 0.03);
//!
//! let mut file = Vec::new(); // or any other writer
//! facetmill::export::stl::write_stl(&plate.mesh, &mut file)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # A tour in working order
//!
//! The modules stand in reading order, and each imports only from those above it.
//!
//! 1. **Ground.** [`progress`] lets a caller listen to long work and stop it; the library never prints. [`fence`] turns a
//!    panic of a file's decoder into an error. [`memory`] refuses work that would take more than there is. [`fourier`] and [`descent`] are the two numerical tools that several
//!    stages share.
//! 2. **Geometry.** [`slope`] is the only home of signs: slope, normal, mirror. [`projection`] lays directions out on
//!    the image plane. [`raster`] is a rectangle of numbers. [`lamp`] is where light comes from, far away or nearby, asked
//!    for its light at a place. [`scene`] has lamp, plate and wall in a room, in millimetres. [`setup`] is the far scene,
//!    light, image and plate tied together: which slope lights which point of the image; [`near`]
//!    says what a lamp and a wall nearby change of it. [`brdf`] is what metal and paint do to light: Fresnel, measured metals, microfacet lobes.
//! 3. **Drawing.** [`picture`] reads a file into linear light on a square.
//!    [`highlight`] says what the numbers mean and turns them into flux per pixel.
//! 4. **Wanted slopes.** [`sharpen`] makes up for what lamp and metal will blur; [`distribution`] gives every pixel its
//!    share of the plate's area. [`cutter`] is what it is to be cut with.
//! 5. **Facets.** [`facets::sample`] draws N facets of equal area, [`facets::arrange`] puts each in its place,
//!    [`facets::heights`] raises them so that neighbours meet, [`facets::steps`] measures what is left.
//! 6. **Or one sheet.** [`sculpt`] shapes a sheet in place of facets: see [`recipe::SurfaceKind`].
//!    Or a picture that stands on the metal itself: [`patches`].
//! 7. **Body.** [`relief`] is the exact object, a plane per facet with walls between, and the mesh that is written.
//! 8. **Proof.** [`trace`] follows rays over the relief or over any mesh ([`trace::traced_plate`] takes the tracer that serves it
//!    best), [`verify`] collects them as an image and scores it, each figure with its standard error.
//!    [`verify::goniometer`] measures a whole BRDF, [`verify::microgeometry`] normals and masking, [`verify::wall`] the
//!    reflection on a wall nearby, [`verify::render`] what a camera sees of the plate.
//!    [`milling`] makes the plate as a machine does, and [`shop`] writes the programs for it and judges anybody's.
//! 9. **Out.** [`export`] makes the closed solid, STL, height map and pictures, in memory.
//!    [`coupon`] is a test piece that tells what a machine does to a surface.
//!    [`goal`] is what a plate may be asked for in place of a drawing: reflectance by name, by measurement or by a map;
//!    [`fit`] finds models for a measured one.
//! 10. **All of it.** [`recipe`] holds every setting with its default, [`job`] goes from one and its picture
//!     to everything that an output folder holds: [`job::design`] is the way to a plate in a page, [`job::proof`] sends
//!     light over what comes of it.
//!
//! # The two frames
//!
//! The plate lies in a right-handed frame, its optical area from x = y = 0 to its size. Heights are z = f(x, y); the
//! lowest point may lie below z = 0, and the base of the solid lies `thickness` below that.
//!
//! ```text
//!            z   out of the plate, toward light and viewer
//!            |
//!      o     |     l       l  from the plate to the light:  theta from +z,
//!        \   |   /            phi from +x, counter-clockwise seen from above
//!         \  |  /          o  from the plate to a viewer
//!          \ | /    y  up on the plate
//!           \|/   /
//!            +---/-----------------+
//!           /   /                 /
//!          /   /                 /
//!         +---------------------+ -----> x  right
//!     x = y = 0
//! ```
//!
//! The highlight image is the hemisphere of viewers as a map, seen from above the plate.
//!
//! ```text
//!     row 0  +---------------------+  v = +1
//!            |          |          |
//!            |          |          |     u right, along the plate's x
//!            |          |          |     v up,    along the plate's y
//!            |----------c----------|     c        where the flat plate mirrors the light,
//!            |          |          |              (-l.x, -l.y, l.z)
//!            |          |          |     the rim  is the half field H away from c at |u| = 1 or |v| = 1
//!            |          |          |
//!            +---------------------+  v = -1
//!          u = -1                u = +1
//! ```
//!
//! On a ceiling or a wall, looked at from the plate's side, this map is mirrored; see [`recipe::Seen`].
//!
//! # Conventions
//!
//! | what | here | signs and units |
//! |---|---|---|
//! | lengths | millimetres | everywhere, in memory and in files |
//! | angles | radians in the library; degrees in a [`recipe::Recipe`], flags, files, reports, in the blurs of [`verify`] and on the slope plane of [`sculpt`] | theta from +z, phi from +x toward +y |
//! | slope (p, q) | gradient of the height | a surface that climbs toward +x throws light toward -x |
//! | normal m | (-p, -q, 1)/√(1 + p² + q²) | unit, out of the metal |
//! | l, o | from the plate to light and viewer | unit; o = 2 (l·m) m - l |
//! | deflection | twice the tilt at normal incidence | a facet tilted by 5° throws light 10° aside |
//! | image (u, v) | [-1, 1]², u right, v up | pixel row 0 is v = +1; half field H at the rim |
//! | rasters | row-major, row 0 on top | a picture's light is brightness; from [`highlight`] on, flux per pixel |
//! | slope grids, reliefs | row-major, row 0 is the lowest y | the opposite of rasters |
//! | shares | of incident flux unless said otherwise | `multi_bounce` is a share of the flux that leaves upward |
//! | lobe | scatter of the base metal | standard deviation of its deflections along each axis, at normal incidence |
//! | blur | standard deviation of a Gaussian at the image centre | 0.5°, 1°, 2° in reports |
//! | numbers | f64 | f32 in a [`relief::mesh::Mesh`], as in an STL file, in the heights and light of a sheet ([`relief::periodic`], [`sculpt`]) and in a BRDF table |
//! | randomness | streams from (seed, index) | same bytes for any number of threads |
//!
//! # Beside other systems
//!
//! *Optics and rendering.* As in most BSDF literature, both directions point away from the surface, theta is the polar
//! and phi the azimuthal angle, and z is the macroscopic normal. Formats that tabulate scatter relative to the specular
//! direction (as Zemax's) measure angles about the same c as the equidistant projection. Systems whose y axis points up
//! need (x, y, z) to become (x, z, -y). `radiance` is the slice of the BRDF at one direction of light, up to a factor;
//! `intensity` is that times cos θo.
//!
//! *Images.* Row 0 is on top, as in all picture files; v points up, as in mathematics; so v falls as rows grow.
//!
//! *CAD, STL and machines.* z points out of the stock toward the spindle, x right, y away from the operator, as on a
//! vertical mill; the origin is the lower-left corner of the optical area. STL has no units: files say mm in their
//! header. Triangles turn counter-clockwise seen from outside.

#![forbid(unsafe_code)]
#![warn(missing_docs)]
#![deny(clippy::print_stdout, clippy::print_stderr)]

// Their types stand in public signatures: a caller who uses these needs no version of the same number.
pub use glam;
pub use image;

pub mod progress;

pub mod fence;

pub mod memory;

pub mod golden;

pub mod fourier;

pub mod descent;

pub mod slope;

pub mod projection;

pub mod raster;

pub mod lamp;

pub mod scene;

pub mod setup;

pub mod near;

pub mod brdf;

pub mod picture;

pub mod highlight;

pub mod sharpen;

pub mod distribution;

pub mod cutter;

pub mod gcode;

pub mod facets;

pub mod relief;

pub mod milling;

pub mod shop;

pub mod sculpt;

pub mod patches;

pub mod trace;

pub mod verify;

pub mod export;

pub mod coupon;

pub mod goal;

pub mod fit;

pub mod recipe;

pub mod report;

pub mod job;
