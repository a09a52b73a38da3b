// SPDX-License-Identifier: GPL-3.0-or-later
//! Who computes: the CPU, a GPU, or whichever is faster for the mesh at hand; and the CPU again where a GPU fails.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use isochor_core::{Binding, DVec3, Preserve, Preserved, Result, Scalar};
use isochor_gpu::{Choice, Device, Error, Failure, Mesh, Work};

use crate::device::cpu_name;
use crate::words::DeviceWord;

/// Vertices below which "auto" does not ask for a GPU at all: a frame there costs two dozen dispatches and a read-back,
/// some tenths of a millisecond whatever the mesh, in which a few cores correct a mesh of this size.
const WORTH_ASKING: usize = 20_000;

/// Chooses between CPU and GPU, call by call.
pub(crate) struct Backend {
    word: DeviceWord,
    state: Mutex<State>,
}

/// What is known of a binding on a GPU.
enum State {
    /// Nothing yet.
    Fresh,
    /// "auto": what a correction costs on the CPU.
    CpuTimed(Duration),
    /// "auto": the same, and the mesh is on the GPU, warm.
    Warm(Duration, Arc<Mesh>),
    /// The GPU computes.
    Gpu(Arc<Mesh>),
    /// The CPU computes: asked for, or faster, or nothing else is there.
    Cpu,
    /// The CPU computes, and goes on to: the GPU failed.
    Failed,
}

/// Who does a call, and what it is to teach "auto".
enum Turn {
    Cpu,
    CpuTimed,
    Gpu(Arc<Mesh>),
    GpuTimed(Duration, Arc<Mesh>),
}

/// A finished correction.
pub(crate) struct Ran {
    pub(crate) preserved: Preserved,
    /// "cpu" or "gpu".
    pub(crate) device: &'static str,
    /// Seconds of the kernels, where a GPU kept time.
    pub(crate) seconds: Option<f64>,
    /// Why a GPU was asked for and the CPU computed.
    pub(crate) warning: Option<String>,
}

impl Backend {
    /// The backend of a new binding, and a warning where the GPU asked for is not there.
    pub(crate) fn new(word: DeviceWord) -> (Self, Option<String>) {
        let opened = match choice(&word) {
            Some(choice) if word != DeviceWord::Auto => Device::open(choice).map(drop),
            _ => Ok(()),
        };
        let state = match (&word, &opened) {
            (DeviceWord::Cpu, _) => State::Cpu,
            (_, Ok(())) => State::Fresh,
            (_, Err(_)) => State::Failed,
        };
        (Self { word, state: Mutex::new(state) }, opened.err().map(|cause| took_over(&cause)))
    }

    /// Forgets what was uploaded and learnt: the binding changed.
    pub(crate) fn reset(&self) {
        let mut state = self.state();
        if self.word != DeviceWord::Cpu && !matches!(*state, State::Failed) {
            *state = State::Fresh;
        }
    }

