// SPDX-License-Identifier: GPL-3.0-or-later
//! Faults on demand, so that what follows them can be tested on a machine in order: environment variables, read when a mesh
//! is uploaded or a frame starts.
//!
//! - `ISOCHOR_GPU_BUFFER_LIMIT`: bytes that a buffer may have, where the adapter allows more.
//! - `ISOCHOR_GPU_FAULT=memory`: the next mesh finds the device's memory full.
//! - `ISOCHOR_GPU_FAULT=lost`: the next frame finds the device lost.
//! - `ISOCHOR_GPU_FAULT=trust`: software rasterisers pass for graphics cards, so that "auto" has something to choose from.

/// The lowered limit of a buffer's size.
pub(crate) fn buffer_limit() -> Option<u64> {
    std::env::var("ISOCHOR_GPU_BUFFER_LIMIT").ok()?.parse().ok()
}

/// Whether the fault of this name is asked for.
pub(crate) fn is_wanted(name: &str) -> bool {
    std::env::var("ISOCHOR_GPU_FAULT").is_ok_and(|wanted| wanted == name)
}
