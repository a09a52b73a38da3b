// SPDX-License-Identifier: GPL-3.0-or-later
//! A mesh bound to a lattice: everything that stays fixed while the control points move.

use std::sync::{Mutex, OnceLock, PoisonError};

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::embedding::{Embedding, Task, split};
use crate::error::{Error, Result};
use crate::kernels::{Cell, Deform, Reduce, Reduced, Shift};
use crate::lanes::{Lanes, dispatch};
use crate::lattice::Lattice;
use crate::surface::{ClosedSurface, Measure};
use crate::vertices::{Outside, Scalar, check_influence, check_triangles, check_vertices};
use crate::walks::Walks;

/// Vertices (and triangles, if a volume is wanted) embedded in a lattice.
///
/// All coordinates are in the lattice's space. Methods take `&self` and may run on several threads at once; results do
/// not depend on the number of threads.
pub struct Binding<T> {
    lattice: Lattice,
    vertices: Vec<[T; 3]>,
    triangles: Vec<[u32; 3]>,
    influence: Option<Vec<f64>>,
    outside: Outside,
    surface: OnceLock<Result<ClosedSurface>>,
    embedding: Embedding,
    walks: OnceLock<Walks>,
    reference: OnceLock<Measure>,
    /// Coordinate arrays of finished calls, kept for the next.
    spare: Mutex<Vec<State>>,
}

/// Coordinates of all slots.
pub(crate) type State = [Vec<Lanes>; 3];

impl<T: Scalar> Binding<T> {
    /// Embeds `vertices` in the lattice. `influence` (one number in [0, 1] a vertex) scales the deformation.
    ///
    /// Any points deform; a closed surface is needed, and checked, only when a volume is asked for.
    ///
    /// # Errors
    /// [`Error::Mesh`] for non-finite vertices, indices out of range, or a wrong influence.
    pub fn new(
        lattice: Lattice,
        vertices: Vec<[T; 3]>,
        triangles: Vec<[u32; 3]>,
        influence: Option<Vec<f64>>,
        outside: Outside,
    ) -> Result<Self> {
        check_vertices(&vertices)?;
        check_triangles(&triangles, vertices.len())?;
        if let Some(influence) = &influence {
            check_influence(influence, vertices.len())?;
        }
        let embedding = Embedding::new(&lattice, &vertices, influence.as_deref(), outside);
        Ok(Self {
            lattice,
            vertices,
            triangles,
            influence,
            outside,
            surface: OnceLock::new(),
            embedding,
            walks: OnceLock::new(),
            reference: OnceLock::new(),
            spare: Mutex::default(),
        })
    }

    /// Embeds anew what is given and keeps the rest: new positions for the same vertices, another lattice, another
    /// influence. The surface's topology is not looked at again. On an error nothing changes.
    ///
    /// # Errors
    /// [`Error::Mesh`] for another number of vertices, non-finite ones, or a wrong influence.
    pub fn update(
        &mut self,
        vertices: Option<Vec<[T; 3]>>,
        lattice: Option<Lattice>,
        influence: Option<Vec<f64>>,
    ) -> Result<()> {
        if let Some(vertices) = &vertices {
            if vertices.len() != self.vertices.len() {
                return Err(Error::Mesh(format!(
                    "vertices: found {}, expected the {} that were bound; bind anew after the topology changed",
                    vertices.len(),
                    self.vertices.len()
                )));
            }
            check_vertices(vertices)?;
        }
        if let Some(influence) = &influence {
            check_influence(influence, self.vertices.len())?;
            self.influence = Some(influence.clone());
        }
        if let Some(lattice) = lattice {
            self.lattice = lattice;
        }
        if let Some(vertices) = vertices {
            self.vertices = vertices;
            self.reference = OnceLock::new();
        }
        self.embedding =
            Embedding::new(&self.lattice, &self.vertices, self.influence.as_deref(), self.outside);
        self.walks = OnceLock::new();
        self.spare = Mutex::default();
        Ok(())
    }

    /// The lattice.
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// The vertices as bound.
    pub fn vertices(&self) -> &[[T; 3]] {
        &self.vertices
    }

