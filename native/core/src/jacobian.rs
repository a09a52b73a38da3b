// SPDX-License-Identifier: GPL-3.0-or-later
//! The derivative of a shaped lattice in each of its cells, as Bernstein coefficients.
//!
//! The control points' differences are the coefficients of the three partial derivatives, splines again. In a cell each
//! is brought to Bernstein form by blossoming (Ramshaw; Sederberg ch. 6), and its own axis raised by one degree, so that
//! the matrix `J` of all three has one tensor of matrices for coefficients, of the lattice's own degree. Every step but
//! the differences is a convex combination: rounding is bounded by the largest difference in the cell.

use glam::{DMat3, DVec3};

use crate::basis::AxisBasis;
use crate::lattice::Lattice;
use crate::pieces::{contracted, indices};
use crate::quotient::{Quotient, Scaled};

/// Half of float64's epsilon: the relative error of one rounding.
const ROUNDING: f64 = f64::EPSILON / 2.0;

/// Roundings between control points and a value of `J`: a difference over a difference of knots; and for each axis, per
/// degree, a row of the change of basis (six a step), sums over it, Bernstein polynomials at a parameter that is itself
/// rounded (eight).
const DIFFERENCE_ROUNDINGS: f64 = 8.0;
const DEGREE_ROUNDINGS: f64 = 16.0;

/// One cell of one axis.
pub(crate) struct AxisCell {
    first_point: usize,
    start: f64,
    end: f64,
    /// From control points to Bernstein coefficients; `None` where they are the same.
    value: Option<Vec<Vec<f64>>>,
    /// From differences of control points to Bernstein coefficients of the derivative, raised by one degree.
    pub(crate) slope: Vec<Vec<f64>>,
}

/// The changes of basis of a lattice, the same for every shape of it.
pub(crate) struct Cells {
    axes: [Vec<AxisCell>; 3],
    degrees: [usize; 3],
}

/// A lattice's shape by the coefficients of its three partial derivatives, coordinates scaled by powers of two.
pub(crate) struct Derivatives {
    shape: [usize; 3],
    nets: [Vec<DVec3>; 3],
    /// In the place of both, where the lattice is no plain spline.
    quotient: Option<Quotient>,
}

/// Bernstein coefficients of `J` in a cell or a piece of one, the last axis fastest.
#[derive(Debug, Clone)]
pub(crate) struct Tensor {
    pub(crate) taps: [usize; 3],
    pub(crate) coefficients: Vec<DMat3>,
}

/// `J` in a cell, or a positive multiple of it, with what its numbers may be wrong by.
pub(crate) struct Cell {
    pub(crate) tensor: Tensor,
    /// No coefficient's entry is larger.
    pub(crate) largest: DMat3,
    /// Error of every entry, as a fraction of the largest.
    pub(crate) rounding: f64,
    /// Whether the multiple changes from place to place.
    pub(crate) is_scaled: bool,
    start: DVec3,
    end: DVec3,
}

impl Cells {
    pub(crate) fn new(lattice: &Lattice) -> Self {
        Self {
            axes: lattice
                .axes()
                .each_ref()
                .map(|axis| axis.domain_cells().map(|cell| AxisCell::new(axis, cell)).collect()),
            degrees: lattice.axes().each_ref().map(AxisBasis::degree),
        }
    }

    /// Number of cells along each axis.
    pub(crate) fn count(&self) -> [usize; 3] {
        self.axes.each_ref().map(Vec::len)
    }

    /// Whether anything changes along each axis.
    pub(crate) fn varies(&self) -> [bool; 3] {
        self.degrees.map(|degree| degree > 0)
    }

