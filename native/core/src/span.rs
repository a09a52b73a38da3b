// SPDX-License-Identifier: GPL-3.0-or-later
//! The basis functions of one cell of an axis: the recurrence over the knots around it.

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
    pub(crate) fn new(knots: &[f64], degree: usize, m: usize) -> Self {
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