    /// "cpu" or "gpu": what computes the next call, as far as is known.
    pub(crate) fn device(&self) -> &'static str {
        match &*self.state() {
            State::Gpu(_) | State::Warm(..) => "gpu",
            State::Fresh if self.word != DeviceWord::Auto => "gpu",
            _ => "cpu",
        }
    }

    /// The device by the name it has in the list of devices.
    pub(crate) fn name(&self) -> String {
        let opened = || choice(&self.word).and_then(|choice| Device::open(choice).ok());
        match (self.device(), &*self.state()) {
            (_, State::Gpu(mesh) | State::Warm(_, mesh)) => mesh.device().adapter().name.clone(),
            ("gpu", _) => opened().map_or_else(cpu_name, |device| device.adapter().name.clone()),
            _ => cpu_name(),
        }
    }

    /// Bytes that the binding takes on a GPU; 0 where it is not there.
    pub(crate) fn bytes(&self) -> u64 {
        match &*self.state() {
            State::Gpu(mesh) | State::Warm(_, mesh) => mesh.bytes(),
            _ => 0,
        }
    }

    /// Deforms; returns a warning where the CPU took over. float64 vertices are the CPU's: float32 is not enough for them.
    pub(crate) fn deform<T: Scalar>(
        &self,
        binding: &Binding<T>,
        control: &[DVec3],
        out: &mut [[T; 3]],
    ) -> Result<Option<String>> {
        let is_single = T::EPSILON >= f64::from(f32::EPSILON);
        let cause = match self.turn(binding) {
            Ok(Turn::Gpu(mesh) | Turn::GpuTimed(_, mesh)) if is_single => {
                match mesh.deform(binding, control, out) {
                    Ok(_) => return Ok(None),
                    Err(Failure::Core(error)) => return Err(error),
                    Err(Failure::Device(cause)) => Some(cause),
                }
            }
            Ok(_) => None,
            Err(cause) => Some(cause),
        };
        binding.deform(control, out).map(|()| cause.map(|cause| self.give_up(&cause)))
    }

    /// Corrects. "auto" times the first correction of a large mesh on the CPU, warms a GPU up with the second, times the
    /// third there and stays with the faster.
    pub(crate) fn preserve<T: Scalar>(
        &self,
        binding: &Binding<T>,
        control: &[DVec3],
        options: &Preserve,
        out: &mut [[T; 3]],
    ) -> Result<Ran> {
        let turn = match self.turn(binding) {
            Ok(turn) => turn,
            Err(cause) => return on_cpu(binding, control, options, out, Some(self.give_up(&cause))),
        };
        let start = Instant::now();
        let ran = match &turn {
            Turn::Cpu | Turn::CpuTimed => on_cpu(binding, control, options, out, None),
            Turn::Gpu(mesh) | Turn::GpuTimed(_, mesh) => {
                match mesh.preserve(binding, control, options, out) {
                    Ok(outcome) => Ok(Ran {
                        preserved: outcome.preserved,
                        device: if outcome.work == Work::Cpu { "cpu" } else { "gpu" },
                        seconds: outcome.seconds,
                        warning: None,
                    }),
                    Err(Failure::Core(error)) => Err(error),
                    Err(Failure::Device(cause)) => {
                        return on_cpu(binding, control, options, out, Some(self.give_up(&cause)));
                    }
                }
            }
        }?;
        self.learn(turn, start.elapsed());
        Ok(ran)
    }

    /// Who does the next call; uploads the mesh where that is due.
    fn turn<T: Scalar>(&self, binding: &Binding<T>) -> isochor_gpu::Result<Turn> {
        let mut state = self.state();
        let is_auto = self.word == DeviceWord::Auto;
        let cpu = match &*state {
            State::Cpu | State::Failed => return Ok(Turn::Cpu),
            // Only the CPU corrects over combinations of what the lattice moves.
            _ if binding.over().is_some() => {
                *state = State::Cpu;
                return Ok(Turn::Cpu);
            }
            State::Gpu(mesh) => return Ok(Turn::Gpu(Arc::clone(mesh))),
            State::Warm(cpu, mesh) => return Ok(Turn::GpuTimed(*cpu, Arc::clone(mesh))),
            State::Fresh if is_auto => {
                if binding.vertices().len() >= WORTH_ASKING && Device::open(Choice::Hardware).is_ok() {
                    return Ok(Turn::CpuTimed);
                }
                *state = State::Cpu;
                return Ok(Turn::Cpu);
            }
            State::CpuTimed(cpu) => Some(*cpu),
            State::Fresh => None,
        };
        let Some(choice) = choice(&self.word) else { return Ok(Turn::Cpu) };
        let mesh = Arc::new(Mesh::new(Device::open(choice)?, binding)?);
        *state = match cpu {
            Some(cpu) => State::Warm(cpu, Arc::clone(&mesh)),
            None => State::Gpu(Arc::clone(&mesh)),
        };
        Ok(Turn::Gpu(mesh))
    }

    fn learn(&self, turn: Turn, took: Duration) {
        match turn {
            Turn::CpuTimed => *self.state() = State::CpuTimed(took),
            Turn::GpuTimed(cpu, mesh) => {
                *self.state() = if took < cpu { State::Gpu(mesh) } else { State::Cpu };
            }
            Turn::Cpu | Turn::Gpu(_) => {}
        }
    }

    /// Leaves the GPU for good, and says why.
    fn give_up(&self, cause: &Error) -> String {
        *self.state() = State::Failed;
        took_over(cause)
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The adapter that a word stands for, `None` for the CPU.
fn choice(word: &DeviceWord) -> Option<Choice<'_>> {
    match word {
        DeviceWord::Cpu => None,
        DeviceWord::Auto => Some(Choice::Hardware),
        DeviceWord::Gpu => Some(Choice::Any),
        DeviceWord::Adapter(name) => Some(Choice::Named(name)),
    }
}

fn took_over(cause: &Error) -> String {
    format!("{cause} (the CPU computes instead)")
}

fn on_cpu<T: Scalar>(
    binding: &Binding<T>,
    control: &[DVec3],
    options: &Preserve,
    out: &mut [[T; 3]],
    warning: Option<String>,
) -> Result<Ran> {
    let preserved = binding.preserve(control, options, out)?;
    Ok(Ran { preserved, device: "cpu", seconds: None, warning })
}
