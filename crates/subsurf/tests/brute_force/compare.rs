//! The crate's closed forms beside brute force.

use super::{Soup, apart, diagonal, worse};
use std::cell::Cell;
use subsurf::{ControlMesh, Derivatives, LimitSurface, Location, Method, PatchTable, Scheme};

/// Largest errors so far: position, first, second derivatives, position in f32.
#[derive(Default)]
pub struct Worst([Cell<f64>; 4]);

impl Worst {
    fn note(&self, what: usize, error: f64) {
        self.0[what].set(worse(self.0[what].get(), error));
    }

    pub fn print(&self, name: &str) {
        let [p, d, dd, f32] = [0, 1, 2, 3].map(|k| self.0[k].get());
        println!("{name}: position {p:.1e}, first {d:.1e}, second {dd:.1e}, f32 {f32:.1e}");
    }
}

/// Position within 1e-12 of the box (sums of 100 terms with weights of size one reach 1e-14). Derivatives relative to the
/// largest there, 1e-10 and 1e-8: they lose a digit or two to the condition of the local step, not to the depth.
/// In f32, 1e-6 of the box: control points and result are rounded, sums are not.
const BOUNDS: [f64; 4] = [1e-12, 1e-10, 1e-8, 1e-6];

const MORE: [u32; 4] = [0, 1, 0, 3];

struct Case<'a> {
    soup: &'a Soup,
    box_size: f64,
    worst: &'a Worst,
}

impl Case<'_> {
    fn at(
        &self,
        surface: &LimitSurface<'_, f64, 3>,
        single: &LimitSurface<'_, f32, 3>,
        at: Location,
        more: u32,
    ) -> Result<(), String> {
        let (jet, truth) = match (surface.eval_second(at), self.soup.eval_after(at, more)) {
            (None, None) => return Ok(()),
            (Some(jet), Some(truth)) => (jet, truth),
            (jet, _) => return Err(format!("{at:?}: is it a hole? The table says {}", jet.is_none())),
        };
        let mut errors = [apart(jet.position, truth.position) / self.box_size, 0.0, 0.0, 0.0];
        match truth.derivatives {
            None if jet.second.is_some() => return Err(format!("{at:?}: second derivatives at a special vertex")),
            None => {}
            Some(_) => {
                if jet.derivatives != Derivatives::Finite {
                    return Err(format!("{at:?}: derivatives are finite, not {:?}", jet.derivatives));
                }
                let second = jet.second.ok_or_else(|| format!("{at:?}: no second derivatives"))?;
                [errors[1], errors[2]] = truth.derivative_errors(jet.du, jet.dv, second);
            }
        }
        let rounded = single.eval(at).expect("no hole").position.map(|x| f64::from(x as f32));
        errors[3] = apart(rounded, truth.position) / self.box_size;
        for (k, what) in ["position", "first derivatives", "second derivatives", "position in f32"].iter().enumerate() {
            self.worst.note(k, errors[k]);
            if errors[k].is_nan() || errors[k] > BOUNDS[k] {
                return Err(format!("{at:?} (depth {}): {what} off by {:.2e}", truth.depth, errors[k]));
            }
        }
        Ok(())
    }
}

/// Compares positions in both precisions and derivatives with brute force, at the given places; every other place after
/// up to three more refinements than it needs.
pub fn check(
    mesh: &ControlMesh,
    scheme: Scheme,
    positions: &[[f64; 3]],
    at: &[Location],
    method: Method,
    worst: &Worst,
) -> Result<(), String> {
    let table = PatchTable::with_method(mesh, scheme, method).map_err(|e| e.to_string())?;
    let soup = Soup::new(mesh, scheme, positions);
    let rounded: Vec<[f32; 3]> = positions.iter().map(|p| p.map(|x| x as f32)).collect();
    let (surface, single) = (table.surface(positions), table.surface(&rounded));
    let case = Case { soup: &soup, box_size: diagonal(positions), worst };
    let one = |(k, &at): (usize, &Location)| {
        case.at(&surface, &single, at, MORE[k % MORE.len()]).map_err(|e| format!("{method:?} {e}"))
    };
    at.iter().enumerate().try_for_each(one)
}
