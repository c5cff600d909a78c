//! Normals to shade with: smooth blended subdivision shading.
//!
//! The normal `n_L` of the limit surface is continuous, but next to extraordinary vertices it turns without bound, which
//! shows in highlights and reflections. Normals that are subdivided like positions, `n_S` (Alexa, Boubekeur 2008), are
//! smooth there but wash detail out. A blend has the best of both (Bakker, Barendrecht, Kosinka 2018, equation 1):
//!
//! ```text
//! n_B = (1 - b^p) n_L + b^p n_S,  at unit length
//! ```
//!
//! with a blend weight b that is 1 at extraordinary vertices and 0 some rings away. `n_S` and b are fields over the same
//! plans that positions have: rows of values at vertices, evaluated by a [`PatchTable`]. Decisions at creases, boundaries
//! and polygons, and measured continuity: `docs/theory/blended-normals.md`.

mod blend;
mod field;
mod levels;
mod options;
mod patterns;
mod sectors;
mod spherical;
mod vertex_normals;

use crate::limit::{Jet, Location, PatchTable};
use crate::real::Real;
use crate::refine::Level;
use crate::topology::Topology;
use field::FieldTable;
use levels::Levels;
use options::check;
pub use options::{Averaging, Blend, NormalField, Power, ShadingError, ShadingOptions};
pub(crate) use patterns::Patterns;
use std::sync::Arc;
use vertex_normals::unit;

/// What depends on connectivity alone.
struct Shared<'a> {
    mesh: &'a Topology,
    /// Number of vertices of the mesh.
    points: usize,
    /// The tables of the fields: the first has the weights, the last the normals; one for both where they start alike.
    tables: Vec<FieldTable<'a>>,
    /// Per value of the first table: b.
    weights: Vec<[f64; 1]>,
    /// Per patch of the first table: true where b is not 0 all over it.
    is_blended: Vec<bool>,
    /// Per value of the first table: p, where it is not one for all.
    powers: Vec<[f64; 1]>,
    power: f64,
    /// The mesh up to the level whose vertex normals are taken.
    whole: Vec<Arc<Level>>,
    /// The same cut into sectors, from that level on to the one that the normals' table starts at.
    cut: Vec<Arc<Level>>,
}

/// Normals to shade with, at any place of a limit surface.
///
/// ```
/// use subsurf::{Location, PatchTable, Scheme, ShadingNormals, ShadingOptions, TessellateOptions, shapes};
///
/// let cube = shapes::cube();
/// let patches = PatchTable::new(&cube.mesh, Scheme::CatmullClark)?; // once per connectivity
/// let surface = patches.surface(&cube.positions);
/// let shading = ShadingNormals::new(&patches, &cube.positions, &ShadingOptions::default())?;
///
/// let corner = Location::new(0, 0.0, 0.0); // three edges meet here: an extraordinary vertex
/// let jet = surface.eval(corner).expect("face 0 is no hole");
/// let normal = shading.normal(corner, &jet).expect("the surface is smooth there");
/// assert_eq!(shading.blend_weight(corner), 1.0);
/// assert!((normal[2] + 3f64.sqrt() / 3.0).abs() < 1e-15);
///
/// let mesh = surface.tessellate_shaded(&TessellateOptions::default(), &shading)?;
/// assert_eq!(mesh.normals.len(), mesh.positions.len());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct ShadingNormals<'a> {
    /// None where the limit normal is what was asked for.
    shared: Option<Arc<Shared<'a>>>,
    /// Per value of the last table: `n_S`, and b where the table is the first one too.
    rows: Vec<[f64; 4]>,
}

impl<'a> ShadingNormals<'a> {
    /// Normals of the surface of `patches` with these control points, whose vertex normals are the area-weighted means of
    /// face normals.
    ///
    /// # Errors
    /// [`ShadingError`] says which option does not fit.
    ///
    /// # Panics
    /// If `positions` has not one row per vertex of the mesh.
    pub fn new<T: Real>(
        patches: &'a PatchTable,
        positions: &[[T; 3]],
        options: &ShadingOptions,
    ) -> Result<Self, ShadingError> {
        let shared = Shared::new(patches, options)?.map(Arc::new);
        Ok(Self { shared, rows: Vec::new() }.with_positions(positions))
    }

    /// The same with the vertex normals that a mesh brings along: `corners` has an index into `normals` per face corner.
    /// At every vertex those of a sector are averaged: the surface decides where it is sharp. [`with_positions`] then
    /// takes none of these but those of its positions.
    ///
    /// [`with_positions`]: Self::with_positions
    ///
    /// # Errors
    /// [`ShadingError`] says which option, corner or normal does not fit.
    pub fn from_normals<T: Real>(
        patches: &'a PatchTable,
        normals: &[[T; 3]],
        corners: &[u32],
        options: &ShadingOptions,
    ) -> Result<Self, ShadingError> {
        let expected = patches.topology().half_edge_count();
        if corners.len() != expected {
            return Err(ShadingError::CornerCount { given: corners.len(), expected });
        }
        if let Some(corner) = corners.iter().position(|&n| n as usize >= normals.len()) {
            return Err(ShadingError::NormalOutOfRange { corner, normal: corners[corner], normals: normals.len() });
        }
        if options.normals_level > 0 {
            return Err(ShadingError::OwnNormalsLevel { level: options.normals_level });
        }
        let Some(shared) = Shared::new(patches, options)? else { return Ok(Self { shared: None, rows: Vec::new() }) };
        let start = vertex_normals::of_corners(shared.cut[0].topology(), normals, corners);
        let rows = shared.rows(start);
        Ok(Self { shared: Some(Arc::new(shared)), rows })
    }

