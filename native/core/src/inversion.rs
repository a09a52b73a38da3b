// SPDX-License-Identifier: GPL-3.0-or-later
//! The way back through a shaped lattice: from points in space to the parameters that the lattice takes there.
//!
//! Newton's method, started from the affine map nearest to the lattice. Where that ends nowhere inside, the lattice is
//! searched: boxes around small pieces of it say where to start again. What is not found then lies outside, and gets the
//! nearest parameters. Every point is solved for itself, from the same start: results depend on neither order nor past.

use std::ops::{AddAssign, Mul};
use std::sync::OnceLock;

use glam::{DMat3, DVec3};

use crate::basis::{MAX_POINTS, Span};
use crate::lattice::{Lattice, bounds, unit_columns};
use crate::pieces::{NEAREST, Pieces, indices};

/// Sizes are of the order of 1 in the coordinates of the search. A residual below `EXACT` is left as it is; one that gets no
/// smaller counts as zero below `ROUNDING`. Both are fractions of the largest size in the lattice.
const EXACT: f64 = 1e-15;
const ROUNDING: f64 = 1e-13;

const NEWTON_STEPS: usize = 40;
const HALVINGS: usize = 6;
const NEAREST_STEPS: usize = 30;
/// Parameters that move by less are near enough, where a point is outside.
const NEAR_ENOUGH: f64 = 1e-9;
const DIFFERENCE: f64 = 1e-6;

/// The affine map that the search goes by is taken only where its unit columns enclose more than this volume: a worse one would
/// cost digits.
const FLAT_FIT: f64 = 1e-3;

/// Where a shaped lattice takes a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Preimage {
    /// Parameters (s, t, u) in the domain, where the point is inside; else the nearest ones found.
    pub parameter: DVec3,
    /// Whether the lattice takes the parameters to the point, to rounding.
    pub inside: bool,
}

/// A lattice in one shape, made ready to be inverted.
///
/// In its coordinates `y = to_local (x - origin)` the lattice is `s + sum B(s) bend`, over inner control points. With unequal weights it is
/// `s + sum B(s) bend / sum B(s) weights`; or, where it is the rational map itself, the same with what lies beyond the domain for `s`.
pub(crate) struct Inversion<'a> {
    lattice: &'a Lattice,
    /// The knots around every cell, along each axis.
    spans: [Vec<Span>; 3],
    origin: DVec3,
    to_local: DMat3,
    /// Of distances in space, and how much of plain ones they are at least.
    metric: DMat3,
    least: f64,
    /// What the inner control points add to the affine map, in local coordinates, times their weights.
    bend: Vec<DVec3>,
    weights: Option<&'a [f64]>,
    is_rational_map: bool,
    /// Axes with more than one control point: those that have faces.
    solid: [bool; 3],
    /// Box of the control points in local coordinates: all that is inside is inside this.
    hull: [DVec3; 2],
    /// Largest size in local coordinates.
    size: f64,
    pieces: OnceLock<Pieces>,
}

/// The lattice at parameters: how far from a point, and its derivatives.
struct Local {
    residual: DVec3,
    jacobian: DMat3,
}

impl<'a> Inversion<'a> {
    /// `control`: checked to fit the lattice.
    pub(crate) fn new(lattice: &'a Lattice, control: &[DVec3]) -> Self {
        let solid = lattice.axes().each_ref().map(|axis| axis.count() > 1);
        let (weights, is_rational_map) = (lattice.map().inner_weights(), lattice.is_rational_map());
        let (points, grid) = (inner_points(lattice, control), abscissae(lattice));
        // Displacements over a denominator are no displacements any more where another frame takes part of them.
        let own_frame = weights.is_some() && !is_rational_map;
        let (origin, frame) =
            if own_frame { (lattice.origin(), lattice.edges()) } else { nearest_affine(lattice, &points) };
        let to_local = inverse(frame);
        // About the frame's origin first, so that a lattice far away loses no more digits than it has to.
        let mut bend: Vec<DVec3> =
            points.iter().zip(&grid).map(|(p, s)| to_local * (p - origin - frame * *s)).collect();
        let size = 1.0 + bend.iter().map(|d| d.abs().max_element()).fold(0.0, f64::max);
        let spans =
            lattice.axes().each_ref().map(|axis| (0..axis.cells()).map(|cell| axis.span(cell)).collect());
        let placed: Vec<DVec3> = grid.iter().zip(&bend).map(|(s, d)| s + d).collect();
        let mut hull = <[DVec3; 2]>::from(bounds(&placed));
        if own_frame {
            let (low, high) = bounds(&bend);
            hull = [low, high + DVec3::ONE];
        }
        if is_rational_map {
            bend = placed;
        }
        if let Some(weights) = weights {
            bend.iter_mut().zip(weights).for_each(|(bend, weight)| *bend *= *weight);
        }
        let metric = frame.transpose() * frame;
        let least = to_local.to_cols_array().iter().map(|c| c * c).sum::<f64>().recip();
        Self {
            lattice,
            spans,
            origin,
            to_local,
            metric,
            least,
            bend,
            weights,
            is_rational_map,
            solid,
            hull,
            size,
            pieces: OnceLock::new(),
        }
    }

