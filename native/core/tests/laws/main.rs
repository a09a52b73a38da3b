// SPDX-License-Identifier: GPL-3.0-or-later
//! The laws that the core keeps, a module for each thing they are about. One program, for each compiles the passes over the mesh
//! anew, which takes a minute.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "../shared/mod.rs"]
mod shared;

mod blender_basis;
mod bodies;
mod costs;
mod elastic;
mod folds;
mod inversion;
mod lattice;
mod limit;
mod mapped;
mod methods;
mod patches;
mod proxy;
mod rational;
mod refine;
mod tensor;
mod tessellation;
mod volume;
mod weights;