    /// The same normals for other control points of the same mesh: once per frame.
    ///
    /// # Panics
    /// If `positions` has not one row per vertex of the mesh.
    #[must_use]
    pub fn with_positions<T: Real>(&self, positions: &[[T; 3]]) -> Self {
        let Some(shared) = &self.shared else { return self.clone() };
        assert_eq!(positions.len(), shared.points, "one control point per vertex of the mesh");
        let (last, before) = shared.whole.split_last().expect("level 0 at least");
        let points = positions.iter().map(|p| p.map(T::to_f64)).collect();
        let points: Vec<[f64; 3]> = before.iter().fold(points, |points, level| level.refine_values(&points));
        let start = vertex_normals::of_positions(last.topology(), shared.cut[0].topology(), &points);
        Self { rows: shared.rows(start), shared: self.shared.clone() }
    }

    /// The normal at `at`, whose jet on the surface is `jet`; none in holes, and where there is none to blend: at cone
    /// points, say.
    ///
    /// # Panics
    /// If the location names no sub-face of the mesh.
    pub fn normal(&self, at: Location, jet: &Jet<3>) -> Option<[f64; 3]> {
        self.blend(at, jet.normal(), None)
    }

    /// The subdivided normal `n_S` at unit length; none in holes, where it vanishes, and where [`NormalField::Limit`]
    /// was asked for.
    ///
    /// # Panics
    /// If the location names no sub-face of the mesh.
    pub fn subdivided(&self, at: Location) -> Option<[f64; 3]> {
        let table = self.shared.as_ref()?.tables.last()?;
        let place = table.locate(self.shared.as_ref()?.mesh, at);
        direction(table.weights(place, None)?.sum(&self.rows))
    }

    /// The blend weight b in [0, 1], before it is raised to the power p; 0 in holes.
    ///
    /// # Panics
    /// If the location names no sub-face of the mesh.
    pub fn blend_weight(&self, at: Location) -> f64 {
        self.shared.as_ref().and_then(|s| s.weight(at)).unwrap_or(0.0)
    }

    /// The power p of the blend weight.
    ///
    /// # Panics
    /// If the location names no sub-face of the mesh.
    pub fn power(&self, at: Location) -> f64 {
        self.shared.as_ref().map_or(1.0, |s| s.power(at))
    }

    /// The level that blend weights start at: that of the options, or a finer one that they need.
    pub fn weights_level(&self) -> u32 {
        self.shared.as_ref().map_or(0, |s| s.tables[0].depth)
    }

    /// True where these are the normals of the limit surface, unchanged.
    pub fn is_limit(&self) -> bool {
        self.shared.is_none()
    }

    /// True where these are normals over a mesh with the faces of `t`.
    pub(crate) fn fits(&self, t: &Topology) -> bool {
        self.shared
            .as_ref()
            .is_none_or(|s| s.mesh.face_offsets() == t.face_offsets() && s.mesh.corners() == t.corners())
    }

    /// Weights for the samples of a uniform tessellation, one list per table.
    pub(crate) fn patterns(&self, cells: [u32; 2]) -> Vec<Patterns> {
        self.shared.iter().flat_map(|s| &s.tables).map(|table| Patterns::new(table, cells)).collect()
    }

    /// `n_B` from `n_L`.
    pub(crate) fn blend(
        &self,
        at: Location,
        limit: Option<[f64; 3]>,
        patterns: Option<&[Patterns]>,
    ) -> Option<[f64; 3]> {
        let Some(shared) = &self.shared else { return limit };
        let first = &shared.tables[0];
        let place = first.locate(shared.mesh, at);
        if !shared.is_blended[place.0] {
            return limit;
        }
        let weights = first.weights(place, patterns.map(|p| &p[0]))?;
        let (b, n) = match &shared.tables[1..] {
            [] => {
                let row = weights.sum(&self.rows);
                (row[3], direction(row))
            }
            [normals, ..] => {
                let [b] = weights.sum(&shared.weights);
                let place = normals.locate(shared.mesh, at);
                let row =
                    if b > 0.0 { normals.weights(place, patterns.map(|p| &p[1]))?.sum(&self.rows) } else { [0.0; 4] };
                (b, direction(row))
            }
        };
        let p = if shared.powers.is_empty() { shared.power } else { weights.sum(&shared.powers)[0] };
        let w = raise(b.clamp(0.0, 1.0), p);
        let (Some(limit), Some(subdivided)) = (limit, n) else { return if w >= 1.0 { n.or(limit) } else { limit } };
        if w == 0.0 {
            return Some(limit);
        }
        let blended = unit(std::array::from_fn(|i| (1.0 - w) * limit[i] + w * subdivided[i]));
        // Opposite normals of equal weight.
        Some(if blended == [0.0; 3] { limit } else { blended })
    }
}

