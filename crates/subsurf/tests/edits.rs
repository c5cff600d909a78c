//! A table that was edited is the table of the edited mesh.

mod random_mesh;

use proptest::prelude::*;
use random_mesh::{Recipe, SHARPNESS, for_all, random_points, recipe, triangle_recipe};
use subsurf::{
    ControlMesh, EditError, Face, Facets, Location, PatchTable, Rates, Scheme, TableEditor, Tags, TessellateOptions,
    shapes,
};

/// One edit, of whatever elements the numbers fall on.
#[derive(Clone, Copy, Debug)]
enum Step {
    Crease(u16, u8),
    Corner(u16, u8),
    Hole(u16, bool),
    TakeOut(u16),
    /// Puts the last face that was taken out back in, or its mirror image.
    PutBack(bool),
    /// Cuts a face from a corner to the one after the next.
    Cut(u16, u8),
    /// Triangles round a new vertex.
    Star(u16),
    /// Two triangles that share an edge change it.
    Flip(u16),
}

fn step() -> impl Strategy<Value = Step> {
    let x = any::<u16>;
    prop_oneof![
        4 => (x(), any::<u8>()).prop_map(|(e, s)| Step::Crease(e, s)),
        2 => (x(), any::<u8>()).prop_map(|(v, s)| Step::Corner(v, s)),
        1 => (x(), any::<bool>()).prop_map(|(f, h)| Step::Hole(f, h)),
        2 => x().prop_map(Step::TakeOut),
        2 => any::<bool>().prop_map(Step::PutBack),
        2 => (x(), any::<u8>()).prop_map(|(f, c)| Step::Cut(f, c)),
        1 => x().prop_map(Step::Star),
        1 => x().prop_map(Step::Flip),
    ]
}

struct Session {
    editor: TableEditor,
    /// Vertices of all faces by their number; none where a face was taken out.
    faces: Vec<Option<Vec<u32>>>,
    last: Option<Vec<u32>>,
}

impl Session {
    fn new(mesh: &ControlMesh, scheme: Scheme) -> Self {
        let faces = mesh.faces().map(|f| Some(f.to_vec())).collect();
        Self { editor: TableEditor::new(mesh, scheme).unwrap(), faces, last: None }
    }

    fn live(&self) -> Vec<u32> {
        (0..self.faces.len() as u32).filter(|&f| self.faces[f as usize].is_some()).collect()
    }

    fn face(&self, i: u16) -> Option<(u32, Vec<u32>)> {
        let live = self.live();
        let f = *live.get(usize::from(i) % live.len().max(1))?;
        Some((f, self.faces[f as usize].clone()?))
    }

    fn replace(&mut self, old: &[u32], new: &[Vec<u32>]) {
        let lists: Vec<&[u32]> = new.iter().map(Vec::as_slice).collect();
        let edited = self.editor.replace_faces(old, &lists).unwrap();
        old.iter().for_each(|&f| self.last = self.faces[f as usize].take());
        assert_eq!(edited.added.len(), new.len());
        for (face, vertices) in edited.added.iter().zip(new) {
            self.faces.resize(self.faces.len().max(face.index() + 1), None);
            assert!(self.faces[face.index()].replace(vertices.clone()).is_none(), "{face} was there");
        }
    }

