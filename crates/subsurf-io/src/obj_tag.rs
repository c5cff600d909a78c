//! The tag lines of OBJ files with subdivision surfaces, as OpenSubdiv's regression shapes write them:
//!
//! ```text
//! t crease 2/1/0 4 5 2.5        ints/floats/strings, then the values; vertices and faces count from 0
//! t crease 4/2/0 4 5 5 6 1 2    pairs of vertices, each pair an edge, with one sharpness each or one for all
//! ```
//!
//! Departure: where there are several sharpnesses, OpenSubdiv's own reader takes the one at the place of the pair's
//! first vertex and so skips every other; here they are one for each pair.

use crate::number::integer;
use crate::read_error::{LineError, quoted};
use crate::scene::{FileRules, Warning, WarningKind};
use crate::source_lines::SourceLines;
use crate::words::Words;
use subsurf::{Boundary, Corner, Crease, Creasing, FaceVarying, Triangles};

/// What the tags said so far.
#[derive(Debug, Default)]
pub struct TagLines {
    pub creases: Vec<Crease>,
    pub corners: Vec<Corner>,
    pub holes: Vec<u32>,
    pub rules: FileRules,
}

/// The values of a tag, counted as its head announced.
struct Values<'a> {
    tag: &'static str,
    ints: usize,
    floats: usize,
    words: Words<'a>,
}

impl TagLines {
    /// Reads one tag; `words` stands behind the `t`.
    pub fn read(
        &mut self,
        mut words: Words<'_>,
        line: u32,
        lines: &mut SourceLines,
        warnings: &mut Vec<Warning>,
    ) -> Result<(), LineError> {
        let name = words.next().ok_or(LineError::BadTagHead)?;
        let values = |tag| Values::new(tag, words.clone());
        match name {
            b"crease" => self.crease(values("crease")?)?,
            b"corner" => self.corner(values("corner")?)?,
            b"hole" => self.hole(values("hole")?)?,
            b"interpolateboundary" => {
                let value = values("interpolateboundary")?.choice("0, 1 or 2", |value| match value {
                    b"0" => Some(Boundary::None),
                    b"1" => Some(Boundary::EdgeAndCorner),
                    b"2" => Some(Boundary::EdgeOnly),
                    _ => None,
                });
                self.rules.boundary = Some(value?);
            }
            b"facevaryinginterpolateboundary" => {
                let value =
                    values("facevaryinginterpolateboundary")?.choice("0, 1, 2, 3, 4 or 5", |value| match value {
                        b"0" => Some(FaceVarying::None),
                        b"1" => Some(FaceVarying::CornersOnly),
                        b"2" => Some(FaceVarying::CornersPlus1),
                        b"3" => Some(FaceVarying::CornersPlus2),
                        b"4" => Some(FaceVarying::Boundaries),
                        b"5" => Some(FaceVarying::All),
                        _ => None,
                    });
                self.rules.face_varying = Some(value?);
            }
            b"creasemethod" => {
                let value = values("creasemethod")?.choice("normal or chaikin", |value| match value {
                    b"normal" => Some(Creasing::Uniform),
                    b"chaikin" => Some(Creasing::Chaikin),
                    _ => None,
                });
                self.rules.creasing = Some(value?);
            }
            b"smoothtriangles" => {
                let value = values("smoothtriangles")?.choice("catmark or smooth", |value| match value {
                    b"catmark" => Some(Triangles::CatmullClark),
                    b"smooth" => Some(Triangles::Smooth),
                    _ => None,
                });
                self.rules.triangles = Some(value?);
            }
            b"vertexedit" | b"edgeedit" | b"faceedit" => Warning::count(warnings, WarningKind::HierarchicalEdit, line),
            _ => Warning::count(warnings, WarningKind::UnknownTag, line),
        }
        lines.creases.resize(self.creases.len(), line);
        lines.corners.resize(self.corners.len(), line);
        lines.holes.resize(self.holes.len(), line);
        Ok(())
    }

