// SPDX-License-Identifier: GPL-3.0-or-later
//! The smallest of all corrections: `min sum w |delta|^2` over all axes with a share at once, subject to the volumes and the pins.
//!
//! In the search's coordinates a solution is a combination of the volumes' gradients where it stands, `q = sum lambda g(q)`: the
//! conditions of Karush, Kuhn and Tucker (the paper's equations (14)-(16), for all axes together). Each iteration takes a step of
//! sequential quadratic programming: across the volumes' surfaces the shortest to their targets (linearised), along them downhill as
//! the last few steps have taught (L-BFGS on the tangent space; nothing known, straight to where `q^2` alone has its minimum). An
//! augmented Lagrangian decides how much of it is kept, so that the way is down and ends in a minimum, not in a saddle, except where
//! symmetry holds it there. One iteration measures the mesh once: a pass an axis, and one that deforms.

use glam::DVec3;

use crate::preserve::constraints::{Basis, Taken, add_scaled, dot, norm};
use crate::preserve::correction::Correction;
use crate::preserve::curvature::Memory;
use crate::preserve::gradient::{along_gradient, gradient};
use crate::preserve::passes::Passes;
use crate::preserve::search::{Place, Search};
use crate::preserve::sweep::sweep;
use crate::preserve::{Method, Solved};

/// Done where the conditions are met to this fraction of the correction's length. Lengths near a minimum grow with the square of the
/// distance from it, so the length is then right to rounding.
pub(crate) const TOLERANCE: f64 = 1e-8;

/// The same in roundings of the passes, where those are coarser.
const ROUNDINGS: f64 = 8.0;

/// Iterations at most. Corrections of random lattices take 5 to 20, a sphere squashed to 0.15 30, the longest of hundreds 57; what takes
/// more than this creeps along a valley for nothing.
pub(crate) const MAX_ITERATIONS: u32 = 100;

/// Weight of the volumes' errors in the merit: their second derivatives are some times smaller where steps are accepted at all.
const PENALTY: f64 = 10.0;

/// Halvings of a step at most; the merit function falls along it, so that a thousandth that does not help is rounding's.
const MAX_HALVINGS: u32 = 10;

/// Fraction of the fall foretold that a step must keep (Armijo's usual constant).
const ENOUGH: f64 = 1e-4;

/// How far a place where the conditions are met is pushed off, as a fraction of the correction: enough to leave a saddle in a dozen
/// iterations, little enough to come back to a minimum in as many.
const PUSH: f64 = 0.05;

/// By what fraction shorter the place must be that the push led to, to be another one.
const LOWER: f64 = 1e-6;

/// A correction found, to start from or to fall back on.
struct Candidate {
    control: Vec<DVec3>,
    q: Vec<f64>,
    length: f64,
}

/// Finds the nearest control points, from the shortest of the other corrections; the gradient's first, for it does not depend on
/// an order of axes.
pub(crate) fn nearest<P: Passes>(correction: &mut Correction<'_, P>) -> Result<Solved, P::Error> {
    let (mut search, start) = Search::new(correction)?;
    if search.targets == start.volumes {
        return Ok(Solved { targets: search.targets, method: Method::Nearest, rounds: 0 });
    }
    let (mut best, mut rounds) = (None, 0);
    if let Some((q, _)) = along_gradient(&mut search, &start)? {
        let here = Candidate::new(&search, q);
        rounds += descend_from(&mut search, here, &mut best)?;
    }
    let swept = shortest_sweep(&mut search);
    match (swept, &best) {
        (Err(error), None) => return Err(error),
        (Ok(swept), best_yet) if best_yet.as_ref().is_none_or(|best| swept.length < best.length) => {
            rounds += descend_from(&mut search, swept, &mut best)?;
        }
        _ => {}
    }
    if let Some(best) = best {
        let like = search.evaluate(best.q)?;
        search.correction.go_to(best.control)?;
        if search.close(&like)? {
            return Ok(Solved { targets: search.targets, method: Method::Nearest, rounds });
        }
    }
    shortest_other(correction)
}