    /// `J` in one cell; `halvings`: how often it will be halved along each axis at most.
    pub(crate) fn cell(&self, of: &Derivatives, index: [usize; 3], halvings: u32) -> Cell {
        let axes: [&AxisCell; 3] = std::array::from_fn(|axis| &self.axes[axis][index[axis]]);
        let roundings = |degrees: [usize; 3]| {
            DEGREE_ROUNDINGS * degrees.iter().map(|degree| (degree + 1) as f64).sum::<f64>()
        };
        let of_spline = DIFFERENCE_ROUNDINGS + roundings(self.degrees);
        let scaled = match &of.quotient {
            Some(quotient) => {
                let mut scaled = quotient.cell(axes, self.degrees, of_spline);
                scaled.roundings += roundings(scaled.taps.map(|taps| taps - 1));
                scaled
            }
            None => self.plain(of, axes, of_spline),
        };
        let halved = f64::from(halvings) * scaled.taps.iter().map(|taps| (taps - 1) as f64).sum::<f64>();
        let [s, t, u] = &scaled.columns;
        let matrices = s.iter().zip(t).zip(u).map(|((&s, &t), &u)| DMat3::from_cols(s, t, u));
        Cell {
            tensor: Tensor { taps: scaled.taps, coefficients: matrices.collect() },
            largest: scaled.largest,
            rounding: ROUNDING * (scaled.roundings + halved),
            is_scaled: of.quotient.is_some(),
            start: DVec3::from_array(axes.map(|axis| axis.start)),
            end: DVec3::from_array(axes.map(|axis| axis.end)),
        }
    }

    /// Of a plain spline.
    fn plain(&self, of: &Derivatives, axes: [&AxisCell; 3], roundings: f64) -> Scaled {
        let taps = self.degrees.map(|degree| degree + 1);
        let mut largest = DMat3::ZERO;
        let columns: [Vec<DVec3>; 3] = std::array::from_fn(|along| {
            let (mut shape, mut reach) = (of.shape, taps);
            shape[along] = (shape[along] - 1).max(1);
            reach[along] = axes[along].slope[0].len();
            let values = window(&of.nets[along], shape, axes, reach);
            *largest.col_mut(along) = values.iter().fold(DVec3::ZERO, |most, value| most.max(value.abs()));
            spread(values, axes, reach, Some(along))
        });
        Scaled { taps, columns, largest, roundings }
    }
}

/// What acts in a cell, of a net of `shape`.
pub(crate) fn window(
    net: &[DVec3],
    shape: [usize; 3],
    axes: [&AxisCell; 3],
    window: [usize; 3],
) -> Vec<DVec3> {
    let first = axes.map(|axis| axis.first_point);
    let row = |i: usize, j: usize| ((first[0] + i) * shape[1] + first[1] + j) * shape[2] + first[2];
    indices([window[0], window[1], 1])
        .flat_map(|[i, j, _]| net[row(i, j)..row(i, j) + window[2]].iter().copied())
        .collect()
}

/// What acts in a cell as Bernstein coefficients; of the differences along an axis, those of the derivative.
pub(crate) fn spread(
    mut values: Vec<DVec3>,
    axes: [&AxisCell; 3],
    mut window: [usize; 3],
    along: Option<usize>,
) -> Vec<DVec3> {
    for axis in 0..3 {
        let rows = if along == Some(axis) { Some(&axes[axis].slope) } else { axes[axis].value.as_ref() };
        if let Some(rows) = rows {
            values = contracted(&values, window, axis, rows);
            window[axis] = rows.len();
        }
    }
    values
}

impl AxisCell {
    fn new(basis: &AxisBasis, cell: usize) -> Self {
        let span = basis.span(cell);
        let (first_point, degree, knots) = (basis.first_point(cell), basis.degree(), basis.knots());
        let (m, start) = (first_point + degree, span.start());
        let value = blossoms(knots, degree, m);
        let is_identity = value.iter().enumerate().all(|(i, row)| {
            row.iter().enumerate().all(|(j, &weight)| weight == if i == j { 1.0 } else { 0.0 })
        });
        let slope = match degree {
            0 => vec![vec![1.0]],
            _ => raised(&blossoms(&knots[1..knots.len() - 1], degree - 1, m - 1)),
        };
        Self { first_point, start, end: knots[m + 1], value: (!is_identity).then_some(value), slope }
    }
}

