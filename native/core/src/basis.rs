// SPDX-License-Identifier: GPL-3.0-or-later
//! One axis of a lattice: a B-spline basis of any degree over any knot vector, Bernstein included.
//!
//! All knot vectors are stored rescaled, so that the domain `[k_d, k_n]` is `[0, 1]`. Clamped knots with
//! `count = degree + 1` give the Bernstein polynomials, so one recurrence serves every lattice.

use crate::error::{Error, Result};
use crate::words::number;

/// Largest number of control points on one axis (Blender's own lattices end there too).
pub const MAX_POINTS: usize = 64;

/// Shortest non-empty span, as a fraction of the domain. What float64 leaves of a basis function across a shorter one is
/// less than four digits.
const SHORTEST_SPAN: f64 = 1e-12;

/// B-spline basis functions of one axis over the parameter range `[0, 1]`.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisBasis {
    count: usize,
    degree: usize,
    knots: Vec<f64>,
    /// Knot index `m` of each non-empty span `[k_m, k_m+1)` of the domain, ascending.
    spans: Vec<usize>,
}

impl AxisBasis {
    /// Bernstein polynomials of degree `count - 1` (Sederberg ch. 14; Hoff).
    ///
    /// # Errors
    /// `count` is 0 or above [`MAX_POINTS`].
    pub fn bernstein(count: usize) -> Result<Self> {
        check_count(count)?;
        Self::clamped(count, count - 1)
    }

    /// Uniform B-spline, the volume paper's: knots evenly spaced, `(degree - 1)/2` layers of control points
    /// outside the domain on each side.
    ///
    /// # Errors
    /// Fewer than `degree + 1` points (1 is allowed: an axis without deformation), or more than [`MAX_POINTS`].
    pub fn uniform(count: usize, degree: usize) -> Result<Self> {
        check_count(count)?;
        let degree = degree_for(count, degree)?;
        Self::with_knots(count, degree, (0..=count + degree).map(|i| i as f64).collect())
    }

    /// Clamped (open) B-spline with evenly spaced inner knots: the first and last control points stand on the
    /// ends of the domain.
    ///
    /// # Errors
    /// As for [`AxisBasis::uniform`].
    pub fn clamped(count: usize, degree: usize) -> Result<Self> {
        check_count(count)?;
        let degree = degree_for(count, degree)?;
        let inner = count - degree;
        let knots =
            (0..=count + degree).map(|i| i.clamp(degree, count) - degree).map(|i| i as f64 / inner as f64);
        Self::with_knots(count, degree, knots.collect())
    }

