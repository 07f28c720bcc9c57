//! ballstick shows molecules as balls and sticks: it reads molecule files, knows their bonds, and draws them exactly, in a
//! window or as a picture, with or without a graphics card.
//!
//! ```
//! use ballstick::render::{Choice, Quality, View, select};
//! use ballstick::scene::{Item, Scene, SceneOptions};
//! use std::sync::Arc;
//!
//! // bytes → structure → structure with bonds
//! let water = b"3\nwater\nO 0 0 0.12\nH 0 0.76 -0.47\nH 0 -0.76 -0.47\n";
//! let document = ballstick::import::read_bytes(water, "water.xyz", &Default::default())?;
//! let molecule = ballstick::bonds::assign(document.records[0].clone(), &Default::default());
//! assert_eq!(molecule.bonds().len(), 2);
//!
//! // → scene → picture
//! let scene = Arc::new(Scene::new(&[Item::of(&molecule)], &SceneOptions::default()));
//! let view = View::new(scene.fitted_camera(4.0 / 3.0), 64, 48);
//! let mut renderer = select(Choice::Cpu)?.renderer;
//! renderer.load(scene)?;
//! let image = renderer.image(&view, &Quality::Draft.settings())?;
//! assert_eq!((image.width, image.height, image.rgba.len()), (64, 48, 64 * 48 * 4));
//! # Ok::<(), ballstick::Error>(())
//! ```
//!
//! # One way through the code
//!
//! ```text
//! bytes ──import──▶ Structure ──bonds, crystal──▶ what is drawn ──scene──▶ Scene (primitives, camera, lights, ground)
//!                                                                     │ the same instance bytes
//!                                                    render::cpu ◀────┴────▶ render::gpu
//!                                                         └──────▶ Image / window ◀┘
//! ```
//!
//! Modules import only from those before them in this list; a test keeps it so.
//!
//! | layer | what it owns |
//! |---|---|
//! | [`math`], [`color`], [`element`], [`error`] | geometry, the only sRGB conversion, the element table, errors by whose fault they are |
//! | [`stop`] | the flag by which long work is given up |
//! | [`structure`] | the molecular model: structure of arrays, immutable once built |
//! | [`import`], [`bonds`] | bytes to structures (and triangle meshes, [`import::mesh`], and frames of trajectories, [`import::trajectory`], which has a table of their formats), never guessing a bond; structures to bonds, never reading a file |
//! | [`crystal`] | which copies of a structure's atoms are drawn: whole molecules, cells, supercells, assemblies |
//! | [`select`] | atoms by words, as in `chain A and not water`: the language, its errors and completions |
//! | [`scene`] | blocks of primitives × placements, styles, colours, arrows, overlays, camera, light, ground; knows no renderer |
//! | [`render`] | the definition of the picture ([`render::frame`]), the CPU renderer, the wgpu renderer, and the choice between them |
//! | [`export`] | picture files, structure files, scenes as solid shapes ([`export::solid`]), atomic writes |
//! | [`session`] | all that makes a picture, as JSON and as a command line |
//! | [`cli`], `app` | the commands, the window; no chemistry |
//!
//! # Spaces and units
//!
//! Lengths are ångström, angles degrees in files and radians (`_rad`) in code, colours sRGB in files and flags and linear in shading.
//! World and view space are right-handed with +Y up; the camera looks down −Z. Matrices are named `dst_from_src`. A view ray has a direction with
//! `z = −1` in both projections, so its parameter `t` is the depth along the view axis. Depth buffers are reversed (near 1, far 0).
//!
//! # The picture
//!
//! There is one definition of the picture, in [`render::frame`] and [`render::field`]; each renderer computes it. `render::cpu::reference` is plain,
//! scalar and single-threaded: it is the truth, and the only writer of golden pictures. `render::cpu::tiles` gives the same bytes on all cores (but for light from afar, see below).
//! `render::gpu` draws the same instance bytes as impostors, with WGSL twins of the Rust functions under the same names; parity tests compare ids, depth,
//! normals and colour.
//!
//! - Spheres, cylinders, cones, tori and triangles are intersected exactly, from a ray origin moved to the primitive
//!   ([`render::cpu::intersect`]); a torus by a march that is safe and near the surface as fast as Newton's.
//! - See-through primitives are drawn in as many of the samples as their opacity says, without sorting, and hide light in as many, so that
//!   shadows have the share of the opacity ([`render::opacity`]); below a half they are not in the channels.
//! - Their bounds on the picture are exact for any projection, off-centre parts included ([`render::bounds`]).
//! - The ground is lit by the scene's distance field: the key light's penumbra from the smallest `sharpness · distance / t` along the way to
//!   the light, and the sky's part from how far the field falls short above the ground ([`render::field`]). Where one would usually march
//!   along the way, each primitive is asked at its own nearest point of it, found through the hierarchy: it is faster and leaves no bands.
//! - Ambient occlusion is the part of the sky that a surface point sees, over 64 fixed directions, without a reach; the key light's shadow
//!   on the molecule is the mean over 16 directions in a cone ([`render::sky`]). The reference casts rays. The
//!   GPU asks the primitives in the tube above a point ([`render::tubes`]); the CPU does so, too, up to some
//!   ten thousand atoms; of larger scenes it sorts all points that ask along a direction, and each primitive asks those under it. All of it by
//!   distances across the direction and heights along it, as exact as rays. The samples of a pixel share the directions out.
//! - A part of a picture ([`render::View::region`]) is byte for byte what it is in the whole: large pictures are made of such parts.
//! - Outlines are flat rims that primitives wear, a little behind their silhouettes ([`render::outline`]); with depth of field every
//!   sample has a camera of its own ([`render::lens`]).
//! - Ground and background are smooth and found once a pixel; what a primitive covers is found and shaded at every sample.
//! - Labels, legend and scale bar are placed in parts of the full picture's height and drawn onto the finished picture, by the same code for both
//!   renderers ([`render::overlay`]).
//!
//! # Known limits
//!
//! - Without hydrogens, which nitrogen of an azole carries one, and keto or enol, is guessed from lengths: about 3 % of such molecules
//!   come out as the other form.
//! - Meshes have no outlines. An outline is as wide along the whole of a stick, however far that runs into the depth.
//! - Depth of field leaves ground and background sharp, and shows faint copies where a blur is wider than 64 samples make smooth.
//! - Finished pictures of large structures take time for the light from afar: on two cores some 2 s at 100,000 atoms and 8 s at 1,000,000.
//!   `--quality draft` goes without.
//! - Copies of an assembly share their atoms in structure and scene, and in the CPU's pictures, finished or in motion. Pictures by a GPU spread
//!   them out.
//! - What others hide is left out on a GPU only where it can compute, of scenes without many copies, and of balls and sticks: cones, rings and
//!   triangles are drawn all. Lists of what is drawn take some 5 bytes a ball and a stick each. Things smaller than a pixel are not merged.
//! - On a GPU whose textures are too small for the primitives, or for the tubes of one sample's directions (about 200,000 atoms
//!   where 2048 texels a side are all), there is no ambient occlusion and no shadow on the molecule.
//! - See-through primitives seen through one another take their samples each by its id, so that two may show a little more or less than
//!   they would by the rules of glass; with 4 samples there are only 4 steps of opacity. Their shadows on the ground do not add up:
//!   the darkest counts.
//! - A coarse mesh with smooth normals shades itself where the light grazes it: its faces are flat.
//! - In a window drawn by a GPU there are no labels while something moves. The rings about picked atoms are drawn over the picture, faint
//!   where something is before the atom, and are not in exports.
//! - Sessions find atoms by their numbers. `--camera` writes one frame and one
//!   view; files that show different frames are one command line only with the same. WebP, PPM, NPY, GIF and MP4 files do not say how they were made; of
//!   trajectories no sums are kept.
//! - A film of frames keeps the camera that fits the first one. In a GIF a pixel is there or not, and has one of 255 colours.
//! - On Wayland without Xwayland pictures cannot be copied.
//! - Selections know distances within what is drawn, not across the faces of a cell, and no secondary structure but what the file states.
//! - A trajectory's bonds are those of its structure file in that file's own coordinates, where a cell counts only if that file states it. Hydrogen bonds across the cell's faces are
//!   not drawn in its frames, nor are networks without end the same atoms in each. Compressed trajectories are unpacked into memory, and `convert` writes none.
//! - Before a large file is read the window shows some of its atoms ([`import::Glimpse`]), but of compressed files and other formats than XYZ, PDB, mmCIF and GRO none, and none over
//!   what is open already. How far reading a file is can be told by its steps only. One that is given up ends soon, but JSON is parsed to its end.
//! - The ground's shadow grades by distance, not by width: a wire's is as dark as a ball's.
//! - Large pictures are drawn in strips, each of which sorts all primitives anew. JPEG and WebP are gathered in memory, 3 or 4 bytes a
//!   pixel. If a device is lost in the middle, the CPU draws the rest of the picture, while its metadata names the device.
//! - One opacity cannot serve every way of laying pictures over one another: edges of transparent pictures are exact where light is
//!   added in linear space, the ground's shadow where sRGB values are, as most programs do; there, edges on white look a little darker. Edge samples brighter than white are cut after the mean, not before.
//! - A truncated single-frame XYZ file is refused, not shown in part.
//! - Symmetry is applied where the file lists its operations (CIF of small molecules, REMARK 290 of PDB), not from the name of the
//!   space group, which is all that mmCIF files of proteins give. A protein is drawn as listed unless `--cell full` asks for the
//!   crystal.
//! - Copies of an assembly have the colours, styles and selections of the one that is listed; bonds between copies are not drawn. Words select atoms of
//!   the first copy, clicks and rectangles those of any; what is done with them holds in all copies.
//! - Formal charges of metals are not told, nor those of acids and amines whose hydrogens a file leaves out. Nitrides and carbenes on
//!   metals have single bonds or dashes.
//! - Dative bonds do not keep which atom gives the pair.
//! - What a packed file unpacks to, and what light from afar takes, is not known when memory is asked for. Under a limit of the process (`ulimit -v`,
//!   `ulimit -d`) each input is tried in a process of its own, twice if need be, and one that runs out of memory is an error like any other; where a container or
//!   the machine has none left, the system ends the program by a signal (137), and nothing is left half done. The window does not ask. Graphics drivers do not look
//!   whether they get memory: where `ulimit -v` leaves less than 4 GB, pictures are drawn by the CPU. Below some 50 MB of addresses (`ulimit -v`) the system cannot
//!   even load the program.
//! - Elsewhere than on Linux `kill -9` may leave a temporary file, as it may of a film that `ffmpeg` writes.
//! - Of a file whose name is not UTF-8 a picture cannot say that it was made of it.
//! - Exported meshes have no ground, light and texts. Shells of an STL file overlap and are not united, and an overlay in it is closed only if it was.
//!   Programs that do not know `EXT_mesh_gpu_instancing` need `--compat`, whose triangles do not say which atom they are of. Of a session
//!   `convert` writes meshes, not atoms.
//! - Textures of meshes are read at their vertices and nowhere between. Of glTF compression, skins and morph targets are not read; polygons of OBJ files
//!   are fans, so that concave ones come out wrong. Vectors do not turn with symmetry operations: no format that states them has any.

#![doc = include_str!("threats.md")]

#[cfg(feature = "window")]
pub mod app;
pub mod bonds;
pub mod cli;
pub mod color;
pub mod crystal;
pub mod element;
pub mod error;
pub mod export;
pub mod import;
pub mod math;
pub mod render;
pub mod scene;
pub mod select;
pub mod session;
pub mod stop;
pub mod structure;

// What most programs begin with, by short names.
pub use error::{Error, Result};
pub use import::{read_bytes, read_path};
pub use render::{Image, Renderer};
pub use scene::Scene;
pub use structure::Structure;