/// `b^p`, exact for p = 1 and at both ends.
fn raise(b: f64, p: f64) -> f64 {
    if p == 1.0 { b } else { b.powf(p) }
}

fn direction([x, y, z, _]: [f64; 4]) -> Option<[f64; 3]> {
    let n = unit([x, y, z]);
    (n != [0.0; 3]).then_some(n)
}

impl<'a> Shared<'a> {
    fn new(patches: &'a PatchTable, options: &ShadingOptions) -> Result<Option<Self>, ShadingError> {
        let mesh = patches.topology();
        check(mesh, options)?;
        let blend = match options.field {
            NormalField::Limit => return Ok(None),
            NormalField::Subdivided => None,
            NormalField::Blended(blend) => Some(blend),
        };
        let mut levels = Levels::new(patches, options.crease_sharpness)?;
        let start = options.normals_level;
        let normals_depth = start
            + match options.averaging {
                Averaging::Linear => 0,
                Averaging::Spherical(levels) => levels.min(u32::MAX - start),
            };
        levels.cut(normals_depth, "normals")?;
        levels.whole(start, "normals")?;
        let mut depth = if blend.is_some() { options.weights_level } else { start };
        levels.cut(depth, "blend weights")?;
        while blend.is_some_and(|blend| !blend::is_ready(blend, &levels, depth)) {
            depth += 1;
            levels.cut(depth, "blend weights")?;
        }

        let is_linear = blend == Some(Blend::A1);
        let mut tables = vec![levels.table(depth, is_linear)?];
        if normals_depth != depth || is_linear {
            tables.push(levels.table(normals_depth, false)?);
        }
        let weights = match blend {
            Some(blend) => blend::weights(blend, &levels, &tables[0]),
            None => levels.locked(depth).iter().map(|&locked| if locked { 0.0 } else { 1.0 }).collect(),
        };
        let table: &PatchTable = &tables[0].table;
        let is_blended = (0..table.patch_count())
            .map(|patch| table.ring(patch).iter().any(|&v| weights[v as usize] > 0.0))
            .collect();
        let power = if let Power::Uniform(p) = options.power { p } else { 1.0 };
        Ok(Some(Self {
            mesh,
            points: mesh.vertex_count(),
            is_blended,
            powers: powers(&options.power, mesh, &levels, depth),
            power,
            whole: levels.whole_up_to(start),
            cut: levels.cut_between(start, normals_depth),
            weights: weights.into_iter().map(|b| [b]).collect(),
            tables,
        }))
    }

    /// The rows of the normals' table, from normals at the level where they start.
    fn rows(&self, start: Vec<[f64; 3]>) -> Vec<[f64; 4]> {
        let mut normals = start;
        for pair in self.cut.windows(2) {
            let (t, next) = (&pair[0], pair[1].topology());
            normals = spherical::refine(t.topology(), self.tables[0].table.scheme(), &normals, next.vertex_count());
        }
        let weights = if self.tables.len() == 1 { self.weights.clone() } else { vec![[0.0]; normals.len()] };
        normals.into_iter().zip(weights).map(|([x, y, z], [b])| [x, y, z, b]).collect()
    }

    fn weight(&self, at: Location) -> Option<f64> {
        let place = self.tables[0].locate(self.mesh, at);
        let [b] = self.tables[0].weights(place, None)?.sum(&self.weights);
        Some(b.clamp(0.0, 1.0))
    }

    fn power(&self, at: Location) -> f64 {
        let place = self.tables[0].locate(self.mesh, at);
        match self.tables[0].weights(place, None) {
            Some(weights) if !self.powers.is_empty() => weights.sum(&self.powers)[0],
            _ => self.power,
        }
    }
}

/// Powers of all values of level `depth`; none where there is one for all.
fn powers(power: &Power, mesh: &Topology, levels: &Levels<'_>, depth: u32) -> Vec<[f64; 1]> {
    let sectors = &levels.sectors;
    let start = match power {
        Power::Uniform(_) => return Vec::new(),
        Power::PerVertex(powers) => sectors.vertex.iter().map(|&v| [powers[v as usize]]).collect(),
        Power::PerFace(powers) => {
            let mut sum = vec![(0.0, 0.0); sectors.len()];
            for (&value, face) in sectors.corner.iter().zip((0..).map(|h| mesh.face.get(h))) {
                let (sum, count) = &mut sum[value as usize];
                (*sum, *count) = (*sum + powers[face as usize], *count + 1.0);
            }
            // Vertices without faces have no say.
            sum.into_iter().map(|(sum, count)| [if count > 0.0 { sum / count } else { 1.0 }]).collect()
        }
    };
    levels.refine_values(start, depth)
}
