// SPDX-License-Identifier: GPL-3.0-or-later
//! The ground: no vertex of the surface goes below, and friction holds those that stand on it.

use glam::DVec3;

use super::skin::Skin;

/// Sweeps over the vertices in contact at most, there and back.
const SWEEPS: usize = 100;

/// Sweeps end where they move no vertex by more than this fraction of the depth allowed: what they leave would turn the body.
const SETTLED: f64 = 1e-3;

/// Rounds of looking which vertices are in contact.
const ROUNDS: usize = 4;

/// Sweeps for friction.
const FRICTION_SWEEPS: usize = 24;

/// A plane that the body stays above.
#[derive(Debug, Clone, Copy)]
pub struct Ground {
    /// A point of the plane.
    pub point: DVec3,
    /// Direction away from the ground; of any length but zero.
    pub normal: DVec3,
    /// Coefficient of Coulomb friction, 0 for ice.
    pub friction: f64,
}

/// What holds the vertices in contact in one substep.
#[derive(Debug, Clone, Default)]
pub(super) struct Contact {
    /// Lowest place allowed to each vertex.
    floor: Vec<f64>,
    /// Push on each vertex, never negative.
    push: Vec<f64>,
    /// Change of a vertex's own place by a unit of push on it.
    give: Vec<f64>,
    /// Vertices that were pushed or found below, in ascending order.
    touching: Vec<usize>,
    heights: Vec<f64>,
}

impl Ground {
    fn level(&self) -> f64 {
        self.point.dot(self.normal)
    }

    fn heights(&self, control: &[DVec3], into: &mut Vec<f64>) {
        into.clear();
        into.extend(control.iter().map(|point| point.dot(self.normal)));
    }

    /// Height of the lowest vertex of the surface above the plane.
    pub(super) fn lowest(&self, skin: &Skin, control: &[DVec3]) -> f64 {
        let mut heights = Vec::new();
        self.heights(control, &mut heights);
        let above = (0..skin.len()).map(|vertex| skin.height(vertex, &heights, self.normal) - self.level());
        above.fold(f64::INFINITY, f64::min)
    }
}

impl Contact {
    /// Begins a substep at these control points. A vertex that is below already may come up by `rise` at most.
    pub(super) fn begin(
        &mut self,
        ground: &Ground,
        skin: &Skin,
        control: &[DVec3],
        inverse_mass: &[f64],
        rise: f64,
    ) {
        if self.give.len() != skin.len() {
            let give = |v| skin.row(v).map(|(point, weight)| weight * weight * inverse_mass[point]).sum();
            self.give = (0..skin.len()).map(give).collect();
        }
        ground.heights(control, &mut self.heights);
        let level = ground.level();
        let floor = |v| level.min(skin.height(v, &self.heights, ground.normal) + rise);
        self.floor = (0..skin.len()).map(floor).collect();
        self.push = vec![0.0; skin.len()];
        self.touching.clear();
    }

    /// Whether the ground pushed any vertex in the last substep.
    pub(super) fn is_touching(&self) -> bool {
        !self.touching.is_empty()
    }

    /// Lifts the vertices that are below, moving the control points as little as their masses allow: the projected
    /// Gauss-Seidel method on the pushes of the vertices, which all point along the plane's normal.
    pub(super) fn lift(
        &mut self,
        ground: &Ground,
        skin: &Skin,
        control: &mut [DVec3],
        inverse_mass: &[f64],
        tolerance: f64,
    ) {
        ground.heights(control, &mut self.heights);
        for _ in 0..ROUNDS {
            if !self.look(ground, skin, tolerance) {
                break;
            }
            for sweep in 0..SWEEPS {
                if self.sweep(ground, skin, inverse_mass, sweep % 2 == 1) <= SETTLED * tolerance {
                    break;
                }
            }
        }
        for (point, &height) in control.iter_mut().zip(&self.heights) {
            *point += ground.normal * (height - point.dot(ground.normal));
        }
    }

    /// Finds vertices below their floor; whether there are any.
    fn look(&mut self, ground: &Ground, skin: &Skin, tolerance: f64) -> bool {
        let below = |v: &usize| {
            self.give[*v] > 0.0 && skin.height(*v, &self.heights, ground.normal) < self.floor[*v] - tolerance
        };
        let found: Vec<usize> = (0..skin.len()).filter(below).collect();
        let any = !found.is_empty();
        self.touching.extend(found);
        self.touching.sort_unstable();
        self.touching.dedup();
        any
    }

    fn sweep(&mut self, ground: &Ground, skin: &Skin, inverse_mass: &[f64], backwards: bool) -> f64 {
        let mut worst = 0.0_f64;
        for place in 0..self.touching.len() {
            let vertex = self.touching[if backwards { self.touching.len() - 1 - place } else { place }];
            let gap = skin.height(vertex, &self.heights, ground.normal) - self.floor[vertex];
            let push = (self.push[vertex] - gap / self.give[vertex]).max(0.0);
            let change = push - self.push[vertex];
            if change == 0.0 {
                continue;
            }
            self.push[vertex] = push;
            for (point, weight) in skin.row(vertex) {
                self.heights[point] += weight * inverse_mass[point] * change;
            }
            worst = worst.max((change * self.give[vertex]).abs());
        }
        worst
    }

    /// Holds the vertices in contact where they were at `before`, as far as friction goes (Coulomb: no more than
    /// `friction` times the push).
    pub(super) fn rub(
        &self,
        ground: &Ground,
        skin: &Skin,
        before: &[DVec3],
        control: &mut [DVec3],
        inverse_mass: &[f64],
    ) {
        if ground.friction <= 0.0 || self.touching.is_empty() {
            return;
        }
        let mut held = vec![DVec3::ZERO; self.touching.len()];
        for sweep in 0..FRICTION_SWEEPS {
            for place in 0..held.len() {
                let place = if sweep % 2 == 1 { held.len() - 1 - place } else { place };
                let vertex = self.touching[place];
                let most = ground.friction * self.push[vertex];
                let moved =
                    skin.row(vertex).map(|(p, weight)| (control[p] - before[p]) * weight).sum::<DVec3>();
                let slid = moved - ground.normal * moved.dot(ground.normal);
                let hold = (held[place] - slid / self.give[vertex]).clamp_length_max(most);
                let change = hold - held[place];
                held[place] = hold;
                for (point, weight) in skin.row(vertex) {
                    control[point] += change * (weight * inverse_mass[point]);
                }
            }
        }
    }
}
