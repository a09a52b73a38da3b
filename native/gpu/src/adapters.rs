// SPDX-License-Identifier: GPL-3.0-or-later
//! What this machine offers.

use std::sync::OnceLock;

use crate::error::{Error, Result};
use crate::faults;

/// What stands behind an adapter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// A graphics card, or the graphics unit of a processor.
    Gpu,
    /// A rasteriser on the CPU, such as lavapipe: right, and slow.
    Software,
}

/// An adapter, as the machine names it.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Adapter {
    /// Name of the device.
    pub name: String,
    /// What it is.
    pub kind: Kind,
    /// Programming interface: "vulkan", "metal" or "dx12".
    pub backend: &'static str,
}

/// Whether an adapter has this name.
pub fn is_adapter(name: &str) -> bool {
    known().iter().any(|adapter| adapter.name == name)
}

/// Which adapter to take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Choice<'a> {
    /// The best graphics card; never a software rasteriser.
    Hardware,
    /// The best graphics card, or a software rasteriser where there is none.
    Any,
    /// The adapter of this name.
    Named(&'a str),
}

/// All adapters, best first: discrete cards, then integrated ones, then software. Empty without a driver.
pub fn adapters() -> Vec<Adapter> {
    known().to_vec()
}

/// The adapters that were there when the process first looked. Asking the drivers takes milliseconds, and they may print.
fn known() -> &'static [Adapter] {
    static KNOWN: OnceLock<Vec<Adapter>> = OnceLock::new();
    KNOWN.get_or_init(|| sorted().iter().map(describe).collect())
}

/// The adapter to take.
///
/// # Errors
/// [`Error::NoAdapter`] where none fits.
pub(crate) fn choose(choice: Choice<'_>) -> Result<(wgpu::Adapter, Adapter)> {
    let fits = |adapter: &Adapter| match choice {
        Choice::Hardware => adapter.kind == Kind::Gpu || faults::is_wanted("trust"),
        Choice::Any => true,
        Choice::Named(name) => adapter.name == name,
    };
    let none = || {
        let names: Vec<String> = known().iter().map(|adapter| format!("{:?}", adapter.name)).collect();
        Error::NoAdapter(missing(choice, &names))
    };
    if !known().iter().any(fits) {
        return Err(none());
    }
    let described = sorted().into_iter().map(|adapter| (describe(&adapter), adapter));
    let chosen = described.into_iter().find(|(described, _)| fits(described));
    chosen.map(|(described, adapter)| (adapter, described)).ok_or_else(none)
}

fn missing(choice: Choice<'_>, names: &[String]) -> String {
    let wanted = match choice {
        Choice::Hardware => "a graphics card".to_owned(),
        Choice::Any => "an adapter".to_owned(),
        Choice::Named(name) => format!("the adapter {name:?}"),
    };
    let found = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
    format!(
        "GPU: found {found}, expected {wanted}; install a Vulkan, Metal or DirectX 12 driver, or use the CPU"
    )
}

/// One instance for the process: making it loads the drivers.
fn instance() -> &'static wgpu::Instance {
    static INSTANCE: OnceLock<wgpu::Instance> = OnceLock::new();
    INSTANCE.get_or_init(|| {
        let mut description = wgpu::InstanceDescriptor::new_without_display_handle();
        description.backends = wgpu::Backends::VULKAN | wgpu::Backends::METAL | wgpu::Backends::DX12;
        description.flags = wgpu::InstanceFlags::empty();
        wgpu::Instance::new(description)
    })
}

fn sorted() -> Vec<wgpu::Adapter> {
    let mut found = pollster::block_on(instance().enumerate_adapters(wgpu::Backends::all()));
    found.retain(|adapter| {
        adapter.get_downlevel_capabilities().flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS)
    });
    found.sort_by_key(|adapter| rank(adapter.get_info().device_type));
    found
}

fn rank(device_type: wgpu::DeviceType) -> u8 {
    match device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::VirtualGpu => 1,
        wgpu::DeviceType::IntegratedGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    }
}

fn kind(adapter: &wgpu::Adapter) -> Kind {
    match adapter.get_info().device_type {
        wgpu::DeviceType::Cpu | wgpu::DeviceType::Other => Kind::Software,
        _ => Kind::Gpu,
    }
}

fn describe(adapter: &wgpu::Adapter) -> Adapter {
    let info = adapter.get_info();
    Adapter { name: info.name, kind: kind(adapter), backend: info.backend.to_str() }
}
