//! What a file may say about a control mesh beyond its faces: creases, corners, holes and the rules
//! of interpretation. Sharpness: `<= 0` smooth, `>= 10` infinitely sharp, fractions allowed
//! (DeRose, Kass, Truong 1998; the scale is that of OpenSubdiv and USD).

/// Sharpness from which on an edge or vertex is infinitely sharp and never decays.
pub const INFINITE_SHARPNESS: f64 = 10.0;

/// A sharp edge, named by its two vertices.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Crease {
    /// The two ends, in either order.
    pub vertices: [u32; 2],
    /// How many refinement steps the edge stays sharp; `>= 10` for ever.
    pub sharpness: f64,
}

impl Crease {
    /// A crease along the edge between vertices `a` and `b`.
    pub fn new(a: u32, b: u32, sharpness: f64) -> Self {
        Self { vertices: [a, b], sharpness }
    }
}

/// A sharp vertex.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Corner {
    /// The vertex.
    pub vertex: u32,
    /// How many refinement steps the vertex stays put; `>= 10` for ever.
    pub sharpness: f64,
}

impl Corner {
    /// A sharp vertex.
    pub fn new(vertex: u32, sharpness: f64) -> Self {
        Self { vertex, sharpness }
    }
}

/// Everything but the faces.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Tags {
    /// Sharp edges. Naming an edge twice keeps the last sharpness.
    pub creases: Vec<Crease>,
    /// Sharp vertices. Naming a vertex twice keeps the last sharpness.
    pub corners: Vec<Corner>,
    /// Faces that shape their neighbours but are not part of the surface.
    pub holes: Vec<u32>,
    /// How boundaries, creases and triangles are treated.
    pub rules: Rules,
}

/// How the surface behaves along the mesh's boundary.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum Boundary {
    /// Faces that touch the boundary are holes, unless every boundary edge at the touched vertex is
    /// tagged infinitely sharp.
    None,
    /// Boundary edges become curves; corners (vertices with one face) are rounded.
    EdgeOnly,
    /// Boundary edges become curves; corners (vertices with one face) stay.
    #[default]
    EdgeAndCorner,
}

/// How the sharpness of an edge's two halves follows from the edge.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum Creasing {
    /// Both halves inherit the sharpness less one.
    #[default]
    Uniform,
    /// Sharpness is smoothed along the crease: 3/4 own and 1/4 of the neighbours' mean, less one.
    Chaikin,
}

/// How triangles of a Catmull-Clark mesh are treated in the first step.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum Triangles {
    /// Plain Catmull-Clark weights.
    #[default]
    CatmullClark,
    /// Weights fitted for smoother triangles (OpenSubdiv's `smoothtriangles`).
    Smooth,
}

/// How face-varying values behave at seams and boundaries (OpenSubdiv's linear interpolation rules).
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum FaceVarying {
    /// Smooth everywhere; seams are smooth curves.
    None,
    /// Sharp where one face alone meets a corner of the value's domain.
    CornersOnly,
    /// Also sharp where more than two values meet at a vertex, and next to darts and creases.
    #[default]
    CornersPlus1,
    /// Also sharp at both sides where a concave corner faces a one-face corner.
    CornersPlus2,
    /// All seams and boundaries are piecewise linear.
    Boundaries,
    /// Bilinear everywhere.
    All,
}

/// The rules of interpretation. `Default` is [`Rules::usd`].
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub struct Rules {
    /// Boundary rule.
    pub boundary: Boundary,
    /// Decay of edge sharpness.
    pub creasing: Creasing,
    /// Triangles under Catmull-Clark.
    pub triangles: Triangles,
    /// Face-varying interpolation.
    pub face_varying: FaceVarying,
}

impl Rules {
    /// USD's defaults: edge-and-corner, uniform creasing, corners-plus-1.
    pub fn usd() -> Self {
        Self::default()
    }

    /// OpenSubdiv's library defaults: boundary none, uniform creasing, face-varying all.
    pub fn opensubdiv() -> Self {
        Self { boundary: Boundary::None, face_varying: FaceVarying::All, ..Self::default() }
    }

    /// Blender's defaults since its version 2.91: edge-only boundaries, uniform creasing, piecewise linear seams ("keep
    /// boundaries").
    pub fn blender() -> Self {
        Self { boundary: Boundary::EdgeOnly, face_varying: FaceVarying::Boundaries, ..Self::default() }
    }
}