/// The shortest of the other corrections, where the conditions cannot be met to the last digit.
fn shortest_other<P: Passes>(correction: &mut Correction<'_, P>) -> Result<Solved, P::Error> {
    let mut length = |method: Method| -> Result<f64, P::Error> {
        correction.restart()?;
        match method {
            Method::Sweep | Method::Balanced => sweep(correction, method)?,
            Method::Gradient | Method::Nearest => gradient(correction)?,
        };
        Ok(correction.plan.distance(&correction.control))
    };
    let [balanced, swept, along] = [Method::Balanced, Method::Sweep, Method::Gradient].map(&mut length);
    let (balanced, swept, along) = (balanced?, swept?, along?);
    correction.restart()?;
    if along <= swept.min(balanced) {
        return gradient(correction);
    }
    sweep(correction, if swept < balanced { Method::Sweep } else { Method::Balanced })
}

impl Candidate {
    /// The place where the search's mesh stands.
    fn new<P: Passes>(search: &Search<'_, '_, P>, q: Vec<f64>) -> Self {
        Self { control: search.correction.control.clone(), length: norm(&q), q }
    }
}

/// The shorter of the two sweeps.
fn shortest_sweep<P: Passes>(search: &mut Search<'_, '_, P>) -> Result<Candidate, P::Error> {
    let mut run = |method: Method| -> Result<Candidate, P::Error> {
        search.correction.restart()?;
        sweep(search.correction, method)?;
        let q = search.found(&search.correction.control);
        Ok(Candidate::new(search, q))
    };
    let (balanced, swept) = (run(Method::Balanced)?, run(Method::Sweep)?);
    Ok(if swept.length < balanced.length { swept } else { balanced })
}

/// Keeps `from`, or what lies below it, as the best so far if it is; says in how many iterations.
fn descend_from<P: Passes>(
    search: &mut Search<'_, '_, P>,
    from: Candidate,
    best: &mut Option<Candidate>,
) -> Result<u32, P::Error> {
    let (mut place, mut rounds) = descend(search, from.q.clone())?;
    let (other, more) = descend(search, pushed(search, &place.q))?;
    rounds += more;
    if norm(&other.q) < norm(&place.q) * (1.0 - LOWER) {
        place = other;
    }
    let found = settle(search, place)?.map(|q| Candidate::new(search, q));
    for candidate in found.into_iter().chain([from]) {
        if best.as_ref().is_none_or(|best| candidate.length < best.length) {
            *best = Some(candidate);
        }
    }
    Ok(rounds)
}

/// A place off the one found, without its symmetries: symmetric shapes have saddles that nothing symmetric leaves. The pins stay.
fn pushed<P: Passes>(search: &Search<'_, '_, P>, q: &[f64]) -> Vec<f64> {
    // The fractional parts of multiples of the golden ratio: spread evenly, without a pattern that a lattice could have.
    let noise = |i: usize| 2.0 * ((i + 1) as f64 * 0.618_033_988_749_894_9).fract() - 1.0;
    let mut pushed: Vec<f64> = q.iter().enumerate().map(|(i, q)| q * (1.0 + PUSH * noise(i))).collect();
    search.keep_pins(&mut pushed);
    pushed
}

/// The conditions at a place.
pub(crate) struct Conditions {
    /// The bodies' gradients.
    pub(crate) basis: Basis,
    /// How much of each gradient comes nearest to `q`.
    multipliers: Vec<f64>,
    missing: Vec<f64>,
    /// The shortest step that meets the linearised volumes.
    normal: Vec<f64>,
    /// What is missing of `q` to be a combination of the gradients: downhill, with the volumes as they are.
    pub(crate) tangent: Vec<f64>,
}

impl Conditions {
    /// `None` where the bodies' gradients depend on each other.
    fn at<P: Passes>(search: &Search<'_, '_, P>, place: &Place) -> Option<Self> {
        let mut basis = Basis::default();
        for gradient in &place.gradients {
            let Taken::Independent(_) = basis.take(gradient.clone(), 0.0) else { return None };
        }
        let missing = search.missing(&place.volumes);
        let mut tangent: Vec<f64> = place.q.iter().map(|q| -q).collect();
        basis.project_off(&mut tangent);
        let multipliers = basis.combination(&basis.along(&place.q));
        Some(Self { multipliers, normal: basis.shortest(&missing), tangent, missing, basis })
    }

    /// How far from met, in the coordinates of `q`.
    fn residual(&self) -> f64 {
        norm(&self.normal).hypot(norm(&self.tangent))
    }

