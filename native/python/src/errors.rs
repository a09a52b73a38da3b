// SPDX-License-Identifier: GPL-3.0-or-later
//! The core's errors as Python exceptions.

use std::ffi::CString;

use pyo3::exceptions::PyRuntimeWarning;
use pyo3::prelude::*;

pyo3::import_exception!(isochor.errors, LatticeError);
pyo3::import_exception!(isochor.errors, MeshError);
pyo3::import_exception!(isochor.errors, VolumeError);
pyo3::import_exception!(isochor.errors, PinError);
pyo3::import_exception!(isochor.errors, ElasticError);
pyo3::import_exception!(isochor.errors, DeviceError);
pyo3::import_exception!(isochor.errors, UnknownDeviceError);

/// The family of the exception to raise about an argument.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Family {
    Lattice,
    Mesh,
    Volume,
    Pin,
    Elastic,
}

impl Family {
    pub(crate) fn error(self, message: String) -> PyErr {
        match self {
            Self::Lattice => LatticeError::new_err(message),
            Self::Mesh => MeshError::new_err(message),
            Self::Volume => VolumeError::new_err(message),
            Self::Pin => PinError::new_err(message),
            Self::Elastic => ElasticError::new_err(message),
        }
    }
}

/// The Python exception for an error of the core.
pub(crate) fn to_python(error: isochor_core::Error) -> PyErr {
    match error {
        isochor_core::Error::Lattice(message) => LatticeError::new_err(message),
        isochor_core::Error::Mesh(message) => MeshError::new_err(message),
        isochor_core::Error::Volume(message) => VolumeError::new_err(message),
        isochor_core::Error::Pin(message) => PinError::new_err(message),
        isochor_core::Error::Elastic(message) => ElasticError::new_err(message),
    }
}

/// Warns the caller, a `RuntimeWarning`, if there is anything to say.
pub(crate) fn warn(py: Python<'_>, text: Option<String>) -> PyResult<()> {
    let Some(text) = text else { return Ok(()) };
    PyErr::warn(py, &py.get_type::<PyRuntimeWarning>(), &CString::new(text.replace('\0', " "))?, 1)
}
