//! Control meshes from files.

#![forbid(unsafe_code)]
#![allow(dead_code)]

mod line;
mod number;