    fn crease(&mut self, mut values: Values<'_>) -> Result<(), LineError> {
        let pairs = values.ints / 2;
        if pairs == 0 || values.ints != 2 * pairs || (values.floats != 1 && values.floats != pairs) {
            let needed = "two vertices for each edge, and one sharpness in all or one for each edge";
            return Err(LineError::TagShape { tag: "crease", needed });
        }
        let first = self.creases.len();
        for _ in 0..pairs {
            let vertices = [values.index()?, values.index()?];
            self.creases.push(Crease { vertices, sharpness: 0.0 });
        }
        let mut sharpness = 0.0;
        for (i, crease) in self.creases[first..].iter_mut().enumerate() {
            if i < values.floats {
                sharpness = values.sharpness()?;
            }
            crease.sharpness = sharpness;
        }
        Ok(())
    }

    fn corner(&mut self, mut values: Values<'_>) -> Result<(), LineError> {
        let count = values.ints;
        if count == 0 || (values.floats != 1 && values.floats != count) {
            let needed = "vertices, and one sharpness in all or one for each";
            return Err(LineError::TagShape { tag: "corner", needed });
        }
        let first = self.corners.len();
        for _ in 0..count {
            let vertex = values.index()?;
            self.corners.push(Corner { vertex, sharpness: 0.0 });
        }
        let mut sharpness = 0.0;
        for (i, corner) in self.corners[first..].iter_mut().enumerate() {
            if i < values.floats {
                sharpness = values.sharpness()?;
            }
            corner.sharpness = sharpness;
        }
        Ok(())
    }

    fn hole(&mut self, mut values: Values<'_>) -> Result<(), LineError> {
        for _ in 0..values.ints {
            let face = values.index()?;
            self.holes.push(face);
        }
        Ok(())
    }
}

impl<'a> Values<'a> {
    /// Reads the counts of the head and checks that as many values follow.
    fn new(tag: &'static str, mut words: Words<'a>) -> Result<Self, LineError> {
        let head = words.next().and_then(read_counts).ok_or(LineError::BadTagHead)?;
        let found = words.clone().count();
        let announced = head.iter().fold(0u64, |sum, &count| sum.saturating_add(count));
        if announced != found as u64 {
            return Err(LineError::TagValueCount { tag, announced, found });
        }
        Ok(Self { tag, ints: head[0] as usize, floats: head[1] as usize, words })
    }

    /// The next vertex or face.
    fn index(&mut self) -> Result<u32, LineError> {
        let word = self.words.next().unwrap_or_default();
        let allowed = "whole numbers that count from 0";
        let whole = integer(word).filter(|&(_, length)| length == word.len());
        let index = whole.and_then(|(index, _)| u32::try_from(index).ok());
        index.ok_or_else(|| LineError::BadTagValue { tag: self.tag, word: quoted(word), allowed })
    }

    /// The next sharpness.
    fn sharpness(&mut self) -> Result<f64, LineError> {
        let sharpness = self.words.finite_number(self.tag, "10 is infinitely sharp")?;
        sharpness.ok_or(LineError::TagShape { tag: self.tag, needed: "a sharpness" })
    }

    /// The tag's only value, one of those that `known` maps.
    fn choice<T>(mut self, allowed: &'static str, known: impl Fn(&[u8]) -> Option<T>) -> Result<T, LineError> {
        match (self.words.next(), self.words.next()) {
            (Some(word), None) => {
                known(word).ok_or_else(|| LineError::BadTagValue { tag: self.tag, word: quoted(word), allowed })
            }
            _ => Err(LineError::TagShape { tag: self.tag, needed: "exactly one value" }),
        }
    }
}

