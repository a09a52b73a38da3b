// SPDX-License-Identifier: GPL-3.0-or-later
//! The lattice as a damped elastic body under gravity, on a ground plane, with the volume of what it carries kept.
//!
//! The control points are the body's mass points; the cells of their grid are its material, as heavy and stiff as the share of
//! each that is inside the surface carried. Every corner of every cell has the
//! strain energy of the linear corotated model, `μ |F - R|²` (a hexahedron with one integration point a corner; A. McAdams et
//! al., "Efficient elasticity for character skinning with contact and collisions", 2011, eq. 1 without its volume term), with `R` the
//! rotation nearest to the deformation gradient `F`. That energy is finite in every state, flat and inverted ones too, and its
//! curvature is nowhere above the one at rest: an explicit step that is stable at rest is stable everywhere. So no system is
//! solved, no order of elements matters, and a symmetric body stays symmetric.
//!
//! What resists a change of volume is not the material but the constraint `V = V₀` on the volume inside the carried surface, the
//! cubic form of the volume correction: a uniform pressure, as in a filled skin. It and the ground are constraints on
//! positions after the explicit step, by position-based dynamics (M. Müller, B. Heidelberger, M. Hennix, J. Ratcliff,
//! "Position based dynamics", 2006, eq. 8 and 9; with small steps instead of many iterations, M. Macklin et al., "Small steps in
//! physics simulation", 2019, algorithm 1). The ground is met by the *vertices of the surface*: control points are not material, and
//! may stand far off it or below the ground. The push on a vertex moves its control points by their weights.
//!
//! Damping is that of the strain rate (Rayleigh's, proportional to stiffness), so that what falls or turns freely is not slowed;
//! on the ground it resists rolling as well.

mod cells;
mod ground;
mod material;
mod rotation;
mod skin;
mod state;

use glam::{DMat3, DVec3};

use crate::error::{Error, Result};
use crate::lattice::Lattice;
use crate::words::number;
use cells::{Cells, Modulus};
use ground::Contact;
pub use ground::Ground;
pub use material::Material;
use material::checked;
use skin::Skin;
pub use state::{Carried, Start, Totals};
use state::{check_targets, check_velocity};

/// Angle of the grid's fastest oscillation that one substep covers at most; 2 is where the leapfrog method turns unstable.
const STEP_ANGLE: f64 = 0.5;

/// Substeps of one call at most.
const MOST_SUBSTEPS: f64 = 1e5;

/// Seconds of one call at least: velocities are differences of places, of which rounding leaves too little in less.
const SHORTEST: f64 = 1e-9;

/// Rounds of volume and ground in one substep.
const ROUNDS: usize = 3;

/// How far below the ground a vertex may be left by a substep, as a fraction of the lattice's longest side.
const TOLERANCE: f64 = 1e-5;

/// How far volume may move a control point in one round, as a fraction of the lattice's longest side.
const LONGEST_SHIFT: f64 = 0.02;

/// An elastic lattice in motion. Everything is float64; results do not depend on the number of threads.
#[derive(Debug, Clone)]
pub struct Elastic {
    material: Material,
    cells: Cells,
    skin: Skin,
    contact: Contact,
    position: Vec<DVec3>,
    velocity: Vec<DVec3>,
    before: Vec<DVec3>,
    scratch: Vec<DVec3>,
    pressure: Vec<DVec3>,
    inverse_mass: Vec<f64>,
    time: f64,
    rest_volume: f64,
    start_volume: f64,
    fastest: f64,
}

impl Elastic {
    /// A body of the lattice's rest shape, in any state.
    ///
    /// # Errors
    /// [`Error::Elastic`] for a material that is none, [`Error::Lattice`] for a wrong start, [`Error::Mesh`] for a wrong surface.
    pub fn new(lattice: &Lattice, material: Material, carried: Carried<'_>, start: Start) -> Result<Self> {
        let material = checked(material)?;
        lattice.displacement(&start.control)?;
        check_velocity(&start.velocity, lattice.len())?;
        if start.pinned.len() != lattice.len() {
            return Err(Error::Lattice(format!(
                "pinned: found {}, expected {}",
                start.pinned.len(),
                lattice.len()
            )));
        }
        let Carried { vertices, triangles, influence, outside } = carried;
        let skin = Skin::new(lattice, vertices, triangles.to_vec(), influence, outside)?;
        let rest = lattice.rest();
        let inside = |point| !skin.encloses() || skin.is_inside(vertices, point);
        let mut cells = Cells::new(lattice.shape(), &rest, inside);
        cells.start(&start.control);
        let inverse = |(&mass, &pinned): (&f64, &bool)| if pinned { 0.0 } else { 1.0 / mass };
        let inverse_mass = cells.mass.iter().zip(&start.pinned).map(inverse).collect();
        let scratch = vec![DVec3::ZERO; rest.len()];
        let rest_volume = material.volume * skin.own_volume(&rest)?;
        let start_volume = skin.volume(&start.control);
        if !start_volume.is_finite() {
            return Err(Error::Lattice(
                "control: the surface has a volume too large for float64 there; bring the control points closer".into(),
            ));
        }
        let fastest = cells.fastest();
        Ok(Self {
            material,
            cells,
            skin,
            contact: Contact::default(),
            before: start.control.clone(),
            position: start.control,
            velocity: start.velocity,
            pressure: scratch.clone(),
            scratch,
            inverse_mass,
            time: 0.0,
            rest_volume,
            start_volume,
            fastest,
        })
    }

