//! What a picture shows.

use std::str::FromStr;
use thiserror::Error;

/// What colours the surface. Lines, dots and a legend come with any of them, as [`Overlay`](crate::Overlay).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Show {
    /// The plain material in soft light.
    #[default]
    Shaded,
    /// The direction of the normal: x, y, z from −1 to 1 as red, green, blue from 0 to 1.
    Normals,
    /// The plain material, for lines on the surface.
    Wireframe,
    /// The plain material, for the control mesh around it.
    Cage,
    /// The shader's colours: one for each kind of patch.
    Patches,
    /// The shader's colours: one for each level.
    Levels,
    /// The shader's stripes: of equal angle between the normal and a direction.
    Isophotes,
    /// The shader's stripes: the mirror image of parallel straight lights.
    ReflectionLines,
    /// The shader's colours: a scale of Gaussian curvature.
    Gaussian,
    /// The shader's colours: a scale of mean curvature.
    Mean,
    /// The shader's colours: a scale of how much of the normal is blended in.
    BlendWeight,
}

impl Show {
    /// All, with the names that they parse from.
    pub const ALL: [(&str, Self); 11] = [
        ("shaded", Self::Shaded),
        ("normals", Self::Normals),
        ("wireframe", Self::Wireframe),
        ("cage", Self::Cage),
        ("patches", Self::Patches),
        ("levels", Self::Levels),
        ("isophotes", Self::Isophotes),
        ("reflection-lines", Self::ReflectionLines),
        ("gaussian", Self::Gaussian),
        ("mean", Self::Mean),
        ("blend-weight", Self::BlendWeight),
    ];

    /// Whether the shader is asked for stripes.
    pub(crate) fn is_striped(self) -> bool {
        matches!(self, Self::Isophotes | Self::ReflectionLines)
    }

    /// How much light and shade colours get: numbers none, so that they can be read off the picture; scales a little,
    /// so that form shows and colours still match the legend.
    pub(crate) fn lit(self) -> f32 {
        match self {
            Self::Normals => 0.0,
            Self::Isophotes | Self::ReflectionLines => 0.25,
            Self::Gaussian | Self::Mean | Self::BlendWeight => 0.45,
            Self::Shaded | Self::Wireframe | Self::Cage | Self::Patches | Self::Levels => 1.0,
        }
    }
}

/// A name that is none of [`Show::ALL`].
#[derive(Clone, Debug, PartialEq, Error)]
#[error(
    "'{0}' cannot be shown; use one of shaded, normals, wireframe, cage, patches, levels, isophotes, reflection-lines, gaussian, mean, blend-weight"
)]
pub struct ShowParseError(String);

impl FromStr for Show {
    type Err = ShowParseError;

    fn from_str(text: &str) -> Result<Self, ShowParseError> {
        let found = Self::ALL.iter().find(|(name, _)| *name == text);
        found.map(|&(_, show)| show).ok_or_else(|| ShowParseError(text.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_lists_every_name() {
        let message = "nothing".parse::<Show>().expect_err("no such name").to_string();
        assert!(Show::ALL.iter().all(|(name, _)| message.contains(name)), "{message}");
    }
}
