// SPDX-License-Identifier: GPL-3.0-or-later
//! When a binding's corrections go without the mesh: the tensor is summed up in the background once they have been worth it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::sync::{Arc, Mutex, PoisonError};

use crate::binding::{Binding, with_engine};
use crate::engine::Engine;
use crate::error::Result;
use crate::lanes::Lanes;
use crate::tensor::Tensor;
use crate::tensor::build::operations;
use crate::tensor::source::{FIXED, Source};
use crate::tensor::triples::Triples;
use crate::vertices::Scalar;

/// Bytes of a tensor at most: 216 control points, at which a sum takes minutes and larger caches end.
const LARGEST: usize = 16 << 20;

// What things cost, in multiply-adds of the sum over the mesh, of which a core does fifteen in a nanosecond.

/// Three coefficients and three shifts, for one vertex.
const PASSES: f64 = 300.0;
const PASSES_PER_TAP: f64 = 8.0;

/// Three contractions, for one byte of the tensor.
const CONTRACTIONS: f64 = 3.0 * 0.9;

/// By how much the tensor must be faster.
const FASTER: f64 = 2.0;

/// The tensor of a binding: not there yet, on its way, or there.
#[derive(Default)]
pub(crate) struct Chosen(Mutex<State>);

#[derive(Default)]
enum State {
    #[default]
    Fresh,
    /// Corrections over the mesh so far.
    Counting(u32),
    Building(Building),
    Ready(Arc<Tensor>),
    Never,
}

/// A sum under way in a thread of its own, which stops soon after this is dropped.
struct Building {
    stop: Arc<AtomicBool>,
    result: Receiver<Tensor>,
}

impl Drop for Building {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

impl Chosen {
    /// The tensor for the next correction, if it is there; starts to sum it up once `worth` corrections went over the mesh, or never.
    fn next(
        &self,
        worth: impl FnOnce() -> Option<u32>,
        start: impl FnOnce() -> Option<Building>,
    ) -> Option<Arc<Tensor>> {
        let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match &mut *state {
            State::Never => {}
            State::Ready(tensor) => return Some(Arc::clone(tensor)),
            State::Building(building) => match building.result.try_recv() {
                Ok(tensor) => {
                    let tensor = Arc::new(tensor);
                    *state = State::Ready(Arc::clone(&tensor));
                    return Some(tensor);
                }
                Err(TryRecvError::Empty) => {}
                Err(TryRecvError::Disconnected) => *state = State::Never,
            },
            State::Fresh => *state = State::Counting(1),
            State::Counting(count) => {
                *count += 1;
                match worth() {
                    None => *state = State::Never,
                    Some(worth) if *count > worth => {
                        *state = start().map_or(State::Never, State::Building);
                    }
                    Some(_) => {}
                }
            }
        }
        None
    }

    fn set(&self, tensor: Tensor) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = State::Ready(Arc::new(tensor));
    }

    /// Bytes that the tensor takes, 0 where it is not there.
    fn bytes(&self) -> usize {
        match &*self.0.lock().unwrap_or_else(PoisonError::into_inner) {
            State::Ready(tensor) => tensor.bytes(),
            _ => 0,
        }
    }
}

impl Building {
    /// Starts a thread. `None` where the system gives none.
    fn start<L: Lanes + 'static>(source: Source<L>) -> Option<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        let (sender, result) = channel();
        let stopped = Arc::clone(&stop);
        let work = move || {
            if let Some(tensor) = Tensor::new(source, 1, &|| stopped.load(Ordering::Relaxed)) {
                // Nobody waits for it any more where the binding is gone.
                let _ = sender.send(tensor);
            }
        };
        std::thread::Builder::new().name("isochor tensor".into()).spawn(work).ok()?;
        Some(Self { stop, result })
    }
}

/// Corrections over the mesh that cost as much as summing up the tensor: having waited for so many, the sum never costs more than
/// what was spent already. `None` where corrections by the tensor would not be faster, or it would be too large.
fn worth(vertices: usize, taps: usize, functions: usize) -> Option<u32> {
    if Triples::bytes(functions) > LARGEST {
        return None;
    }
    let over_mesh = PASSES + PASSES_PER_TAP * taps as f64;
    let by_tensor = CONTRACTIONS * Triples::bytes(functions) as f64;
    let sum = operations(FIXED + taps + 1) as f64;
    (by_tensor * FASTER < vertices as f64 * over_mesh).then(|| (sum / over_mesh).ceil() as u32)
}

impl<T: Scalar> Binding<T> {
    /// Sums up now what makes later corrections independent of the number of vertices, which otherwise happens in the background
    /// after some corrections, where that pays. Takes up to a few seconds for half a million vertices and a lattice of 4 x 4 x 4.
    /// Returns whether it is there: not for lattices of more than 216 control points.
    ///
    /// # Errors
    /// [`Error::Mesh`](crate::Error::Mesh) where the triangles enclose no volume.
    pub fn prepare(&self) -> Result<bool> {
        if !self.has_tensor_form()? || self.tensor_bytes() > 0 {
            return Ok(self.tensor_bytes() > 0);
        }
        let threads = rayon::current_num_threads();
        let tensor = with_engine!(self, engine => Tensor::new(self.source(engine)?, threads, &|| false));
        tensor.into_iter().for_each(|tensor| self.chosen().set(tensor));
        Ok(self.tensor_bytes() > 0)
    }

    /// Bytes that make corrections independent of the number of vertices; 0 while they are not.
    pub fn tensor_bytes(&self) -> usize {
        self.chosen().bytes()
    }

    /// The tensor for the next correction, if it is there.
    pub(crate) fn tensor(&self) -> Option<Arc<Tensor>> {
        let taps = self.lattice().axes().each_ref().map(|axis| axis.degree() + 1).iter().product();
        let functions = FIXED + self.lattice().len() + 1;
        self.chosen().next(
            || self.has_tensor_form().ok()?.then(|| worth(self.vertices().len(), taps, functions)).flatten(),
            || with_engine!(self, engine => Building::start(self.source(engine).ok()?)),
        )
    }

    fn has_tensor_form(&self) -> Result<bool> {
        self.surface()?;
        Ok(Triples::bytes(FIXED + self.lattice().len() + 1) <= LARGEST)
    }

    fn source<L: Lanes>(&self, engine: &Arc<Engine<L>>) -> Result<Source<L>> {
        let centre = self.lattice().centre();
        Ok(Source {
            engine: Arc::clone(engine),
            embedding: Arc::clone(self.embedding()),
            walks: Arc::clone(self.walks()?),
            rest: self.rest().iter().map(|p| p - centre).collect(),
            centre,
            shape: self.lattice().shape(),
        })
    }
}
