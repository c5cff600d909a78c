//! A control mesh with positions and scheme, read from OBJ files with OpenSubdiv's `t` tag lines. A file's name tells
//! its scheme: `bilinear_*`, `loop_*`, otherwise Catmull-Clark. Without tags the rules are those of OpenSubdiv's
//! regression tests: edge-only boundaries, uniform creasing.

use std::path::{Path, PathBuf};
use subsurf::{Boundary, ControlMesh, Corner, Crease, Creasing, FaceVarying, Rules, Tags, Triangles};

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Scheme {
    Bilinear,
    CatmullClark,
    Loop,
}

/// Texture coordinates with indices of their own at face corners.
#[derive(Clone, PartialEq, Debug)]
pub struct Channel {
    pub values: Vec<[f64; 2]>,
    /// One per face corner.
    pub indices: Vec<u32>,
}

#[derive(Clone, Debug)]
pub struct Shape {
    pub name: String,
    pub scheme: Scheme,
    pub positions: Vec<[f64; 3]>,
    pub counts: Vec<u32>,
    pub indices: Vec<u32>,
    pub tags: Tags,
    /// None where a corner lacks a texture coordinate.
    pub channel: Option<Channel>,
}

impl Shape {
    pub fn read(path: &Path) -> Result<Self, String> {
        let mut text = std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
        if path.extension().is_some_and(|e| e == "h") {
            text = string_literals(&text);
        }
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let parsed = Self::parse(&name, &text);
        parsed.map_err(|(line, what)| format!("{}:{line}: {what}", path.display()))
    }

    /// # Errors
    /// The line, counted from 1, and what is wrong with it.
    pub fn parse(name: &str, text: &str) -> Result<Self, (usize, String)> {
        let mut shape = Self {
            name: name.to_string(),
            scheme: match name.split('_').next() {
                Some("bilinear") => Scheme::Bilinear,
                Some("loop") => Scheme::Loop,
                _ => Scheme::CatmullClark,
            },
            positions: vec![],
            counts: vec![],
            indices: vec![],
            channel: Some(Channel { values: vec![], indices: vec![] }),
            tags: Tags { rules: Rules { boundary: Boundary::EdgeOnly, ..Rules::default() }, ..Tags::default() },
        };
        for (number, line) in text.lines().enumerate() {
            let mut words = line.split_whitespace();
            let done = match words.next() {
                Some("v") => shape.vertex(words),
                Some("vt") => shape.texture_coordinate(words),
                Some("f") => shape.face(words),
                Some("t") => shape.tag(&words.collect::<Vec<_>>()),
                _ => Some(()),
            };
            done.ok_or_else(|| (number + 1, format!("cannot read {line:?}")))?;
        }
        let corners = shape.indices.len();
        shape.channel = shape.channel.filter(|c| c.indices.len() == corners && corners > 0);
        Ok(shape)
    }

