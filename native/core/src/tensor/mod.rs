// SPDX-License-Identifier: GPL-3.0-or-later
//! Volume and coefficients from the control points alone, without a look at the mesh.
//!
//! The vertices are sums of fixed functions, one for each control point, times the control points; three more functions carry
//! what does not follow them. The volume is trilinear in the x, y, z of the vertices and changes sign where two are swapped, so it
//! is `sum T_abc det[C_a, C_b, C_c]` over the triples `a < b < c` of functions: `C` the control points, and the unit vectors for the
//! three more. `T_abc` is the volume with functions a, b, c for the vertices' x, y, z, summed once over the mesh.

mod build;
mod source;
mod triples;

use glam::DVec3;

use crate::lanes::{F64x8, Kernel, LANES, Lanes, dispatch};
use source::{FIXED, Source};
use triples::Triples;

/// Volume and coefficients of a binding as functions of its control points.
pub(crate) struct Tensor {
    triples: Triples,
    /// What control points are measured from; `None` for their own mean, where moving all of them by the same moves the whole
    /// mesh by the same.
    centre: Option<DVec3>,
}

/// All functions' coordinates along one axis, in whole lanes.
pub(crate) type Column = Vec<F64x8>;

impl Tensor {
    /// Sums up a mesh on `threads` threads, and gives up where `stop` says so.
    pub(crate) fn new<L: Lanes>(source: &Source<L>, threads: usize, stop: &(dyn Fn() -> bool + Sync)) -> Option<Self> {
        let triples = build::sum(source, threads, stop)?;
        Some(Self { triples, centre: (!source.engine.has_one_influence(&source.embedding)).then_some(source.centre) })
    }

    /// Coordinates of control points, in the frame that `map` maps to.
    pub(crate) fn columns(&self, control: &[DVec3], map: impl Fn(DVec3) -> DVec3) -> [Column; 3] {
        let centre = self.centre.unwrap_or_else(|| control.iter().sum::<DVec3>() / control.len() as f64);
        let points = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().chain(control.iter().map(|p| p - centre));
        let mut columns: [Column; 3] =
            std::array::from_fn(|_| vec![F64x8::ZERO; self.triples.functions().div_ceil(LANES)]);
        for (i, point) in points.enumerate() {
            let point = map(point).to_array();
            for axis in 0..3 {
                columns[axis][i / LANES].0[i % LANES] = point[axis];
            }
        }
        columns
    }

    /// Moves the control points along one axis.
    pub(crate) fn shift(column: &mut Column, delta: &[f64]) {
        let flat: &mut [f64] = bytemuck::cast_slice_mut(column);
        for (coordinate, delta) in flat[FIXED..].iter_mut().zip(delta) {
            *coordinate += delta;
        }
    }

    /// The paper's coefficients (10)-(12) of the control points along `axis`, and the volume.
    pub(crate) fn coefficients(&self, columns: &[Column; 3], axis: usize) -> (Vec<f64>, f64) {
        let all = dispatch(Contract {
            triples: &self.triples,
            next: [&columns[(axis + 1) % 3], &columns[(axis + 2) % 3]],
        });
        let along: &[f64] = bytemuck::cast_slice(&columns[axis]);
        let volume: crate::sum::CompensatedSum = all.iter().zip(along).map(|(c, p)| c * p).collect();
        (all[FIXED..].to_vec(), volume.value())
    }
}

/// `sum T_abc (Y_b Z_c - Y_c Z_b)` over `b`, `c` for every `a`.
struct Contract<'a> {
    triples: &'a Triples,
    next: [&'a Column; 2],
}

impl Contract<'_> {
    /// Of all triples with this `b`: adds to `sums` the part of the functions `a`, lane by lane, to `later` that of the functions
    /// `c`, to be summed over the lanes; returns that of `b`.
    #[inline(always)]
    fn of<const FUSED: bool>(&self, b: usize, sums: &mut [F64x8], later: &mut [F64x8], work: &mut [[F64x8; 3]]) -> f64 {
        let [y, z] = self.next;
        let [flat_y, flat_z]: [&[f64]; 2] = [bytemuck::cast_slice(y), bytemuck::cast_slice(z)];
        let (y_b, z_b) = (flat_y[b], flat_z[b]);
        let layers = Triples::layers(b);
        let work = &mut work[..layers];
        for layer in 0..layers {
            let across = y[layer].times(F64x8::splat(z_b)).minus(z[layer].times(F64x8::splat(y_b)));
            work[layer] = [across, F64x8::ZERO, F64x8::ZERO];
        }
        for (c, numbers) in (b + 1..).zip(self.triples.of(b).chunks_exact(layers)) {
            let (y_c, z_c) = (F64x8::splat(flat_y[c]), F64x8::splat(flat_z[c]));
            let mut own = later[c];
            for ([across, by_y, by_z], number) in work.iter_mut().zip(numbers) {
                own = number.multiply_add::<FUSED>(*across, own);
                *by_y = number.multiply_add::<FUSED>(y_c, *by_y);
                *by_z = number.multiply_add::<FUSED>(z_c, *by_z);
            }
            later[c] = own;
        }
        let mut own = F64x8::ZERO;
        for (layer, [_, by_y, by_z]) in work.iter().enumerate() {
            let pull = by_z.times(F64x8::splat(y_b)).minus(by_y.times(F64x8::splat(z_b)));
            sums[layer] = pull.multiply_add::<FUSED>(F64x8::splat(1.0), sums[layer]);
            own = by_y.multiply_add::<FUSED>(z[layer], own);
            own = own.minus(by_z.times(y[layer]));
        }
        own.sum()
    }
}

