//! How a surface reflects: Fresnel's equations, metals, facets too small to see, and the materials made of them.
//!
//! Everything is for one wavelength at a time and unpolarised light, in a local frame whose z is the normal and whose x
//! is the tangent along which `alpha_x` counts. `wi` and `wo` are unit vectors away from the surface, toward where the
//! light comes from and where it goes; a BRDF is reciprocal, so the two may be exchanged.
//!
//! 1. [`fresnel`] is the mirror share of a smooth face.
//! 2. [`metals`] has measured indices of refraction.
//! 3. [`microfacet`] is the rough lobe of faces too small to be traced.
//! 4. [`model`] is the shelf of analytic BRDFs by name, from Lambert to a painted density of normals.
//! 5. [`material`] puts them together; its textual form, as `brass:ggx:0.2`, is in flags, recipes and reports.
//!
//! What is not simulated: polarisation between bounces, diffraction and interference, light that travels under the
//! surface before it leaves, and second bounces between the facets of one rough lobe (their light is lost: GGX of
//! α = 0.5 returns 0.69 of what falls on it straight).

pub mod fresnel;

pub mod metals;

mod erf;

pub mod microfacet;

mod coat;

pub mod model;

pub mod material;

mod spelling;