    fn texture_coordinate<'a>(&mut self, mut words: impl Iterator<Item = &'a str>) -> Option<()> {
        let mut number = || words.next()?.parse().ok();
        let value = [number()?, number()?];
        self.channel.as_mut()?.values.push(value);
        Some(())
    }

    fn vertex<'a>(&mut self, mut words: impl Iterator<Item = &'a str>) -> Option<()> {
        let mut number = || words.next()?.parse().ok();
        self.positions.push([number()?, number()?, number()?]);
        Some(())
    }

    fn face<'a>(&mut self, words: impl Iterator<Item = &'a str>) -> Option<()> {
        let start = self.indices.len();
        for word in words {
            let index: i64 = word.split('/').next()?.parse().ok()?;
            let vertex = if index < 0 { self.positions.len() as i64 + index } else { index - 1 };
            self.indices.push(u32::try_from(vertex).ok()?);
            let value = word.split('/').nth(1).and_then(|i| i.parse::<i64>().ok());
            if let (Some(index), Some(channel)) = (value, &mut self.channel) {
                let value = if index < 0 { channel.values.len() as i64 + index } else { index - 1 };
                channel.indices.push(u32::try_from(value).ok()?);
            }
        }
        self.counts.push((self.indices.len() - start) as u32);
        Some(())
    }

    /// `name ints/floats/strings int... float... string...`; names that OpenSubdiv 3 ignores are skipped.
    fn tag(&mut self, words: &[&str]) -> Option<()> {
        let (&name, &sizes, values) = (words.first()?, words.get(1)?, words.get(2..)?);
        let sizes: Vec<usize> = sizes.split('/').map(str::parse).collect::<Result<_, _>>().ok()?;
        let &[ints, floats, strings] = sizes.as_slice() else { return None };
        let strings = values.get(ints + floats..ints + floats + strings)?;
        let ints: Vec<u32> = values[..ints].iter().map(|w| w.parse()).collect::<Result<_, _>>().ok()?;
        let floats: Vec<f64> =
            values[ints.len()..][..floats].iter().map(|w| w.parse()).collect::<Result<_, _>>().ok()?;
        let sharpness = |i: usize| Some(floats.get(i.min(floats.len().checked_sub(1)?))?.max(0.0));
        let rules = &mut self.tags.rules;
        match name {
            "crease" => {
                for (i, ends) in ints.chunks_exact(2).enumerate() {
                    self.tags.creases.push(Crease::new(ends[0], ends[1], sharpness(i)?));
                }
            }
            "corner" => {
                for (i, &vertex) in ints.iter().enumerate() {
                    self.tags.corners.push(Corner::new(vertex, sharpness(i)?));
                }
            }
            "hole" => self.tags.holes.extend(&ints),
            "interpolateboundary" => {
                rules.boundary = match ints.first()? {
                    0 => Boundary::None,
                    1 => Boundary::EdgeAndCorner,
                    2 => Boundary::EdgeOnly,
                    _ => return None,
                }
            }
            "facevaryinginterpolateboundary" => {
                rules.face_varying = match ints.first()? {
                    0 => FaceVarying::None,
                    1 => FaceVarying::CornersOnly,
                    2 => FaceVarying::CornersPlus1,
                    3 => FaceVarying::CornersPlus2,
                    4 => FaceVarying::Boundaries,
                    5 => FaceVarying::All,
                    _ => return None,
                }
            }
            "creasemethod" => {
                rules.creasing = match *strings.first()? {
                    "chaikin" => Creasing::Chaikin,
                    "normal" => Creasing::Uniform,
                    _ => return None,
                }
            }
            "smoothtriangles" => {
                rules.triangles = match *strings.first()? {
                    "smooth" => Triangles::Smooth,
                    "catmark" => Triangles::CatmullClark,
                    _ => return None,
                }
            }
            _ => {}
        }
        Some(())
    }

    /// The mesh in our terms.
    ///
    /// # Errors
    /// What our constructor says.
    pub fn mesh(&self) -> Result<ControlMesh, String> {
        ControlMesh::from_counts(self.positions.len(), &self.counts, self.indices.clone(), self.tags.clone())
            .map_err(|e| e.to_string())
    }

    /// The scheme in our terms.
    pub fn our_scheme(&self) -> subsurf::Scheme {
        match self.scheme {
            Scheme::Bilinear => subsurf::Scheme::Bilinear,
            Scheme::CatmullClark => subsurf::Scheme::CatmullClark,
            Scheme::Loop => subsurf::Scheme::Loop,
        }
    }

    /// Length of the diagonal of the box around the control points.
    pub fn diagonal(&self) -> f64 {
        let mut sum = 0.0;
        for k in 0..3 {
            let axis = || self.positions.iter().map(|p| p[k]);
            let side = axis().fold(f64::MIN, f64::max) - axis().fold(f64::MAX, f64::min);
            sum += side * side;
        }
        sum.sqrt()
    }
}

/// The string of a C++ header: its literals, one after the other.
fn string_literals(header: &str) -> String {
    let literal = |line: &str| Some(line.trim().strip_prefix('"')?.rsplit_once('"')?.0.replace("\\n", "\n"));
    header.lines().filter_map(literal).collect()
}

/// The OBJ files of `folder`, and headers that hold one as a string (those of OpenSubdiv's `regression/shapes`), whose name starts with one of `prefixes`, sorted by name.
pub fn shapes(folder: &Path, prefixes: &[&str]) -> Result<Vec<Shape>, String> {
    let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut paths: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    paths.retain(|path| {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        (name.ends_with(".obj") || name.ends_with(".h")) && prefixes.iter().any(|p| name.starts_with(p))
    });
    paths.sort();
    if paths.is_empty() {
        return Err(format!("no shapes in {}", folder.display()));
    }
    paths.iter().map(|path| Shape::read(path)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_carry_lists_and_rules() {
        let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1/1/1 2/2 -2 -1\n\
            t crease 4/2/0 0 1 1 2 2.5 3\nt corner 2/1/0 0 2 9\nt hole 1/0/0 0\nt creasemethod 0/0/1 chaikin\n\
            t interpolateboundary 1/0/0 0\nt vertexedit 2/4/2 0 0 1 2 3 4 translate P";
        let shape = Shape::parse("loop_x", text).unwrap();
        assert_eq!(shape.scheme, Scheme::Loop);
        assert_eq!((shape.counts, shape.indices), (vec![4], vec![0, 1, 2, 3]));
        assert_eq!(shape.tags.creases, vec![Crease::new(0, 1, 2.5), Crease::new(1, 2, 3.0)]);
        assert_eq!(shape.tags.corners, vec![Corner::new(0, 9.0), Corner::new(2, 9.0)]);
        assert_eq!(shape.tags.holes, vec![0]);
        assert_eq!(shape.tags.rules.boundary, Boundary::None);
        assert_eq!(shape.tags.rules.creasing, Creasing::Chaikin);
    }

    #[test]
    fn a_line_that_cannot_be_read_is_named() {
        assert_eq!(Shape::parse("x", "v 0 0 0\nv 0 zero 0").unwrap_err().0, 2);
        assert_eq!(Shape::parse("x", "t crease 2/1/0 0 1").unwrap_err().0, 1);
    }
}
