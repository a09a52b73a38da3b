// SPDX-License-Identifier: GPL-3.0-or-later
//! A mesh bound to a lattice: everything that stays fixed while the control points move.

use std::sync::{Arc, OnceLock};

use glam::DVec3;
use rayon::prelude::*;

use crate::bodies::{Bodies, Partition, check_labels, islands};
use crate::caps::Caps;
use crate::combination::Surface;
use crate::embedding::{Embedding, Located, Spot};
use crate::engine::{Engine, State, numbers};
use crate::error::{Error, Result};
use crate::inversion::{Inversion, Preimage};
use crate::lanes::{F32x8, F64x8, Lanes};
use crate::lattice::Lattice;
use crate::over::Over;
use crate::preserve::Costs;
use crate::surface::{ClosedSurface, Measure};
use crate::tensor::Chosen;
use crate::vertices::{Outside, Scalar, check_influence, check_triangles, check_vertices};
use crate::walks::Walks;
use crate::words::number;

/// Float32 vertices are deformed in float32 lanes where they fill at least this fraction of the domain along an axis. Rounding in
/// such lanes is relative to the domain's size; a smaller mesh would show it, and gets float64 lanes.
const SINGLE_EXTENT: f64 = 1.0 / 16.0;

/// How a mesh is bound, beyond what is bound to what.
#[derive(Debug, Clone, Default)]
pub struct Bind {
    /// One number in [0, 1] a vertex that scales the deformation; `None` for 1.
    pub influence: Option<Vec<f64>>,
    /// What happens to vertices beyond the lattice's domain.
    pub outside: Outside,
    /// Control points, `k` fastest, that leave every vertex where it is; `None` for the lattice's own.
    pub rest: Option<Vec<DVec3>>,
    /// Which triangles enclose a volume of their own.
    pub bodies: Bodies,
    /// Whether holes of bodies are closed by virtual fans of triangles about the mean of each boundary loop.
    pub caps: bool,
    /// The vertices that triangles join, as combinations of those bound; `None` where triangles join those bound themselves.
    pub surface: Option<Surface>,
}

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
    /// Control points that leave the vertices as they are; `None` for the lattice's own.
    rest: Option<Vec<DVec3>>,
    /// Where the vertices stand in the lattice shaped by `rest`.
    preimages: Option<Vec<Preimage>>,
    partition: Partition,
    pub(crate) over: Option<Over>,
    pub(crate) caps_wanted: bool,
    pub(crate) surface: OnceLock<Result<ClosedSurface>>,
    embedding: Arc<Embedding>,
    engine: Precision,
    walks: OnceLock<Arc<Walks>>,
    pub(crate) caps: OnceLock<Caps>,
    pub(crate) reference: OnceLock<Vec<Measure>>,
    costs: Costs,
    chosen: Chosen,
    pub(crate) proxy: OnceLock<Option<Box<Self>>>,
}

/// An engine in the lanes that suit the vertices.
pub(crate) enum Precision {
    Single(Arc<Engine<F32x8>>),
    Double(Arc<Engine<F64x8>>),
}

