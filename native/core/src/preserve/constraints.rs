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

/// A row that keeps more than this fraction of its length has lost so few digits to the rows before that one pass makes it orthogonal
/// to them (Kahan and Parlett's criterion).
const KEPT: f64 = 0.7;

/// The shortest vector that meets the rows of a basis, which grows with it.
#[derive(Debug, Clone)]
pub(crate) struct Solution {
    /// Coordinates along the directions.
    along: Vec<f64>,
    /// The vector itself, in the metric's coordinates; empty before the first row.
    pub(crate) vector: Vec<f64>,
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
        let mut independent = length;
        // Twice is enough: the second pass removes what rounding left of the first (Kahan and Parlett).
        for _ in 0..2 {
            for (direction, coordinate) in self.directions.iter().zip(&mut coordinates) {
                let along = quick_dot(direction, &rest);
                *coordinate += along;
                add_scaled(&mut rest, direction, -along);
            }
            independent = norm(&rest);
            if independent > KEPT * length {
                break;
            }
        }
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
        self.solve(values).vector
    }

    /// The same, to be grown with the basis.
    pub(crate) fn solve(&self, values: &[f64]) -> Solution {
        let mut solution = Solution { along: Vec::new(), vector: Vec::new() };
        values.iter().for_each(|&value| self.meet(&mut solution, value));
        solution
    }

    /// Makes a solution meet the next row as well, whose product must be `value`.
    pub(crate) fn meet(&self, solution: &mut Solution, value: f64) {
        let next = solution.along.len();
        let (direction, coordinates) = (&self.directions[next], &self.coordinates[next]);
        let along = (value - solution.product(coordinates)) / coordinates[next];
        solution.along.push(along);
        solution.vector.resize(direction.len(), 0.0);
        add_scaled(&mut solution.vector, direction, along);
    }

    /// Of a vector in the span of the rows taken in, given by its products with the directions: how much of each row it takes.
    pub(crate) fn combination(&self, along: &[f64]) -> Vec<f64> {
        let mut combination = along.to_vec();
        for last in (0..combination.len()).rev() {
            combination[last] /= self.coordinates[last][last];
            let share = combination[last];
            let earlier = combination[..last].iter_mut().zip(&self.coordinates[last]);
            earlier.for_each(|(left, coordinate)| *left -= share * coordinate);
        }
        combination
    }

    /// Products of a vector with the orthonormal directions.
    pub(crate) fn along(&self, vector: &[f64]) -> Vec<f64> {
        self.directions.iter().map(|direction| dot(direction, vector)).collect()
    }

    /// Takes from a vector what lies in the span of the rows taken in. Twice, as rounding wants it.
    pub(crate) fn project_off(&self, vector: &mut [f64]) {
        for _ in 0..2 {
            for direction in &self.directions {
                let along = dot(direction, vector);
                add_scaled(vector, direction, -along);
            }
        }
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

impl Solution {
    /// Its product with a row of such coordinates along the directions.
    pub(crate) fn product(&self, coordinates: &[f64]) -> f64 {
        coordinates.iter().zip(&self.along).map(|(c, s)| c * s).sum()
    }
}

/// Columns that [`quick_dot`] adds up side by side: as many as fill the vector units whatever they take to add.
const COLUMNS: usize = 16;

/// [`dot`] in another order of terms, several times as fast.
pub(crate) fn quick_dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<COLUMNS>(), b.as_chunks::<COLUMNS>());
    let mut sums = [0.0; COLUMNS];
    for (a, b) in a.iter().zip(b) {
        for column in 0..COLUMNS {
            sums[column] += a[column] * b[column];
        }
    }
    sums.iter().sum::<f64>() + dot(a_rest, b_rest)
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
