// SPDX-License-Identifier: GPL-3.0-or-later
//! One exact step along the gradient of the volume: no order of axes.
//!
//! Of all displacements as long as it, the step `d = Omega^-1 (alpha, beta, gamma)` (the coefficients (10)-(12), weighted as in
//! Remark 2, the axes that are off left out, the pins' rows projected off) changes the volume most at first. Along it the volume
//! is a cubic of how far one goes, exactly, for it is linear in each axis. The root taken is the one reached before the cubic
//! turns; where there is none, the balanced sweep does it. Several bodies have a gradient and a multiplier each, found by
//! Newton's method from zero.

use crate::preserve::constraints::{add_scaled, dot};
use crate::preserve::correction::Correction;
use crate::preserve::passes::Passes;
use crate::preserve::search::{Place, Search};
use crate::preserve::sweep::sweep;
use crate::preserve::{Method, Solved};

/// Evaluations along the gradient at most. The second knows the cubic; the others refine where the first went so far that its
/// volume hides the digits of the others.
const MAX_STEPS: u32 = 6;

/// Newton's iterations for several multipliers at most: they double the digits each time, a dozen is plenty from where they do.
const MAX_NEWTON: u32 = 24;

/// Halvings of one of Newton's steps at most: a step that must be a thousand times shorter leads nowhere.
const MAX_HALVINGS: u32 = 10;

/// A pivot this much smaller than the largest entry of its matrix leaves no digits in the multipliers.
const SINGULAR: f64 = 1e-12;

/// Corrects along the gradient, or from axis to axis where there is no root.
pub(crate) fn gradient<P: Passes>(correction: &mut Correction<'_, P>) -> Result<Solved, P::Error> {
    let (mut search, start) = Search::new(correction)?;
    if let Some((_, rounds)) = along_gradient(&mut search, &start)? {
        return Ok(Solved { targets: search.targets, method: Method::Gradient, rounds });
    }
    correction.restart()?;
    sweep(correction, Method::Balanced)
}

/// Goes along the gradient to the targets, and says where that is and in how many steps; `None`, with the mesh anywhere, where the
/// volume turns before.
pub(crate) fn along_gradient<P: Passes>(
    search: &mut Search<'_, '_, P>,
    start: &Place,
) -> Result<Option<(Vec<f64>, u32)>, P::Error> {
    if search.targets == start.volumes {
        return Ok(Some((start.q.clone(), 0)));
    }
    let is_flat = |(body, gradient): (usize, &Vec<f64>)| {
        dot(gradient, gradient).sqrt() <= search.correction.scale_of(body).no_area()
    };
    if start.gradients.iter().enumerate().any(is_flat) {
        return Ok(None);
    }
    if start.gradients.len() == 1 { along_one(search, start) } else { along_several(search, start) }
}

/// One body: the cubic through the volumes and slopes at both ends of a step, and its root; again from there if need be.
fn along_one<P: Passes>(
    search: &mut Search<'_, '_, P>,
    start: &Place,
) -> Result<Option<(Vec<f64>, u32)>, P::Error> {
    let direction = &start.gradients[0];
    let slope = dot(direction, direction);
    let goal = search.targets[0] - start.volumes[0];
    let mut t = goal / slope;
    for round in 1..=MAX_STEPS {
        let place = search.evaluate(scaled(direction, t))?;
        let cubic = Cubic::through(
            slope,
            t,
            place.volumes[0] - start.volumes[0],
            dot(&place.gradients[0], direction),
        );
        let Some(root) = cubic.first_root(goal) else { return Ok(None) };
        let q = scaled(direction, root);
        if search.is_wild(&q) {
            return Ok(None);
        }
        t = root;
        search.go(&q)?;
        if search.close(&place)? {
            return Ok(Some((q, round)));
        }
    }
    Ok(None)
}

/// `slope t + quadratic t^2 + cubic t^3`: how the volume changes along a direction in which it grows at first.
#[derive(Debug, Clone, Copy)]
struct Cubic {
    slope: f64,
    quadratic: f64,
    cubic: f64,
}

