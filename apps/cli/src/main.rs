//! The `subsurf` command line.
fn main() {}