    fn apply(&mut self, step: Step, scheme: Scheme) {
        let value = |s: u8| if s < 40 { 0.0 } else { SHARPNESS[usize::from(s) % SHARPNESS.len()] };
        let triangles = scheme == Scheme::Loop;
        match step {
            Step::Crease(i, s) => {
                let Some((_, f)) = self.face(i) else { return };
                let k = usize::from(s) % f.len();
                let (a, b) = (f[k], f[(k + 1) % f.len()]);
                if a != b {
                    self.editor.set_creases(&[(a, b)], value(s)).unwrap();
                }
            }
            Step::Corner(v, s) => {
                let v = u32::from(v) % self.editor.table().topology().vertex_count() as u32;
                self.editor.set_corner(v, value(s)).unwrap();
            }
            Step::Hole(i, hole) => {
                let Some((f, _)) = self.face(i) else { return };
                self.editor.set_hole(f, hole).unwrap();
            }
            Step::TakeOut(i) => {
                let Some((f, _)) = self.face(i).filter(|_| self.live().len() > 1) else { return };
                self.replace(&[f], &[]);
            }
            Step::PutBack(mirror) => {
                let Some(mut f) = self.last.take() else { return };
                if mirror {
                    f.reverse();
                }
                self.replace(&[], &[f]);
            }
            Step::Cut(i, c) => {
                let Some((number, mut f)) = self.face(i).filter(|(_, f)| f.len() > 3) else { return };
                let n = f.len();
                f.rotate_left(usize::from(c) % n);
                self.replace(&[number], &[f[..3].to_vec(), [&f[..1], &f[2..]].concat()]);
            }
            Step::Star(i) => {
                let Some((number, f)) = self.face(i) else { return };
                let centre = self.editor.add_vertex().unwrap().0;
                let star: Vec<Vec<u32>> = (0..f.len()).map(|k| vec![f[k], f[(k + 1) % f.len()], centre]).collect();
                self.replace(&[number], &star);
            }
            Step::Flip(i) => {
                let Some((a, f)) = self.face(i).filter(|(_, f)| f.len() == 3) else { return };
                let other = self.live().into_iter().find_map(|b| {
                    let g = self.faces[b as usize].clone()?;
                    let far = (0..g.len()).find(|&k| g[k] == f[1] && g[(k + 1) % g.len()] == f[0])?;
                    (b != a && g.len() == 3).then(|| (b, g[(far + 2) % 3]))
                });
                let Some((b, d)) = other.filter(|&(_, d)| d != f[2]) else { return };
                self.replace(&[a, b], &[vec![f[0], d, f[2]], vec![d, f[1], f[2]]]);
            }
        }
        debug_assert!(!triangles || self.faces.iter().flatten().all(|f| f.len() == 3));
    }

    /// Compares with a table that is built anew.
    fn check(&self, scheme: Scheme, seed: u64) -> Result<(), String> {
        let table = self.editor.table();
        table.topology().check()?;
        let mesh = self.editor.mesh().map_err(|e| e.to_string())?;
        let live = self.live();
        let same = mesh.faces().zip(&live).all(|(f, &g)| Some(f) == self.faces[g as usize].as_deref());
        if mesh.face_count() != live.len() || !same {
            return Err("the mesh has other faces".into());
        }
        let fresh = PatchTable::new(&mesh, scheme).map_err(|e| e.to_string())?;
        let positions = random_points(mesh.vertex_count(), seed);
        let (a, b) = (table.surface(&positions), fresh.surface(&positions));
        let near = |p: [f64; 3], q: [f64; 3]| (0..3).all(|i| (p[i] - q[i]).abs() <= 1e-12 * (1.0 + q[i].abs()));
        for (f, &g) in live.iter().enumerate() {
            for (k, (u, v)) in [(0.3, 0.6), (1e-7, 3e-7), (0.0, 0.7)].into_iter().enumerate() {
                let subfaces = fresh.subfaces(Face::new(f));
                let at = |face: u32| Location { face: Face(face), subface: k as u32 % subfaces, u, v };
                match (a.eval(at(g)), b.eval(at(f as u32))) {
                    (None, None) => {}
                    (Some(a), Some(b)) if near(a.position, b.position) && near(a.du, b.du) && near(a.dv, b.dv) => {}
                    (a, b) => return Err(format!("face {g} at ({u}, {v}): {a:?}, anew {b:?}")),
                }
            }
        }
        // The same facets in the same order.
        let options = TessellateOptions { rates: Rates::Uniform(2), facets: Facets::Triangles, ..Default::default() };
        let (a, b) = (a.tessellate(&options).unwrap(), b.tessellate(&options).unwrap());
        let at = |corners: &[u32], points: &[[f64; 3]]| corners.iter().map(|&c| points[c as usize]).collect::<Vec<_>>();
        let (p, q) = (at(&a.corners, &a.positions), at(&b.corners, &b.positions));
        if p.len() != q.len() || !p.iter().zip(&q).all(|(&p, &q)| near(p, q)) {
            return Err("the tessellations differ".into());
        }
        Ok(())
    }
}

fn edited_tables_are_those_of_the_edited_mesh(
    recipes: impl Strategy<Value = Recipe>,
    scheme: Scheme,
    cases: u32,
    seed: u64,
) {
    let steps = proptest::collection::vec(step(), 1..12);
    for_all((recipes, steps), cases, seed, |(recipe, steps)| {
        let mut session = Session::new(&recipe.mesh().mesh, scheme);
        for (i, &step) in steps.iter().enumerate() {
            session.apply(step, scheme);
            session.check(scheme, i as u64).map_err(|e| format!("after {:?}: {e}", &steps[..=i]))?;
        }
        Ok(())
    });
}