/// Does the same with an engine of either precision.
macro_rules! with_engine {
    ($binding:expr, $engine:ident => $value:expr) => {
        match $binding.engine() {
            crate::binding::Precision::Single($engine) => $value,
            crate::binding::Precision::Double($engine) => $value,
        }
    };
}
pub(crate) use with_engine;

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
        Self::shaped(lattice, vertices, triangles, influence, outside, None)
    }

    /// The same with a lattice that is shaped already: control points `rest` (`k` fastest) leave every vertex where it is, to
    /// the bit, and others move it by `influence * sum B (control - rest)`, at the parameters that [`Lattice::invert`] finds for it
    /// there. So an affine motion of the shaped lattice moves what is inside by just that motion. Vertices that are nowhere inside
    /// the shaped lattice count as outside: they stay, or move with the nearest parameters.
    ///
    /// # Errors
    /// As [`Binding::new`]; [`Error::Lattice`] for a wrong number of control points, and for coordinates not finite or too large.
    pub fn shaped(
        lattice: Lattice,
        vertices: Vec<[T; 3]>,
        triangles: Vec<[u32; 3]>,
        influence: Option<Vec<f64>>,
        outside: Outside,
        rest: Option<Vec<DVec3>>,
    ) -> Result<Self> {
        Self::with(lattice, vertices, triangles, Bind { influence, outside, rest, ..Bind::default() })
    }

    /// The same with several bodies or caps. A mesh without any closed body still deforms: that is an error where a volume is asked
    /// for.
    ///
    /// # Errors
    /// As [`Binding::shaped`]; [`Error::Mesh`] for labels that do not fit the triangles.
    pub fn with(
        lattice: Lattice,
        vertices: Vec<[T; 3]>,
        triangles: Vec<[u32; 3]>,
        options: Bind,
    ) -> Result<Self> {
        let Bind { influence, outside, rest, bodies, caps, surface } = options;
        check_vertices(&vertices)?;
        surface.iter().try_for_each(|over| over.check_count(vertices.len()))?;
        let over = surface.map(Over::new);
        check_triangles(&triangles, over.as_ref().map_or(vertices.len(), |over| over.surface.len()))?;
        if let Some(influence) = &influence {
            check_influence(influence, vertices.len())?;
        }
        if let Some(rest) = &rest {
            check_rest::<T>(&lattice, rest)?;
        }
        let (partition, surface) = partition(&vertices, over.as_ref(), &triangles, bodies, caps)?;
        let preimages = rest.as_deref().map(|rest| invert(&lattice, &vertices, rest, outside));
        let (embedding, engine) = embed(
            &lattice,
            &vertices,
            (&partition, over.as_ref()),
            preimages.as_deref(),
            influence.as_deref(),
            outside,
        );
        Ok(Self {
            lattice,
            vertices,
            triangles,
            influence,
            outside,
            rest,
            preimages,
            partition,
            over,
            caps_wanted: caps,
            surface,
            embedding,
            engine,
            walks: OnceLock::new(),
            costs: Costs::default(),
            caps: OnceLock::new(),
            reference: OnceLock::new(),
            chosen: Chosen::default(),
            proxy: OnceLock::new(),
        })
    }

    /// Embeds anew what is given and keeps what is not: new positions for the same vertices, another lattice, another
    /// influence, other control points at rest. The surface's topology is not looked at again, and its bodies stay. On an error nothing
    /// changes.
    ///
    /// # Errors
    /// [`Error::Mesh`] for another number of vertices, non-finite ones, or a wrong influence; [`Error::Lattice`] for control points
    /// at rest that do not fit the lattice, also those kept.
    pub fn update(
        &mut self,
        vertices: Option<Vec<[T; 3]>>,
        lattice: Option<Lattice>,
        influence: Option<Vec<f64>>,
        rest: Option<Vec<DVec3>>,
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
        }
        if let Some(rest) = rest.as_ref().or(self.rest.as_ref()) {
            check_rest::<T>(lattice.as_ref().unwrap_or(&self.lattice), rest)?;
        }
        let moved = vertices.is_some() || lattice.is_some() || rest.is_some();
        if let Some(vertices) = vertices {
            self.vertices = vertices;
            self.reference = OnceLock::new();
        }
        self.lattice = lattice.unwrap_or_else(|| self.lattice.clone());
        self.influence = influence.or_else(|| self.influence.take());
        self.rest = rest.or_else(|| self.rest.take());
        if moved {
            self.preimages =
                self.rest.as_deref().map(|rest| invert(&self.lattice, &self.vertices, rest, self.outside));
        }
        (self.embedding, self.engine) = embed(
            &self.lattice,
            &self.vertices,
            (&self.partition, self.over.as_ref()),
            self.preimages.as_deref(),
            self.influence.as_deref(),
            self.outside,
        );
        self.walks = OnceLock::new();
        self.costs = Costs::default();
        self.caps = OnceLock::new();
        self.chosen = Chosen::default();
        self.proxy = OnceLock::new();
        Ok(())
    }

    /// The lattice.
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// Control points that leave the vertices as they are.
    pub fn rest(&self) -> Vec<DVec3> {
        self.rest.clone().unwrap_or_else(|| self.lattice.rest())
    }

    /// The same where they are not the lattice's own.
    pub(crate) fn shaped_rest(&self) -> Option<&[DVec3]> {
        self.rest.as_deref()
    }

    /// The vertices as bound.
    pub fn vertices(&self) -> &[[T; 3]] {
        &self.vertices
    }

    /// The triangles as bound.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Number of vertices beyond the lattice's domain, or nowhere inside the lattice where it was bound in a shape.
    pub fn outside_count(&self) -> usize {
        self.embedding.outside
    }

    /// Deforms the vertices: the paper's equation (1), `x + influence * sum B (control - rest)`.
    ///
    /// `control`: the lattice's control points, `k` fastest. `out`: one entry a vertex, in the order bound.
    ///
    /// # Errors
    /// [`Error::Lattice`] for a wrong number of control points or non-finite ones; [`Error::Mesh`] for a wrong `out`.
    pub fn deform(&self, control: &[DVec3], out: &mut [[T; 3]]) -> Result<()> {
        let displacement = self.displacement(control)?;
        with_engine!(self, engine => {
            let inner = self.lattice.map().displacement(&displacement);
            let state = engine.deformed(&self.embedding.tasks, &inner, None);
            self.write(&state, out)?;
            engine.recycle(state);
        });
        Ok(())
    }

    /// `control - rest`, after checking that `control` fits the lattice and the type of the vertices.
    ///
    /// # Errors
    /// [`Error::Lattice`] for a wrong number of control points, and for coordinates not finite or too large.
    pub fn displacement(&self, control: &[DVec3]) -> Result<Vec<DVec3>> {
        self.lattice.check_control("control", control)?;
        check_largest::<T>("control", control)?;
        Ok(match &self.rest {
            Some(rest) => control.iter().zip(rest).map(|(p, rest)| p - rest).collect(),
            None => self.lattice.displacement(control)?,
        })
    }

    /// The factors of costs that couple control points.
    pub(crate) fn costs(&self) -> &Costs {
        &self.costs
    }

    /// The engine that deforms.
    pub(crate) fn engine(&self) -> &Precision {
        &self.engine
    }

    /// Where the vertices stand in the lattice.
    pub(crate) fn embedding(&self) -> &Arc<Embedding> {
        &self.embedding
    }

    /// The bodies.
    pub(crate) fn partition(&self) -> &Partition {
        &self.partition
    }

    /// The closed walks of neighbours around all slots.
    pub(crate) fn walks(&self) -> Result<&Arc<Walks>> {
        let surface = self.surface()?;
        if self.over.is_some() {
            return Err(Error::Mesh("surface: found vertices that combine others, expected the bound vertices themselves; only the CPU corrects over combinations".into()));
        }
        Ok(self.walks.get_or_init(|| Arc::new(Walks::new(&self.embedding, surface))))
    }

    /// Relative rounding error of one number in the passes over the vertices.
    pub(crate) fn epsilon(&self) -> f64 {
        match self.engine {
            Precision::Single(_) => f32::EPSILON.into(),
            Precision::Double(_) => f64::EPSILON,
        }
    }

    /// How much of the deformation each vertex takes; `None` for all of it.
    pub(crate) fn influence(&self) -> Option<&[f64]> {
        self.influence.as_deref()
    }

    /// What happens to vertices beyond the domain.
    pub(crate) fn outside(&self) -> Outside {
        self.outside
    }

    /// How corrections are to be computed.
    pub(crate) fn chosen(&self) -> &Chosen {
        &self.chosen
    }

    /// Writes a state in the order bound, rounded to the vertices' type.
    pub(crate) fn write<L: Lanes>(&self, state: &State<L>, out: &mut [[T; 3]]) -> Result<()> {
        if out.len() != self.vertices.len() {
            return Err(Error::Mesh(format!(
                "output: found room for {} vertices, expected {}",
                out.len(),
                self.vertices.len()
            )));
        }
        let columns = numbers(state);
        out.par_iter_mut().zip(self.embedding.slot_of_vertex()).with_min_len(4096).for_each(|(to, &slot)| {
            *to = columns.map(|column| T::from_f64(column[slot as usize].to_f64()));
        });
        Ok(())
    }

    /// Where a vertex stands in the lattice.
    pub(crate) fn located(&self, vertex: usize) -> Located {
        let influence = self.influence.as_ref().map_or(1.0, |all| all[vertex]);
        let spot = spot(&self.lattice, &self.vertices, self.preimages.as_deref(), vertex);
        Located::new::<T>(&self.lattice, spot, influence, self.outside)
    }

    /// Control points that the correction may move: with vertices kept beyond a face, not the layers acting on that face, or
    /// the mesh would tear there.
    pub(crate) fn correctable(&self) -> Vec<bool> {
        let shape = self.lattice.shape();
        let frozen = |axis: usize, index: usize| {
            let basis = &self.lattice.axes()[axis];
            let [lower, upper] = self.embedding.beyond[axis];
            (lower && index < basis.end_layers(false, 0))
                || (upper && index >= basis.count() - basis.end_layers(true, 0))
        };
        let keep = self.outside == Outside::Keep;
        (0..self.lattice.len())
            .map(|p| {
                let index = [p / (shape[1] * shape[2]), p / shape[2] % shape[1], p % shape[2]];
                !keep || (0..3).all(|axis| !frozen(axis, index[axis]))
            })
            .collect()
    }
}