    /// Where the lattice takes `point`; parameters within `tolerance` of the domain count as in it. `nearest`: whether a point
    /// outside needs the nearest parameters, or only parameters on the faces that it lies beyond, which cost far less.
    pub(crate) fn find(&self, point: DVec3, tolerance: f64, nearest: bool) -> Preimage {
        let local = self.to_local * (point - self.origin);
        if let Some(parameter) = self.beyond_hull(local, tolerance) {
            return if nearest { self.nearest_of(&[], local) } else { Preimage { parameter, inside: false } };
        }
        let first = self.newton(local, local);
        if let Some(parameter) = first.filter(|s| self.is_inside(*s, tolerance)) {
            return Preimage { parameter, inside: true };
        }
        let mut starts = self.pieces().holding(local, self.metric);
        starts.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (_, start) in &starts {
            let found = self.newton(local, *start).filter(|s| self.is_inside(*s, tolerance));
            if let Some(parameter) = found {
                return Preimage { parameter, inside: true };
            }
        }
        match first {
            Some(beyond) if !nearest => Preimage { parameter: self.clamped(beyond), inside: false },
            _ => self.nearest_of(&starts, local),
        }
    }

    /// For a point beyond the box of the control points, parameters on the faces on those sides.
    fn beyond_hull(&self, local: DVec3, tolerance: f64) -> Option<DVec3> {
        let [low, high] = self.hull;
        let mut parameter = self.clamped(local);
        let mut is_beyond = false;
        for axis in (0..3).filter(|&axis| self.solid[axis]) {
            let room = tolerance + ROUNDING * self.size;
            let (below, above) = (local[axis] < low[axis] - room, local[axis] > high[axis] + room);
            if below || above {
                (parameter[axis], is_beyond) = (f64::from(u8::from(above)), true);
            }
        }
        is_beyond.then_some(parameter)
    }

    /// The nearest place from a few starts, or from the nearest pieces where there are none.
    fn nearest_of(&self, starts: &[(f64, DVec3)], local: DVec3) -> Preimage {
        let pieces = self.pieces().nearest(local, self.metric, self.least);
        let found = starts.iter().take(NEAREST).chain(&pieces).map(|(_, start)| self.nearest(local, *start));
        let (distance, parameter) = found
            .map(|at| (self.distance(&self.evaluate(at, local)), at))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .unwrap_or((f64::INFINITY, local));
        // Where numbers overflow there is no nearest place: any other than NaN.
        let parameter = if parameter.is_finite() { parameter } else { DVec3::splat(0.5) };
        // On its way along the faces it may have come to the point itself.
        let inside =
            distance.is_finite() && self.evaluate(parameter, local).residual.length() <= ROUNDING * self.size;
        Preimage { parameter, inside }
    }

    /// The squared distance in space.
    fn distance(&self, here: &Local) -> f64 {
        here.residual.dot(self.metric * here.residual)
    }

    fn is_inside(&self, parameter: DVec3, tolerance: f64) -> bool {
        (0..3).all(|axis| !self.solid[axis] || (-tolerance..=1.0 + tolerance).contains(&parameter[axis]))
    }

