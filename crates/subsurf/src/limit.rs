//! The limit surface.

#[cfg_attr(not(test), allow(dead_code, reason = "an alternative to the deflated powers, compared in tests"))]
mod eigen;