    /// Any non-decreasing knot vector with `count + degree + 1` entries. The domain `[k_degree, k_count]` is
    /// rescaled to `[0, 1]`.
    ///
    /// # Errors
    /// Wrong length, NaN or infinity, decreasing knots, an empty domain, or a knot inside the domain repeated more
    /// than `degree` times (the lattice would tear there).
    pub fn with_knots(count: usize, degree: usize, knots: Vec<f64>) -> Result<Self> {
        check_count(count)?;
        let degree = degree_for(count, degree)?;
        if knots.len() != count + degree + 1 {
            return Err(Error::Lattice(format!(
                "knots: found {} values, expected {} (points {count} + degree {degree} + 1)",
                knots.len(),
                count + degree + 1
            )));
        }
        if let Some(i) = knots.iter().position(|k| !k.is_finite()) {
            return Err(Error::Lattice(format!(
                "knots: found {} at index {i}, expected finite numbers",
                number(knots[i])
            )));
        }
        if let Some(i) = knots.windows(2).position(|pair| pair[0] > pair[1]) {
            return Err(Error::Lattice(format!(
                "knots: found {:?} after {:?} at index {}, expected a non-decreasing sequence",
                knots[i + 1],
                knots[i],
                i + 1
            )));
        }
        let (first, last) = (knots[degree], knots[count]);
        if first >= last {
            return Err(Error::Lattice(format!(
                "knots: the domain from knot {degree} ({first:?}) to knot {count} ({last:?}) is empty, expected it to have a length"
            )));
        }
        if let Some(i) = (degree + 1..count.saturating_sub(degree)).find(|&i| knots[i + degree] == knots[i]) {
            return Err(Error::Lattice(format!(
                "knots: {} is repeated more than {degree} times inside the domain, which would tear the lattice; repeat it at most degree times",
                number(knots[i])
            )));
        }
        let knots: Vec<f64> = knots.iter().map(|k| (k - first) / (last - first)).collect();
        let short = |i: &usize| {
            (0.0..SHORTEST_SPAN).contains(&(knots[i + 1] - knots[*i])) && knots[i + 1] > knots[*i]
        };
        if let Some(i) = (degree..count).find(short) {
            return Err(Error::Lattice(format!(
                "knots: the span from knot {i} to {} is {} of the domain, expected at least {}; make the two knots equal",
                i + 1,
                number(knots[i + 1] - knots[i]),
                number(SHORTEST_SPAN)
            )));
        }
        if let Some(i) = knots.iter().position(|k| !k.is_finite()) {
            return Err(Error::Lattice(format!(
                "knots: the domain's length {} and knot {i} are too far apart for float64; scale the knots",
                number(last - first)
            )));
        }
        let spans = (degree..count).filter(|&m| knots[m] < knots[m + 1]).collect();
        Ok(Self { count, degree, knots, spans })
    }

    /// Number of control points.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Polynomial degree.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Knots, rescaled to a domain of `[0, 1]`; `count + degree + 1` of them.
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// Number of non-empty spans: cells of the lattice along this axis.
    pub fn cells(&self) -> usize {
        self.spans.len()
    }

    /// Index of the cell that holds `t`, a parameter in `[0, 1]`; 1 belongs to the last cell.
    pub fn cell(&self, t: f64) -> usize {
        self.spans.partition_point(|&m| self.knots[m] <= t).saturating_sub(1)
    }

    /// First control point with a non-zero basis function in a cell; `degree + 1` consecutive ones act there.
    pub fn first_point(&self, cell: usize) -> usize {
        self.spans[cell] - self.degree
    }

    /// The knots that a cell's basis functions depend on, ready for evaluation.
    pub fn span(&self, cell: usize) -> Span {
        Span::new(&self.knots, self.degree, self.spans[cell])
    }

    /// Parameter at which control point `i` stands at rest: the Greville abscissa, which makes the rest lattice the
    /// identity map. A single point stands in the middle.
    pub fn greville(&self, i: usize) -> f64 {
        if self.degree == 0 {
            return 0.5;
        }
        self.knots[i + 1..=i + self.degree].iter().sum::<f64>() / self.degree as f64
    }

    /// Number of outer layers of control points that act on an end of the domain: those to hold still when the surface
    /// must join what lies beyond without a tear. One for clamped ends, `degree` for uniform ones.
    pub fn end_layers(&self, upper: bool) -> usize {
        let at_end = |&&k: &&f64| if upper { k == 1.0 } else { k == 0.0 };
        let multiplicity = self.knots.iter().filter(at_end).count();
        (self.degree + 1).saturating_sub(multiplicity).max(1).min(self.count)
    }
}

fn check_count(count: usize) -> Result<()> {
    if (1..=MAX_POINTS).contains(&count) {
        return Ok(());
    }
    Err(Error::Lattice(format!("shape: found {count} control points on an axis, expected 1 to {MAX_POINTS}")))
}

/// An axis with one point is constant whatever the degree asked for.
fn degree_for(count: usize, degree: usize) -> Result<usize> {
    if count == 1 {
        return Ok(0);
    }
    if degree == 0 || degree >= count {
        return Err(Error::Lattice(format!(
            "degree: found {degree} with {count} control points on the axis, expected 1 to {}; use more points or a lower degree",
            count - 1
        )));
    }
    Ok(degree)
}

