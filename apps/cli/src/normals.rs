//! Which normals a verb shows or writes: those of the surface, subdivided ones, or a blend.

use crate::args::{Choices, one_of};
use crate::failure::Failure;
use crate::input::Input;
use clap::Args;
use subsurf::{Averaging, Blend, NormalField, PatchTable, Power, Real, ShadingNormals, ShadingOptions};

/// What `--normals` and its companions say.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Normals")]
pub struct NormalArgs {
    /// Normals to shade with: limit (the surface's own), subdivided, or a blend of both that is smooth at extraordinary
    /// vertices: a1, a2, a3 or a4 (Bakker, Barendrecht, Kosinka 2018; a4 is the one to use)
    #[arg(long, value_name = "FIELD", value_parser = one_of(FIELDS), hide_possible_values = true, default_value = "limit")]
    normals: NormalField,
    /// Exponent of the blend weight: the smaller, the wider subdivided normals reach; smooth above 1/3 [default: 1]
    #[arg(long, value_name = "P", allow_negative_numbers = true, value_parser = positive)]
    blend_power: Option<f64>,
    /// Level at which blend weights start: the higher, the less of the surface is blended [default: 0]
    #[arg(long, value_name = "LEVEL", value_parser = clap::value_parser!(u32).range(..=MOST_LEVELS))]
    weight_level: Option<u32>,
    /// Level whose vertex normals are subdivided: the higher, the closer they are to the surface's own [default: 0]
    #[arg(long, value_name = "LEVEL", value_parser = clap::value_parser!(u32).range(..=MOST_LEVELS))]
    normal_level: Option<u32>,
    /// Average subdivided normals as vectors (linear), or on the sphere for the first K levels (spherical:K) [default:
    /// linear]
    #[arg(long, value_name = "HOW", value_parser = parse_averaging)]
    averaging: Option<Averaging>,
    /// Part normals at edges of at least this sharpness [default: 1]
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = positive)]
    crease_sharpness: Option<f64>,
    /// Subdivide the vertex normals of the file rather than those of its faces
    #[arg(long)]
    file_normals: bool,
}

/// Deeper levels are too large for any mesh worth the name; the library refuses those that are for this one.
const MOST_LEVELS: i64 = 10;

const FIELDS: Choices<NormalField> = &[
    ("limit", NormalField::Limit),
    ("subdivided", NormalField::Subdivided),
    ("a1", NormalField::Blended(Blend::A1)),
    ("a2", NormalField::Blended(Blend::A2)),
    ("a3", NormalField::Blended(Blend::A3)),
    ("a4", NormalField::Blended(Blend::A4)),
];

fn positive(text: &str) -> Result<f64, &'static str> {
    text.parse().ok().filter(|x: &f64| *x > 0.0 && x.is_finite()).ok_or("use a finite number above 0")
}

fn parse_averaging(text: &str) -> Result<Averaging, &'static str> {
    const ADVICE: &str = "write linear, or spherical:K with the number of levels K, for example spherical:2";
    if text == "linear" {
        return Ok(Averaging::Linear);
    }
    let levels = text.strip_prefix("spherical:").ok_or(ADVICE)?.parse().ok();
    levels.filter(|&k| (1..=MOST_LEVELS as u32).contains(&k)).map(Averaging::Spherical).ok_or(ADVICE)
}

impl NormalArgs {
    /// True where normals are the surface's own.
    pub fn is_limit(&self) -> bool {
        self.normals == NormalField::Limit
    }

    /// True where there are blend weights.
    pub fn is_blend(&self) -> bool {
        matches!(self.normals, NormalField::Blended(_))
    }

    /// Refuses options that would have no effect.
    pub fn check(&self) -> Result<(), Failure> {
        let usage = |text| Err(Failure::Usage(text));
        if !self.is_blend() && (self.blend_power.is_some() || self.weight_level.is_some()) {
            return usage("--blend-power and --weight-level are for blended normals: add --normals a4");
        }
        let starts = self.normal_level.is_some() || self.averaging.is_some() || self.crease_sharpness.is_some();
        if self.is_limit() && (starts || self.file_normals) {
            return usage(
                "--normal-level, --averaging, --crease-sharpness and --file-normals are for subdivided or blended \
                 normals: add --normals subdivided or --normals a4",
            );
        }
        if self.file_normals && self.normal_level.is_some_and(|level| level > 0) {
            return usage("the file's normals belong to level 0: leave out --normal-level or --file-normals");
        }
        Ok(())
    }

    fn options(&self) -> ShadingOptions {
        let default = ShadingOptions::default();
        ShadingOptions {
            field: self.normals,
            power: self.blend_power.map_or(default.power, Power::Uniform),
            averaging: self.averaging.unwrap_or(default.averaging),
            normals_level: self.normal_level.unwrap_or(default.normals_level),
            weights_level: self.weight_level.unwrap_or(default.weights_level),
            crease_sharpness: self.crease_sharpness.unwrap_or(default.crease_sharpness),
        }
    }

    /// The normals of the surface of `table` with control points `points`; `turned` turns the file's normals as its
    /// positions have been.
    pub fn shading<'a, T: Real>(
        &self,
        table: &'a PatchTable,
        points: &[[T; 3]],
        input: &Input,
        turned: impl Fn([f64; 3]) -> [f64; 3],
    ) -> Result<ShadingNormals<'a>, Failure> {
        let options = self.options();
        let made = if self.file_normals {
            let Some(own) = &input.scene.normals else { return Err(Failure::NoNormals { name: input.name.clone() }) };
            let normals: Vec<[f64; 3]> = own.values.iter().map(|&n| turned(n)).collect();
            ShadingNormals::from_normals(table, &normals, &own.indices, &options)
        } else {
            ShadingNormals::new(table, points, &options)
        };
        made.map_err(|source| Failure::Shading { name: input.name.clone(), source })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn averaging_is_read_or_explained() {
        assert_eq!(parse_averaging("linear"), Ok(Averaging::Linear));
        assert_eq!(parse_averaging("spherical:3"), Ok(Averaging::Spherical(3)));
        for wrong in ["", "spherical", "spherical:", "spherical:0", "spherical:-1", "spherical:99", "Linear"] {
            assert!(parse_averaging(wrong).is_err(), "{wrong}");
        }
    }
}
