// SPDX-License-Identifier: GPL-3.0-or-later
//! The smallest displacement along one axis that meets several linear constraints at once: `delta = W M' (M W M')^-1 r`.
//!
//! The rows `M` are the pins' and the bodies' (the paper's Problem 2, equations (20)-(24), for any number of both). The solution
//! goes through an orthogonal basis of the rows, not through `M W M'`, which would square away half of the digits where rows
//! are nearly dependent.

use crate::preserve::metric::Metric;

/// A row of which less than this fraction is independent of those before it is dependent on them: the orthogonal basis knows its
/// part to about 1e-15, and a displacement that used it would be a billion times longer than one that met it alone.
const DEPENDENT: f64 = 1e-9;

/// Rows taken in one after the other, as an orthonormal basis of their span in the metric's coordinates.
#[derive(Debug, Clone, Default)]
pub(crate) struct Basis {
    directions: Vec<Vec<f64>>,
    /// Of each row accepted: its coordinates along the directions, the last its own.
    coordinates: Vec<Vec<f64>>,
}

/// What became of a row.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Taken {
    /// It is independent of those before; how long its independent part is.
    Independent(f64),
    /// It depends on those before, with these coefficients of the orthonormal directions.
    Dependent(Vec<f64>),
    /// It is zero: nothing that may move changes what it measures.
    Zero,
}

impl Basis {
    /// Takes a whitened row in, unless its independent part is shorter than `least` or dependent on the rows before.
    pub(crate) fn take(&mut self, row: Vec<f64>, least: f64) -> Taken {
        let length = norm(&row);
        if length <= least || length == 0.0 {
            return Taken::Zero;
        }
        let mut rest = row;
        let mut coordinates = vec![0.0; self.directions.len()];
        // Twice is enough: the second pass removes what rounding left of the first (Kahan and Parlett).
        for _ in 0..2 {
            for (direction, coordinate) in self.directions.iter().zip(&mut coordinates) {
                let along = dot(direction, &rest);
                *coordinate += along;
                add_scaled(&mut rest, direction, -along);
            }
        }
        let independent = norm(&rest);
        if independent <= DEPENDENT * length || independent <= least {
            return Taken::Dependent(coordinates);
        }
        rest.iter_mut().for_each(|value| *value /= independent);
        self.directions.push(rest);
        coordinates.push(independent);
        self.coordinates.push(coordinates);
        Taken::Independent(independent)
    }

    /// The shortest vector, in the metric's coordinates, whose products with the rows taken in are `values`.
    pub(crate) fn shortest(&self, values: &[f64]) -> Vec<f64> {
        let mut solved: Vec<f64> = Vec::with_capacity(values.len());
        for (coordinates, value) in self.coordinates.iter().zip(values) {
            let known: f64 = coordinates.iter().zip(&solved).map(|(c, s)| c * s).sum();
            solved.push((value - known) / coordinates[solved.len()]);
        }
        let mut shortest = vec![0.0; self.directions.first().map_or(0, Vec::len)];
        for (direction, along) in self.directions.iter().zip(&solved) {
            add_scaled(&mut shortest, direction, *along);
        }
        shortest
    }

    /// Forgets the row taken in last.
    pub(crate) fn drop_last(&mut self) {
        self.directions.pop();
        self.coordinates.pop();
    }

    /// The smallest displacement that changes what the rows taken in measure by `values`.
    pub(crate) fn displacement(&self, metric: &Metric, values: &[f64]) -> Vec<f64> {
        metric.displacement(&self.shortest(values))
    }
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

pub(crate) fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

pub(crate) fn add_scaled(to: &mut [f64], what: &[f64], factor: f64) {
    to.iter_mut().zip(what).for_each(|(to, what)| *to += factor * what);
}
