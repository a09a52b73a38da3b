// SPDX-License-Identifier: GPL-3.0-or-later
//! Virtual caps: fans of triangles that close a body's holes, and the part that they add to its volume and coefficients.
//!
//! A cap has one triangle `(a, b, C)` for each half-edge `a b` of a loop, and its apex `C` is the mean of the loop's vertices. So
//! every volume stays trilinear in the control points, and all that holds for a closed surface holds here.
//!
//! Twice the area vector of the triangle, `n = (b - a) x (C - a)`, is what it adds to six times the gradient of each of its corners,
//! measured relative to that corner: the passes over the mesh close the walk around a corner on a loop through the corner itself, and
//! so give the rest. The apex's own gradient, the sum of all `n`, goes to the vertices of the loop in equal parts, as the apex does.

use glam::{DMat3, DVec3};

use crate::binding::Binding;
use crate::bodies::edges_of;
use crate::error::Result;
use crate::preserve::Coefficients;
use crate::vertices::Scalar;

/// The caps of a binding's bodies.
#[derive(Debug, Clone, Default)]
pub(crate) struct Caps {
    loops: Vec<Loop>,
    /// Nodes of all loops, one loop after the other.
    pub(crate) nodes: Vec<u32>,
    /// Where each stands in the lattice.
    weights: Vec<Weights>,
}

/// A loop of so many nodes.
#[derive(Debug, Clone)]
struct Loop {
    body: usize,
    length: usize,
}

/// The rows of the deformation at a node: along each axis the first inner control point and its functions, and the influence on all.
#[derive(Debug, Clone)]
struct Weights {
    axes: [(usize, Vec<f64>); 3],
    influence: f64,
}

impl Weights {
    /// Calls `each` with every control point's index and weight.
    fn visit(&self, shape: [usize; 3], mut each: impl FnMut(usize, f64)) {
        let [(i0, wu), (j0, wv), (k0, ww)] = &self.axes;
        for (i, a) in wu.iter().enumerate() {
            for (j, b) in wv.iter().enumerate() {
                let row = ((i0 + i) * shape[1] + j0 + j) * shape[2] + k0;
                let factor = self.influence * a * b;
                ww.iter().enumerate().for_each(|(k, c)| each(row + k, factor * c));
            }
        }
    }
}

impl Caps {
    fn new<T: Scalar>(binding: &Binding<T>) -> Result<Self> {
        let mut caps = Self::default();
        for each in binding.surface()?.loops() {
            let body = binding.partition().of_node(each[0] as usize) as usize;
            caps.loops.push(Loop { body, length: each.len() });
            for &node in each {
                let located = binding.located(binding.embedding().vertex(node));
                caps.nodes.push(node);
                caps.weights.push(Weights {
                    axes: binding.lattice().inner_axis_taps(DVec3::from_array(located.parameter)),
                    influence: located.inner_influence,
                });
            }
        }
        Ok(caps)
    }

    /// The nodes' ways for displaced control points.
    fn ways(&self, displacement: &[DVec3], shape: [usize; 3]) -> impl Iterator<Item = DVec3> {
        self.weights.iter().map(move |weights| {
            let mut way = DVec3::ZERO;
            weights.visit(shape, |point, weight| way += displacement[point] * weight);
            way
        })
    }

    /// Adds the caps' part of one axis. `positions`: of all nodes; `middles`: origin of each body's volume along the axis.
    pub(crate) fn add(
        &self,
        axis: usize,
        shape: [usize; 3],
        positions: &[DVec3],
        middles: &[f64],
        coefficients: &mut Coefficients,
    ) {
        let mut start = 0;
        for each in &self.loops {
            let range = start..start + each.length;
            start = range.end;
            let corners = &positions[range.clone()];
            let count = each.length as f64;
            let apex = corners.iter().sum::<DVec3>() / count;
            let normal = |a: DVec3, b: DVec3| (b - a).cross(apex - a)[axis];
            let order: Vec<u32> = (0..each.length as u32).collect();
            let mut pulls = vec![0.0; each.length];
            let (mut all, mut six_volumes) = (0.0, 0.0);
            for [from, to] in edges_of(&order).map(|edge| edge.map(|i| i as usize)) {
                let (a, b) = (corners[from], corners[to]);
                let normal = normal(a, b);
                pulls[from] += normal;
                pulls[to] += normal;
                all += normal;
                six_volumes += normal * (a[axis] + b[axis] + apex[axis] - 3.0 * middles[each.body]);
            }
            coefficients.volumes[each.body] += six_volumes / 6.0;
            let row = &mut coefficients.rows[each.body];
            for (weights, pull) in self.weights[range].iter().zip(pulls) {
                let pull = (pull + all / count) / 6.0;
                weights.visit(shape, |point, weight| row[point] += pull * weight);
            }
        }
    }
}

impl<T: Scalar> Binding<T> {
    /// Whether caps close holes of the bodies.
    pub fn has_caps(&self) -> bool {
        self.surface().is_ok_and(|surface| !surface.loops().is_empty())
    }

    /// The caps of all bodies, without any where there are none.
    pub(crate) fn caps(&self) -> Result<&Caps> {
        if let Some(caps) = self.caps.get() {
            return Ok(caps);
        }
        let caps = Caps::new(self)?;
        Ok(self.caps.get_or_init(|| caps))
    }

    /// Positions of the caps' vertices for inner control points displaced so (in space), mapped linearly: what
    /// [`Binding::add_caps`] needs of a backend that keeps the vertices elsewhere.
    ///
    /// # Errors
    /// [`crate::Error::Mesh`] where the triangles enclose no volume.
    pub fn cap_positions(&self, displacement: &[DVec3], map: DMat3) -> Result<Vec<DVec3>> {
        let caps = self.caps()?;
        let ways = caps.ways(displacement, self.lattice().map().inner_shape());
        let at = |node: u32| self.vertices()[self.embedding().vertex(node)].map(T::to_f64);
        Ok(caps
            .nodes
            .iter()
            .zip(ways)
            .map(|(&node, way)| map * (DVec3::from_array(at(node)) + way))
            .collect())
    }

    /// Adds the caps' part to what the passes over the mesh found for one axis and inner control points, with the walks of [`Binding::block_walks`].
    /// `positions`: as from [`Binding::cap_positions`]; `middles`: for each body the coordinate along the axis about which its volume was
    /// summed.
    ///
    /// # Errors
    /// [`crate::Error::Mesh`] where the triangles enclose no volume.
    pub fn add_caps(
        &self,
        axis: usize,
        positions: &[DVec3],
        middles: &[f64],
        coefficients: &mut Coefficients,
    ) -> Result<()> {
        self.caps()?.add(axis, self.lattice().map().inner_shape(), positions, middles, coefficients);
        Ok(())
    }
}
