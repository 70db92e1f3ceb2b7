//! A plate of patches, each a small relief with its own distribution of normals: a picture that stands on the metal.
//!
//! A patch is a dimple ([`dimple`]): a bowl, whose slopes fill a lobe evenly, between walls that throw all other light
//! past the viewer. The share of the patch that the bowl takes is how bright it is to whoever looks at the lobe. All dimples are
//! level at the rims of their patches, so that neighbours join without a step ([`plate`]); [`viewer`] tells in closed form what
//! is seen of the written triangles, and [`portrait`] chooses bowls so that this is a picture.
//! [`maps`] gives each patch its lobe by pictures of gloss, normals, anisotropy and albedo.
//! [`milled`] is what a cutter leaves of them.

pub mod dimple;

pub mod plate;

pub mod viewer;

pub mod portrait;

pub mod maps;

pub mod milled;