impl Cubic {
    /// By the slope at 0, and value and slope at `t`.
    fn through(slope: f64, t: f64, value: f64, slope_there: f64) -> Self {
        let (mean, ends) = (value / t, slope + slope_there);
        Self { slope, quadratic: (3.0 * mean - ends - slope) / t, cubic: (ends - 2.0 * mean) / (t * t) }
    }

    fn value(&self, t: f64) -> f64 {
        t * (self.slope + t * (self.quadratic + t * self.cubic))
    }

    fn slope_at(&self, t: f64) -> f64 {
        self.slope + t * (2.0 * self.quadratic + t * 3.0 * self.cubic)
    }

    /// Where it takes the value `goal` before it turns.
    fn first_root(&self, goal: f64) -> Option<f64> {
        if goal < 0.0 {
            // Seen from the other side: -f(-t).
            let mirrored = Self { quadratic: -self.quadratic, ..*self };
            return mirrored.first_root(-goal).map(|t| -t);
        }
        let mut low = 0.0;
        let mut high = match self.turn() {
            Some(turn) if self.value(turn) < goal => return None,
            Some(turn) => turn,
            None => self.beyond(goal)?,
        };
        // Newton from the far end, with a bisection where it leaves what is known to hold the root.
        let mut t = high;
        for _ in 0..100 {
            let error = self.value(t) - goal;
            if error > 0.0 {
                high = t
            } else {
                low = t
            }
            let newton = t - error / self.slope_at(t);
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            if next == t || error == 0.0 {
                break;
            }
            t = next;
        }
        Some(t)
    }

    /// First positive place where it turns.
    fn turn(&self) -> Option<f64> {
        let discriminant = self.quadratic * self.quadratic - 3.0 * self.slope * self.cubic;
        let divisor = discriminant.sqrt() - self.quadratic;
        (discriminant >= 0.0 && divisor > 0.0).then(|| self.slope / divisor)
    }

    /// Somewhere beyond the goal, for one that does not turn.
    fn beyond(&self, goal: f64) -> Option<f64> {
        let mut t = goal / self.slope;
        (0..1100).find_map(|_| {
            t *= 2.0;
            (self.value(t) >= goal).then_some(t)
        })
    }
}

/// Several bodies: multipliers of their gradients by Newton's method, kept on the branch that begins at zero, where the matrix of
/// slopes has a positive determinant.
fn along_several<P: Passes>(
    search: &mut Search<'_, '_, P>,
    start: &Place,
) -> Result<Option<(Vec<f64>, u32)>, P::Error> {
    let mut place = start.clone();
    for round in 1..=MAX_NEWTON {
        let missing = search.missing(&place.volumes);
        let slopes = place.gradients.iter().map(|g| start.gradients.iter().map(|d| dot(g, d)).collect());
        let Some(step) = solved(slopes.collect(), missing.clone()) else { return Ok(None) };
        if search.is_settled(&place.volumes) {
            let q = place.q.clone();
            return Ok(search.close(&place)?.then_some((q, round)));
        }
        let Some(next) = shorter(search, start, &place, &step, &missing)? else { return Ok(None) };
        place = next;
    }
    Ok(None)
}

/// The whole of a step of the multipliers, or as much of it as brings the volumes nearer to their targets.
fn shorter<P: Passes>(
    search: &mut Search<'_, '_, P>,
    start: &Place,
    place: &Place,
    step: &[f64],
    missing: &[f64],
) -> Result<Option<Place>, P::Error> {
    // Volumes by the slope of their own gradient, so that small bodies count as much as large ones.
    let scale: Vec<f64> = start.gradients.iter().map(|d| dot(d, d)).collect();
    let size = |missing: &[f64]| missing.iter().zip(&scale).map(|(m, s)| (m / s).powi(2)).sum::<f64>();
    let mut share = 1.0;
    for _ in 0..MAX_HALVINGS {
        let mut q = place.q.clone();
        start.gradients.iter().zip(step).for_each(|(d, along)| add_scaled(&mut q, d, share * along));
        if !search.is_wild(&q) {
            let next = search.evaluate(q)?;
            if size(&search.missing(&next.volumes)) < size(missing) || search.is_settled(&next.volumes) {
                return Ok(Some(next));
            }
        }
        share *= 0.5;
    }
    Ok(None)
}

