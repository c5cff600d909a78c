//! What OpenSubdiv computes, and what we compute: `tests/golden/opensubdiv/README.md` describes the data.

mod channels;
mod levels;
mod limits;
#[path = "../opensubdiv_shapes/mod.rs"]
mod opensubdiv_shapes;
mod reference;
