// SPDX-License-Identifier: GPL-3.0-or-later
//! Volume correction: the smallest displacement of the control points that gives the deformed mesh the volume wanted.
//!
//! Hahmann, Bonneau, Barbier, Elber, Hagen: *Volume-preserving FFD for programmable graphics hardware* (2012). The volume is
//! linear in the x coordinates of the control points alone, likewise y and z; so an axis can take its share exactly, by
//! equation (17) in the weighted form of Remark 2: `delta = a W c / (c W c)` with `c` the axis' coefficients (10)-(12) and
//! `W` the reciprocal weights.

use glam::{DMat3, DVec3};

use crate::binding::{Binding, too_large, with_engine};
use crate::engine::{Engine, State};
use crate::error::{Error, Result};
use crate::lanes::Lanes;
use crate::lattice::unit_columns;
use crate::vertices::Scalar;
use crate::words::{bracketed, number};

/// How the axes share the correction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// The paper's: each axis adds its share of the volume difference.
    Sweep,
    /// Each axis multiplies the volume by its share of the ratio (geometric steps), which keeps round things round. Where the
    /// volumes before and after differ in sign there is no ratio, and the sweep is used.
    #[default]
    Balanced,
}

/// What the correction should reach and what it may move.
#[derive(Debug, Clone)]
pub struct Preserve {
    /// Shares of the three axes, not negative, with a positive sum.
    pub axes: [f64; 3],
    /// Directions of the axes, as rows (any lengths, need not be orthogonal); `None` for x, y, z.
    pub frame: Option<[DVec3; 3]>,
    /// How the axes share the correction.
    pub method: Method,
    /// Weight of each control point, `k` fastest: positive, large keeps it, infinity freezes it. `None` for 1.
    pub weights: Option<Vec<f64>>,
    /// Volume to reach; `None` for that of the mesh as bound.
    pub target: Option<f64>,
    /// How much of the way to the target: 0 leaves the volume as deformed, 1 reaches the target.
    pub amount: f64,
}

impl Default for Preserve {
    fn default() -> Self {
        Self {
            axes: [1.0; 3],
            frame: None,
            method: Method::Balanced,
            weights: None,
            target: None,
            amount: 1.0,
        }
    }
}

/// What the correction did.
#[derive(Debug, Clone, PartialEq)]
pub struct Preserved {
    /// Corrected control points, `k` fastest. Coordinates along axes without a share are those given, bit for bit.
    pub control: Vec<DVec3>,
    /// Volume that was aimed at: `target` as weakened by `amount`.
    pub target: f64,
    /// What ran, after any fall-back.
    pub method: Method,
    /// Rounds over the axes: 0 where nothing was to do, more than 1 where an axis was flat and passed its share on.
    pub iterations: u32,
}

/// An axis whose coefficients are smaller than this fraction of the squared extent of the lattice is flat: rounding alone
/// makes coefficients of about 1e-15 of it. A volume smaller than this fraction of the cube is zero but for rounding: it
/// has no sign, and no ratio to another.
const FLAT: f64 = 1e-12;

/// Rounding errors of coordinates, in units of the largest coordinate and of one rounding. A few dozen operations lie between
/// control points and the differences of deformed vertices, but their errors mostly cancel in sums over vertices.
const ROUNDINGS: f64 = 2.0;

/// A frame whose unit directions enclose less than this volume has lost twelve of float64's sixteen digits.
const FLAT_FRAME: f64 = 1e-12;

/// Rounds over the axes at most: one, a second where an axis was flat, a third without those still flat.
const MAX_ROUNDS: u32 = 3;

impl<T: Scalar> Binding<T> {
    /// Deforms the mesh by `control` and corrects the control points so that its volume is the one wanted; writes the
    /// vertices deformed by the corrected points to `out`, in the order bound.
    ///
    /// The volume of the result equals `Preserved::target` to about `4 epsilon A R / |V|` relative (area, radius; epsilon of
    /// the vertices' type). It is measured and summed in float64 on the vertices as they stand, before every step.
    ///
    /// # Errors
    /// [`Error::Mesh`] where the triangles enclose no volume; [`Error::Lattice`] for wrong control points or weights;
    /// [`Error::Volume`] for wrong axes, frame, target or amount, for a flat mesh without a target of its own, and where no
    /// displacement allowed can change the volume.
    pub fn preserve(&self, control: &[DVec3], options: &Preserve, out: &mut [[T; 3]]) -> Result<Preserved> {
        let shares = normalised_shares(options.axes)?;
        let frame = Frame::new(options.frame)?;
        let mobility = self.mobility(options.weights.as_deref())?;
        let wanted = self.wanted_volume(options)?;
        let displacement = self.displacement(control)?;

        with_engine!(self, engine => {
            let mut correction = Correction {
                middle: frame.coordinates(control.iter().sum::<DVec3>() / control.len() as f64),
                scale: Scale::new(control, &self.rest(), rounding_of(engine)),
                binding: self,
                engine,
                state: engine.deformed(&self.embedding().tasks, &displacement, frame.to_frame()),
                mobility,
                determinant: frame.determinant,
                control: control.to_vec(),
                frame: &frame,
            };
            let (target, method, iterations) = correction.run(shares, options, wanted)?;
            let Correction { control, state, .. } = correction;
            if frame.is_identity() {
                self.write(&state, out)?;
            } else {
                self.deform(&control, out)?;
            }
            engine.recycle(state);
            Ok(Preserved { control, target, method, iterations })
        })
    }

