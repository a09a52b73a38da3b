// SPDX-License-Identifier: GPL-3.0-or-later
//! A coarse copy of a mesh: corrections found on it are nearly those of the mesh, for a fraction of the passes' cost.

use std::collections::HashMap;

use glam::DVec3;

use crate::binding::{Bind, Binding, with_engine};
use crate::error::Result;
use crate::preserve::{Accuracy, Method, OnEngine, Plan, Preserve, Preserved};
use crate::surface::ClosedSurface;
use crate::vertices::Scalar;

/// Vertices below which a mesh is its own proxy: all passes of a correction take a millisecond or two.
const SMALLEST: usize = 20_000;

/// Vertices of a mesh for one of its proxy. Passes over the proxy then cost a few hundredths of those over the mesh; fewer vertices
/// would save nothing and cost accuracy.
const COARSER: f64 = 32.0;

/// Cells of a cubic grid that a surface meets, for one face of a cell in its area: 1.5 for a plane in any direction, and some are met
/// by surfaces of different directions, which are kept apart.
const CELLS_FOR_AREA: f64 = 1.7;

/// How far the proxy's volume may be from the mesh's, as a fraction. More is lost where the mesh is thinner than the grid.
const CLOSE: f64 = 0.25;

impl<T: Scalar> Binding<T> {
    /// The proxy, made when first asked for; `None` where the mesh has none that would do.
    fn proxy(&self) -> Option<&Self> {
        self.proxy.get_or_init(|| self.coarse().map(Box::new)).as_deref()
    }

    /// Joins the vertices of each cell of a grid whose normals point into the same octant. What were triangles and are not any more
    /// drop out in pairs of half-edges, so the rest is still a closed surface, if not a manifold one.
    fn coarse(&self) -> Option<Self> {
        let plain = self.partition().of_triangle().is_none() && !self.has_caps() && self.over().is_none();
        let reference = self.reference().ok()?;
        if !plain || self.vertices().len() < SMALLEST || reference.is_flat(T::EPSILON) {
            return None;
        }
        let size = (CELLS_FOR_AREA * reference.area * COARSER / self.vertices().len() as f64).sqrt();
        let (cluster, count) = self.clusters(size);
        let mean = |value: &dyn Fn(usize) -> DVec3| {
            let mut sums = vec![(DVec3::ZERO, 0.0); count];
            for (v, &c) in cluster.iter().enumerate() {
                sums[c as usize].0 += value(v);
                sums[c as usize].1 += 1.0;
            }
            sums.into_iter().map(|(sum, n)| sum / n).collect::<Vec<_>>()
        };
        let triangles: Vec<[u32; 3]> = self
            .triangles()
            .iter()
            .map(|corners| corners.map(|v| cluster[v as usize]))
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .collect();
        let influence =
            self.influence().map(|all| mean(&|v| DVec3::splat(all[v])).iter().map(|s| s.x).collect());
        let vertices = mean(&|v| self.position(v)).iter().map(|p| p.to_array().map(T::from_f64)).collect();
        let surface = ClosedSurface::of_cycle(count, &triangles);
        let options = Bind {
            influence,
            outside: self.outside(),
            rest: self.shaped_rest().map(<[DVec3]>::to_vec),
            ..Bind::default()
        };
        let proxy = Self::with(self.lattice().clone(), vertices, triangles, options).ok()?;
        proxy.surface.set(Ok(surface)).ok()?;
        let close = (proxy.reference().ok()?.volume / reference.volume - 1.0).abs() < CLOSE;
        close.then_some(proxy)
    }

    fn position(&self, vertex: usize) -> DVec3 {
        DVec3::from_array(self.vertices()[vertex].map(T::to_f64))
    }

    /// The cluster of each vertex, and their number.
    fn clusters(&self, size: f64) -> (Vec<u32>, usize) {
        let mut normals = vec![DVec3::ZERO; self.vertices().len()];
        for corners in self.triangles() {
            let [a, b, c] = corners.map(|v| self.position(v as usize));
            corners.iter().for_each(|&v| normals[v as usize] += (b - a).cross(c - a));
        }
        let mut known: HashMap<([i64; 3], [bool; 3]), u32> = HashMap::new();
        let cluster = normals.iter().enumerate().map(|(v, normal)| {
            let cell = ((self.position(v) - self.lattice().centre()) / size).floor();
            let next = known.len() as u32;
            let key = (cell.to_array().map(|c| c as i64), normal.to_array().map(|c| c < 0.0));
            *known.entry(key).or_insert(next)
        });
        let cluster = cluster.collect();
        (cluster, known.len())
    }

    /// Corrects on the proxy, and writes the mesh deformed by what was found; `None`, with nothing written, where the mesh itself
    /// must be corrected.
    pub(crate) fn preserve_by_proxy(
        &self,
        plan: &Plan,
        options: &Preserve,
        out: &mut [[T; 3]],
    ) -> Result<Option<Preserved>> {
        if plan.amount == 0.0 || plan.is_limited() {
            return Ok(None);
        }
        let Some(proxy) = self.proxy() else { return Ok(None) };
        let scale = proxy.reference()?.volume / self.reference()?.volume;
        let mut coarse = plan.clone();
        coarse.wanted.iter_mut().for_each(|volume| *volume *= scale);
        let found = with_engine!(proxy, engine => {
            let mut passes = OnEngine::new(proxy, engine, plan);
            let found = coarse.carry_out(&mut passes);
            engine.recycle(passes.state);
            found
        });
        // What cannot be reached is for the mesh itself to say.
        let Ok(mut found) = found else { return Ok(None) };
        found.targets.iter_mut().for_each(|volume| *volume /= scale);
        if options.accuracy == Accuracy::Rough {
            self.deform(&found.control, out)?;
            return Ok(Some(found));
        }
        let axis =
            (0..3).fold(0, |best, axis| if plan.shares[axis] >= plan.shares[best] { axis } else { best });
        let last = Preserve {
            axes: std::array::from_fn(|a| if a == axis { 1.0 } else { 0.0 }),
            method: Method::Sweep,
            target: Some(found.targets.clone()),
            amount: 1.0,
            accuracy: Accuracy::Exact,
            ..options.clone()
        };
        let Ok(finished) = self.preserve(&found.control, &last, out) else { return Ok(None) };
        let (control, iterations) = (finished.control, found.iterations + finished.iterations);
        Ok(Some(Preserved { distance: plan.distance(&control), control, iterations, ..found }))
    }
}
