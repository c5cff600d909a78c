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
}

impl Show {
    /// All, with the names that they parse from.
    pub const ALL: [(&str, Self); 6] = [
        ("shaded", Self::Shaded),
        ("normals", Self::Normals),
        ("wireframe", Self::Wireframe),
        ("cage", Self::Cage),
        ("patches", Self::Patches),
        ("levels", Self::Levels),
    ];
}

/// A name that is none of [`Show::ALL`].
#[derive(Clone, Debug, PartialEq, Error)]
#[error("'{0}' cannot be shown; use shaded, normals, wireframe, cage, patches or levels")]
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
