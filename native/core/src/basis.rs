// SPDX-License-Identifier: GPL-3.0-or-later
//! One axis of a lattice: a B-spline basis of any degree over any knot vector, Bernstein included.
//!
//! All knot vectors are stored rescaled, so that the domain `[k_d, k_n]` is `[0, 1]`. Clamped knots with
//! `count = degree + 1` give the Bernstein polynomials, so one recurrence serves every lattice.

use std::ops::Range;

use crate::error::{Error, Result};
use crate::words::number;

/// Largest number of control points on one axis (Blender's own lattices end there too).
pub const MAX_POINTS: usize = 64;

/// Shortest non-empty span, as a fraction of the domain. What float64 leaves of a basis function across a shorter one is
/// less than four digits.
const SHORTEST_SPAN: f64 = 1e-12;

/// A derivative this much smaller than the largest of its order is nothing but rounding.
const NO_SLOPE: f64 = 1e-9;

/// A sparse matrix by rows: of each the columns and the entries.
pub(crate) type Rows = Vec<Vec<(usize, f64)>>;

/// Basis functions of one axis over the parameter range `[0, 1]`: those of a B-spline, or sums of them.
///
/// Cells, spans, knots and the degree are the spline's. Where functions are sums of the spline's (Blender's, [`AxisBasis::blender`]), its
/// control points are *inner* ones, more than the axis has, and it reaches beyond `[0, 1]`.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisBasis {
    /// Of the spline.
    count: usize,
    degree: usize,
    knots: Vec<f64>,
    /// Knot index `m` of each non-empty span `[k_m, k_m+1)` of the domain, ascending.
    spans: Vec<usize>,
    /// Where the functions are sums of the spline's.
    sums: Option<Sums>,
}

