//! The integration tests: one binary, since wgpu links slowly.
//!
//! Where a new test goes: what one module does is tested beside its code; what several do together here, by topic.
//! `layering` the order of the modules and the size of files; `corpus` real files with independent truth; `bond_tables` our bonds beside those of toolkits; `perceive` listed bonds found
//! again from the positions alone; `ligands` residues beside the component dictionary; `crystals` of proteins; `culling` what the GPU leaves out; `dependencies` what the program is built of; `examples` those of the library; `faults` what goes wrong around the program, `threats` what comes with its files; `files` what these run over; `memory` what limits of it leave; `mmcif` CIF written and read again; `bad_input` truncated
//! and corrupted ones; `roundtrip` written and read again; `schema` our JSON and its schema; `golden` small pictures, one idea each; `parity` CPU against GPU; `shaders` WGSL without a GPU; `sky` visibility of the sky against rays; `cli` the program
//! as a user runs it; `again` pictures made again, and films; `assemblies` as placements and as copied atoms; `batch` many pictures in one run; `selecting` its flags that select atoms; `large` pictures of any size, their parts and resolution; `trajectories` against their truth, and behind a structure; `transparent` ones laid over colours; `window` and `care` the window under a virtual display.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test fails by panicking")]

mod again;
mod assemblies;
mod bad_input;
mod batch;
mod bond_tables;
#[cfg(feature = "window")]
mod care;
mod cli;
mod corpus;
mod crystals;
#[cfg(feature = "gpu")]
mod culling;
mod dependencies;
#[cfg(all(unix, feature = "window"))]
mod endurance;
mod examples;
mod faults;
mod files;
mod golden;
mod large;
mod layering;
mod ligands;
mod memory;
mod mmcif;
#[cfg(feature = "gpu")]
mod parity;
mod perceive;
mod roundtrip;
mod scenes;
mod schema;
mod selecting;
#[cfg(feature = "gpu")]
mod shaders;
mod sky;
mod threats;
mod trajectories;
mod transparent;
#[cfg(feature = "window")]
mod window;
