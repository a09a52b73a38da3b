// SPDX-License-Identifier: GPL-3.0-or-later
//! What can compute.

use isochor_gpu::{Adapter, Choice, Kind};
use pyo3::prelude::*;

use crate::errors::DeviceError;

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

/// Lists the devices, best first: graphics cards, software rasterisers, and the CPU, which is always there.
#[pyfunction]
pub(crate) fn devices(py: Python<'_>) -> Vec<Device> {
    let adapters = py.detach(isochor_gpu::adapters);
    let mut devices: Vec<Device> = adapters.into_iter().map(Device::from).collect();
    devices.push(Device { name: cpu_name(), kind: "cpu".into(), backend: "rayon".into() });
    devices
}

/// Bytes per second that the adapter of this name copies within its own memory: for benchmarks, to compare with. Raises
/// DeviceError.
#[pyfunction]
pub(crate) fn copy_bandwidth(py: Python<'_>, name: &str) -> PyResult<f64> {
    let measured = py.detach(|| isochor_gpu::Device::open(Choice::Named(name))?.copy_bandwidth());
    measured.map_err(|cause| DeviceError::new_err(cause.to_string()))
}

/// What the CPU is called here.
pub(crate) fn cpu_name() -> String {
    format!("CPU, {} threads", rayon::current_num_threads())
}

impl From<Adapter> for Device {
    fn from(adapter: Adapter) -> Self {
        let kind = match adapter.kind {
            Kind::Gpu => "gpu",
            Kind::Software => "software",
        };
        Self { name: adapter.name, kind: kind.into(), backend: adapter.backend.into() }
    }
}
