//! The others, each used as its documentation has it used for speed, behind interfaces that are safe to call.

pub mod embree;
pub mod faces;
pub mod kernels;
pub mod patches;
pub mod program;
pub mod uniform;

/// Names in tables, most with what they are used through.
pub mod name {
    pub const FAR: &str = "OpenSubdiv Far";
    pub const FAR_4: &str = "Far, isolation 4";
    pub const FAR_6: &str = "Far, isolation 6";
    pub const FAR_CREASES: &str = "Far, feature-adaptive";
    pub const FAR_SINGLE: &str = "Far, single-crease patches";
    pub const OSD: &str = "Osd, batches";
    pub const OSD_XYZ: &str = "Osd stencils, xyz";
    pub const OSD_XYZW: &str = "Osd stencils, xyzw";
    pub const BFR: &str = "Bfr";
    pub const BFR_CACHED: &str = "Bfr, cached";
    pub const EMBREE: &str = "Embree";
    pub const EMBREE_MANY: &str = "Embree, batches";
    pub const KERNELS: &str = "subdiv-kernels";
    pub const KERNELS_STENCILS: &str = "subdiv-kernels stencils";
    pub const HALF_EDGE: &str = "half-edge";
    pub const OURS: &str = "subsurf";
    pub const OURS_SINGLE: &str = "subsurf, single";
    pub const OUR_STENCILS: &str = "subsurf stencils";
    pub const OURS_ANEW: &str = "subsurf, built anew";
    pub const FLOOR: &str = "writing the output";
    pub const FLOOR_ORDINARY: &str = "writing, ordinary pages";
}

/// Names the program that refines with Dupuy and Vanhoey's half-edge rule.
pub const HALF_EDGE_PROGRAM: &str = "PEERS_HALF_EDGE";