/// The knots around one cell and the reciprocals of their differences, as the Cox-de Boor recurrence uses them.
#[derive(Debug, Clone)]
pub struct Span {
    degree: usize,
    /// Parameter at which the cell starts.
    start: f64,
    /// `(k_left, k_right, 1 / (k_right - k_left))` for each inner step of the recurrence, in its order.
    steps: Vec<[f64; 3]>,
}

impl Span {
    fn new(knots: &[f64], degree: usize, m: usize) -> Self {
        let mut steps = Vec::with_capacity(degree * (degree + 1) / 2);
        for order in 1..=degree {
            for r in 0..order {
                let (left, right) = (knots[m + 1 + r - order], knots[m + 1 + r]);
                steps.push([left, right, 1.0 / (right - left)]);
            }
        }
        Self { degree, start: knots[m], steps }
    }

    /// Degree of the basis.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Parameter at which the cell starts.
    pub fn start(&self) -> f64 {
        self.start
    }

    /// Steps `(left knot, right knot, reciprocal of their difference)` of the recurrence, `degree (degree + 1) / 2` of
    /// them.
    pub fn steps(&self) -> &[[f64; 3]] {
        &self.steps
    }

    /// Of a cubic, the four basis functions as polynomials of the parameter measured from the cell's start: coefficients from
    /// the constant up. `None` for other degrees.
    pub fn cubic(&self) -> Option<[[f64; 4]; 4]> {
        if self.degree != 3 {
            return None;
        }
        // The recurrence on polynomials: times (c + d t) shifts coefficients.
        let times = |p: [f64; 4], c: f64, d: f64| -> [f64; 4] {
            std::array::from_fn(|i| c * p[i] + if i > 0 { d * p[i - 1] } else { 0.0 })
        };
        let mut functions = [[0.0; 4]; 4];
        functions[0][0] = 1.0;
        let mut steps = self.steps.iter();
        for order in 1..=3 {
            let mut carried = [0.0; 4];
            for (function, [left, right, inverse]) in functions[..order].iter_mut().zip(steps.by_ref()) {
                let part = function.map(|c| c * inverse);
                let falling = times(part, right - self.start, -1.0);
                *function = std::array::from_fn(|i| carried[i] + falling[i]);
                carried = times(part, self.start - left, 1.0);
            }
            functions[order] = carried;
        }
        Some(functions)
    }

    /// Values and derivatives of the `degree + 1` basis functions at `t`: those of degree `d` are `d` times the differences of
    /// neighbouring terms in the recurrence's last step.
    pub(crate) fn evaluate_with_slopes(&self, t: f64, weights: &mut [f64], slopes: &mut [f64]) {
        weights[0] = 1.0;
        slopes[0] = 0.0;
        let mut steps = self.steps.iter();
        for order in 1..=self.degree {
            let (mut carried, mut before) = (0.0, 0.0);
            let terms = weights[..order].iter_mut().zip(&mut slopes[..order]).zip(steps.by_ref());
            for ((weight, slope), [left, right, inverse]) in terms {
                let part = *weight * inverse;
                *weight = carried + (right - t) * part;
                *slope = order as f64 * (before - part);
                carried = (t - left) * part;
                before = part;
            }
            weights[order] = carried;
            slopes[order] = order as f64 * before;
        }
    }

    /// Values of the `degree + 1` basis functions at `t`, by the Cox-de Boor recurrence: sums of non-negative products, so
    /// stable at every degree.
    pub fn evaluate(&self, t: f64, weights: &mut [f64]) {
        weights[0] = 1.0;
        let mut steps = self.steps.iter();
        for order in 1..=self.degree {
            let mut carried = 0.0;
            for (weight, [left, right, inverse]) in weights[..order].iter_mut().zip(steps.by_ref()) {
                let part = *weight * inverse;
                *weight = carried + (right - t) * part;
                carried = (t - left) * part;
            }
            weights[order] = carried;
        }
    }
}
