// SPDX-License-Identifier: GPL-3.0-or-later
//! Weights that keep a correction local (Remark 2 of the volume paper): near chosen points, or where the volume went.

use std::ops::{Add, Mul};

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::basis::AxisBasis;
use crate::error::{Error, Result};
use crate::lattice::Lattice;
use crate::net::Net;
use crate::pieces::indices;
use crate::words::number;

/// Exponents up to this one leave weights that are numbers, with room for sums of them.
const LARGEST_EXPONENT: f64 = 600.0;

/// A volume that changes by no more than this fraction anywhere has not changed: rounding alone changes it by 1e-15 or so.
const UNCHANGED: f64 = 1e-9;

impl Lattice {
    /// `exp(d / distance)` for each control point, `k` fastest, where `d` is its distance from the nearest of `points`: figure 7's
    /// weights, with which a correction stays near them. Control points stand at rest, or as in `control`.
    ///
    /// Where even the smallest weight were more than `exp(600)`, all are divided by one factor, which changes no correction. Those
    /// that are no number even so are infinite: frozen.
    ///
    /// # Errors
    /// [`Error::Lattice`] without points, for points that are not finite, for a distance that is not finite and positive, and for a
    /// control array of another length or with a non-finite entry.
    pub fn falloff(&self, points: &[DVec3], distance: f64, control: Option<&[DVec3]>) -> Result<Vec<f64>> {
        if points.is_empty() {
            return Err(Error::Lattice("points: found none, expected at least one to fall off from".into()));
        }
        if let Some(i) = points.iter().position(|p| !p.is_finite()) {
            return Err(Error::Lattice(format!(
                "points: found NaN or infinity at index {i}, expected finite numbers"
            )));
        }
        if !(distance.is_finite() && distance > 0.0) {
            return Err(Error::Lattice(format!(
                "distance: found {}, expected a positive number, in the units of the points",
                number(distance)
            )));
        }
        let rest;
        let control = match control {
            Some(control) => {
                self.check_control("control", control)?;
                control
            }
            None => {
                rest = self.rest();
                &rest
            }
        };
        let exponent = |from: &DVec3| {
            points.iter().map(|point| from.distance(*point)).fold(f64::INFINITY, f64::min) / distance
        };
        let exponents: Vec<f64> = control.par_iter().map(exponent).collect();
        let smallest = exponents.iter().copied().fold(f64::INFINITY, f64::min);
        let common = (smallest - LARGEST_EXPONENT).max(0.0);
        Ok(exponents.into_iter().map(|exponent| (exponent - common).exp()).collect())
    }

    /// Weights that are small where the lattice changed volume, `k` fastest: the correction goes where the loss is (the volume paper's
    /// conclusion).
    ///
    /// The determinant of the map's derivative says by how much volume changes at a place. A control point `i` answers for its
    /// support, so the change is averaged with its basis function: `e_i = |sum B_i (det J - det J_rest)| / sum B_i |det J_rest|`, sums over
    /// `degree + 1` evenly spaced parameters in each cell along each axis. Its weight is `1 / (floor + (1 - floor) e_i / max e)`:
    /// 1 where most was lost or gained, `1 / floor` where nothing was. Without any change all weights are 1. With weights `w` the functions
    /// are `w B / sum w B`.
    ///
    /// `rest`: the shape that volume is measured from; `None` for the lattice at rest. `floor`: in (0, 1]; 0.01 leaves a hundredth
    /// of the mobility to what did not change, and 1 makes all equal.
    ///
    /// # Errors
    /// [`Error::Lattice`] for arrays of another length or with a non-finite entry, and for another floor.
    pub fn loss_weights(&self, control: &[DVec3], rest: Option<&[DVec3]>, floor: f64) -> Result<Vec<f64>> {
        if !(floor > 0.0 && floor <= 1.0) {
            return Err(Error::Lattice(format!(
                "floor: found {}, expected a number above 0, up to 1",
                number(floor)
            )));
        }
        let displacement = self.displacement(control)?;
        let shapes = match rest {
            Some(rest) => {
                self.check_control("rest", rest)?;
                [Net::of(self, control)?, Net::of(self, rest)?]
            }
            None => [displacement, vec![DVec3::ZERO; self.len()]].map(|moved| Net::displaced(self, &moved)),
        };
        let changes = Changes::new(self, &shapes).of_points();
        let largest = changes.iter().copied().fold(0.0, f64::max);
        if !(largest > UNCHANGED && largest.is_finite()) {
            return Ok(vec![1.0; self.len()]);
        }
        Ok(changes.into_iter().map(|change| 1.0 / (floor + (1.0 - floor) * change / largest)).collect())
    }
}

/// Basis functions of one axis and their slopes at evenly spaced parameters.
struct Samples {
    first_point: usize,
    weights: Vec<f64>,
    slopes: Vec<f64>,
    /// Length of the part of the domain that the sample stands for.
    length: f64,
}

/// Two shapes of a lattice, compared.
struct Changes<'a> {
    lattice: &'a Lattice,
    shapes: &'a [Net<'a>; 2],
    samples: [Vec<Samples>; 3],
}

