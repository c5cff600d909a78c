//! Every verb as a user calls it: arguments in; standard output, standard error, exit status and files out.

mod bench;
mod bilinear;
mod eval;
mod figures;
mod info;
mod loop_scheme;
mod models;
mod normals;
mod program;
mod refine;
mod render;
mod tessellate;
mod usage;
mod wrong_input;
