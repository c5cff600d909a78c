//! One row of the result.

use super::Summary;
use super::places::Words;
use super::table_error::RowError;
use subsurf::{Derivatives, Jet, LimitSurface, Location, Real, ShadingNormals};

/// Columns beyond the usual ones.
#[derive(Clone, Copy, Debug)]
pub struct Columns {
    pub second: bool,
    pub curvature: bool,
    pub blend_weight: bool,
}

const USUAL: &str = "face,subface,u,v,x,y,z,du_x,du_y,du_z,dv_x,dv_y,dv_z,n_x,n_y,n_z,derivatives";
const SECOND: &str = ",duu_x,duu_y,duu_z,duv_x,duv_y,duv_z,dvv_x,dvv_y,dvv_z";
const CURVATURE: &str = ",k1,k2,gaussian,mean";
const BLEND_WEIGHT: &str = ",b";
const TEXTURE: &str = ",s,t,du_s,du_t,dv_s,dv_t,texture_derivatives";

/// A number of the chosen precision, written with the fewest digits from which it reads back: at most 17 or 9.
pub trait Number: Real {
    fn write(self, out: &mut Vec<u8>);
}

impl Number for f64 {
    fn write(self, out: &mut Vec<u8>) {
        out.extend_from_slice(zmij::Buffer::new().format(self).as_bytes());
    }
}

impl Number for f32 {
    fn write(self, out: &mut Vec<u8>) {
        out.extend_from_slice(zmij::Buffer::new().format(self).as_bytes());
    }
}

/// Evaluates and writes rows.
pub struct Rows<'a, T> {
    surface: LimitSurface<'a, T, 3>,
    shading: ShadingNormals<'a>,
    texture: Option<LimitSurface<'a, T, 2>>,
    columns: Columns,
}

impl<'a, T: Number> Rows<'a, T> {
    pub fn new(
        surface: LimitSurface<'a, T, 3>,
        shading: ShadingNormals<'a>,
        texture: Option<LimitSurface<'a, T, 2>>,
        columns: Columns,
    ) -> Self {
        Self { surface, shading, texture, columns }
    }

    /// The names of the columns.
    pub fn header(&self) -> String {
        let second = if self.columns.second { SECOND } else { "" };
        let curvature = if self.columns.curvature { CURVATURE } else { "" };
        let blend_weight = if self.columns.blend_weight { BLEND_WEIGHT } else { "" };
        let texture = if self.texture.is_some() { TEXTURE } else { "" };
        format!("{USUAL}{second}{curvature}{blend_weight}{texture}\n")
    }

    /// What the surface is at some places; none in holes.
    pub fn jets(&self, places: &[Location]) -> Vec<Option<Jet<3>>> {
        self.surface.eval_many(places)
    }

    /// Appends the row of the place `at`, which was given as `words` and where the surface is `jet`.
    pub fn write(
        &self,
        words: &Words<'_>,
        at: Location,
        jet: Option<Jet<3>>,
        out: &mut Vec<u8>,
        counts: &mut Summary,
    ) -> Result<(), RowError> {
        let Columns { second, curvature, blend_weight } = self.columns;
        let jet = jet.ok_or(RowError::Hole { face: at.face.0 })?;
        for word in words.fields {
            out.extend_from_slice(word);
            out.push(b',');
        }
        for vector in [jet.position, jet.du, jet.dv] {
            fields::<T>(&vector, out);
        }
        optional_fields::<T, 3>(self.shading.normal(at, &jet), out);
        state(jet.derivatives, out);
        if second {
            optional_fields::<T, 9>(jet.second.map(|d| std::array::from_fn(|i| d[i / 3][i % 3])), out);
        }
        if curvature {
            let all = jet.curvature().map(|c| [c.k1, c.k2, c.gaussian, c.mean]);
            optional_fields::<T, 4>(all, out);
        }
        if blend_weight {
            fields::<T>(&[self.shading.blend_weight(at)], out);
        }
        if let Some(jet) = self.texture.and_then(|texture| texture.eval(at)) {
            fields::<T>(&jet.position, out);
            fields::<T>(&[jet.du[0], jet.du[1], jet.dv[0], jet.dv[1]], out);
            state(jet.derivatives, out);
        }
        // Every field wrote a comma behind it.
        out.pop();
        out.push(b'\n');
        counts.count(jet.derivatives);
        Ok(())
    }
}

fn state(derivatives: Derivatives, out: &mut Vec<u8>) {
    out.extend_from_slice(match derivatives {
        Derivatives::Finite => b"finite,",
        Derivatives::Vanishes => b"vanishes,",
        Derivatives::Diverges => b"diverges,",
    });
}

fn fields<T: Number>(values: &[f64], out: &mut Vec<u8>) {
    for &x in values {
        T::from_f64(x).write(out);
        out.push(b',');
    }
}

/// Empty fields where there is no value, or none that is finite.
fn optional_fields<T: Number, const N: usize>(values: Option<[f64; N]>, out: &mut Vec<u8>) {
    match values.filter(|values| values.iter().all(|&x| T::from_f64(x).to_f64().is_finite())) {
        Some(values) => fields::<T>(&values, out),
        None => out.extend([b','; N]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(x: impl Number) -> String {
        let mut out = Vec::new();
        x.write(&mut out);
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn numbers_read_back_and_are_short() {
        for x in [0.1f64, 1.0 / 3.0, -(2.0f64.sqrt()) * 1e-200, 5e-324, 1e300] {
            let text = text(x);
            assert_eq!(text.parse::<f64>().unwrap(), x);
            let digits = text.split('e').next().unwrap().trim_start_matches(['0', '.', '-']);
            assert!(digits.chars().filter(char::is_ascii_digit).count() <= 17, "{text}");
        }
        assert_eq!(text(0.1f32), "0.1");
    }
}