    /// Newton's method with halved steps; `None` where it does not end at the point. Beyond the domain the lattice goes on by
    /// its affine map, so iterates may leave it and come back.
    fn newton(&self, local: DVec3, start: DVec3) -> Option<DVec3> {
        let mut at = start;
        let mut here = self.evaluate(at, local);
        for _ in 0..NEWTON_STEPS {
            let error = here.residual.length();
            if error <= EXACT * self.size {
                break;
            }
            let Some((next, there)) = self.step(at, &here, local) else { break };
            (at, here) = (next, there);
        }
        (here.residual.length() <= ROUNDING * self.size).then_some(at)
    }

    /// The longest of the halved steps that comes nearer; `None` where none does.
    fn step(&self, at: DVec3, here: &Local, local: DVec3) -> Option<(DVec3, Local)> {
        let error = here.residual.length();
        let step = -(here.jacobian.inverse() * here.residual);
        if !step.is_finite() {
            return None;
        }
        // What is as good as zero may lose its last digits, but is not worth a search.
        let halvings = if error <= ROUNDING * self.size { 0 } else { HALVINGS };
        (0..=halvings).find_map(|halved| {
            let next = at + step * 0.5f64.powi(halved as i32);
            let there = self.evaluate(next, local);
            (there.residual.length() < error).then_some((next, there))
        })
    }

    /// Parameters in the domain where the lattice comes nearest to the point, from a start: Newton's method on the squared
    /// distance, on the faces where it leads beyond them.
    fn nearest(&self, local: DVec3, start: DVec3) -> DVec3 {
        let mut at = self.clamped(start);
        let mut here = self.evaluate(at, local);
        for _ in 0..NEAREST_STEPS {
            let downhill = self.downhill(&here);
            let free: [bool; 3] = std::array::from_fn(|axis| {
                let stuck =
                    (at[axis] <= 0.0 && downhill[axis] < 0.0) || (at[axis] >= 1.0 && downhill[axis] > 0.0);
                !(self.solid[axis] && stuck)
            });
            let gentle = here.jacobian.transpose() * self.metric * here.jacobian;
            let step = reduced_step(self.curvature(at, downhill, local), downhill, free)
                .or_else(|| reduced_step(gentle, downhill, free));
            // Cut off at the faces, a step may lead away; along one axis alone it does not.
            let better = step
                .and_then(|step| self.nearer(at, &here, step, local))
                .or_else(|| self.nearer(at, &here, axis_step(gentle, downhill, free)?, local));
            let Some((next, there)) = better else { break };
            let moved = (next - at).abs().max_element();
            (at, here) = (next, there);
            if moved < NEAR_ENOUGH {
                break;
            }
        }
        at
    }

    /// The longest of the halved steps in the domain that comes nearer in space; `None` where none does.
    fn nearer(&self, at: DVec3, here: &Local, step: DVec3, local: DVec3) -> Option<(DVec3, Local)> {
        let distance = self.distance(here);
        (0..=HALVINGS).find_map(|halved| {
            let next = self.clamped(at + step * 0.5f64.powi(halved as i32));
            let there = self.evaluate(next, local);
            (self.distance(&there) < distance).then_some((next, there))
        })
    }

    /// Minus half the derivative of the squared distance.
    fn downhill(&self, here: &Local) -> DVec3 {
        -(here.jacobian.transpose() * (self.metric * here.residual))
    }

    /// Half the second derivative of the squared distance, by differences into the domain.
    fn curvature(&self, at: DVec3, downhill: DVec3, local: DVec3) -> DMat3 {
        let column = |axis: usize| {
            let step = if at[axis] > 0.5 { -DIFFERENCE } else { DIFFERENCE };
            let mut beside = at;
            beside[axis] += step;
            (downhill - self.downhill(&self.evaluate(beside, local))) / step
        };
        let matrix = DMat3::from_cols(column(0), column(1), column(2));
        (matrix + matrix.transpose()) * 0.5
    }

    fn clamped(&self, parameter: DVec3) -> DVec3 {
        let mut clamped = parameter;
        (0..3)
            .filter(|&axis| self.solid[axis])
            .for_each(|axis| clamped[axis] = clamped[axis].clamp(0.0, 1.0));
        clamped
    }

