//! subsurf-io.
