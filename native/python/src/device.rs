// SPDX-License-Identifier: GPL-3.0-or-later
//! What can compute.

use pyo3::prelude::*;

/// Something that isochor can compute on.
///
/// name: as the machine calls it. kind: "gpu" (hardware), "software" (a rasteriser on the CPU) or "cpu". backend: the
/// programming interface, such as "vulkan"; "rayon" for the CPU.
#[pyclass(frozen, eq, hash, module = "isochor")]
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct Device {
    /// The device as the machine calls it.
    #[pyo3(get)]
    name: String,
    /// "gpu", "software" or "cpu".
    #[pyo3(get)]
    kind: String,
    /// The programming interface.
    #[pyo3(get)]
    backend: String,
}

#[pymethods]
impl Device {
    fn __repr__(&self) -> String {
        format!("Device(name={:?}, kind={:?}, backend={:?})", self.name, self.kind, self.backend)
    }
}

/// Lists the devices, best first. The CPU is always there.
#[pyfunction]
pub(crate) fn devices() -> Vec<Device> {
    let threads = rayon::current_num_threads();
    vec![Device { name: format!("CPU, {threads} threads"), kind: "cpu".into(), backend: "rayon".into() }]
}
