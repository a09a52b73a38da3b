// SPDX-License-Identifier: GPL-3.0-or-later
//! What can go wrong with a GPU. None of it is the caller's fault, and the CPU can always do the work instead.

/// An error of a device.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// No adapter, or none of the name given, or no driver at all.
    #[error("{0}")]
    NoAdapter(String),
    /// The mesh needs a larger buffer than the adapter allows.
    #[error("{0}")]
    TooLarge(String),
    /// The device's memory is full.
    #[error("{0}")]
    OutOfMemory(String),
    /// The device stopped working: driver reset, unplugged, or an error that wgpu reports.
    #[error("{0}")]
    Lost(String),
}

/// Result of what needs a device.
pub type Result<T> = std::result::Result<T, Error>;

/// Why a call failed: its arguments, or the device.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Failure {
    /// The arguments, as the core would say too.
    #[error(transparent)]
    Core(#[from] isochor_core::Error),
    /// The device; the CPU can do the same call.
    #[error(transparent)]
    Device(#[from] Error),
}
