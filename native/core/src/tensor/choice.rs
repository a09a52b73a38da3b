// SPDX-License-Identifier: GPL-3.0-or-later
//! When a binding's corrections go without the mesh: the tensor is summed up in the background once they have been worth it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::sync::{Arc, Mutex, PoisonError};

use glam::DVec3;

use crate::binding::{Binding, with_engine};
use crate::engine::Engine;
use crate::error::Result;
use crate::lanes::Lanes;
use crate::lattice::Lattice;
use crate::tensor::Tensor;
use crate::tensor::build::operations;
use crate::tensor::source::{FIXED, Source};
use crate::tensor::triples::Triples;
use crate::vertices::Scalar;

/// Bytes of a tensor at most: 216 control points, beyond which a sum takes minutes and a contraction longer than the passes of a
/// mesh of a million vertices.
const LARGEST: usize = 16 << 20;

/// Nanoseconds of one core for a sum at most, a minute: nobody's shot needs a longer one.
const LONGEST: f64 = 60e9;

/// The tensor must save this many times what it costs a correction: passes over a mesh use more cores than contractions do.
const FASTER: f64 = 4.0;

/// Whether tensors may come by themselves.
static BY_THEMSELVES: AtomicBool = AtomicBool::new(true);

/// Allows or forbids, for the whole process, that corrections become independent of the number of vertices by themselves. What they
/// give differs by rounding then, so a frame depends in its last bits on how many came before: forbid it where frames computed by
/// several processes must be the same to the bit. [`Binding::prepare`] works all the same.
pub fn prepare_in_background(allowed: bool) {
    BY_THEMSELVES.store(allowed, Ordering::Relaxed);
}

/// The tensor of a binding: not there yet, on its way, or there.
#[derive(Default)]
pub(crate) struct Chosen(Mutex<State>);

#[derive(Default)]
enum State {
    #[default]
    Fresh,
    /// Passes over the mesh so far.
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
    /// The tensor for the next correction, if it is there; starts to sum it up once `worth` passes went over the mesh, or never.
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
            State::Fresh => *state = State::Counting(0),
            State::Counting(_) if !BY_THEMSELVES.load(Ordering::Relaxed) => {}
            State::Counting(passes) => match worth() {
                None => *state = State::Never,
                Some(worth) if *passes >= worth => {
                    *state = start().map_or(State::Never, State::Building);
                }
                Some(_) => {}
            },
        }
        None
    }

    /// Counts passes that a correction took over the mesh.
    pub(crate) fn spent(&self, more: u32) {
        if let State::Counting(passes) = &mut *self.0.lock().unwrap_or_else(PoisonError::into_inner) {
            *passes = passes.saturating_add(more);
        }
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

/// Nanoseconds that one core takes, measured on a server's processor with 512-bit vectors: only their ratios matter.
struct Costs {
    /// A pass over the mesh, for one vertex: one axis' coefficients, or a shift along one.
    pass: f64,
    /// The sum over the mesh, for one vertex.
    sum: f64,
    /// A pass by the tensor.
    contraction: f64,
}

impl Costs {
    fn of(lattice: &Lattice) -> Self {
        let taps = lattice.axes().each_ref().map(|axis| axis.degree() + 1);
        let all: usize = taps.iter().product();
        let several_cells = lattice.axes().iter().any(|axis| axis.cells() > 1);
        // Fifteen multiply-adds in a nanosecond after evaluating a vertex and its neighbours. Triangles across cells take several
        // times as many; they are a part of all.
        let sum = 700.0 + operations(FIXED + all + 1) as f64 / 15.0;
        Self {
            // The cubic's passes are compiled for it.
            pass: if taps == [4; 3] { 8.0 } else { 3.3 + 0.38 * all as f64 },
            sum: if several_cells { 2.0 * sum } else { sum },
            // Shifts cost nothing: half of the contraction that belongs to each.
            contraction: 0.02 * Triples::bytes(functions(lattice)) as f64,
        }
    }

    /// Passes over the mesh that cost as much as the sum: whoever waits for so many never spends more than twice of what would have
    /// been best. `None` where the tensor does not pay.
    fn worth(&self, vertices: usize) -> Option<u32> {
        let vertices = vertices as f64;
        let pays = FASTER * self.contraction < vertices * self.pass && vertices * self.sum < LONGEST;
        pays.then(|| (self.sum / self.pass).ceil() as u32)
    }
}

fn functions(lattice: &Lattice) -> usize {
    FIXED + lattice.map().inner_len() + 1
}

impl<T: Scalar> Binding<T> {
    /// Sums up now what makes later corrections independent of the number of vertices, which otherwise happens in the background
    /// after some corrections, where that pays. Takes up to a few seconds for half a million vertices and a lattice of 4 x 4 x 4.
    /// Returns whether it is there: not for
    /// lattices of more than 216 control points, nor for several bodies or caps.
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
        let worth = || Costs::of(self.lattice()).worth(self.vertices().len());
        self.chosen().next(
            || self.has_tensor_form().ok()?.then(worth).flatten(),
            || with_engine!(self, engine => Building::start(self.source(engine).ok()?)),
        )
    }

    /// Whether the volume is a form of the control points alone that fits in memory.
    fn has_tensor_form(&self) -> Result<bool> {
        self.surface()?;
        let plain = self.partition().of_triangle().is_none() && !self.has_caps() && self.over().is_none();
        Ok(plain && Triples::bytes(functions(self.lattice())) <= LARGEST)
    }

    fn source<L: Lanes>(&self, engine: &Arc<Engine<L>>) -> Result<Source<L>> {
        let centre = self.lattice().centre();
        let map = self.lattice().map();
        let rest: Vec<DVec3> = self.rest().iter().map(|p| p - centre).collect();
        let weights = map.inner_weights();
        Ok(Source {
            engine: Arc::clone(engine),
            embedding: Arc::clone(self.embedding()),
            walks: Arc::clone(self.walks()?),
            rest: map.displacement(&rest).into_owned(),
            weights: weights.map_or_else(|| vec![1.0; map.inner_len()], <[f64]>::to_vec),
            is_weighted: weights.is_some(),
            centre,
            shape: map.inner_shape(),
        })
    }
}
