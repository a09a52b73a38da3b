// SPDX-License-Identifier: GPL-3.0-or-later
//! Free-form deformation with exact volume.
//!
//! A [`Lattice`] is a spline over a box of space. A mesh is bound to it once ([`Binding`]); then control points come in and
//! vertices go out ([`Binding::deform`]), with the mesh's volume kept if wanted ([`Binding::preserve`]), by the closed form
//! of Hahmann, Bonneau, Barbier, Elber and Hagen (2012).
//!
//! Whatever decides the volume is float64; float32 vertices are deformed in float32. Everything runs on all cores, and gives
//! the same bits on any number of them. No Python, no GPU, no files.

mod basis;
mod bends;
mod binding;
mod blend;
mod bodies;
mod broken;
mod caps;
mod combination;
mod control_map;
mod derivative;
mod determinant;
pub mod elastic;
mod embedding;
mod engine;
mod error;
mod fold_search;
mod folds;
mod interpolation;
mod inversion;
mod jacobian;
mod kernels;
mod lanes;
mod lattice;
pub mod layout;
mod measures;
mod net;
mod over;
mod patches;
mod pieces;
mod preserve;
mod proxy;
mod quotient;
mod refine;
mod subdivision;
mod sum;
mod surface;
mod tensor;
mod tessellation;
mod vertices;
mod walks;
mod weights;
mod words;

pub use basis::{AxisBasis, MAX_POINTS, Span};
pub use bends::Deformation;
pub use binding::{Bind, Binding};
pub use bodies::Bodies;
pub use combination::Surface;
pub use control_map::ControlMap;
pub use elastic::Elastic;
pub use error::{Error, Result};
pub use folds::{DEPTH, FoldTest, Folds, MOST_DEPTH, Verdict};
pub use glam::{DMat3, DVec3};
pub use interpolation::Interpolation;
pub use inversion::Preimage;
pub use lattice::{FACE_TOLERANCE, FACE_TOLERANCE_F32, Lattice};
pub use patches::Patches;
pub use preserve::{
    Accuracy, Coefficients, Cost, Limit, Method, Passes, PinPoint, Pins, Plan, Preserve, Preserved,
};
pub use refine::{RefineAxis, Refinement};
pub use subdivision::Refined;
pub use surface::{ClosedSurface, Measure};
pub use tensor::prepare_in_background;
pub use tessellation::{NO_CORNER, Tessellation};
pub use vertices::{Outside, Scalar};
