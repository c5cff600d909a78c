//! Pictures of surfaces on the CPU: anti-aliased, in soft light, with exact normals in every sample.
//!
//! A [`RenderMesh`] says where the surface is, a [`SurfaceShader`] what it looks like: the renderer casts rays at the
//! triangles and asks the shader for normal and colour where they hit, by face and surface parameters. An [`Overlay`]
//! adds lines, dots and a legend, [`Options`] hold size, camera and background, and the [`Image`] writes itself as PNG.
//!
//! ```
//! use subsurf_render::{Faceted, Options, Overlay, RenderMesh, render};
//!
//! let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
//! let tetrahedron = RenderMesh::from_triangles(positions, &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]);
//! let options = Options { width: 64, height: 48, samples: 4, ..Options::default() };
//! let image = render(&tetrahedron, &Faceted, &Overlay::default(), &options, None)?;
//!
//! let mut png = Vec::new();
//! image.write_png(&mut png)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The pipeline, in the order of its files: `mesh`, [`bvh`] (rays against triangles), `camera`, `sampler` (points in
//! a pixel), `shader`, `stripes`, `light` (the studio), `trace` (samples of a pixel), `smooth` (of visibility over the surface),
//! `overlay`, `legend`, `image`; `scene` runs it. Work is shared among rayon's threads, and the picture is the same to
//! the bit for any number of them.
//!
//! Limits: one mesh, opaque, no textures; light bounces only by an estimate.

#![forbid(unsafe_code)]

pub mod bvh;
mod camera;
mod error;
mod image;
mod legend;
mod light;
mod mesh;
mod overlay;
pub mod palette;
mod sampler;
mod scene;
mod shader;
mod show;
mod smooth;
mod stripes;
mod trace;

pub use camera::{Camera, CameraParseError, View};
pub use error::{MAX_PIXELS, MAX_SAMPLES, MAX_SIDE, RenderError, SceneError};
pub use image::Image;
pub use legend::Legend;
pub use mesh::{RenderMesh, RenderTriangle};
pub use overlay::{Dot, Overlay, Polyline, Stroke};
pub use scene::{Background, Options, Progress, Scene, render};
pub use shader::{Faceted, SurfaceAt, SurfacePoint, SurfaceShader, VertexNormals};
pub use show::{Show, ShowParseError};
pub use stripes::{MAX_STRIPES, Phase, Stripes};
