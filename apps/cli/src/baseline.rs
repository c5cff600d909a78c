//! Feature-adaptive patches, the usual way to evaluate subdivision surfaces, beside ours.

use crate::args::{Choices, one_of, word};
use crate::failure::{Bytes, Failure};
use crate::input::Input;
use clap::Args;
use serde_json::{Value, json};
use subsurf::{AdaptiveKind, AdaptiveOptions, AdaptiveRefinement, AdaptiveSize, MAX_ISOLATION, Topology};

/// Which baseline to look at.
#[derive(Args, Clone, Copy, Debug)]
pub struct BaselineArgs {
    /// Look at the patches of feature-adaptive refinement: feature-adaptive or feature-adaptive-single-crease
    #[arg(long, value_name = "WHICH", value_parser = one_of(BASELINES), hide_possible_values = true, help_heading = "Baseline")]
    baseline: Option<Baseline>,
    /// The baseline's deepest level, 1 to 10 [default: what sharpness needs to decay, at least 4]
    #[arg(long, value_name = "LEVEL", requires = "baseline", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_ISOLATION)), help_heading = "Baseline")]
    isolation: Option<u32>,
}

/// Another way to make patches.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Baseline {
    FeatureAdaptive,
    FeatureAdaptiveSingleCrease,
}

const BASELINES: Choices<Baseline> = &[
    ("feature-adaptive", Baseline::FeatureAdaptive),
    ("feature-adaptive-single-crease", Baseline::FeatureAdaptiveSingleCrease),
];

/// Kinds in the order of [`AdaptiveKind::ALL`], as they are called.
pub const KINDS: [&str; 4] = ["regular", "boundary", "single crease", "end cap"];

impl BaselineArgs {
    /// True where a baseline is asked for.
    pub fn is_some(&self) -> bool {
        self.baseline.is_some()
    }

    /// The baseline's patches, if it is asked for.
    pub fn refine(&self, topology: &Topology, input: &Input) -> Result<Option<AdaptiveRefinement>, Failure> {
        let Some(baseline) = self.baseline else { return Ok(None) };
        let single_crease = baseline == Baseline::FeatureAdaptiveSingleCrease;
        let mut options = AdaptiveOptions::for_sharpness_of(topology, single_crease);
        options.isolation = self.isolation.unwrap_or(options.isolation);
        let refined = AdaptiveRefinement::from_topology(topology, input.scheme, options);
        refined.map(Some).map_err(|source| Failure::Baseline { name: input.name.clone(), source })
    }
}

/// Facts about a baseline.
pub struct BaselineFacts {
    name: &'static str,
    isolation: u32,
    size: AdaptiveSize,
    counts: Vec<[usize; 4]>,
    vertices: Vec<usize>,
}

impl BaselineFacts {
    pub fn new(refined: &AdaptiveRefinement) -> Self {
        let options = refined.options();
        let baseline =
            if options.single_crease { Baseline::FeatureAdaptiveSingleCrease } else { Baseline::FeatureAdaptive };
        Self {
            name: word(BASELINES, baseline),
            isolation: options.isolation,
            size: refined.size(),
            counts: refined.counts(),
            vertices: refined.vertices().to_vec(),
        }
    }

    fn total(&self, kind: AdaptiveKind) -> usize {
        self.counts.iter().map(|level| level[kind as usize]).sum()
    }

    fn bytes(&self) -> usize {
        self.size.patch_bytes + self.size.mask_bytes + self.size.point_bytes
    }

    pub fn json(&self) -> Value {
        let kinds = |count: &dyn Fn(AdaptiveKind) -> usize| {
            json!({
                "regular": count(AdaptiveKind::Regular),
                "boundary": count(AdaptiveKind::Boundary),
                "single_crease": count(AdaptiveKind::SingleCrease),
                "end_cap": count(AdaptiveKind::EndCap),
            })
        };
        let level = |(counts, vertices): (&[usize; 4], &usize)| json!({ "vertices": vertices, "patches": kinds(&|kind| counts[kind as usize]) });
        let s = &self.size;
        json!({
            "baseline": self.name,
            "isolation": self.isolation,
            "patches": s.patches,
            "kinds": kinds(&|kind| self.total(kind)),
            "approximate_patches": s.approximate,
            "cut_short_patches": s.cut_short,
            "refined_points": s.refined_points,
            "end_cap_points": s.end_cap_points,
            "bytes": self.bytes(),
            "bytes_of": { "patches": s.patch_bytes, "masks": s.mask_bytes, "points": s.point_bytes },
            "levels": self.counts.iter().zip(&self.vertices).map(level).collect::<Vec<_>>(),
        })
    }

    /// Label, count (if it is one) and text of every line.
    pub fn lines(&self) -> Vec<(&'static str, Option<usize>, String)> {
        let s = &self.size;
        let kinds = AdaptiveKind::ALL.iter().zip(KINDS).filter(|(kind, _)| self.total(**kind) > 0);
        let kinds: Vec<String> = kinds.map(|(&kind, name)| format!("{} {name}", self.total(kind))).collect();
        let levels: Vec<String> = self.counts.iter().map(|level| level.iter().sum::<usize>().to_string()).collect();
        let memory = format!(
            "{} (patches {}, masks {}, points {})",
            Bytes(self.bytes() as u64),
            Bytes(s.patch_bytes as u64),
            Bytes(s.mask_bytes as u64),
            Bytes(s.point_bytes as u64)
        );
        vec![
            ("method", None, format!("{}, isolation level {}", self.name, self.isolation)),
            ("patches", Some(s.patches), kinds.join(", ")),
            ("by level", None, levels.join(", ")),
            ("approximate", Some(s.approximate), format!("end caps and cut-off sharpness ({} of them)", s.cut_short)),
            ("points", Some(s.refined_points + s.end_cap_points), "to refine every frame".to_owned()),
            ("memory", None, memory),
        ]
    }
}