    pub(crate) fn wanted_volume(&self, options: &Preserve) -> Result<f64> {
        if !options.amount.is_finite() {
            return Err(Error::Volume(format!(
                "amount: found {}, expected a finite number; 1 preserves",
                number(options.amount)
            )));
        }
        let reference = self.reference()?;
        match options.target {
            Some(target) if target.is_finite() => Ok(target),
            Some(target) => {
                Err(Error::Volume(format!("target: found {}, expected a finite volume", number(target))))
            }
            None if reference.is_flat(T::EPSILON) => Err(Error::Volume(format!(
                "the mesh as bound encloses no volume: found {} with an area of {}; give it thickness, or give a target",
                number(reference.volume),
                number(reference.area)
            ))),
            None => Ok(reference.volume),
        }
    }

    /// Reciprocal weights: 0 for control points that must not move.
    pub(crate) fn mobility(&self, weights: Option<&[f64]>) -> Result<Vec<f64>> {
        let count = self.lattice().len();
        if let Some(weights) = weights {
            if weights.len() != count {
                return Err(Error::Lattice(format!(
                    "weights: found {} values, expected {count} for a lattice of shape {:?}",
                    weights.len(),
                    self.lattice().shape()
                )));
            }
            if let Some(i) = weights.iter().position(|w| w.is_nan() || *w <= 0.0) {
                return Err(Error::Lattice(format!(
                    "weights: found {} at control point {i}, expected positive numbers (infinity freezes)",
                    number(weights[i])
                )));
            }
        }
        let free = self.correctable();
        let lightest = weights.map_or(1.0, |all| all.iter().copied().fold(f64::INFINITY, f64::min));
        // Only ratios of weights matter; scaled by the lightest, none under- or overflows.
        let mobility = |p: usize| match weights {
            _ if !free[p] => 0.0,
            Some(all) if all[p].is_finite() => lightest / all[p],
            Some(_) => 0.0,
            None => 1.0,
        };
        Ok((0..count).map(mobility).collect())
    }
}

/// The correction under way, in the coordinates of its frame.
struct Correction<'a, T, L: Lanes> {
    binding: &'a Binding<T>,
    engine: &'a Engine<L>,
    state: State<L>,
    control: Vec<DVec3>,
    frame: &'a Frame,
    mobility: Vec<f64>,
    /// Volume in space over volume in the frame's coordinates.
    determinant: f64,
    middle: DVec3,
    scale: Scale,
}

impl<T: Scalar, L: Lanes> Correction<'_, T, L> {
    fn run(&mut self, shares: [f64; 3], options: &Preserve, wanted: f64) -> Result<(f64, Method, u32)> {
        let mut active: Vec<usize> = (0..3).filter(|&axis| shares[axis] > 0.0).collect();
        let mut measured = self.coefficients(active[0])?;
        let before = measured.1;
        if !before.is_finite() {
            return Err(too_large(before));
        }
        let target = before + options.amount * (wanted - before);
        let ratio = target / before;
        let method = match options.method {
            Method::Balanced if before.abs() > self.scale.no_volume() && ratio > 0.0 => Method::Balanced,
            _ => Method::Sweep,
        };
        if target == before {
            return Ok((target, method, 0));
        }
        let volume_at = |done: f64| match method {
            // The last step aims at the target itself: shares add up to 1 only to rounding.
            _ if done > 1.0 - 1e-9 => target,
            Method::Sweep => before + done * (target - before),
            Method::Balanced => before * ratio.powf(done),
        };

        let (mut done, mut current) = (0.0, true);
        for round in 1..=MAX_ROUNDS {
            let (budget, total) = (1.0 - done, active.iter().map(|&axis| shares[axis]).sum::<f64>());
            let mut flat = Vec::new();
            for &axis in &active {
                if !current {
                    measured = self.coefficients(axis)?;
                }
                current = false;
                let next = done + budget * shares[axis] / total;
                if self.step(axis, &measured.0, volume_at(next) - measured.1)? {
                    done = next;
                } else {
                    flat.push(axis);
                }
            }
            if flat.is_empty() {
                return Ok((target, method, round));
            }
            if flat.len() == active.len() {
                break;
            }
            if round > 1 {
                active.retain(|axis| !flat.contains(axis));
            }
        }
        if (target - before).abs() <= self.already_there(target)? {
            return Ok((target, method, 0));
        }
        Err(Error::Volume(format!(
            "the target volume {} cannot be reached from {}: no displacement that axes {}, weights and frozen layers allow changes the volume; allow another axis or free control points",
            number(target),
            number(before),
            bracketed(options.axes)
        )))
    }

    /// Difference from the target that rounding explains, where nothing may move: 4 epsilon A R for each of two sums.
    fn already_there(&self, target: f64) -> Result<f64> {
        let reference = self.binding.reference()?;
        Ok(8.0 * L::Real::EPSILON * (reference.area * reference.radius + target.abs()))
    }

    /// Coefficients of an axis of the frame, and the volume in space.
    fn coefficients(&self, axis: usize) -> Result<(Vec<f64>, f64)> {
        let (tasks, walks) = (&self.binding.embedding().tasks, self.binding.walks()?);
        let (coefficients, volume) =
            self.engine.coefficients(tasks, walks, &self.state, axis, self.middle[axis]);
        Ok((coefficients, volume * self.determinant))
    }

    /// Changes the volume by `change` along one axis: equation (17). Returns `false`, changing nothing, where the axis is
    /// flat.
    fn step(&mut self, axis: usize, coefficients: &[f64], change: f64) -> Result<bool> {
        let steep: f64 = coefficients.iter().zip(&self.mobility).map(|(c, w)| c * c * w).sum();
        if steep.sqrt() <= self.scale.no_area() {
            return Ok(false);
        }
        let factor = change / self.determinant / steep;
        let delta: Vec<f64> = coefficients.iter().zip(&self.mobility).map(|(c, w)| factor * c * w).collect();
        if let Some(i) = delta.iter().position(|d| !d.is_finite()) {
            return Err(Error::Volume(format!(
                "the correction would move control point {i} by {}: the target is out of reach",
                delta[i]
            )));
        }
        self.engine.shift(&self.binding.embedding().tasks, &mut self.state[axis], &delta);
        for (point, d) in self.control.iter_mut().zip(&delta) {
            self.frame.move_along(axis, *d, point);
        }
        Ok(true)
    }
}