impl<'a> Changes<'a> {
    fn new(lattice: &'a Lattice, shapes: &'a [Net<'a>; 2]) -> Self {
        Self { lattice, shapes, samples: lattice.axes().each_ref().map(samples) }
    }

    /// `e_i` of each control point, `k` fastest.
    fn of_points(&self) -> Vec<f64> {
        let map = self.lattice.map();
        let [_, nv, nw] = map.inner_shape();
        // A layer of samples at a time; layers are added in order, so the sums are the same on any number of threads.
        let layers: Vec<[Vec<f64>; 2]> = self.samples[0].par_iter().map(|s| self.of_layer(s)).collect();
        let mut sums = [(); 2].map(|()| vec![0.0; map.inner_len()]);
        for (s, layer) in self.samples[0].iter().zip(layers) {
            for (i, weight) in s.weights.iter().enumerate() {
                let start = (s.first_point + i) * nv * nw;
                for (sums, layer) in sums.iter_mut().zip(&layer) {
                    let to = sums[start..].iter_mut().zip(layer);
                    to.for_each(|(sum, part)| *sum += s.length * weight * part);
                }
            }
        }
        let [change, whole] = sums.map(|sums| map.row(sums));
        let share = |(change, whole): (f64, f64)| if whole > 0.0 { change.abs() / whole } else { 0.0 };
        change.into_iter().zip(whole).map(share).collect()
    }

    /// Sums over one layer of samples, for each inner control point of a layer: of the change, and of what it is a change of.
    fn of_layer(&self, s: &Samples) -> [Vec<f64>; 2] {
        let [_, nv, nw] = self.lattice.map().inner_shape();
        let mut sums = [(); 2].map(|()| vec![0.0; nv * nw]);
        for t in &self.samples[1] {
            for u in &self.samples[2] {
                let at = [s, t, u];
                let area = t.length * u.length;
                let [now, before] =
                    self.shapes.each_ref().map(|shape| area * self.jacobian(shape, at).determinant());
                let denominator = self.shapes[0].weights.map_or(1.0, |weights| self.sums(weights, at).0);
                let parts = [(now - before) / denominator, before.abs() / denominator];
                for (j, b) in t.weights.iter().enumerate() {
                    let row = (t.first_point + j) * nw + u.first_point;
                    for (sums, part) in sums.iter_mut().zip(parts) {
                        let to = sums[row..].iter_mut().zip(&u.weights);
                        to.for_each(|(sum, c)| *sum += b * c * part);
                    }
                }
            }
        }
        sums
    }

    /// The derivative of the map, in parameters.
    fn jacobian(&self, shape: &Net<'_>, at: [&Samples; 3]) -> DMat3 {
        let (value, slopes) = self.sums(&shape.values, at);
        let columns = match shape.weights {
            None => slopes,
            Some(weights) => {
                let (whole, by) = self.sums(weights, at);
                std::array::from_fn(|axis| (slopes[axis] - value / whole * by[axis]) / whole)
            }
        };
        shape.base_slope() + DMat3::from_cols(columns[0], columns[1], columns[2])
    }

    /// What inner control points carry, summed with the functions of a sample, and with their slopes along each axis.
    fn sums<V>(&self, carried: &[V], [s, t, u]: [&Samples; 3]) -> (V, [V; 3])
    where
        V: Copy + Default + Add<Output = V> + Mul<f64, Output = V>,
    {
        let [_, nv, nw] = self.lattice.map().inner_shape();
        let taps = [s, t, u].map(|axis| axis.weights.len());
        let (mut sum, mut columns) = (V::default(), [V::default(); 3]);
        for [i, j, _] in indices([taps[0], taps[1], 1]) {
            let row = ((s.first_point + i) * nv + t.first_point + j) * nw + u.first_point;
            let (mut value, mut slope) = (V::default(), V::default());
            for (k, &d) in carried[row..row + taps[2]].iter().enumerate() {
                value = value + d * u.weights[k];
                slope = slope + d * u.slopes[k];
            }
            sum = sum + value * (s.weights[i] * t.weights[j]);
            columns[0] = columns[0] + value * (s.slopes[i] * t.weights[j]);
            columns[1] = columns[1] + value * (s.weights[i] * t.slopes[j]);
            columns[2] = columns[2] + slope * (s.weights[i] * t.weights[j]);
        }
        (sum, columns)
    }
}

/// `degree + 1` samples in each cell of an axis, in the middles of equal parts.
fn samples(axis: &AxisBasis) -> Vec<Samples> {
    let count = axis.degree() + 1;
    let of_cell = |cell: usize| {
        let (span, first_point) = (axis.span(cell), axis.first_point(cell));
        let (start, end) = (span.start(), axis.knots()[first_point + axis.degree() + 1]);
        (0..count).map(move |part| {
            let t = start + (end - start) * (part as f64 + 0.5) / count as f64;
            let (mut weights, mut slopes) = (vec![0.0; count], vec![0.0; count]);
            span.evaluate_with_slopes(t, &mut weights, &mut slopes);
            Samples { first_point, weights, slopes, length: (end - start) / count as f64 }
        })
    };
    axis.domain_cells().flat_map(of_cell).collect()
}
