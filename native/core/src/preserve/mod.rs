// SPDX-License-Identifier: GPL-3.0-or-later
//! Volume correction: the smallest displacement of the control points that gives the deformed mesh the volume wanted.
//!
//! Hahmann, Bonneau, Barbier, Elber, Hagen: *Volume-preserving FFD for programmable graphics hardware* (2012), both problems, and
//! what goes beyond: any number of pins and bodies, and methods that do not depend on an order of axes.

mod band;
mod bending;
mod constraints;
mod correction;
mod costs;
mod curvature;
mod factor;
pub(crate) mod frame;
mod gradient;
mod limit;
mod metric;
mod nearest;
mod over_points;
mod passes;
mod pins;
mod plan;
mod scale;
mod search;
mod surface_cost;
mod sweep;
mod together;
mod wanted;

use glam::DVec3;

use crate::binding::{Binding, with_engine};
use crate::error::Result;
use crate::vertices::Scalar;

use crate::tensor::OnTensor;
use correction::Correction;
pub use costs::Cost;
pub(crate) use costs::Costs;
pub use limit::Limit;
pub(crate) use over_points::OverPoints;
pub(crate) use passes::OnEngine;
pub use passes::{Coefficients, Passes};
pub use pins::{PinPoint, Pins};
pub use plan::Plan;

/// How the axes share the correction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// The paper's: each axis adds its share of the volume difference.
    Sweep,
    /// Each axis multiplies the volume by its share of the ratio (geometric steps), which keeps round things round. Where the
    /// volumes before and after differ in sign there is no ratio, and the sweep is used.
    #[default]
    Balanced,
    /// One exact step along the gradient of the volume, over all axes with a share at once: no order of axes, and less displacement
    /// than the sweeps nearly always. Where the volume turns before it reaches the target, the balanced sweep is used.
    Gradient,
    /// The smallest displacement of all, by iteration from the shortest of the others; over all axes with a share at once.
    Nearest,
}

/// How exactly a huge mesh is corrected. Smaller ones, those of several bodies or with caps, and those whose control points alone
/// decide already ([`Binding::prepare`]) are always corrected exactly.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Accuracy {
    /// By passes over the mesh itself.
    #[default]
    Exact,
    /// By passes over a coarse copy of it, and one exact step along one axis: the volume is exact, the displacement of the control
    /// points nearly the smallest.
    Finished,
    /// By passes over a coarse copy alone: the volume is off by what the copy lacks.
    Rough,
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
    /// Points of the surface that must land on targets.
    pub pins: Pins,
    /// Volume of each body to reach, or one number for all together, which is shared in proportion to the bodies' own; `None` for
    /// those of the mesh as bound.
    pub target: Option<Vec<f64>>,
    /// How much of the way from the volume as deformed (with the pins on their targets) to the target: 0 leaves it, 1 reaches the
    /// target.
    pub amount: f64,
    /// What is kept small while the volume changes.
    pub cost: Cost,
    /// What the correction must not do, even if it then misses the volume.
    pub limit: Option<Limit>,
    /// How exactly a huge mesh is corrected.
    pub accuracy: Accuracy,
}

impl Default for Preserve {
    fn default() -> Self {
        Self {
            axes: [1.0; 3],
            frame: None,
            method: Method::Balanced,
            weights: None,
            pins: Pins::default(),
            target: None,
            amount: 1.0,
            cost: Cost::Points,
            limit: None,
            accuracy: Accuracy::Exact,
        }
    }
}

/// What the correction did.
#[derive(Debug, Clone, PartialEq)]
pub struct Preserved {
    /// Corrected control points, `k` fastest. Coordinates along axes without a share are those given, bit for bit, if there are no
    /// pins.
    pub control: Vec<DVec3>,
    /// Volume of each body that was aimed at: the target as weakened by `amount`. None where pins alone were wanted of a mesh that
    /// encloses nothing.
    pub targets: Vec<f64>,
    /// What ran, after any fall-back.
    pub method: Method,
    /// Rounds over the axes: 0 where nothing was to do, more than 1 where an axis was flat and passed its share on. Of the gradient,
    /// steps to the root; of the nearest, iterations.
    pub iterations: u32,
    /// Length of the displacements of the control points by the correction, `sqrt(sum w |delta|^2)`, in the weights' norm with the
    /// lightest weight 1.
    pub distance: f64,
    /// Volume, of all bodies together, that is missing from the targets because of a limit.
    pub missing: f64,
}

impl Preserved {
    /// The volume aimed at, of all bodies together.
    pub fn target(&self) -> f64 {
        self.targets.iter().fold(0.0, |sum, target| sum + target)
    }
}

