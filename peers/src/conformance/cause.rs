//! What kind of vertex a point is at or nearest to: the cause of a difference, where there is one.

use crate::opensubdiv::OsdLevel;
use crate::shape::Scheme;

/// In the order of the report; of two that apply, the later one counts.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Cause {
    Regular,
    Crease,
    Corner,
    Extraordinary,
    IrregularCrease,
    IrregularCorner,
    Dart,
    ValenceTwo,
    Cone,
    SemiSharp,
    NonManifold,
    /// Second derivatives of the right size and the wrong sign, under Loop.
    UpsideDown,
}

impl Cause {
    pub const ALL: [Self; 12] = [
        Self::Regular,
        Self::Crease,
        Self::Corner,
        Self::Extraordinary,
        Self::IrregularCrease,
        Self::IrregularCorner,
        Self::Dart,
        Self::ValenceTwo,
        Self::Cone,
        Self::SemiSharp,
        Self::NonManifold,
        Self::UpsideDown,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::Regular => "regular",
            Self::Crease => "regular crease or boundary",
            Self::Corner => "corner with one face per sector",
            Self::Extraordinary => "extraordinary, smooth",
            Self::IrregularCrease => "irregular crease or boundary",
            Self::IrregularCorner => "corner with more faces in a sector",
            Self::Dart => "infinitely sharp dart",
            Self::ValenceTwo => "interior, valence 2",
            Self::Cone => "interior, pinned, no sharp edge",
            Self::SemiSharp => "semi-sharp",
            Self::NonManifold => "non-manifold",
            Self::UpsideDown => "Loop patch upside down",
        }
    }

    /// Why OpenSubdiv is off there.
    pub fn reason(self) -> &'static str {
        match self {
            Self::Regular | Self::Crease | Self::Corner => {
                "Regular places nearest to which there is no special vertex, but on faces that have one elsewhere: the end \
                 cap reaches this far where isolation is shallow."
            }
            Self::Extraordinary => {
                "Isolation is bounded; what is left of the face is a Gregory patch or a B-spline patch that approximates \
                 the limit. `Limit` at the vertex itself is right."
            }
            Self::IrregularCrease => {
                "Cross tangents, and with them normals, follow rules for other masks than those that OpenSubdiv refines \
                 with. Positions are right in `Limit`; patches end in approximating caps."
            }
            Self::IrregularCorner => "Tangents along the first two edges, whichever they are; end caps.",
            Self::Dart => "The mask of a smooth vertex, which forgets the one sharp edge.",
            Self::ValenceTwo => "The mask of a corner: the vertex is said to stay where it is. End caps beside it.",
            Self::Cone => "End caps round a point that has no tangent plane.",
            Self::SemiSharp => {
                "The rule of the level at which the limit is taken holds for ever: what is still sharp counts as \
                 infinitely sharp, in `Limit` and where isolation ends."
            }
            Self::NonManifold => {
                "`Limit` has one normal for what are several sheets. Patches: end caps of the faces at the vertex."
            }
            Self::UpsideDown => {
                "Triangles in the middle of others are turned by half a circle. Their second derivatives are multiplied \
                 by the cube of that sign instead of its square (`d2Scale` in `far/patchBasis.cpp`)."
            }
        }
    }
}

/// The kind of every vertex of a level.
pub fn causes(level: &OsdLevel, scheme: Scheme) -> Vec<Cause> {
    let count = level.positions.len();
    // Per face corner at the vertex: the edges that lead in and out.
    let mut corners: Vec<Vec<[u32; 2]>> = vec![vec![]; count];
    let mut start = 0;
    for &n in &level.face_counts {
        let n = n as usize;
        for i in 0..n {
            let v = level.face_vertices[start + i];
            corners[v as usize].push([level.face_edges[start + i], level.face_edges[start + (i + n - 1) % n]]);
        }
        start += n;
    }
    (0..count)
        .map(|v| if scheme == Scheme::Bilinear { Cause::Regular } else { cause(level, scheme, v, &corners[v]) })
        .collect()
}

fn cause(level: &OsdLevel, scheme: Scheme, v: usize, corners: &[[u32; 2]]) -> Cause {
    let semi_sharp = |s: f32| s > 0.0 && s < 10.0;
    let sharpness = |e: u32| level.edge_sharpness[e as usize];
    if level.vertex_non_manifold[v] {
        return Cause::NonManifold;
    }
    if semi_sharp(level.vertex_sharpness[v]) || corners.iter().flatten().any(|&e| semi_sharp(sharpness(e))) {
        return Cause::SemiSharp;
    }
    // Faces in every sector, walked from each sharp edge to the next.
    let sharp = corners.iter().filter(|c| sharpness(c[0]) > 0.0);
    let sectors: Vec<usize> = sharp
        .map(|first| {
            let (mut at, mut faces) = (first, 1);
            while sharpness(at[1]) <= 0.0 && faces < corners.len() {
                let Some(next) = corners.iter().find(|c| c[0] == at[1]) else { break };
                (at, faces) = (next, faces + 1);
            }
            faces
        })
        .collect();
    let (interior, crease) = if scheme == Scheme::Loop { (6, 3) } else { (4, 2) };
    match level.vertex_rules[v] {
        1 if corners.len() == interior => Cause::Regular,
        1 if corners.len() == 2 => Cause::ValenceTwo,
        1 => Cause::Extraordinary,
        2 => Cause::Dart,
        4 if sectors.iter().all(|&k| k == crease) => Cause::Crease,
        4 => Cause::IrregularCrease,
        _ if sectors.is_empty() => Cause::Cone,
        _ if sectors.iter().all(|&k| k == 1) => Cause::Corner,
        _ => Cause::IrregularCorner,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::opensubdiv::{self, VertexOrder};
    use crate::shape::Shape;

    #[test]
    fn the_vertices_of_a_strip_are_told_apart() {
        // Two quads side by side, the shared edge sharp at one end only by the boundary's doing.
        let text = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nf 1 2 5 4\nf 2 3 6 5";
        let kinds = |tags: &str| {
            let shape = Shape::parse("catmark_strip", &format!("{text}\n{tags}")).unwrap();
            let level = opensubdiv::refine(&shape, 0, VertexOrder::default()).unwrap().pop().unwrap();
            causes(&level, Scheme::CatmullClark)
        };
        use Cause::*;
        let free = kinds("");
        assert_eq!(free, [IrregularCrease, Crease, IrregularCrease, IrregularCrease, Crease, IrregularCrease]);
        assert_eq!(kinds("t interpolateboundary 1/0/0 1"), [Corner, Crease, Corner, Corner, Crease, Corner]);
        assert_eq!(kinds("t corner 1/1/0 1 2")[1], SemiSharp);
        assert_eq!(kinds("t corner 1/1/0 1 10")[1], IrregularCorner);
    }
}