    /// The lattice at `parameter`, less `local`, and its derivatives; beyond the domain the bend stays that of the nearest
    /// parameters.
    fn evaluate(&self, parameter: DVec3, local: DVec3) -> Local {
        // Cubics are by far the commonest; room for any degree takes longer to clear than they take to evaluate.
        if self.lattice.axes().iter().all(|axis| axis.degree() < 4) {
            self.evaluate_in::<4>(parameter, local)
        } else {
            self.evaluate_in::<MAX_POINTS>(parameter, local)
        }
    }

    fn evaluate_in<const MAX: usize>(&self, parameter: DVec3, local: DVec3) -> Local {
        let mut weights = [[0.0; MAX]; 3];
        let mut slopes = [[0.0; MAX]; 3];
        let mut first = [0; 3];
        let mut taps = [0; 3];
        for axis in 0..3 {
            let (basis, t) = (&self.lattice.axes()[axis], parameter[axis].clamp(0.0, 1.0));
            let cell = basis.cell(t);
            (first[axis], taps[axis]) = (basis.first_point(cell), basis.degree() + 1);
            self.spans[axis][cell].evaluate_with_slopes(t, &mut weights[axis], &mut slopes[axis]);
            if t != parameter[axis] {
                slopes[axis].fill(0.0);
            }
        }
        let taps = Taps { first, taps, weights: &weights, slopes: &slopes };
        let shape = self.lattice.map().inner_shape();
        let [mut value, mut by_s, mut by_t, mut by_u] = taps.sums(&self.bend, shape);
        if let Some(weights) = self.weights {
            let [whole, of_s, of_t, of_u] = taps.sums(weights, shape);
            value /= whole;
            by_s = (by_s - value * of_s) / whole;
            by_t = (by_t - value * of_t) / whole;
            by_u = (by_u - value * of_u) / whole;
        }
        let (base, [s, t, u]) = self.base(parameter);
        Local {
            residual: (base - local) + value,
            jacobian: DMat3::from_cols(DVec3::X * s + by_s, DVec3::Y * t + by_t, DVec3::Z * u + by_u),
        }
    }

    /// What no control point moves, and its slope along each axis.
    fn base(&self, parameter: DVec3) -> (DVec3, [f64; 3]) {
        if !self.is_rational_map {
            return (parameter, [1.0; 3]);
        }
        let clamped = self.clamped(parameter);
        let mut base = parameter - clamped;
        (0..3).filter(|&axis| !self.solid[axis]).for_each(|axis| base[axis] = parameter[axis] - 0.5);
        let moves = |axis: usize| !self.solid[axis] || clamped[axis] != parameter[axis];
        (base, std::array::from_fn(|axis| f64::from(u8::from(moves(axis)))))
    }

    fn pieces(&self) -> &Pieces {
        self.pieces.get_or_init(|| {
            Pieces::new(self.lattice, &self.bend, self.weights, |parameter| self.base(parameter).0)
        })
    }
}

/// Basis functions at parameters, along each axis, and their slopes.
struct Taps<'a, const MAX: usize> {
    first: [usize; 3],
    taps: [usize; 3],
    weights: &'a [[f64; MAX]; 3],
    slopes: &'a [[f64; MAX]; 3],
}

impl<const MAX: usize> Taps<'_, MAX> {
    /// The sum over what control points carry, and its slopes along s, t, u. Along u first, then t, then s.
    fn sums<V>(&self, carried: &[V], shape: [usize; 3]) -> [V; 4]
    where
        V: Copy + Default + AddAssign + Mul<f64, Output = V>,
    {
        let Self { first, taps, weights, slopes } = self;
        let [_, nv, nw] = shape;
        let [mut value, mut by_s, mut by_t, mut by_u] = [V::default(); 4];
        for i in 0..taps[0] {
            let [mut plane, mut plane_t, mut plane_u] = [V::default(); 3];
            for j in 0..taps[1] {
                let row = ((first[0] + i) * nv + first[1] + j) * nw + first[2];
                let [mut line, mut line_u] = [V::default(); 2];
                for (k, &point) in carried[row..row + taps[2]].iter().enumerate() {
                    line += point * weights[2][k];
                    line_u += point * slopes[2][k];
                }
                plane += line * weights[1][j];
                plane_t += line * slopes[1][j];
                plane_u += line_u * weights[1][j];
            }
            value += plane * weights[0][i];
            by_s += plane * slopes[0][i];
            by_t += plane_t * weights[0][i];
            by_u += plane_u * weights[0][i];
        }
        [value, by_s, by_t, by_u]
    }
}