impl Kernel for Contract<'_> {
    type Output = Vec<f64>;
    #[inline(always)]
    fn run<const FUSED: bool>(self) -> Vec<f64> {
        let functions = self.triples.functions();
        let mut sums = vec![F64x8::ZERO; functions.div_ceil(LANES)];
        let mut later = vec![F64x8::ZERO; functions];
        let mut work = vec![[F64x8::ZERO; 3]; sums.len()];
        let mut own = vec![0.0; functions];
        for b in 1..functions - 1 {
            own[b] = self.of::<FUSED>(b, &mut sums, &mut later, &mut work);
        }
        let flat: &[f64] = bytemuck::cast_slice(&sums);
        for i in 0..functions {
            own[i] += flat[i] + later[i].sum();
        }
        own
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use crate::{AxisBasis, Binding, Lattice, Outside};
    use crate::binding::with_engine;
    use std::sync::Arc;
    use std::time::Instant;

    fn grid_sphere(m: usize) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
        // Six faces of a cube as one welded grid mesh pushed onto a sphere.
        use std::collections::HashMap;
        let mut index: HashMap<[i64; 3], u32> = HashMap::new();
        let (mut v, mut f) = (Vec::new(), Vec::new());
        for face in 0..6 {
            let (axis, side) = (face / 2, face % 2);
            for i in 0..m { for j in 0..m {
                let mut id = |i: usize, j: usize| {
                    let mut key = [0i64; 3];
                    key[axis] = if side == 1 { m as i64 } else { 0 };
                    key[(axis + 1) % 3] = i as i64;
                    key[(axis + 2) % 3] = j as i64;
                    *index.entry(key).or_insert_with(|| {
                        let p = DVec3::from_array(key.map(|k| 2.0 * k as f64 / m as f64 - 1.0)).normalize();
                        v.push((p * (1.0 + 0.1 * (5.0 * p.x).sin())).to_array());
                        v.len() as u32 - 1
                    })
                };
                let q = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
                let q = if side == 1 { q } else { [q[0], q[3], q[2], q[1]] };
                f.push([q[0], q[1], q[2]]);
                f.push([q[0], q[2], q[3]]);
            } }
        }
        (v, f)
    }

    #[test]
    fn timing() {
        let m: usize = std::env::var("M").ok().and_then(|m| m.parse().ok()).unwrap_or(20);
        let n: usize = std::env::var("N").ok().and_then(|m| m.parse().ok()).unwrap_or(4);
        let (v, f) = grid_sphere(m);
        let axes = std::array::from_fn(|_| if std::env::var("U").is_ok() { AxisBasis::uniform(n, 3).unwrap() } else { AxisBasis::bernstein(n).unwrap() });
        let pts: Vec<DVec3> = v.iter().map(|p| DVec3::from_array(*p)).collect();
        let lattice = Lattice::around(axes, &pts, 0.01).unwrap();
        let binding = Binding::new(lattice.clone(), v.clone(), f, None, Outside::Keep).unwrap();
        let rest = binding.rest();
        let centre = lattice.centre();
        let mut s = 1u64;
        let mut noise = || { s ^= s << 13; s ^= s >> 7; s ^= s << 17; (s >> 11) as f64 / (1u64 << 52) as f64 - 1.0 };
        let control: Vec<DVec3> = rest.iter().map(|p| *p * 0.7 + 0.2 * DVec3::new(noise(), noise(), noise())).collect();
        let mut out = vec![[0.0; 3]; v.len()];
        for _ in 0..3 {
            let t = Instant::now();
            binding.preserve(&control, &Default::default(), &mut out).unwrap();
            println!("{} vertices preserve {:?}", v.len(), t.elapsed());
            let t = Instant::now();
            binding.deform(&control, &mut out).unwrap();
            println!("deform {:?}", t.elapsed());
        }
        let displacement = binding.displacement(&control).unwrap();
        let embedding = Arc::clone(binding.embedding());
        let walks = Arc::clone(binding.walks().unwrap());
        with_engine!(&binding, engine => {
            let source = Source { engine: Arc::clone(engine), embedding: Arc::clone(&embedding), walks: Arc::clone(&walks), rest: rest.iter().map(|p| p - centre).collect(), centre, shape: lattice.shape() };
            for threads in [1, 2, 1] {
            let t = Instant::now();
            let tensor = Tensor::new(&source, threads, &|| false).unwrap();
            println!("build {threads} {:?} functions {}", t.elapsed(), source.functions());
            let state = engine.deformed(&embedding.tasks, &displacement, None);
            let mut columns = tensor.columns(&control, |p| p);
            for axis in 0..3 {
                let (e, ev) = engine.coefficients(&embedding.tasks, &walks, &state, axis, 0.0);
                let t = Instant::now();
                let (c, cv) = tensor.coefficients(&columns, axis);
                let took = t.elapsed();
                let big = e.iter().fold(0.0f64, |a, b| a.max(b.abs()));
                let err = e.iter().zip(&c).fold(0.0f64, |a, (b, c)| a.max((b - c).abs()));
                println!("axis {axis}: {took:?} err {:e} vol {:e} {ev}", err / big, cv / ev - 1.0);
            }
            Tensor::shift(&mut columns[0], &vec![0.0; rest.len()]);
            }
        });
    }
}