/// Solves a small dense system by elimination with row pivots; `None` where it is singular or its determinant is not positive.
fn solved(mut matrix: Vec<Vec<f64>>, mut right: Vec<f64>) -> Option<Vec<f64>> {
    let count = right.len();
    let mut is_positive = true;
    for k in 0..count {
        let largest = matrix[k..].iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
        let pivot = (k..count).max_by(|&a, &b| matrix[a][k].abs().total_cmp(&matrix[b][k].abs()))?;
        // Written so that NaN is refused as well.
        let usable = matrix[pivot][k].abs() > SINGULAR * largest;
        if !usable {
            return None;
        }
        is_positive ^= (pivot != k) ^ (matrix[pivot][k] < 0.0);
        matrix.swap(k, pivot);
        right.swap(k, pivot);
        for row in k + 1..count {
            let factor = matrix[row][k] / matrix[k][k];
            let (upper, lower) = matrix.split_at_mut(row);
            add_scaled(&mut lower[0][k..], &upper[k][k..], -factor);
            right[row] -= factor * right[k];
        }
    }
    for k in (0..count).rev() {
        let known = dot(&matrix[k][k + 1..], &right[k + 1..]);
        right[k] = (right[k] - known) / matrix[k][k];
    }
    is_positive.then_some(right)
}

fn scaled(vector: &[f64], factor: f64) -> Vec<f64> {
    vector.iter().map(|value| value * factor).collect()
}

#[cfg(test)]
mod tests {
    use super::{Cubic, solved};

    #[test]
    fn the_root_is_the_one_before_the_turn() {
        // (1 + t)^3 - 1, which never turns down.
        let grows = Cubic { slope: 3.0, quadratic: 3.0, cubic: 1.0 };
        assert!((grows.first_root(7.0).unwrap_or(0.0) - 1.0).abs() < 1e-14);
        assert!((grows.first_root(-0.875).unwrap_or(0.0) + 0.5).abs() < 1e-14);
        // t - t^2 / 4 turns at t = 2 with the value 1; t - t^3 at 0.577.
        let turns = Cubic { slope: 1.0, quadratic: -0.25, cubic: 0.0 };
        assert!(turns.first_root(1.01).is_none());
        assert!((turns.first_root(0.75).unwrap_or(0.0) - 1.0).abs() < 1e-14);
        let both = Cubic { slope: 1.0, quadratic: 0.0, cubic: -1.0 };
        assert!(both.first_root(0.4).is_none() && both.first_root(-0.4).is_none());
        assert!((both.first_root(0.375).unwrap_or(0.0) - 0.5).abs() < 1e-14);
    }

    #[test]
    fn the_cubic_is_found_from_its_ends() {
        let cubic = Cubic { slope: 2.0, quadratic: -0.7, cubic: 0.3 };
        let found = Cubic::through(2.0, 1.7, cubic.value(1.7), cubic.slope_at(1.7));
        assert!((found.quadratic + 0.7).abs() < 1e-14 && (found.cubic - 0.3).abs() < 1e-14);
    }

    #[test]
    fn systems_off_the_branch_are_refused() {
        let found = solved(vec![vec![0.0, -2.0], vec![1.0, 1.0]], vec![-4.0, 5.0]);
        assert_eq!(found, Some(vec![3.0, 2.0]));
        assert_eq!(solved(vec![vec![0.0, 2.0], vec![1.0, 1.0]], vec![4.0, 5.0]), None);
        assert_eq!(solved(vec![vec![1.0, 2.0], vec![2.0, 4.0]], vec![1.0, 2.0]), None);
    }
}