    /// Control points now, `k` fastest.
    pub fn control(&self) -> &[DVec3] {
        &self.position
    }

    /// Their velocities.
    pub fn velocity(&self) -> &[DVec3] {
        &self.velocity
    }

    /// Seconds since the start.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Volume inside the carried surface over the one that is kept; `None` where there is none.
    pub fn volume_ratio(&self) -> Option<f64> {
        self.skin.encloses().then(|| self.skin.volume(&self.position) / self.rest_volume)
    }

    /// Height of the lowest vertex above the ground; `None` without a ground or vertices.
    pub fn lowest(&self) -> Option<f64> {
        let ground = self.material.ground.as_ref()?;
        (self.skin.len() > 0).then(|| ground.lowest(&self.skin, &self.position))
    }

    /// Mass, momentum and energy.
    pub fn totals(&self) -> Totals {
        let all =
            || self.cells.mass.iter().zip(&self.position).zip(&self.velocity).map(|((m, x), v)| (*m, *x, *v));
        let mass: f64 = self.cells.mass.iter().sum();
        let centre = all().map(|(m, x, _)| x * m).sum::<DVec3>() / mass;
        let stretch = self.wave_speed().powi(2);
        Totals {
            mass,
            centre,
            momentum: all().map(|(m, _, v)| v * m).sum(),
            angular_momentum: all().map(|(m, x, v)| (x - centre).cross(v) * m).sum(),
            energy: [
                all().map(|(m, _, v)| 0.5 * m * v.length_squared()).sum(),
                stretch * self.cells.energy(&self.position),
                -mass * centre.dot(self.material.gravity),
            ],
        }
    }

    /// Moves on by `seconds`. Pinned points move evenly to their places in `targets` (one entry for each control point; those
    /// of free points do not count), or stay without.
    ///
    /// # Errors
    /// [`Error::Elastic`] for a time that is too short or not finite, or that is too many substeps for this stiffness, and for a
    /// motion beyond all numbers; [`Error::Lattice`] for wrong targets. Nothing has moved then.
    pub fn step(&mut self, seconds: f64, targets: Option<&[DVec3]>) -> Result<()> {
        let substeps = self.substeps(seconds)?;
        if let Some(targets) = targets {
            check_targets(targets, &self.inverse_mass)?;
        }
        let (from, velocity, time) = (self.position.clone(), self.velocity.clone(), self.time);
        let step = seconds / f64::from(substeps);
        for substep in 1..=substeps {
            let share = f64::from(substep) / f64::from(substeps);
            self.substep(step, |point| targets.map_or(from[point], |to| from[point].lerp(to[point], share)));
            self.time += step;
        }
        if self.position.iter().chain(&self.velocity).all(|value| value.is_finite()) {
            return Ok(());
        }
        (self.position, self.velocity, self.time) = (from, velocity, time);
        self.cells.start(&self.position);
        Err(Error::Elastic(format!(
            "seconds: within {} the motion goes beyond what float64 holds; lower gravity, velocity or the way of the targets",
            number(seconds)
        )))
    }

    fn wave_speed(&self) -> f64 {
        2.0 * self.cells.extent * self.material.frequency
    }

    /// Enough for the fastest oscillation of the grid.
    fn substeps(&self, seconds: f64) -> Result<u32> {
        if !(seconds.is_finite() && seconds >= SHORTEST) {
            return Err(Error::Elastic(format!(
                "seconds: found {}, expected a time of at least {}",
                number(seconds),
                number(SHORTEST)
            )));
        }
        let needed = (seconds * self.wave_speed() * self.fastest.sqrt() / STEP_ANGLE).ceil();
        if needed > MOST_SUBSTEPS {
            return Err(Error::Elastic(format!(
                "seconds: {} need {} substeps at frequency {}, expected at most {}; take a shorter time, a lower frequency or fewer control points",
                number(seconds),
                number(needed),
                number(self.material.frequency),
                number(MOST_SUBSTEPS)
            )));
        }
        Ok(self.material.substeps.max(needed as u32))
    }

    /// Relaxation time of the strain rate: damping ratio ζ at angular frequency ω takes 2 ζ / ω. In the grid's fastest
    /// oscillations no more than what one substep can carry.
    fn modulus(&self, step: f64) -> Modulus {
        let speed_squared = self.wave_speed().powi(2);
        let slowest = std::f64::consts::TAU * self.material.frequency;
        let most = 0.5 / (step * speed_squared * self.fastest).max(f64::MIN_POSITIVE);
        let relaxation = (2.0 * self.material.damping / slowest).min(most);
        let spin =
            if relaxation > 0.0 { self.turning().map_or(DVec3::ZERO, |(_, spin)| spin) } else { DVec3::ZERO };
        Modulus { speed_squared, relaxation, spin }
    }