    /// By how much the merit of another place differs.
    fn change(&self, from: &[f64], to: &[f64], missing: &[f64]) -> f64 {
        let squares: f64 = from.iter().zip(to).map(|(a, b)| (b - a) * (b + a)).sum();
        let costs =
            self.multipliers.iter().zip(missing).zip(&self.missing).map(|((m, to), from)| m * (to - from));
        let penalty =
            |missing: &[f64]| PENALTY * self.basis.shortest(missing).iter().map(|x| x * x).sum::<f64>();
        0.5 * (squares + penalty(missing) - penalty(&self.missing)) + costs.sum::<f64>()
    }

    /// What rounding can make of a change.
    fn rounding(&self, q: &[f64], slack: &[f64]) -> f64 {
        let costs = self.multipliers.iter().zip(slack).map(|(cost, slack)| (cost * slack).abs());
        1e-15 * dot(q, q) + costs.sum::<f64>()
    }

    /// The Lagrangian's gradient at a place, with the multipliers from here.
    pub(crate) fn lagrangian(&self, place: &Place) -> Vec<f64> {
        let mut slope = place.q.clone();
        for (gradient, multiplier) in place.gradients.iter().zip(&self.multipliers) {
            add_scaled(&mut slope, gradient, -multiplier);
        }
        slope
    }
}

/// Goes down from `q` until the conditions are met, or no step leads further.
fn descend<P: Passes>(search: &mut Search<'_, '_, P>, q: Vec<f64>) -> Result<(Place, u32), P::Error> {
    let tolerance = TOLERANCE.max(ROUNDINGS * search.correction.passes.epsilon());
    let mut place = search.evaluate(q)?;
    let mut memory = Memory::default();
    let mut conditions = Conditions::at(search, &place);
    for round in 1..=MAX_ITERATIONS {
        let Some(here) = &conditions else { return Ok((place, round)) };
        if here.residual() <= tolerance * norm(&place.q) {
            add_scaled(&mut place.q, &here.tangent, 1.0);
            add_scaled(&mut place.q, &here.normal, 1.0);
            return Ok((place, round));
        }
        let Some(next) = next(search, &place, here, &memory)? else { return Ok((place, round)) };
        let there = Conditions::at(search, &next);
        if let Some(there) = &there {
            memory.learn(there, &place, &next);
        }
        (place, conditions) = (next, there);
    }
    Ok((place, MAX_ITERATIONS))
}

/// The next place: a step, or as much of it as lowers the merit.
fn next<P: Passes>(
    search: &mut Search<'_, '_, P>,
    place: &Place,
    here: &Conditions,
    memory: &Memory,
) -> Result<Option<Place>, P::Error> {
    let bodies = 0..here.missing.len();
    let slack: Vec<f64> = bodies.map(|body| search.correction.slack(body, search.targets[body])).collect();
    let rounding = here.rounding(&place.q, &slack);
    let mut step = memory.direction(here);
    let fall = dot(&here.tangent, &step) + PENALTY * dot(&here.normal, &here.normal);
    add_scaled(&mut step, &here.normal, 1.0);
    let mut share = 1.0;
    for _ in 0..MAX_HALVINGS {
        let mut q = place.q.clone();
        add_scaled(&mut q, &step, share);
        if !search.is_wild(&q) {
            let next = search.evaluate(q)?;
            let change = here.change(&place.q, &next.q, &search.missing(&next.volumes));
            if change <= rounding - ENOUGH * share * fall {
                return Ok(Some(next));
            }
        }
        share *= 0.5;
    }
    Ok(None)
}

/// Makes the volumes of a place exact, by the shortest steps; `None` where they do not come.
fn settle<P: Passes>(search: &mut Search<'_, '_, P>, place: Place) -> Result<Option<Vec<f64>>, P::Error> {
    search.go(&place.q)?;
    if search.close(&place)? {
        return Ok(Some(place.q));
    }
    let mut q = place.q;
    for _ in 0..MAX_HALVINGS {
        let place = search.evaluate(q)?;
        if search.is_settled(&place.volumes) {
            return Ok(search.close(&place)?.then_some(place.q));
        }
        let mut basis = Basis::default();
        let is_independent =
            |gradient: &Vec<f64>| matches!(basis.take(gradient.clone(), 0.0), Taken::Independent(_));
        if !place.gradients.iter().all(is_independent) {
            return Ok(None);
        }
        let step = basis.shortest(&search.missing(&place.volumes));
        q = place.q;
        add_scaled(&mut q, &step, 1.0);
        if search.is_wild(&q) {
            return Ok(None);
        }
    }
    Ok(None)
}