    /// The triangles as bound.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Number of vertices beyond the lattice's domain.
    pub fn outside_count(&self) -> usize {
        self.embedding.outside
    }

    /// The closed surface that the triangles form.
    ///
    /// # Errors
    /// [`Error::Mesh`] where they form none.
    pub fn surface(&self) -> Result<&ClosedSurface> {
        self.surface
            .get_or_init(|| ClosedSurface::new(self.vertices.len(), &self.triangles))
            .as_ref()
            .map_err(Clone::clone)
    }

    /// Volume, area and radius of the mesh as bound.
    ///
    /// # Errors
    /// [`Error::Mesh`] where the triangles enclose no volume.
    pub fn reference(&self) -> Result<Measure> {
        self.surface()?;
        Ok(*self.reference.get_or_init(|| self.measure_vertices(&self.vertices)))
    }

    /// Measures deformed vertices (in the order bound) over the bound triangles, in float64.
    ///
    /// # Errors
    /// [`Error::Mesh`] where the triangles enclose no volume, or for another number of vertices.
    pub fn measure(&self, vertices: &[[T; 3]]) -> Result<Measure> {
        self.surface()?;
        if vertices.len() != self.vertices.len() {
            return Err(Error::Mesh(format!(
                "vertices: found {}, expected the {} that were bound",
                vertices.len(),
                self.vertices.len()
            )));
        }
        Ok(self.measure_vertices(vertices))
    }

    fn measure_vertices(&self, vertices: &[[T; 3]]) -> Measure {
        let at = |v: usize| DVec3::from_array(vertices[v].map(T::to_f64));
        Measure::of(at, vertices.len(), &self.triangles)
    }

    /// Deforms the vertices: the paper's equation (1), `x + influence * sum B (control - rest)`.
    ///
    /// `control`: the lattice's control points, `k` fastest. `out`: one entry a vertex, in the order bound.
    ///
    /// # Errors
    /// [`Error::Lattice`] for a wrong number of control points or non-finite ones; [`Error::Mesh`] for a wrong `out`.
    pub fn deform(&self, control: &[DVec3], out: &mut [[T; 3]]) -> Result<()> {
        let state = self.deformed(&self.lattice.displacement(control)?, None);
        self.write(&state, out)?;
        self.recycle(state);
        Ok(())
    }

    /// Signed volume of the mesh deformed by `control`, in float64 before rounding to the vertices' type.
    ///
    /// # Errors
    /// As [`Binding::deform`]; [`Error::Mesh`] where the triangles enclose no volume.
    pub fn volume(&self, control: &[DVec3]) -> Result<f64> {
        self.surface()?;
        let state = self.deformed(&self.lattice.displacement(control)?, None);
        let columns = flat(&state);
        let at = |v: usize| {
            let slot = self.embedding.slot[v] as usize;
            DVec3::new(columns[0][slot], columns[1][slot], columns[2][slot])
        };
        let volume = Measure::of(at, self.vertices.len(), &self.triangles).volume;
        self.recycle(state);
        Ok(volume)
    }

    /// All slots deformed by control displacements, then mapped linearly.
    pub(crate) fn deformed(&self, displacement: &[DVec3], map: Option<DMat3>) -> State {
        let mut state = self.take_state();
        let shape = self.lattice.shape();
        let [x, y, z] = state.each_mut().map(|column| split(column, self.run_lengths()));
        self.embedding.tasks.par_iter().zip(x).zip(y).zip(z).for_each(|(((task, x), y), z)| {
            let local: Vec<f64> = task.points(shape).flat_map(|p| displacement[p].to_array()).collect();
            dispatch(Deform {
                cell: self.cell(task),
                displacement: &local,
                rest: self.embedding.rest.each_ref().map(|column| &column[task.blocks.clone()]),
                map,
                out: [x, y, z],
            });
        });
        state
    }

