// SPDX-License-Identifier: GPL-3.0-or-later
//! What can go wrong, by the thing that is wrong.

/// An error of the core. Every message names the thing, what was found, what was expected and what to do.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// The lattice, its frame, or an array with one entry per control point.
    #[error("{0}")]
    Lattice(String),
    /// The mesh, or an array with one entry per vertex.
    #[error("{0}")]
    Mesh(String),
    /// The volume asked for, or what the correction may use to reach it.
    #[error("{0}")]
    Volume(String),
    /// Points of the surface that must land on targets.
    #[error("{0}")]
    Pin(String),
    /// What an elastic body is made of, its ground, or the time to move on by.
    #[error("{0}")]
    Elastic(String),
}

/// Result of a fallible operation of the core.
pub type Result<T> = std::result::Result<T, Error>;