impl Derivatives {
    /// `control`: checked to fit the lattice. `is_displaced`: the form in which bound vertices move, where weights are unequal.
    pub(crate) fn new(lattice: &Lattice, control: &[DVec3], is_displaced: bool) -> Self {
        if !lattice.map().is_identity() {
            let quotient = Some(Quotient::new(lattice, control, is_displaced));
            return Self { shape: lattice.map().inner_shape(), nets: Default::default(), quotient };
        }
        let mut nets: [Vec<DVec3>; 3] =
            std::array::from_fn(|axis| differences(lattice, control, axis).collect());
        // A power of two for each coordinate changes no digit, and keeps products of three away from the ends of float64.
        let largest = nets.iter().flatten().fold(DVec3::ZERO, |most, value| most.max(value.abs()));
        let scale = largest.to_array().map(|size| (-size.log2().floor()).exp2());
        let scale = DVec3::from_array(scale.map(|s| if s.is_normal() { s } else { 1.0 }));
        nets.iter_mut().flatten().for_each(|value| *value *= scale);
        Self { shape: lattice.shape(), nets, quotient: None }
    }
}

/// Coefficients of the derivative along an axis: `d (P_i+1 - P_i) / (k_i+d+1 - k_i+1)`; the lattice's edge, on an axis
/// with one control point.
fn differences(lattice: &Lattice, control: &[DVec3], along: usize) -> impl Iterator<Item = DVec3> {
    let (basis, shape) = (&lattice.axes()[along], lattice.shape());
    let (degree, edge) = (basis.degree(), lattice.edges().col(along));
    let stride: usize = shape[along + 1..].iter().product();
    let mut count = shape;
    count[along] = (shape[along] - 1).max(1);
    indices(count).map(move |index| {
        if degree == 0 {
            return edge;
        }
        let at = (index[0] * shape[1] + index[1]) * shape[2] + index[2];
        (control[at + stride] - control[at]) * basis.slope_rate(index[along])
    })
}

impl Cell {
    /// Global parameters at local ones in `[0, 1]`, and `J` there, at the parameters as rounded.
    pub(crate) fn at(&self, local: DVec3) -> (DVec3, DMat3) {
        let length = self.end - self.start;
        let parameter = (self.start + local * length).clamp(self.start, self.end);
        let (up, down) = ((parameter - self.start) / length, (self.end - parameter) / length);
        (parameter, self.tensor.value(up, down))
    }
}

impl Tensor {
    /// The value at `up` in `[0, 1]`, of which `down` is the rest.
    fn value(&self, up: DVec3, down: DVec3) -> DMat3 {
        let weights: [Vec<f64>; 3] =
            std::array::from_fn(|axis| bernstein(self.taps[axis] - 1, up[axis], down[axis]));
        let mut coefficients = self.coefficients.iter();
        let mut sum = DMat3::ZERO;
        for a in &weights[0] {
            for b in &weights[1] {
                let line = coefficients.by_ref().take(self.taps[2]).zip(&weights[2]);
                sum += line.fold(DMat3::ZERO, |sum, (&matrix, &c)| sum + matrix * c) * (a * b);
            }
        }
        sum
    }

    /// The value in the middle.
    pub(crate) fn middle(&self) -> DMat3 {
        self.value(DVec3::splat(0.5), DVec3::splat(0.5))
    }

    /// The eight corners, as 0 and 1 along each axis, with the values there: coefficients themselves.
    pub(crate) fn corners(&self) -> impl Iterator<Item = (DVec3, DMat3)> {
        indices([2; 3]).map(|corner| {
            let [i, j, k]: [usize; 3] = std::array::from_fn(|axis| corner[axis] * (self.taps[axis] - 1));
            let at = (i * self.taps[1] + j) * self.taps[2] + k;
            (DVec3::from_array(corner.map(|c| c as f64)), self.coefficients[at])
        })
    }