/// Coordinates along the directions that "axes" means.
#[derive(Debug, Clone)]
pub(crate) struct Frame {
    /// Unit directions as columns, and the inverse; `None` for x, y, z.
    pub(crate) directions: Option<(DMat3, DMat3)>,
    pub(crate) determinant: f64,
}

impl Frame {
    pub(crate) fn new(rows: Option<[DVec3; 3]>) -> Result<Self> {
        let Some(rows) = rows else { return Ok(Self { directions: None, determinant: 1.0 }) };
        if rows.iter().any(|row| !row.is_finite()) {
            return Err(Error::Volume(format!("frame: found {rows:?}, expected finite numbers")));
        }
        let columns = unit_columns(DMat3::from_cols(rows[0], rows[1], rows[2]));
        if columns == DMat3::IDENTITY {
            return Ok(Self { directions: None, determinant: 1.0 });
        }
        let determinant = columns.determinant();
        if determinant.abs() <= FLAT_FRAME {
            return Err(Error::Volume(format!(
                "frame: the rows {rows:?} span no space, expected three independent directions"
            )));
        }
        Ok(Self { directions: Some((columns, columns.inverse())), determinant })
    }

    fn is_identity(&self) -> bool {
        self.directions.is_none()
    }

    fn to_frame(&self) -> Option<DMat3> {
        self.directions.map(|(_, inverse)| inverse)
    }

    pub(crate) fn coordinates(&self, point: DVec3) -> DVec3 {
        self.directions.map_or(point, |(_, inverse)| inverse * point)
    }

    pub(crate) fn move_along(&self, axis: usize, distance: f64, point: &mut DVec3) {
        match self.directions {
            Some((columns, _)) => *point += columns.col(axis) * distance,
            None => point[axis] += distance,
        }
    }
}

pub(crate) fn normalised_shares(axes: [f64; 3]) -> Result<[f64; 3]> {
    if axes.iter().any(|share| !share.is_finite() || *share < 0.0) {
        return Err(Error::Volume(format!(
            "axes: found {axes:?}, expected three finite shares, none negative"
        )));
    }
    let largest = axes.iter().copied().fold(0.0, f64::max);
    if largest == 0.0 {
        return Err(Error::Volume(format!(
            "axes: found {axes:?}, expected at least one positive share; no displacement is allowed"
        )));
    }
    let total: f64 = axes.iter().map(|share| share / largest).sum();
    Ok(axes.map(|share| share / largest / total))
}

/// Relative rounding error of coordinates in an engine's lanes.
fn rounding_of<L: Lanes>(_: &Engine<L>) -> f64 {
    ROUNDINGS * L::Real::EPSILON
}

/// Sizes below which areas and volumes of the deformed mesh are nothing but rounding.
struct Scale {
    /// Largest side of the control points' box: an upper bound for the size of what they deform.
    extent: f64,
    /// Rounding error of a coordinate.
    rounding: f64,
}

impl Scale {
    fn new(control: &[DVec3], rest: &[DVec3], rounding: f64) -> Self {
        let (low, high) = crate::lattice::bounds(control);
        let largest = control.iter().chain(rest).map(|p| p.abs().max_element()).fold(0.0, f64::max);
        Self { extent: (high - low).max_element(), rounding: rounding * largest }
    }

    fn no_area(&self) -> f64 {
        (FLAT * self.extent + self.rounding) * (self.extent + self.rounding)
    }

    fn no_volume(&self) -> f64 {
        self.no_area() * (self.extent + self.rounding)
    }
}