pub(crate) fn too_large(volume: f64) -> Error {
    Error::Volume(format!(
        "the deformed mesh has a volume of {}, too large for float64; bring the control points closer",
        number(volume)
    ))
}

fn check_largest<T: Scalar>(name: &str, control: &[DVec3]) -> Result<()> {
    let largest = control.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    if largest > T::LARGEST {
        return Err(Error::Lattice(format!(
            "{name}: found a coordinate of {}, expected at most {} for vertices of this type",
            number(largest),
            number(T::LARGEST)
        )));
    }
    Ok(())
}

fn check_rest<T: Scalar>(lattice: &Lattice, rest: &[DVec3]) -> Result<()> {
    lattice.check_control("rest", rest)?;
    check_largest::<T>("rest", rest)
}

/// Where a lattice shaped by `rest` takes the vertices.
fn invert<T: Scalar>(
    lattice: &Lattice,
    vertices: &[[T; 3]],
    rest: &[DVec3],
    outside: Outside,
) -> Vec<Preimage> {
    let inversion = Inversion::new(lattice, rest);
    let nearest = outside == Outside::Extend;
    let find = |p: &[T; 3]| inversion.find(DVec3::from_array(p.map(T::to_f64)), T::FACE_TOLERANCE, nearest);
    vertices.par_iter().map(find).collect()
}

