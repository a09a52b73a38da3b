// SPDX-License-Identifier: GPL-3.0-or-later
//! The volume-preserving deformation on a GPU, through wgpu (Vulkan, Metal, DirectX 12).
//!
//! A [`Mesh`] keeps a [`isochor_core::Binding`]'s fixed data on a [`Device`]; then control points go in and vertices come
//! out, in one submission for all three axes ([`Mesh::preserve`]). A frame:
//!
//! | kernel | for every | does |
//! |---|---|---|
//! | `deform` | slot | equation (1) |
//! | `gradient` | slot, each turn | gradient of the volume along the turn's axis; the volume |
//! | `reduce` | run, each turn | the gradient times the basis: a small dense product |
//! | `gather` | control point, each turn | the paper's coefficients (10)-(12) |
//! | `solve` | turn | the step of the control points, equation (17) |
//! | `shift` | slot, each turn | the step of the vertices |
//! | `write` | vertex | how far it moved, in the order bound |
//!
//! No kernel adds atomically, and every sum has one order: two runs on one device give the same bits.
//!
//! # What each precision guarantees
//!
//! The kernels compute in float32, on coordinates relative to the lattice's centre. Sums that decide the volume carry their
//! rounding error along (two-floats), so what is left is the rounding of single terms: about 1e-7 of each, at random, which
//! averages out over the vertices. The volume that a frame aims at is met to a few 1e-8 on ordinary meshes, to 1e-6 where a
//! lattice of degree 20 pulls a thousand vertices about.
//!
//! - *float32 vertices*: the volume of the vertices as returned is measured in float64 on the CPU. Where it is off by more
//!   than 1e-6 ([`TOLERANCE`]) - thin sheets, far offsets - one closing step along the last axis follows on the CPU, with sums in
//!   float64. So the error is at most 1e-6, or what [`isochor_core::Binding::preserve`] guarantees where that is more: about
//!   `4 epsilon A R / |V|` (area, largest coordinate about the centre), which no float32 vertices can beat.
//! - *float64 vertices*: the closing step always follows, and with it the guarantee of [`isochor_core::Binding::preserve`];
//!   the shape of the correction is the device's, to float32. [`Mesh::deform`] gives them no more than float32's accuracy.
//! - *what needs no correction*: a volume within a quarter of 1e-6 of the target stays as it is, so a lattice at rest moves
//!   nothing.
//! - *control points*: those asked for plus the device's steps; coordinates along axes without a share keep every bit.
//! - *vertices without influence*, and all vertices where nothing moves, keep every bit.
//!
//! Flat axes and volumes without a ratio are rare and left to the CPU, in the same call ([`Work::Cpu`]).
//!
//! # What goes pass by pass
//!
//! Pins, several bodies, rational lattices, Blender's bases, and the methods that search are the core's own ([`isochor_core::Plan::carry_out`]) over passes on the device
//! (`passes.rs`): some submissions a frame instead of one, and the same guarantees by the same closing step.
//!
//! # What a frame costs
//!
//! Counted in `BENCHMARKS.md`. Everything is made when a binding is uploaded; a frame writes the control points into a mapped
//! buffer, submits once and waits for the results.
//!
//! # Faults on demand
//!
//! `ISOCHOR_GPU_BUFFER_LIMIT` (bytes) and `ISOCHOR_GPU_FAULT` (`memory`, `lost`, `trust`) make a machine in order fail, for tests: see
//! `faults.rs`.

mod adapters;
mod bandwidth;
mod buffers;
mod device;
mod error;
mod faults;
mod frames;
pub mod kernels;
mod mesh;
pub mod pack;
mod parts;
mod passes;
pub mod twins;
pub mod types;

pub use adapters::{Adapter, Choice, Kind, adapters, is_adapter};
pub use device::Device;
pub use error::{Error, Failure, Result};
pub use mesh::{Mesh, Outcome, TOLERANCE, Work};