#[test]
fn edited_quads_and_polygons_are_those_of_the_edited_mesh() {
    edited_tables_are_those_of_the_edited_mesh(recipe(), Scheme::CatmullClark, 120, 5);
}

#[test]
fn edited_triangles_are_those_of_the_edited_mesh() {
    edited_tables_are_those_of_the_edited_mesh(triangle_recipe(), Scheme::Loop, 50, 6);
}

#[test]
fn edited_bilinear_meshes_are_those_of_the_edited_mesh() {
    edited_tables_are_those_of_the_edited_mesh(recipe(), Scheme::Bilinear, 25, 7);
}

#[test]
fn the_work_of_an_edit_does_not_grow_with_the_mesh() {
    let work = |n: u32| {
        let grid = shapes::grid(n, n);
        let mut editor = TableEditor::new(&grid.mesh, Scheme::CatmullClark).unwrap();
        // The face in the middle, and an edge beside it.
        let middle = n / 2 * n + n / 2;
        let f = grid.mesh.face_vertices(middle as usize).to_vec();
        let crease = editor.set_creases(&[(f[0], f[1])], 2.5).unwrap();
        let cut = editor.replace_faces(&[middle], &[&[f[0], f[1], f[2]], &[f[0], f[2], f[3]]]).unwrap();
        [crease, cut].map(|edited| (edited.rebuilt.len(), edited.nodes))
    };
    let small = work(12);
    // Six faces touch an edge of a grid, and nine a face, one of which is two now.
    assert_eq!([small[0].0, small[1].0], [6, 10]);
    assert_eq!(small, work(60));
}

#[test]
fn known_surroundings_are_not_compiled_again() {
    let grid = shapes::grid(12, 12);
    let mut editor = TableEditor::new(&grid.mesh, Scheme::CatmullClark).unwrap();
    let edge = |face: usize| (grid.mesh.face_vertices(face)[0], grid.mesh.face_vertices(face)[1]);
    assert!(editor.set_creases(&[edge(40)], 1.5).unwrap().nodes > 0);
    assert_eq!(editor.set_creases(&[edge(90)], 1.5).unwrap().nodes, 0);
    assert_eq!(editor.set_creases(&[edge(40), edge(90)], 0.0).unwrap().nodes, 0);
}

#[test]
fn a_place_is_used_again_by_a_face_of_as_many_corners() {
    let cube = shapes::cube();
    let mut editor = TableEditor::new(&cube.mesh, Scheme::CatmullClark).unwrap();
    let f = cube.mesh.face_vertices(2).to_vec();
    editor.replace_faces(&[2], &[]).unwrap();
    assert_eq!(editor.replace_faces(&[], &[&f[..3]]).unwrap().added, [Face(6)]);
    assert_eq!(editor.replace_faces(&[6], &[&f]).unwrap().added, [Face(2)]);
    assert_eq!(editor.mesh().unwrap(), cube.mesh);
}

#[test]
fn bad_edits_are_refused_and_change_nothing() {
    let cube = shapes::cube();
    let mut editor = TableEditor::new(&cube.mesh, Scheme::CatmullClark).unwrap();
    let refuse = |e: EditError, text: &str| assert_eq!(e.to_string(), text);
    refuse(editor.set_creases(&[(0, 1), (0, 7)], 2.0).unwrap_err(), "no edge joins vertices 0 and 7");
    refuse(editor.set_creases(&[(0, 80)], 2.0).unwrap_err(), "no edge joins vertices 0 and 80");
    refuse(
        editor.set_creases(&[(0, 1)], f64::NAN).unwrap_err(),
        "the sharpness is NaN; use a finite number, 10 for infinitely sharp",
    );
    refuse(editor.set_corner(8, 1.0).unwrap_err(), "there is no vertex 8: the mesh has 8 (they count from 0)");
    refuse(editor.replace_faces(&[9], &[]).unwrap_err(), "there is no face 9");
    refuse(editor.replace_faces(&[0], &[&[0, 1]]).unwrap_err(), "new face 0 has 2 corners; at least 3 are needed");
    assert_eq!(
        editor.mesh().unwrap(),
        ControlMesh::new(&cube.mesh.faces().collect::<Vec<_>>(), Tags::default()).unwrap()
    );
}
