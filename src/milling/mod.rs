//! Milling as machines do it: where a cutter's tip stands over the triangles that are written.

pub mod tip;