/// What a method reached.
struct Solved {
    targets: Vec<f64>,
    method: Method,
    rounds: u32,
}

impl<T: Scalar> Binding<T> {
    /// Deforms the mesh by `control` and corrects the control points so that its volume is the one wanted and its pins are on their
    /// targets; writes the vertices deformed by the corrected points to `out`, in the order bound.
    ///
    /// The volume of the result equals `Preserved::target` to about `4 epsilon A R / |V|` relative (area, radius; epsilon of
    /// the vertices' type). It is measured and summed in float64 on the vertices as they stand, before every step; or by a cubic form
    /// of the control points that was summed once over the mesh ([`Binding::prepare`]), which differs by rounding only.
    ///
    /// # Errors
    /// [`Error::Mesh`](crate::Error::Mesh) where the triangles enclose no volume; [`Error::Lattice`](crate::Error::Lattice) for wrong
    /// control points or weights; [`Error::Pin`](crate::Error::Pin) for wrong, repeated, immovable or dependent pins;
    /// [`Error::Volume`](crate::Error::Volume) for wrong axes, frame, target or amount, for a flat mesh without a target of its own,
    /// and where no displacement allowed can change the volume.
    pub fn preserve(&self, control: &[DVec3], options: &Preserve, out: &mut [[T; 3]]) -> Result<Preserved> {
        let plan = self.plan(control, options)?;
        if let Some(tensor) = self.tensor() {
            let mut passes = OnTensor::new(&tensor, &plan.frame, &plan.inner_displacement(), self.epsilon());
            let preserved = plan.carry_out(&mut passes)?;
            self.deform(&preserved.control, out)?;
            return Ok(preserved);
        }
        if self.over().is_some() {
            return self.preserve_over_points(&plan, out);
        }
        if options.accuracy != Accuracy::Exact
            && let Some(preserved) = self.preserve_by_proxy(&plan, options, out)?
        {
            return Ok(preserved);
        }
        with_engine!(self, engine => {
            let mut passes = OnEngine::new(self, engine, &plan);
            let preserved = plan.carry_out(&mut passes)?;
            self.chosen().spent(passes.count);
            if plan.frame.is_identity() {
                self.write(&passes.state, out)?;
            } else {
                self.deform(&preserved.control, out)?;
            }
            engine.recycle(passes.state);
            Ok(preserved)
        })
    }

    /// The same where the volume is that of a surface over the vertices.
    fn preserve_over_points(&self, plan: &Plan, out: &mut [[T; 3]]) -> Result<Preserved> {
        with_engine!(self, engine => {
            let mut passes = OverPoints::new(self, engine, &plan.frame, &plan.inner_displacement());
            let preserved = plan.carry_out(&mut passes)?;
            engine.recycle(passes.state);
            self.deform(&preserved.control, out)?;
            Ok(preserved)
        })
    }
}

impl Plan {
    /// Carries the correction out on a backend, which must hold the mesh deformed by the plan's `inner_displacement` and then holds it as
    /// corrected.
    ///
    /// # Errors
    /// [`Error::Volume`](crate::Error::Volume) and [`Error::Pin`](crate::Error::Pin) for what cannot be reached, and the backend's own.
    pub fn carry_out<P: Passes>(&self, passes: &mut P) -> std::result::Result<Preserved, P::Error> {
        let mut correction = Correction::new(self, passes);
        let solved = match self.method {
            // Pins alone are brought to their targets the same way by all.
            _ if self.amount == 0.0 => sweep::sweep(&mut correction, self.method)?,
            Method::Sweep | Method::Balanced => sweep::sweep(&mut correction, self.method)?,
            Method::Gradient => gradient::gradient(&mut correction)?,
            Method::Nearest => nearest::nearest(&mut correction)?,
        };
        let missing = match &self.unfolded {
            Some(unfolded) => unfolded.hold(&mut correction, &solved.targets)?,
            None => 0.0,
        };
        let control = correction.control;
        Ok(Preserved {
            missing,
            distance: self.distance(&control),
            control,
            targets: solved.targets,
            method: solved.method,
            iterations: solved.rounds,
        })
    }

    /// Length of the way from the control points asked for, in the weights' norm.
    pub fn distance(&self, control: &[DVec3]) -> f64 {
        let moved = control.iter().zip(&self.control).zip(&self.mobility);
        let squares = moved.map(|((new, old), &mobility)| match mobility {
            0.0 => 0.0,
            mobility => (*new - *old).length_squared() / mobility,
        });
        squares.sum::<f64>().sqrt()
    }
}