/// The three counts of a tag's head.
fn read_counts(word: &[u8]) -> Option<[u64; 3]> {
    let mut parts = word.split(|&b| b == b'/');
    let mut count = || {
        let part = parts.next()?;
        let (count, length) = integer(part)?;
        u64::try_from(count).ok().filter(|_| length == part.len())
    };
    let counts = [count()?, count()?, count()?];
    parts.next().is_none().then_some(counts)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tag(text: &str) -> Result<TagLines, LineError> {
        let mut tags = TagLines::default();
        tags.read(Words::new(text.as_bytes()), 1, &mut SourceLines::default(), &mut Vec::new())?;
        Ok(tags)
    }

    #[test]
    fn a_crease_names_pairs_with_one_sharpness_or_one_each() {
        let pair = |a, b, s| Crease::new(a, b, s);
        assert_eq!(tag("crease 2/1/0 4 5 2.5").unwrap().creases, [pair(4, 5, 2.5)]);
        assert_eq!(tag("crease 4/1/0 0 1 1 2 3").unwrap().creases, [pair(0, 1, 3.0), pair(1, 2, 3.0)]);
        assert_eq!(tag("crease 4/2/0 0 1 1 2 3 4").unwrap().creases, [pair(0, 1, 3.0), pair(1, 2, 4.0)]);
        for shape in ["crease 3/1/0 0 1 2 1", "crease 0/1/0 1", "crease 2/0/0 0 1", "crease 6/2/0 0 1 1 2 2 3 1 1"] {
            assert!(matches!(tag(shape), Err(LineError::TagShape { tag: "crease", .. })), "{shape}");
        }
    }

    #[test]
    fn corners_holes_and_rules_are_read() {
        assert_eq!(tag("corner 2/1/0 3 1 2").unwrap().corners, [Corner::new(3, 2.0), Corner::new(1, 2.0)]);
        assert_eq!(tag("corner 2/2/0 3 1 2 -1").unwrap().corners, [Corner::new(3, 2.0), Corner::new(1, -1.0)]);
        assert_eq!(tag("hole 2/0/0 3 1").unwrap().holes, [3, 1]);
        assert_eq!(tag("interpolateboundary 1/0/0 2").unwrap().rules.boundary, Some(Boundary::EdgeOnly));
        let rules = tag("facevaryinginterpolateboundary 1/0/0 4").unwrap().rules;
        assert_eq!(rules.face_varying, Some(FaceVarying::Boundaries));
        assert_eq!(tag("creasemethod 0/0/1 chaikin").unwrap().rules.creasing, Some(Creasing::Chaikin));
        assert_eq!(tag("smoothtriangles 0/0/1 smooth").unwrap().rules.triangles, Some(Triangles::Smooth));
    }

    #[test]
    fn a_head_that_lies_is_refused_whatever_it_announces() {
        for head in ["crease", "", "crease 2/1 0 1 2", "crease 2/1/0/0 0 1 2", "crease a/b/c 0 1 2", "crease -2/1/0 0"]
        {
            assert_eq!(tag(head).unwrap_err(), LineError::BadTagHead, "{head}");
        }
        for counts in ["2/2/0", "2147483647/1/0", "9223372036854775807/99999999999999999999/1", "0/0/0"] {
            let error = tag(&format!("crease {counts} 0 1 2")).unwrap_err();
            assert!(matches!(error, LineError::TagValueCount { found: 3, .. }), "{counts}");
        }
    }

    #[test]
    fn values_out_of_range_are_refused_by_name() {
        assert!(matches!(tag("hole 1/0/0 -1"), Err(LineError::BadTagValue { tag: "hole", .. })));
        assert!(matches!(tag("hole 1/0/0 1.5"), Err(LineError::BadTagValue { tag: "hole", .. })));
        assert!(matches!(tag("interpolateboundary 1/0/0 3"), Err(LineError::BadTagValue { .. })));
        assert!(matches!(tag("corner 1/1/0 0 inf"), Err(LineError::NotFinite { .. })));
        assert!(matches!(tag("corner 1/1/0 0 x"), Err(LineError::BadNumber { .. })));
    }
}
