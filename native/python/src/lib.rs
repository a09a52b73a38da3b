// SPDX-License-Identifier: GPL-3.0-or-later
//! The Python module `isochor._native`: it checks what comes in, leaves the interpreter, and calls the core.

mod arrays;
mod axes;
mod backend;
mod binding;
mod bodies;
mod device;
mod elastic;
mod errors;
mod folds;
mod lattice;
mod patches;
mod pins;
mod preserved;
mod refine;
mod subdivision;
mod surface;
mod words;

/// The native half of isochor.
#[pyo3::pymodule]
mod _native {
    #[pymodule_export]
    use super::binding::Binding;
    #[pymodule_export]
    use super::binding::prepare_in_background;
    #[pymodule_export]
    use super::device::Device;
    #[pymodule_export]
    use super::device::copy_bandwidth;
    #[pymodule_export]
    use super::device::devices;
    #[pymodule_export]
    use super::elastic::Elastic;
    #[pymodule_export]
    use super::folds::Folds;
    #[pymodule_export]
    use super::lattice::Lattice;
    #[pymodule_export]
    use super::patches::Patches;
    #[pymodule_export]
    use super::patches::Tessellation;
    #[pymodule_export]
    use super::pins::Pins;
    #[pymodule_export]
    use super::preserved::Preserved;
    #[pymodule_export]
    use super::subdivision::Refined;
    #[pymodule_export]
    use super::subdivision::bent_edges;
    #[pymodule_export]
    use super::subdivision::tessellate;
    #[pymodule_export]
    use super::surface::Surface;
    #[pymodule_export]
    #[expect(non_upper_case_globals, reason = "the name that Python expects")]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