/// Where the inner control points stand of a lattice shaped so; of Blender's bases, those that give it as a plain lattice.
fn inner_points(lattice: &Lattice, control: &[DVec3]) -> Vec<DVec3> {
    let map = lattice.map();
    if lattice.axes().iter().all(|axis| axis.rows().is_none()) {
        return control.to_vec();
    }
    let displacement: Vec<DVec3> = control.iter().zip(lattice.rest()).map(|(p, rest)| p - rest).collect();
    let mut moved = map.displacement(&displacement).into_owned();
    if let Some(weights) = map.inner_weights() {
        moved.iter_mut().zip(weights).for_each(|(way, weight)| *way /= *weight);
    }
    moved.iter().zip(abscissae(lattice)).map(|(way, s)| lattice.point(s) + way).collect()
}

/// The affine map nearest to a shaped lattice, as its origin and edges: control points over their abscissae, by least squares.
/// On a tensor grid the axes do not depend on each other. Axes with one control point keep the lattice's edge; the lattice's own
/// frame is taken where the nearest map is all but flat.
fn nearest_affine(lattice: &Lattice, control: &[DVec3]) -> (DVec3, DMat3) {
    let grid = abscissae(lattice);
    let count = control.len() as f64;
    let (middle, centre) = (control.iter().sum::<DVec3>() / count, grid.iter().sum::<DVec3>() / count);
    let mut edges = lattice.edges();
    for axis in 0..3 {
        let spread: f64 = grid.iter().map(|s| (s[axis] - centre[axis]).powi(2)).sum();
        if lattice.axes()[axis].count() > 1 {
            let lever = grid.iter().zip(control).map(|(s, p)| (s[axis] - centre[axis]) * (p - middle));
            *edges.col_mut(axis) = lever.sum::<DVec3>() / spread;
        }
    }
    let is_sound = edges.is_finite() && unit_columns(edges).determinant().abs() > FLAT_FIT;
    let frame = if is_sound { edges } else { lattice.edges() };
    (middle - frame * centre, frame)
}

/// Parameters at which the inner control points stand in a plain lattice at rest.
fn abscissae(lattice: &Lattice) -> Vec<DVec3> {
    let at = |index: [usize; 3]| {
        DVec3::from_array(std::array::from_fn(|axis| lattice.axes()[axis].inner_greville(index[axis])))
    };
    indices(lattice.map().inner_shape()).map(at).collect()
}

/// By columns of length one, so that edges of very different lengths cost no digits.
fn inverse(frame: DMat3) -> DMat3 {
    let lengths = DVec3::new(frame.x_axis.length(), frame.y_axis.length(), frame.z_axis.length());
    DMat3::from_diagonal(lengths.recip()) * unit_columns(frame).inverse()
}

/// The step that solves `matrix step = right` on the free axes; `None` where it does not lead the way of `right`.
fn reduced_step(mut matrix: DMat3, mut right: DVec3, free: [bool; 3]) -> Option<DVec3> {
    for axis in (0..3).filter(|&axis| !free[axis]) {
        for other in 0..3 {
            matrix.col_mut(axis)[other] = 0.0;
            matrix.col_mut(other)[axis] = 0.0;
        }
        matrix.col_mut(axis)[axis] = 1.0;
        right[axis] = 0.0;
    }
    let step = matrix.inverse() * right;
    (step.is_finite() && step.dot(right) > 0.0).then_some(step)
}

/// The step along that free axis on which it gains most; `None` where it gains nothing worth a search.
fn axis_step(matrix: DMat3, right: DVec3, free: [bool; 3]) -> Option<DVec3> {
    let step = |axis: usize| right[axis] / matrix.col(axis)[axis];
    let gain = |axis: usize| right[axis] * step(axis);
    let best = (0..3)
        .filter(|&axis| free[axis] && gain(axis).is_finite())
        .max_by(|&a, &b| gain(a).total_cmp(&gain(b)))?;
    (step(best).abs() > NEAR_ENOUGH).then(|| DVec3::AXES[best] * step(best))
}
