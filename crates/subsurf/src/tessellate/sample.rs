//! Evaluates samples of a tessellation one by one, in `f64`, wherever they lie: where rates differ from face to face, and
//! where sums in the caller's precision do not tell a normal.

use super::layout::Layout;
use super::normals::{Sides, Source};
use super::patch_grid::PatchGrid;
use crate::index::{Face, HalfEdge};
use crate::limit::{Jet, LastPole, LimitSurface, Location, cubic, unit_normal};
use crate::real::{Real, round};
use rayon::prelude::*;

/// How to get normals of values that are positions.
#[derive(Clone, Copy)]
pub(super) struct NormalOf<const N: usize> {
    /// From both derivatives.
    pub tangents: fn([f64; N], [f64; N]) -> Option<[f64; 3]>,
    /// At places of all kinds.
    pub jet: fn(&Jet<N>) -> Option<[f64; 3]>,
}

impl NormalOf<3> {
    /// Of positions in space.
    pub const SPACE: Self = Self { tangents: unit_normal, jet: Jet::normal };
}

#[derive(Clone, Copy)]
pub(super) struct Sampler<'a, T, const N: usize> {
    surface: LimitSurface<'a, T, N>,
    layout: &'a Layout<'a>,
    normals: Option<NormalOf<N>>,
}

/// A value and, where it is wanted, a normal.
pub(super) type Sample<const N: usize> = ([f64; N], [f64; 3]);

impl<'a, T: Real, const N: usize> Sampler<'a, T, N> {
    pub fn new(surface: LimitSurface<'a, T, N>, layout: &'a Layout<'a>, normals: Option<NormalOf<N>>) -> Self {
        Self { surface, layout, normals }
    }