    /// Adds `influence * B delta` to one coordinate of all slots.
    pub(crate) fn shift(&self, coordinate: &mut [Lanes], delta: &[f64]) {
        let shape = self.lattice.shape();
        let runs = split(coordinate, self.run_lengths());
        self.embedding.tasks.par_iter().zip(runs).for_each(|(task, run)| {
            let local: Vec<f64> = task.points(shape).map(|p| delta[p]).collect();
            dispatch(Shift { cell: self.cell(task), delta: &local, coordinate: run });
        });
    }

    /// The paper's coefficients (10)-(12) for one axis of the state, and the state's volume, both through the gradient
    /// at the vertices. Tasks are added in their order.
    pub(crate) fn coefficients(&self, state: &State, axis: usize, middle: f64) -> Result<(Vec<f64>, f64)> {
        let surface = self.surface()?;
        let walks = self.walks.get_or_init(|| Walks::new(&self.embedding, surface));
        let parts: Vec<Reduced> = self
            .embedding
            .tasks
            .par_iter()
            .map(|task| {
                dispatch(Reduce {
                    cell: self.cell(task),
                    first_block: task.blocks.start,
                    walks,
                    along: &state[axis],
                    next: [&state[(axis + 1) % 3], &state[(axis + 2) % 3]],
                    middle,
                })
            })
            .collect();
        let mut coefficients = vec![0.0; self.lattice.len()];
        for (task, part) in self.embedding.tasks.iter().zip(&parts) {
            for (point, c) in task.points(self.lattice.shape()).zip(&part.coefficients) {
                coefficients[point] += c;
            }
        }
        let volume: crate::sum::CompensatedSum = parts.iter().map(|part| part.volume).collect();
        Ok((coefficients, volume.value()))
    }

    /// Writes a state in the order bound, rounded to the vertices' type.
    pub(crate) fn write(&self, state: &State, out: &mut [[T; 3]]) -> Result<()> {
        if out.len() != self.vertices.len() {
            return Err(Error::Mesh(format!(
                "output: found room for {} vertices, expected {}",
                out.len(),
                self.vertices.len()
            )));
        }
        let columns = flat(state);
        out.par_iter_mut().zip(&self.embedding.slot).with_min_len(4096).for_each(|(to, &slot)| {
            *to = columns.map(|column| T::from_f64(column[slot as usize]));
        });
        Ok(())
    }

    /// Control points that the correction may move: with vertices kept beyond a face, not the layers acting on that face, or
    /// the mesh would tear there.
    pub(crate) fn correctable(&self) -> Vec<bool> {
        let shape = self.lattice.shape();
        let frozen = |axis: usize, index: usize| {
            let basis = &self.lattice.axes()[axis];
            let [lower, upper] = self.embedding.beyond[axis];
            (lower && index < basis.end_layers(false))
                || (upper && index >= basis.count() - basis.end_layers(true))
        };
        let keep = self.outside == Outside::Keep;
        (0..self.lattice.len())
            .map(|p| {
                let index = [p / (shape[1] * shape[2]), p / shape[2] % shape[1], p % shape[2]];
                !keep || (0..3).all(|axis| !frozen(axis, index[axis]))
            })
            .collect()
    }

    /// Returns a state's memory for the next call.
    pub(crate) fn recycle(&self, state: State) {
        self.spare.lock().unwrap_or_else(PoisonError::into_inner).push(state);
    }

    fn take_state(&self) -> State {
        let spare = self.spare.lock().unwrap_or_else(PoisonError::into_inner).pop();
        spare.unwrap_or_else(|| std::array::from_fn(|_| vec![Lanes::ZERO; self.embedding.blocks()]))
    }

    fn run_lengths(&self) -> impl Iterator<Item = usize> {
        self.embedding.tasks.iter().map(|task| task.blocks.len())
    }

    fn cell<'a>(&'a self, task: &'a Task) -> Cell<'a> {
        Cell {
            spans: task.spans.each_ref(),
            parameter: &self.embedding.parameter[task.blocks.clone()],
            influence: &self.embedding.influence[task.blocks.clone()],
        }
    }
}

fn flat(state: &State) -> [&[f64]; 3] {
    state.each_ref().map(|column| bytemuck::cast_slice(column))
}