fn spot<T: Scalar>(
    lattice: &Lattice,
    vertices: &[[T; 3]],
    preimages: Option<&[Preimage]>,
    vertex: usize,
) -> Spot {
    match preimages {
        Some(preimages) => Spot::Inverted(preimages[vertex]),
        None => Spot::Projected(lattice.parameter(DVec3::from_array(vertices[vertex].map(T::to_f64)))),
    }
}

/// The bodies, and their surface where finding them took it.
fn partition<T: Scalar>(
    vertices: &[[T; 3]],
    over: Option<&Over>,
    triangles: &[[u32; 3]],
    bodies: Bodies,
    caps: bool,
) -> Result<(Partition, OnceLock<Result<ClosedSurface>>)> {
    let count = over.map_or(vertices.len(), |over| over.surface.len());
    match bodies {
        Bodies::Whole => Ok((Partition::whole(), OnceLock::new())),
        Bodies::Labels(labels) => {
            check_labels(&labels, triangles.len())?;
            Ok((Partition::labelled(count, triangles, labels), OnceLock::new()))
        }
        Bodies::Islands => {
            let bound = |v: usize| DVec3::from_array(vertices[v].map(T::to_f64));
            let places = over.map(|over| over.surface.at(bound));
            let at = |v: usize| places.as_ref().map_or_else(|| bound(v), |places| places[v]);
            let (partition, surface) = islands(count, triangles, at, T::EPSILON, caps);
            Ok((partition, OnceLock::from(surface)))
        }
    }
}

fn embed<T: Scalar>(
    lattice: &Lattice,
    vertices: &[[T; 3]],
    (partition, over): (&Partition, Option<&Over>),
    preimages: Option<&[Preimage]>,
    influence: Option<&[f64]>,
    outside: Outside,
) -> (Arc<Embedding>, Precision) {
    let at = |vertex: usize| spot(lattice, vertices, preimages, vertex);
    let partition = over.map_or(partition, |over| &over.whole);
    let (embedding, located) =
        Embedding::new::<T>(lattice, (vertices.len(), partition), at, influence, outside);
    // What combines few vertices to many sums their errors up.
    let single = T::EPSILON > f64::EPSILON && embedding.extent >= SINGLE_EXTENT && over.is_none();
    let engine = if single {
        Precision::Single(Arc::new(Engine::new(&embedding, &located, vertices, lattice.map().inner_shape())))
    } else {
        Precision::Double(Arc::new(Engine::new(&embedding, &located, vertices, lattice.map().inner_shape())))
    };
    (Arc::new(embedding), engine)
}
