// SPDX-License-Identifier: GPL-3.0-or-later
//! An opened adapter: its queue, its pipelines, and what went wrong with it.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::adapters::{Adapter, Choice, choose};
use crate::error::{Error, Result};
use crate::faults;
use crate::kernels::Kernel;

/// An adapter opened for computing. Shared by all meshes on it; every method may be called from several threads.
pub struct Device {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    adapter: Adapter,
    pipelines: Mutex<HashMap<[usize; 3], Arc<Pipelines>>>,
    failure: Arc<Mutex<Option<Error>>>,
}

/// The kernels compiled for lattices of one degree.
pub(crate) struct Pipelines(HashMap<Kernel, wgpu::ComputePipeline>);

impl Pipelines {
    pub(crate) fn of(&self, kernel: Kernel) -> &wgpu::ComputePipeline {
        &self.0[&kernel]
    }
}

impl Device {
    /// The device of a choice, opened once for the process and again after it was lost.
    ///
    /// # Errors
    /// [`Error::NoAdapter`] where no adapter fits, or it cannot be opened.
    pub fn open(choice: Choice<'_>) -> Result<Arc<Self>> {
        static OPENED: Mutex<Vec<(String, Arc<Device>)>> = Mutex::new(Vec::new());
        let key = format!("{choice:?}");
        let mut opened = locked(&OPENED);
        opened.retain(|(_, device)| device.failure().is_none());
        if let Some((_, device)) = opened.iter().find(|(known, _)| *known == key) {
            return Ok(Arc::clone(device));
        }
        let (adapter, described) = choose(choice)?;
        let same = opened.iter().find(|(_, device)| device.adapter == described);
        let device = match same {
            Some((_, device)) => Arc::clone(device),
            None => Arc::new(Self::request(&adapter, described)?),
        };
        opened.push((key, Arc::clone(&device)));
        Ok(device)
    }

    fn request(adapter: &wgpu::Adapter, described: Adapter) -> Result<Self> {
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("isochor"),
            required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
            required_limits: adapter.limits(),
            memory_hints: wgpu::MemoryHints::Performance,
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).map_err(|cause| {
            Error::NoAdapter(format!("GPU: {:?} could not be opened: {cause}; use the CPU", described.name))
        })?;
        let failure = Arc::new(Mutex::new(None));
        device.set_device_lost_callback({
            let (failure, name) = (Arc::clone(&failure), described.name.clone());
            move |reason, message| {
                record(&failure, Error::Lost(format!("GPU: {name:?} was lost ({reason:?}): {message}")));
            }
        });
        device.on_uncaptured_error(Arc::new({
            let failure = Arc::clone(&failure);
            move |error| record(&failure, translated(error))
        }));
        Ok(Self { device, queue, adapter: described, pipelines: Mutex::default(), failure })
    }

    /// The adapter.
    pub fn adapter(&self) -> &Adapter {
        &self.adapter
    }

    /// What broke the device, if anything did: it is of no more use then.
    pub fn failure(&self) -> Option<Error> {
        locked(&self.failure).clone()
    }

    /// Gives the device back, as if its driver had failed. For tests.
    pub fn lose(&self) {
        self.device.destroy();
        record(&self.failure, Error::Lost(format!("GPU: {:?} was given back", self.adapter.name)));
    }

    /// `Err` once the device is broken.
    pub(crate) fn check(&self) -> Result<()> {
        self.failure().map_or(Ok(()), Err)
    }

    /// Bytes that one buffer may hold.
    pub(crate) fn buffer_limit(&self) -> u64 {
        let limits = self.device.limits();
        let own = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        faults::buffer_limit().map_or(own, |lowered| own.min(lowered))
    }

    /// Runs `f`; errors that it causes are returned instead of breaking the device.
    pub(crate) fn scoped<R>(&self, f: impl FnOnce() -> R) -> Result<R> {
        use wgpu::ErrorFilter::{Internal, OutOfMemory, Validation};
        let scopes = [Validation, Internal, OutOfMemory].map(|filter| self.device.push_error_scope(filter));
        let result = f();
        let errors: Vec<wgpu::Error> =
            scopes.into_iter().rev().filter_map(|scope| pollster::block_on(scope.pop())).collect();
        self.check()?;
        errors.into_iter().next().map_or(Ok(result), |error| Err(translated(error)))
    }

    /// The kernels for lattices with so many taps along each axis.
    pub(crate) fn pipelines(&self, taps: [usize; 3]) -> Result<Arc<Pipelines>> {
        let mut known = locked(&self.pipelines);
        if let Some(pipelines) = known.get(&taps) {
            return Ok(Arc::clone(pipelines));
        }
        let compiled = self.scoped(|| {
            Pipelines(Kernel::ALL.iter().map(|&kernel| (kernel, self.compile(kernel, taps))).collect())
        })?;
        let compiled = Arc::new(compiled);
        known.insert(taps, Arc::clone(&compiled));
        Ok(compiled)
    }

    fn compile(&self, kernel: Kernel, taps: [usize; 3]) -> wgpu::ComputePipeline {
        let descriptor = wgpu::ShaderModuleDescriptor {
            label: Some(kernel.name()),
            source: wgpu::ShaderSource::Wgsl(kernel.source(taps).into()),
        };
        let mut checks = wgpu::ShaderRuntimeChecks::checked();
        // Counters in every loop would keep drivers from unrolling those over the taps.
        checks.force_loop_bounding = false;
        checks.int_div_checks = false;
        // SAFETY: every loop of the kernels counts up to a constant, an array's length or an offset in one, all below 2^31, so
        // it ends; every divisor is a constant above 0, and no division is signed. Indices stay checked.
        let module = unsafe { self.device.create_shader_module_trusted(descriptor, checks) };
        self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(kernel.name()),
            layout: None,
            module: &module,
            entry_point: Some(kernel.name()),
            // The kernels write workgroup memory before they read it.
            compilation_options: wgpu::PipelineCompilationOptions {
                zero_initialize_workgroup_memory: false,
                ..Default::default()
            },
            cache: None,
        })
    }
}

fn translated(error: wgpu::Error) -> Error {
    match error {
        wgpu::Error::OutOfMemory { source } => Error::OutOfMemory(format!("GPU: out of memory: {source}")),
        other => Error::Lost(format!("GPU: {other}")),
    }
}

/// Keeps the first failure: those after it follow from it.
fn record(failure: &Mutex<Option<Error>>, error: Error) {
    locked(failure).get_or_insert(error);
}

pub(crate) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
