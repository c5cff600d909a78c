//! subsurf-render.
