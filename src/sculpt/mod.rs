//! Sheets whose light is the picture: one periodic sheet of triangles, optimised as it is written.

pub mod edge_slopes;

pub mod periodic_filter;

pub mod start;

pub mod target;

pub mod bound;

pub mod detail;

pub mod slope_histogram;

pub mod closing;

pub mod resample;

pub mod sweep;

pub mod tool;

pub mod milled_facets;

pub mod matching;

pub mod concave_edges;

pub mod light_model;

pub mod objective;

pub mod plan;

pub mod checkpoint;

pub mod stages;
