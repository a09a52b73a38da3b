// SPDX-License-Identifier: GPL-3.0-or-later
//! Direct manipulation: points of the surface that must land on targets (the paper's Problem 2).

use glam::DVec3;

use crate::binding::Binding;
use crate::error::{Error, Result};
use crate::preserve::constraints::{Basis, Taken, dot};
use crate::preserve::frame::Frame;
use crate::preserve::metric::Metric;
use crate::vertices::Scalar;

/// How far the barycentric coordinates of a pin may be from summing to 1: what float32 input leaves of it.
const SUM_TOLERANCE: f64 = 1e-5;

/// A displacement of the control points this many times longer than their box and the ways of the pins together serves no shape:
/// pins so near each other that it takes one contradict each other.
const WILD: f64 = 1e3;

/// A point of the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PinPoint {
    /// A vertex.
    Vertex(u32),
    /// A triangle and barycentric coordinates of its corners, which sum to 1.
    Face(u32, [f64; 3]),
}

/// Points of the surface and the places in the lattice's space where the deformed surface must have them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Pins {
    /// The points.
    pub points: Vec<PinPoint>,
    /// Where each must land.
    pub targets: Vec<DVec3>,
}

/// A pin in the lattice: `position = at + sum weight (control - rest)`.
#[derive(Debug, Clone)]
struct Pin {
    /// Control points with their weights: influence times basis, the paper's `B(u_s)`.
    row: Vec<(usize, f64)>,
    /// Where the point stands when the control points are at rest.
    at: DVec3,
    target: DVec3,
}

/// The pins of a correction, checked.
#[derive(Debug, Clone, Default)]
pub(crate) struct PinRows {
    pins: Vec<Pin>,
    names: Vec<String>,
    /// The rows in the metric's coordinates.
    pub(crate) basis: Basis,
    /// The pair of pins that are nearest to dependent.
    nearest: Option<(usize, usize)>,
}

impl PinRows {
    /// Looks the pins up in the lattice and checks that they can move independently.
    ///
    /// # Errors
    /// [`Error::Pin`] for wrong indices, barycentric coordinates or targets, and for pins that are repeated, immovable or dependent.
    pub(crate) fn new<T: Scalar>(binding: &Binding<T>, pins: &Pins, metric: &Metric) -> Result<Self> {
        if pins.points.len() != pins.targets.len() {
            return Err(Error::Pin(format!(
                "pins: found {} points and {} targets, expected one target for each point",
                pins.points.len(),
                pins.targets.len()
            )));
        }
        let mut rows = Self::default();
        for (i, (point, target)) in pins.points.iter().zip(&pins.targets).enumerate() {
            if !target.is_finite() {
                return Err(Error::Pin(format!("pin {i}: its target is {target}, expected finite numbers")));
            }
            rows.pins.push(located(binding, i, *point, *target)?);
            rows.names.push(match point {
                PinPoint::Vertex(vertex) => format!("vertex {vertex}"),
                PinPoint::Face(face, [a, b, c]) => format!("({a:.4}, {b:.4}, {c:.4}) of triangle {face}"),
            });
        }
        rows.take_all(binding.lattice().len(), metric)?;
        Ok(rows)
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.pins.is_empty()
    }

    /// How far each pin still has to go along an axis of the frame, with control points displaced so.
    pub(crate) fn residuals(&self, displacement: &[DVec3], frame: &Frame, axis: usize) -> Vec<f64> {
        self.pins.iter().map(|pin| frame.coordinates(pin.way(displacement))[axis]).collect()
    }

    /// How far displacements along one axis move each pin.
    pub(crate) fn moved(&self, delta: &[f64]) -> Vec<f64> {
        let of = |pin: &Pin| pin.row.iter().map(|&(point, weight)| weight * delta[point]).sum();
        self.pins.iter().map(of).collect()
    }

    /// Refuses displacements along one axis that pins near each other blow up. `extent`: size of the lattice.
    pub(crate) fn refuse_wild(&self, delta: &[f64], residuals: &[f64], extent: f64) -> Result<()> {
        let largest = |values: &[f64]| values.iter().map(|value| value.abs()).fold(0.0, f64::max);
        let allowed = WILD * (extent + largest(residuals));
        if largest(delta) <= allowed {
            return Ok(());
        }
        let (a, b) = self.nearest.unwrap_or((0, self.pins.len() - 1));
        Err(Error::Pin(format!(
            "pins {a} and {b}: {} and {} are too near each other for targets so different; the lattice would have to move {:.1e} times its size; remove one of them, or bring their targets closer",
            self.names[a],
            self.names[b],
            largest(delta) / extent.max(f64::MIN_POSITIVE)
        )))
    }

    fn take_all(&mut self, count: usize, metric: &Metric) -> Result<()> {
        let mut nearest = f64::INFINITY;
        let mut whitened: Vec<Vec<f64>> = Vec::with_capacity(self.pins.len());
        for (i, pin) in self.pins.iter().enumerate() {
            let mut row = vec![0.0; count];
            pin.row.iter().for_each(|&(point, weight)| row[point] += weight);
            let row = metric.whitened(&row);
            match self.basis.take(row.clone(), 0.0) {
                Taken::Independent(length) => {
                    let share = length / dot(&row, &row).sqrt();
                    if i > 0 && share < nearest {
                        nearest = share;
                        self.nearest = Some((closest(&row, &whitened), i));
                    }
                }
                Taken::Dependent(_) => return Err(self.dependent(i, closest(&row, &whitened))),
                Taken::Zero => {
                    return Err(Error::Pin(format!(
                        "pin {i}: {} is not moved by any control point that may move; it lies outside the lattice, has no influence, or its control points are frozen; remove the pin, or free them",
                        self.names[i]
                    )));
                }
            }
            whitened.push(row);
        }
        Ok(())
    }

