//! What is run: every shape under its own scheme and rules, then under every other scheme and rule that makes a
//! difference to it.

use crate::opensubdiv::{self, VertexOrder};
use crate::shape::{Scheme, Shape};
use subsurf::{Boundary, Creasing, Triangles};

/// A shape under one scheme and one set of rules.
pub struct Variant {
    pub shape: Shape,
    /// The scheme and rules that the shape's file asks for.
    pub own: bool,
}

impl Variant {
    pub fn rules(&self) -> String {
        let rules = &self.shape.tags.rules;
        if self.shape.scheme == Scheme::Bilinear {
            return "any".into();
        }
        let boundary = match rules.boundary {
            Boundary::None => "none",
            Boundary::EdgeOnly => "edge-only",
            Boundary::EdgeAndCorner => "edge-and-corner",
        };
        let creasing = if rules.creasing == Creasing::Chaikin { ", Chaikin" } else { "" };
        let triangles = if rules.triangles == Triangles::Smooth { ", smooth triangles" } else { "" };
        format!("{boundary}{creasing}{triangles}")
    }

    /// Name and rules, the latter where they are not the file's.
    pub fn name(&self) -> String {
        if self.own {
            return self.shape.name.clone();
        }
        let scheme = scheme_name(self.shape.scheme);
        if self.shape.scheme == Scheme::Bilinear {
            return format!("{} as {scheme}", self.shape.name);
        }
        format!("{} as {scheme}, {}", self.shape.name, self.rules())
    }
}

pub fn scheme_name(scheme: Scheme) -> &'static str {
    match scheme {
        Scheme::Bilinear => "bilinear",
        Scheme::CatmullClark => "Catmull-Clark",
        Scheme::Loop => "Loop",
    }
}

/// The file's own scheme and rules first. A rule varies only where the mesh has what it is about: boundary edges,
/// semi-sharp edges, triangles; bilinear subdivision heeds none of them, and Loop's takes triangles only.
///
/// # Errors
/// What OpenSubdiv says when it refuses the mesh.
pub fn variants(shape: &Shape) -> Result<Vec<Variant>, String> {
    let level = opensubdiv::refine(shape, 0, VertexOrder::default())?.pop().expect("level 0");
    let has_boundary = level.edge_face_counts.contains(&1);
    let has_semi_sharp = shape.tags.creases.iter().any(|c| c.sharpness > 0.0 && c.sharpness < 10.0);
    let has_triangles = shape.counts.contains(&3);
    let all_triangles = shape.counts.iter().all(|&n| n == 3);

    let own = (shape.scheme, shape.tags.rules);
    let mut out = vec![Variant { shape: shape.clone(), own: true }];
    for scheme in [Scheme::CatmullClark, Scheme::Loop, Scheme::Bilinear] {
        if scheme == Scheme::Loop && !all_triangles {
            continue;
        }
        let plain = scheme == Scheme::Bilinear;
        let options = |own, all: &[_], varies: bool| if varies && !plain { all.to_vec() } else { vec![own] };
        let boundaries = if has_boundary && !plain {
            vec![Boundary::None, Boundary::EdgeOnly, Boundary::EdgeAndCorner]
        } else {
            vec![own.1.boundary]
        };
        for boundary in boundaries {
            for creasing in options(own.1.creasing, &[Creasing::Uniform, Creasing::Chaikin], has_semi_sharp) {
                let smooth = has_triangles && scheme == Scheme::CatmullClark;
                let triangles = if smooth {
                    vec![Triangles::CatmullClark, Triangles::Smooth]
                } else {
                    vec![Triangles::CatmullClark]
                };
                for triangles in triangles {
                    let mut variant = Variant { shape: shape.clone(), own: false };
                    variant.shape.scheme = scheme;
                    let rules = &mut variant.shape.tags.rules;
                    (rules.boundary, rules.creasing, rules.triangles) = (boundary, creasing, triangles);
                    let same_triangles = !smooth || triangles == own.1.triangles;
                    let same = boundary == own.1.boundary && creasing == own.1.creasing && same_triangles;
                    if scheme != own.0 || !same {
                        out.push(variant);
                    }
                }
            }
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_vary_only_where_the_mesh_has_what_they_are_about() {
        let closed = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4";
        let count = |text: &str| variants(&Shape::parse("catmark_x", text).unwrap()).unwrap().len();
        // Catmull-Clark with two rules for triangles, Loop, bilinear.
        assert_eq!(count(closed), 4);
        // Two ways of decay for the first three of them.
        assert_eq!(count(&format!("{closed}\nt crease 2/1/0 0 1 2.5")), 7);
        // A quad: three boundaries, and bilinear.
        assert_eq!(count("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4"), 4);
    }
}