/// Functions that are sums of a spline's.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Sums {
    /// Number of functions.
    pub(crate) count: usize,
    /// Of each of the spline's control points what it takes of those of the axis.
    pub(crate) rows: Rows,
    /// Cells beyond each end of `[0, 1]`.
    pub(crate) beyond: usize,
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
        Ok(Self::of_spline(count, degree, knots, None))
    }

    pub(crate) fn of_spline(count: usize, degree: usize, knots: Vec<f64>, sums: Option<Sums>) -> Self {
        let spans = (degree..count).filter(|&m| knots[m] < knots[m + 1]).collect();
        Self { count, degree, knots, spans, sums }
    }

    /// Number of control points.
    pub fn count(&self) -> usize {
        self.sums.as_ref().map_or(self.count, |sums| sums.count)
    }

    /// Number of the spline's control points.
    pub fn inner_count(&self) -> usize {
        self.count
    }

    /// What the spline's control points take of the axis's; `None` where they are the same.
    pub(crate) fn rows(&self) -> Option<&Rows> {
        self.sums.as_ref().map(|sums| &sums.rows)
    }

    /// Whether functions may be negative.
    pub(crate) fn has_negative_functions(&self) -> bool {
        self.rows().is_some_and(|rows| rows.iter().flatten().any(|(_, share)| *share < 0.0))
    }

    /// The parameter nearest to `t` at which the functions are defined; beyond they go on as they are there.
    pub(crate) fn clamped_to_reach(&self, t: f64) -> f64 {
        t.clamp(self.knots[self.degree], self.knots[self.count])
    }

    /// The cells of `[0, 1]`.
    pub(crate) fn domain_cells(&self) -> Range<usize> {
        let beyond = self.sums.as_ref().map_or(0, |sums| sums.beyond);
        beyond..self.cells() - beyond
    }

    /// Polynomial degree.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Knots of the spline, rescaled to a domain of `[0, 1]`; `inner_count + degree + 1` of them.
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// Number of non-empty spans: cells of the lattice along this axis.
    pub fn cells(&self) -> usize {
        self.spans.len()
    }

    /// Index of the cell that holds `t`, a parameter in `[0, 1]` or within reach; 1 belongs to the last cell.
    pub fn cell(&self, t: f64) -> usize {
        self.spans.partition_point(|&m| self.knots[m] <= t).saturating_sub(1)
    }

    /// First control point of the spline with a non-zero basis function in a cell; `degree + 1` consecutive ones act there.
    pub fn first_point(&self, cell: usize) -> usize {
        self.spans[cell] - self.degree
    }

    /// The knots that a cell's basis functions depend on, ready for evaluation.
    pub fn span(&self, cell: usize) -> Span {
        Span::new(&self.knots, self.degree, self.spans[cell])
    }

    /// Parameter at which control point `i` stands at rest: the Greville abscissa, which makes the rest lattice the
    /// identity map; Blender's are evenly spaced. A single point stands in the middle.
    pub fn greville(&self, i: usize) -> f64 {
        if self.degree == 0 {
            return 0.5;
        }
        if let Some(sums) = &self.sums {
            return i as f64 / (sums.count - 1) as f64;
        }
        self.inner_greville(i)
    }

    /// What makes the difference of control points `i` and `i + 1` of the spline a coefficient of its derivative.
    pub(crate) fn slope_rate(&self, i: usize) -> f64 {
        let length = self.knots[i + self.degree + 1] - self.knots[i + 1];
        // No cell uses a coefficient whose knots are all one.
        if length > 0.0 { self.degree as f64 / length } else { 0.0 }
    }

    /// The Greville abscissa of one of the spline's control points.
    pub(crate) fn inner_greville(&self, i: usize) -> f64 {
        if self.degree == 0 {
            return 0.5;
        }
        self.knots[i + 1..=i + self.degree].iter().sum::<f64>() / self.degree as f64
    }

    /// Number of outer layers of control points on which the surface's place at an end of the domain, and its derivatives there up to
    /// an order, depend: those to hold still when it must join what lies beyond with that continuity.
    ///
    /// Of a B-spline of degree `d` whose end knot is repeated `m` times, `d + 1 - m` functions reach over the end, and of those that
    /// begin there the first has derivatives from order `d + 1 - m` on, the next from one more on: so `k + 1` for clamped ends, and `d` for
    /// uniform ones up to order `d - 1`. No more than the `d + 1` that act there.
    pub fn end_layers(&self, upper: bool, continuity: usize) -> usize {
        if self.sums.is_some() {
            return self.summed_layers(continuity);
        }
        let at_end = |&&k: &&f64| if upper { k == 1.0 } else { k == 0.0 };
        let multiplicity = self.knots.iter().filter(at_end).count().min(self.degree + 1);
        let cell = if upper { self.cells() - 1 } else { 0 };
        let first = self.first_point(cell);
        // Knots repeated more often leave points that act nowhere.
        let idle = if upper { self.count - 1 - (first + self.degree) } else { first };
        let over = self.degree + 1 - multiplicity;
        let beginning = (continuity + multiplicity).saturating_sub(self.degree).min(multiplicity);
        (idle + over + beginning).max(1).min(self.count)
    }

    /// The same where functions are sums of a cubic's, alike at both ends: by their polynomials in the first cell.
    fn summed_layers(&self, continuity: usize) -> usize {
        let cell = self.domain_cells().start;
        let (Some(sums), Some(cubics)) = (&self.sums, self.span(cell).cubic()) else { return self.count() };
        let rows = &sums.rows[self.first_point(cell)..];
        let of_order = |order: usize| {
            let mut slopes = vec![0.0f64; sums.count];
            for (row, cubic) in rows.iter().zip(&cubics) {
                row.iter().for_each(|(point, share)| slopes[*point] += share * cubic[order]);
            }
            let largest = slopes.iter().fold(0.0f64, |most, slope| most.max(slope.abs()));
            let acts = |slope: &f64| slope.abs() > NO_SLOPE * largest;
            slopes.iter().rposition(acts).map_or(1, |last| last + 1)
        };
        (0..=continuity.min(self.degree)).map(of_order).max().unwrap_or(1)
    }

    /// The control points that may act in the same cells as the one at `t`, and their functions there: the first of so many
    /// consecutive ones.
    pub(crate) fn taps(&self, t: f64) -> (usize, Vec<f64>) {
        let (first, weights) = self.inner_taps(t);
        let Some(sums) = &self.sums else { return (first, weights) };
        let taps = self.window();
        let rows = &sums.rows[first..first + weights.len()];
        let lowest = rows.iter().flatten().map(|(point, _)| *point).min().unwrap_or_default();
        let start = lowest.min(sums.count - taps);
        let mut sum = vec![0.0; taps];
        for (row, weight) in rows.iter().zip(weights) {
            row.iter().for_each(|(point, share)| sum[point - start] += share * weight);
        }
        (start, sum)
    }

    /// How many control points act in one cell at most.
    pub(crate) fn window(&self) -> usize {
        (self.degree + 1).min(self.count())
    }

    /// The same of the spline itself.
    pub(crate) fn inner_taps(&self, t: f64) -> (usize, Vec<f64>) {
        let t = self.clamped_to_reach(t);
        let cell = self.cell(t);
        let mut weights = vec![0.0; self.degree + 1];
        self.span(cell).evaluate(t, &mut weights);
        (self.first_point(cell), weights)
    }
}

pub(crate) fn check_count(count: usize) -> Result<()> {
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