    fn substep(&mut self, step: f64, target: impl Fn(usize) -> DVec3) {
        let modulus = self.modulus(step);
        self.cells.accelerations(&self.position, &self.velocity, modulus, &mut self.scratch);
        self.before.copy_from_slice(&self.position);
        // Gravity's half step squared makes free fall the exact parabola.
        let fall = self.material.gravity * (0.5 * step);
        for (point, position) in self.position.iter_mut().enumerate() {
            if self.inverse_mass[point] > 0.0 {
                *position += (self.velocity[point] + self.scratch[point] * step + fall) * step;
            } else {
                *position = target(point);
            }
        }
        self.constrain(step);
        for (point, velocity) in self.velocity.iter_mut().enumerate() {
            let free = if self.inverse_mass[point] > 0.0 { fall } else { DVec3::ZERO };
            *velocity = (self.position[point] - self.before[point]) / step + free;
        }
        self.resist_rolling(step);
    }

    /// What stands on the ground stops turning as its wobbling stops: rolling resistance, with the time constant of the
    /// damping. Momentum stays; a body that is led by pinned points turns as they do.
    fn resist_rolling(&mut self, step: f64) {
        let led = self.inverse_mass.contains(&0.0);
        if self.material.damping <= 0.0 || led || !self.contact.is_touching() {
            return;
        }
        let Some((centre, spin)) = self.turning() else { return };
        let rate = 2.0 * self.material.damping * std::f64::consts::TAU * self.material.frequency;
        let slowed = spin * (1.0 - (-rate * step).exp());
        for (x, v) in self.position.iter().zip(&mut self.velocity) {
            *v -= slowed.cross(*x - centre);
        }
    }

    /// Centre of mass and angular velocity of the whole; `None` where all is on one line.
    fn turning(&self) -> Option<(DVec3, DVec3)> {
        let mass = &self.cells.mass;
        let centre =
            self.position.iter().zip(mass).map(|(x, m)| *x * *m).sum::<DVec3>() / mass.iter().sum::<f64>();
        let (mut spin, mut inertia) = (DVec3::ZERO, DMat3::ZERO);
        for ((x, v), &m) in self.position.iter().zip(&self.velocity).zip(mass) {
            let arm = *x - centre;
            spin += arm.cross(*v) * m;
            let outer = DMat3::from_cols(arm * arm.x, arm * arm.y, arm * arm.z);
            inertia += (DMat3::from_diagonal(DVec3::splat(arm.length_squared())) - outer) * m;
        }
        let size = inertia.x_axis.x + inertia.y_axis.y + inertia.z_axis.z;
        (inertia.determinant() > 1e-9 * size.powi(3)).then(|| (centre, inertia.inverse() * spin))
    }

    /// Both constraints in turns. The pressure's direction is that before the substep, as SHAKE has it, which keeps angular
    /// momentum exactly.
    fn constrain(&mut self, step: f64) {
        let extent = self.cells.extent;
        if self.skin.encloses() {
            self.skin.gradient(&self.before, &mut self.pressure);
        }
        let ground = self.material.ground.filter(|_| self.skin.len() > 0);
        if let Some(ground) = &ground {
            let rise = extent * self.material.frequency * step;
            self.contact.begin(ground, &self.skin, &self.before, &self.inverse_mass, rise);
        }
        for _ in 0..ROUNDS {
            if self.skin.encloses() {
                self.fill(step);
            }
            if let Some(ground) = &ground {
                let (skin, inverse) = (&self.skin, &self.inverse_mass);
                self.contact.lift(ground, skin, &mut self.position, inverse, TOLERANCE * extent);
            }
        }
        if let Some(ground) = &ground {
            self.contact.rub(ground, &self.skin, &self.before, &mut self.position, &self.inverse_mass);
        }
    }

    /// One step of position-based dynamics towards the volume to keep. Where the start has another, it is reached over the time of
    /// an oscillation instead of at once.
    fn fill(&mut self, step: f64) {
        let late = (-std::f64::consts::TAU * self.material.frequency * (self.time + step)).exp();
        let wanted = self.rest_volume + (self.start_volume - self.rest_volume) * late;
        let lacking = wanted - self.skin.volume(&self.position);
        let pressed = || self.pressure.iter().zip(&self.inverse_mass);
        let slope: f64 = pressed().map(|(g, w)| g.length_squared() * w).sum();
        let steepest = pressed().map(|(g, w)| g.length() * w).fold(0.0, f64::max);
        if slope <= f64::MIN_POSITIVE || steepest <= 0.0 {
            return;
        }
        let most = LONGEST_SHIFT * self.cells.extent / steepest;
        let push = (lacking / slope).clamp(-most, most);
        for ((position, gradient), weight) in
            self.position.iter_mut().zip(&self.pressure).zip(&self.inverse_mass)
        {
            *position += *gradient * (push * weight);
        }
    }
}
