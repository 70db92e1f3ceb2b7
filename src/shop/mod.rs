//! What a shop gets: programs with their stock, zero, feeds and speeds, each read back and judged before it is handed out.

// In reading order: each imports only from those above it.

pub mod feeds;

pub mod blank;

pub mod standing;

pub mod surface;

pub mod check;

pub mod programs;

pub mod sheet;
