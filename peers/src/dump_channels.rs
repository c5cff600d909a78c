//! OpenSubdiv's face-varying values for the core's tests: one file a shape in `channels`, all six rules.
//!
//! Values are given at face corners, in the order of faces and corners, so that it does not matter how values are
//! numbered. Rules that give the same values at all corners share a record.

use crate::conformance::channels::{RULES, rule_name};
use crate::dump_reference::{line, list, numbers, quoted};
use crate::opensubdiv::{self, ChannelLevel, refine_channel, takes_one_value_for_two};
use crate::shape::Shape;
use subsurf::FaceVarying;

const LEVELS: u32 = 3;
/// Shapes made to show the rules' differences: more of their corners are kept.
const IN_FULL: [&str; 5] =
    ["catmark_fvar_bound0", "catmark_fvar_bound2", "catmark_fvar_bound4", "loop_fvar_bound1", "loop_fvar_bound3"];
/// Corners kept of levels 1, 2 and 3, evenly chosen: of these shapes, and of the others.
const KEPT: [[usize; 3]; 2] = [[512, 256, 128], [0, 64, 0]];

/// The values at face corners, level by level.
type Levels = Vec<Vec<[f64; 2]>>;

/// None for shapes without texture coordinates, or with only one.
///
/// # Errors
/// What OpenSubdiv says when it refuses the mesh.
pub fn reference(shape: &Shape) -> Result<Option<String>, String> {
    let Some(channel) = &shape.channel else { return Ok(None) };
    if channel.values.iter().all(|v| *v == channel.values[0]) {
        return Ok(None);
    }
    let mut by_rule: Vec<(Vec<&str>, Levels)> = vec![];
    for rule in RULES {
        let mut shape = shape.clone();
        shape.tags.rules.face_varying = rule;
        // Where values alternate OpenSubdiv rounds one of them and not the other; only this rule shows it.
        if rule == FaceVarying::None && takes_one_value_for_two(&shape)? {
            continue;
        }
        let levels: Levels = refine_channel(&shape, LEVELS)?[1..].iter().map(ChannelLevel::at_corners).collect();
        match by_rule.iter_mut().find(|(_, known)| *known == levels) {
            Some((rules, _)) => rules.push(rule_name(rule)),
            None => by_rule.push((vec![rule_name(rule)], levels)),
        }
    }
    let mut text = String::new();
    line(&mut text, "{\"shape\": ", &quoted(&shape.name));
    let provenance = format!(
        "Texture coordinates: OpenSubdiv's regression/shapes/{0}.h, Modified Apache License 2.0 (see ../LICENSE and \
         ../NOTICE); the mesh is in ../{0}.json. Refined values: OpenSubdiv {1} in double precision, written by `peers \
         dump-reference`.",
        shape.name,
        opensubdiv::version()
    );
    line(&mut text, ",\"provenance\": ", &quoted(&provenance));
    line(&mut text, ",\"values\": ", &list(channel.values.iter().map(|v| numbers(v))));
    line(&mut text, ",\"corners\": ", &numbers(&channel.indices));
    let kept = KEPT[usize::from(!IN_FULL.contains(&shape.name.as_str()))];
    let mut records = vec![];
    for (rules, levels) in &by_rule {
        for (level, (corners, kept)) in (1..).zip(levels.iter().zip(kept)) {
            if kept > 0 {
                let rules = list(rules.iter().map(|r| quoted(r)));
                // Odd, so that all corners of faces are met.
                let stride = corners.len().div_ceil(kept) | 1;
                let values = list(corners.iter().step_by(stride).map(|v| numbers(v)));
                records.push(format!(
                    "{{\"rules\": {rules}, \"level\": {level}, \"count\": {}, \"stride\": {stride}, \"values\": {values}}}",
                    corners.len()
                ));
            }
        }
    }
    line(&mut text, ",\"records\": ", &format!("[\n {}]}}", records.join(",\n ")));
    Ok(Some(text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_that_agree_share_a_record() {
        let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4";
        let shape = Shape::parse("catmark_quad", text).unwrap();
        let json: serde_json::Value = serde_json::from_str(&reference(&shape).unwrap().unwrap()).unwrap();
        let records = json["records"].as_array().unwrap();
        // Rounded corners or sharp ones; with sharp ones a square stays bilinear.
        assert_eq!(records.len(), 2);
        assert_eq!(records[0]["rules"], serde_json::json!(["none"]));
        assert_eq!(records[1]["values"][0], serde_json::json!([0, 0]));
        assert_eq!(records[0]["values"].as_array().unwrap().len(), 64);
    }
}