    fn dependent(&self, later: usize, earlier: usize) -> Error {
        let [a, b] = [&self.pins[earlier], &self.pins[later]];
        let (first, second) = (&self.names[earlier], &self.names[later]);
        if a.at == b.at {
            let end = if a.target == b.target { "the same target" } else { "different targets" };
            return Error::Pin(format!(
                "pins {earlier} and {later}: {first} and {second} are the same point with {end}; remove one of them"
            ));
        }
        Error::Pin(format!(
            "pins {earlier} and {later}: {first} and {second} cannot move independently of each other and the pins before, for the lattice has too few control points that may move there; remove pin {later}, or use a lattice with more points"
        ))
    }
}

impl Pin {
    /// From where the point is to where it must be, in space.
    fn way(&self, displacement: &[DVec3]) -> DVec3 {
        let moved: DVec3 = self.row.iter().map(|&(point, weight)| displacement[point] * weight).sum();
        self.target - (self.at + moved)
    }
}

impl<T: Scalar> Binding<T> {
    /// Largest distance of a pin from its target on deformed vertices, in float64; 0 without pins.
    ///
    /// # Errors
    /// [`Error::Pin`] for indices out of range, [`Error::Mesh`] for another number of vertices.
    pub fn largest_miss(&self, pins: &Pins, vertices: &[[T; 3]]) -> Result<f64> {
        self.check_count(vertices.len())?;
        let mut largest = 0.0f64;
        for (i, (point, target)) in pins.points.iter().zip(&pins.targets).enumerate() {
            let at = |(vertex, share): (u32, f64)| {
                DVec3::from_array(vertices[vertex as usize].map(T::to_f64)) * share
            };
            let found: DVec3 = bound_corners(self, i, *point)?.into_iter().map(at).sum();
            largest = largest.max((found - *target).length());
        }
        Ok(largest)
    }
}

/// The earlier row most nearly parallel to this one.
fn closest(row: &[f64], earlier: &[Vec<f64>]) -> usize {
    let cosine = |other: &Vec<f64>| dot(row, other).abs() / dot(other, other).sqrt();
    (0..earlier.len())
        .max_by(|&a, &b| cosine(&earlier[a]).total_cmp(&cosine(&earlier[b])))
        .unwrap_or_default()
}

fn located<T: Scalar>(binding: &Binding<T>, i: usize, point: PinPoint, target: DVec3) -> Result<Pin> {
    let mut pin = Pin { row: Vec::new(), at: DVec3::ZERO, target };
    for (vertex, share) in bound_corners(binding, i, point)? {
        pin.at += DVec3::from_array(binding.vertices()[vertex as usize].map(T::to_f64)) * share;
        let located = binding.located(vertex as usize);
        let taps = binding.lattice().taps(DVec3::from_array(located.parameter));
        pin.row.extend(taps.map(|(point, weight)| (point, share * located.influence * weight)));
    }
    pin.row.retain(|(_, weight)| *weight != 0.0);
    Ok(pin)
}

/// The vertices bound that a pin's point lies between or is combined of, with their shares.
fn bound_corners<T: Scalar>(binding: &Binding<T>, i: usize, point: PinPoint) -> Result<Vec<(u32, f64)>> {
    let combined = |(corner, share): (u32, f64)| {
        binding.corner(corner).into_iter().map(move |(vertex, weight)| (vertex, share * weight))
    };
    Ok(corners(binding, i, point)?.into_iter().flat_map(combined).collect())
}

/// The corners that a pin's point lies between, with their shares.
fn corners<T: Scalar>(binding: &Binding<T>, i: usize, point: PinPoint) -> Result<Vec<(u32, f64)>> {
    match point {
        PinPoint::Vertex(vertex) if (vertex as usize) < binding.corner_count() => Ok(vec![(vertex, 1.0)]),
        PinPoint::Vertex(vertex) => Err(out_of_range(i, "vertex", vertex, binding.corner_count())),
        PinPoint::Face(face, barycentric) => {
            let Some(triangle) = binding.triangles().get(face as usize) else {
                return Err(out_of_range(i, "triangle", face, binding.triangles().len()));
            };
            let sum: f64 = barycentric.iter().sum();
            let is_finite = barycentric.iter().all(|b| b.is_finite());
            if !is_finite || (sum - 1.0).abs() > SUM_TOLERANCE {
                return Err(Error::Pin(format!(
                    "pin {i}: found barycentric coordinates {barycentric:?}, expected three finite numbers that sum to 1"
                )));
            }
            Ok(triangle.iter().copied().zip(barycentric).collect())
        }
    }
}

fn out_of_range(i: usize, what: &str, index: u32, count: usize) -> Error {
    Error::Pin(format!("pin {i}: found {what} {index}, expected 0 to {}", count as i64 - 1))
}