    /// Halves the piece along an axis, by de Casteljau's algorithm: `self` becomes the upper half, the lower is returned.
    pub(crate) fn halve(&mut self, axis: usize) -> Self {
        let count = self.taps[axis];
        let stride: usize = self.taps[axis + 1..].iter().product();
        let mut lower = self.clone();
        for line in 0..self.coefficients.len() / count {
            let start = line / stride * stride * count + line % stride;
            for step in 1..count {
                for i in 0..count - step {
                    let at = start + i * stride;
                    self.coefficients[at] = (self.coefficients[at] + self.coefficients[at + stride]) * 0.5;
                }
                lower.coefficients[start + step * stride] = self.coefficients[start];
            }
        }
        lower
    }

    /// The largest difference between neighbouring coefficients along an axis, in units of `largest`, entry by entry.
    pub(crate) fn variation(&self, axis: usize, largest: &DMat3) -> f64 {
        let stride: usize = self.taps[axis + 1..].iter().product();
        let unit = largest.to_cols_array().map(|m| if m > 0.0 { m.recip() } else { 0.0 });
        let run = stride * self.taps[axis];
        let lines = self.coefficients.chunks(run);
        let pairs = lines.flat_map(|line| line.iter().zip(&line[stride..]));
        let size = |difference: DMat3| -> f64 {
            difference.to_cols_array().iter().zip(unit).map(|(d, unit)| d.abs() * unit).sum()
        };
        pairs.map(|(&a, &b)| size(b - a)).fold(0.0, f64::max)
    }
}

/// Rows that take the control points of a B-spline to its Bernstein coefficients in the span `[k_m, k_m+1]`: row `j` is
/// the blossom at `degree - j` times its start and `j` times its end, by de Boor's convex combinations.
fn blossoms(knots: &[f64], degree: usize, m: usize) -> Vec<Vec<f64>> {
    let unit = |i: usize| (0..=degree).map(|j| if i == j { 1.0 } else { 0.0 }).collect::<Vec<f64>>();
    (0..=degree)
        .map(|j| {
            let mut rows: Vec<Vec<f64>> = (0..=degree).map(unit).collect();
            for step in 1..=degree {
                let at = if step <= degree - j { knots[m] } else { knots[m + 1] };
                for i in (step..=degree).rev() {
                    let (left, right) = (knots[m - degree + i], knots[m + 1 + i - step]);
                    let (up, down) = ((at - left) / (right - left), (right - at) / (right - left));
                    let (below, here) = rows.split_at_mut(i);
                    let pairs = here[0].iter_mut().zip(&below[i - 1]);
                    pairs.for_each(|(here, below)| *here = up * *here + down * below);
                }
            }
            rows.swap_remove(degree)
        })
        .collect()
}

/// The rows of a Bernstein form raised by one degree.
fn raised(rows: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let count = rows.len();
    (0..=count)
        .map(|i| {
            let (of_left, of_right) = (i as f64 / count as f64, (count - i) as f64 / count as f64);
            (0..count)
                .map(|column| {
                    let left = if i > 0 { of_left * rows[i - 1][column] } else { 0.0 };
                    let right = if i < count { of_right * rows[i][column] } else { 0.0 };
                    left + right
                })
                .collect()
        })
        .collect()
}

/// Bernstein polynomials at `up`, of which `down` is the rest: sums of non-negative products.
fn bernstein(degree: usize, up: f64, down: f64) -> Vec<f64> {
    let mut values = vec![0.0; degree + 1];
    values[0] = 1.0;
    for order in 1..=degree {
        for i in (1..=order).rev() {
            values[i] = down * values[i] + up * values[i - 1];
        }
        values[0] *= down;
    }
    values
}