    pub fn surface(&self) -> LimitSurface<'a, T, N> {
        self.surface
    }

    pub fn layout(&self) -> &'a Layout<'a> {
        self.layout
    }

    pub fn with_normals(&self) -> bool {
        self.normals.is_some()
    }

    /// Points and normals of all control vertices.
    pub fn vertices(&self, points: &mut [[T; N]], normals: &mut [[T; 3]]) {
        let evaluate = |h: u32, last: &mut LastPole| self.single_after(self.layout.corner_location(HalfEdge(h)), last);
        self.fill(&self.layout.vertex_owner, points, normals, evaluate);
    }

    /// Points and normals inside all control edges.
    pub fn edges(&self, points: &mut [[T; N]], normals: &mut [[T; 3]]) {
        let (layout, samples) = (self.layout, self.layout.edge_samples());
        self.fill(&samples, points, normals, |(h, k), last| self.single_after(layout.edge_location(h, k), last));
    }

    /// Normals of the further sides of creases.
    pub fn extra_normals(&self, sides: &Sides, normals: &mut [[T; 3]]) {
        normals.par_iter_mut().zip(&sides.sources).for_each(|(n, source)| {
            let at = match *source {
                Source::Corner(h) => self.layout.corner_location(h),
                Source::Edge(h, k) => self.layout.edge_location(h, k),
            };
            *n = round(self.single(at).1);
        });
    }

    fn fill<S: Copy + Sync>(
        &self,
        samples: &[S],
        points: &mut [[T; N]],
        normals: &mut [[T; 3]],
        evaluate: impl Fn(S, &mut LastPole) -> Sample<N> + Sync,
    ) {
        if self.normals.is_some() {
            points.par_iter_mut().zip(normals).zip(samples).for_each_init(LastPole::default, |last, ((p, n), &s)| {
                let (position, normal) = evaluate(s, last);
                (*p, *n) = (round(position), round(normal));
            });
        } else {
            let samples = points.par_iter_mut().zip(samples);
            samples.for_each_init(LastPole::default, |last, (p, &s)| *p = round(evaluate(s, last).0));
        }
    }

    /// One normal by itself.
    pub fn normal(&self, at: Location) -> [f64; 3] {
        self.single(at).1
    }

    /// One sample by itself.
    pub fn single(&self, at: Location) -> Sample<N> {
        self.single_after(at, &mut LastPole::default())
    }

    /// The same with what the sample before left.
    pub fn single_after(&self, at: Location, last: &mut LastPole) -> Sample<N> {
        let outside = "holes have no samples";
        let Some(normal) = &self.normals else {
            return (self.surface.position_after(at, last).expect(outside), [0.0; 3]);
        };
        let jet = self.surface.eval_after(at, last).expect(outside);
        let near = || (normal.tangents)(jet.du, jet.dv).unwrap_or_else(|| self.normal_nearby(normal, at));
        (jet.position, (normal.jet)(&jet).unwrap_or_else(near))
    }

    /// Where the surface has no tangent plane: the normal a little further inside the face.
    fn normal_nearby(&self, normal: &NormalOf<N>, at: Location) -> [f64; 3] {
        let middle = if self.layout.is_triangle() { 1.0 / 3.0 } else { 0.5 };
        for step in [1e-4, 1e-2, 0.25] {
            let inside = |x: f64| x + (middle - x) * step;
            let near = Location { u: inside(at.u), v: inside(at.v), ..at };
            if let Some(n) = self.surface.eval(near).and_then(|jet| (normal.jet)(&jet)) {
                return n;
            }
        }
        [0.0, 0.0, 1.0]
    }

    /// Points and normals inside all faces.
    pub fn faces(&self, points: &mut [[T; N]], normals: &mut [[T; 3]]) {
        let layout = self.layout;
        let mut tasks = Vec::new();
        let (mut points, mut normals) = (points, normals);
        for faces in layout.face_chunks() {
            let len = layout.face_range(&faces).len();
            let (p, rest) = points.split_at_mut(len);
            points = rest;
            let (n, rest) = normals.split_at_mut(if self.normals.is_some() { len } else { 0 });
            normals = rest;
            tasks.push((faces, p, n));
        }
        tasks.into_par_iter().for_each_init(Vec::new, |ring, (faces, points, normals)| {
            let mut out = Output { points, normals, at: 0 };
            for f in faces.map(Face).filter(|&f| !layout.table.topology().is_hole(f)) {
                self.face(f, ring, &mut out);
            }
        });
    }

    fn face(&self, f: Face, ring: &mut Vec<[f64; N]>, out: &mut Output<'_, T, N>) {
        let subfaces = self.layout.table.subfaces(f);
        if subfaces > 1 {
            let n = self.layout.grid(f, 0).cells[0];
            out.push(self.single(Location { face: f, subface: 0, u: 1.0, v: 1.0 }));
            for subface in 0..subfaces {
                for k in 1..n {
                    let v = f64::from(k) / f64::from(n);
                    out.push(self.single(Location { face: f, subface, u: 1.0, v }));
                }
            }
        }
        for subface in 0..subfaces {
            let grid = self.layout.grid(f, subface);
            if grid.points() > 0 {
                self.patch(f, subface, grid, ring, out);
            }
        }
    }

    /// The interior samples of one patch, row by row in v.
    fn patch(&self, face: Face, subface: u32, grid: PatchGrid, ring: &mut Vec<[f64; N]>, out: &mut Output<'_, T, N>) {
        let table = self.layout.table;
        let patch = table.patch(face, subface);
        let plan = table.patch_plan(patch).expect("holes have no samples");
        let turn = table.turn(patch);
        if let Some(points) = table.plan(plan).regular_points() {
            let base = self.surface.gather(patch, ring);
            let mut control = [[0.0; N]; 16];
            for (k, p) in control.iter_mut().enumerate() {
                for (c, w) in points.row(k) {
                    (0..N).for_each(|i| p[i] += w * ring[c as usize][i]);
                }
            }
            return self.bicubic(&turned_grid(control, turn), base, grid.cells, out);
        }
        let mut last = LastPole::default();
        for (i, j) in grid.interior() {
            let [u, v] = grid.uv(i, j);
            out.push(self.single_after(Location { face, subface, u, v }, &mut last));
        }
    }

    /// A bicubic patch in separable form: four curves in v per column, then one curve in u per sample.
    fn bicubic(&self, control: &[[f64; N]; 16], base: [f64; N], [nu, nv]: [u32; 2], out: &mut Output<'_, T, N>) {
        let bases = |n: u32| -> Vec<[[f64; 4]; 3]> { (0..=n).map(|i| cubic(f64::from(i) / f64::from(n))).collect() };
        let along_u = bases(nu);
        for j in 1..nv {
            let v = cubic(f64::from(j) / f64::from(nv));
            let mut column = [[[0.0; N]; 4]; 2];
            for (order, column) in column.iter_mut().enumerate().take(if self.normals.is_some() { 2 } else { 1 }) {
                for x in 0..4 {
                    for y in 0..4 {
                        (0..N).for_each(|i| column[x][i] += v[order][y] * control[4 * y + x][i]);
                    }
                }
            }
            for basis in &along_u[1..nu as usize] {
                let combine = |w: &[f64; 4], c: &[[f64; N]; 4]| -> [f64; N] {
                    std::array::from_fn(|i| w[0] * c[0][i] + w[1] * c[1][i] + w[2] * c[2][i] + w[3] * c[3][i])
                };
                let p = combine(&basis[0], &column[0]);
                let position = std::array::from_fn(|i| base[i] + p[i]);
                let normal = self.normals.as_ref().map_or([0.0; 3], |normal| {
                    let (du, dv) = (combine(&basis[1], &column[0]), combine(&basis[0], &column[1]));
                    (normal.tangents)(du, dv).unwrap_or([0.0, 0.0, 1.0])
                });
                out.push((position, normal));
            }
        }
    }
}

/// The 4×4 grid of a plan as seen from a face whose corner `turn` is the plan's corner 0.
fn turned_grid<const N: usize>(control: [[f64; N]; 16], turn: u8) -> [[f64; N]; 16] {
    let mut out = control;
    for y in 0..4usize {
        for x in 0..4usize {
            // Face coordinates to plan coordinates, as for parameters.
            let (a, b) = match turn {
                0 => (x, y),
                1 => (y, 3 - x),
                2 => (3 - x, 3 - y),
                _ => (3 - y, x),
            };
            out[4 * y + x] = control[4 * b + a];
        }
    }
    out
}

struct Output<'a, T, const N: usize> {
    points: &'a mut [[T; N]],
    normals: &'a mut [[T; 3]],
    at: usize,
}

impl<T: Real, const N: usize> Output<'_, T, N> {
    fn push(&mut self, (position, normal): Sample<N>) {
        self.points[self.at] = round(position);
        if let Some(n) = self.normals.get_mut(self.at) {
            *n = round(normal);
        }
        self.at += 1;
    }
}
