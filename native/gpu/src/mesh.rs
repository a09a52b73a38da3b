// SPDX-License-Identifier: GPL-3.0-or-later
//! A binding on a device.

use std::sync::{Arc, Mutex};

use isochor_core::{Binding, DMat3, DVec3, Measure, Method, Plan, Preserve, Preserved, Scalar};
use rayon::prelude::*;

use crate::device::{Device, locked};
use crate::error::{Error, Failure, Result};
use crate::frames::{Frames, Reading};
use crate::pack::Packed;
use crate::parts::Parts;
use crate::passes::{OnDevice, Uploaded};
use crate::twins::two_float;
use crate::types::{Frame, Turn};

/// Largest relative error of the volume, measured in float64 on the vertices as returned, that float32 vertices come back with
/// as the device computed them. Above it the closing step follows.
pub const TOLERANCE: f64 = 1e-6;

/// An axis whose coefficients are smaller than this fraction of the squared size of the lattice, deformed or at rest, is left to
/// the CPU: float32 gives coefficients an error of about 1e-7 of it, and the step would have lost three of seven digits.
const FLAT: f64 = 1e-4;

/// A volume smaller than this fraction of the cubed size of the lattice has no sign that float32 could tell.
const NO_VOLUME: f64 = 1e-7;

/// A volume off by less than this fraction of the target stays: it is what float32 makes of the right one, and correcting it
/// would move even a lattice at rest.
const NEGLIGIBLE: f64 = TOLERANCE / 4.0;

/// A binding's fixed data on a device. May be used from several threads; frames of one mesh follow one another.
pub struct Mesh {
    device: Arc<Device>,
    frames: Mutex<Frames>,
    /// Where there are several bodies.
    parts: Option<Parts>,
    unit: f64,
    /// Longest edge of the lattice's domain.
    size: f64,
    /// Whether the lattice leaves a vertex alone, in the order bound.
    is_still: Vec<bool>,
}

/// A correction, and what carried it out.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// What the correction did.
    pub preserved: Preserved,
    /// Where the work was done.
    pub work: Work,
    /// Seconds that the kernels took on the device, where it keeps time.
    pub seconds: Option<f64>,
}

/// Where the work of a correction was done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Work {
    /// On the device alone.
    Device,
    /// On the device, with a closing step in float64 on the CPU.
    DeviceAndClosing,
    /// On the CPU: an axis was flat, the volumes have no ratio, or float64 vertices lack less than float32 can tell.
    Cpu,
}

/// What a frame gave, in float64 and the binding's units.
struct Found {
    steps: Vec<(usize, Vec<f64>)>,
    /// Volume before the correction, in the frame's coordinates.
    before: f64,
    seconds: Option<f64>,
}

impl Mesh {
    /// Uploads a binding.
    ///
    /// # Errors
    /// The mesh is too large for the device, or the device failed.
    pub fn new<T: Scalar>(device: Arc<Device>, binding: &Binding<T>) -> Result<Self> {
        device.check()?;
        let packed = Packed::new(binding);
        if packed.slots() == 0 {
            return Err(Error::TooLarge("GPU: the mesh has no vertices; use the CPU".into()));
        }
        let frames = Mutex::new(Frames::new(&device, &packed)?);
        let bodies = binding.body_count();
        let parts = (bodies > 1).then(|| Parts::new(&packed, bodies));
        Ok(Self { device, frames, parts, unit: packed.unit, size: packed.size, is_still: packed.is_still() })
    }

    /// The device.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Bytes that the mesh takes on the device.
    pub fn bytes(&self) -> u64 {
        locked(&self.frames).bytes()
    }

    /// Deforms as [`Binding::deform`] does, with float32's accuracy: about 1e-6 of the lattice's size. `binding` must be the
    /// one uploaded. Returns the seconds that the kernels took, where the device keeps time.
    ///
    /// # Errors
    /// Those of [`Binding::deform`], or that the device failed.
    pub fn deform<T: Scalar>(
        &self,
        binding: &Binding<T>,
        control: &[DVec3],
        out: &mut [[T; 3]],
    ) -> std::result::Result<Option<f64>, Failure> {
        let displacement = binding.displacement(control)?;
        let inner = binding.lattice().map().displacement(&displacement);
        let controls: Vec<[f32; 4]> = inner.iter().map(|d| self.control(*d, 0.0)).collect();
        let frame = Frame {
            to_frame: columns(DMat3::IDENTITY),
            from_frame: columns(DMat3::IDENTITY),
            shape: shape(binding),
            ..Frame::default()
        };
        Ok(self.run(&frame, &controls, 0, |reading| {
            self.add_moved(binding, reading.moved, out);
            reading.seconds
        })?)
    }

    /// Deforms and corrects as [`Binding::preserve`] does. `binding` must be the one uploaded.
    ///
    /// float32 vertices come back with a relative error of the volume of at most [`TOLERANCE`], or of what rounding the
    /// result to float32 leaves where that is more; float64 vertices with what [`Binding::preserve`] guarantees.
    ///
    /// # Errors
    /// Those of [`Binding::preserve`], or that the device failed.
    pub fn preserve<T: Scalar>(
        &self,
        binding: &Binding<T>,
        control: &[DVec3],
        options: &Preserve,
        out: &mut [[T; 3]],
    ) -> std::result::Result<Outcome, Failure> {
        let plan = binding.plan(control, options)?;
        if !plan.is_plain() {
            return self.pass_by_pass(binding, options, &plan, out);
        }
        if options.amount == 0.0 {
            return self.uncorrected(binding, control, options, out);
        }
        if !binding.lattice().map().is_identity() {
            // The step that one submission solves for is of inner control points, which do not move on their own.
            return self.pass_by_pass(binding, options, &plan, out);
        }
        let (frame, controls) = self.inputs_of(binding, control, options, &plan);
        let turns = frame.turns.iter().position(|turn| turn.last == 1).map_or(0, |last| last + 1);
        let found = self.run(&frame, &controls, turns, |reading| {
            let found = self.found(&reading, &frame, turns);
            if found.is_some() {
                self.add_moved(binding, reading.moved, out);
            }
            found
        })?;
        let Some(found) = found else { return on_cpu(binding, control, options, out) };
        let before = if is_double::<T>() && options.amount != 1.0 {
            binding.volume(control)?
        } else {
            found.before * plan.determinant
        };
        let preserved = corrected(control, options, &plan, &found, before);
        if !is_double::<T>() && is_close(binding, &preserved, out)? {
            return Ok(Outcome { preserved, work: Work::Device, seconds: found.seconds });
        }
        if preserved.iterations == 0 {
            // Nothing that float32 could tell: what is left, if anything, is float64's.
            return on_cpu(binding, control, options, out);
        }
        let last = found.steps.last().map_or(0, |(axis, _)| *axis);
        closed(binding, options, &plan, Reached { preserved, seconds: found.seconds }, last, out)
    }

    /// A correction by the core's methods, each pass over the mesh on the device.
    fn pass_by_pass<T: Scalar>(
        &self,
        binding: &Binding<T>,
        options: &Preserve,
        plan: &Plan,
        out: &mut [[T; 3]],
    ) -> std::result::Result<Outcome, Failure> {
        let between = is_double::<T>() && options.amount != 0.0 && options.amount != 1.0;
        if between || plan.is_limited() {
            // The target lies between volumes that float32 knows to seven digits only; or what float32 leaves of it may not be made up
            // for afterwards.
            return on_cpu(binding, &plan.control, options, out);
        }
        let frame = self.frame(binding, &plan.control, options, plan);
        let frames = locked(&self.frames);
        let uploaded = Uploaded { binding, frames: &frames, parts: self.parts.as_ref(), unit: self.unit };
        let mut passes = OnDevice::new(uploaded, frame, plan)?;
        let preserved = match plan.carry_out(&mut passes) {
            // What float32 cannot reach, float64 may.
            Err(Failure::Core(isochor_core::Error::Volume(_))) => {
                return on_cpu(binding, &plan.control, options, out);
            }
            other => other?,
        };
        passes.moved(|moved| self.add_moved(binding, moved, out))?;
        drop(frames);
        let misses = binding.largest_miss(&options.pins, out)? > TOLERANCE * self.size;
        if !is_double::<T>() && !misses && is_close(binding, &preserved, out)? {
            return Ok(Outcome { preserved, work: Work::Device, seconds: None });
        }
        let last = (0..3).rev().find(|&axis| plan.shares[axis] > 0.0).unwrap_or_default();
        closed(binding, options, plan, Reached { preserved, seconds: None }, last, out)
    }

    /// A correction that leaves the volume as deformed.
    fn uncorrected<T: Scalar>(
        &self,
        binding: &Binding<T>,
        control: &[DVec3],
        options: &Preserve,
        out: &mut [[T; 3]],
    ) -> std::result::Result<Outcome, Failure> {
        if is_double::<T>() {
            return on_cpu(binding, control, options, out);
        }
        let seconds = self.deform(binding, control, out)?;
        let preserved = Preserved {
            control: control.to_vec(),
            targets: vec![binding.measure(out)?.volume],
            method: options.method,
            iterations: 0,
            distance: 0.0,
            missing: 0.0,
        };
        Ok(Outcome { preserved, work: Work::Device, seconds })
    }

    /// What a correction uploads. For tests.
    ///
    /// # Errors
    /// Those of [`Binding::plan`].
    pub fn inputs<T: Scalar>(
        &self,
        binding: &Binding<T>,
        control: &[DVec3],
        options: &Preserve,
    ) -> isochor_core::Result<(Frame, Vec<[f32; 4]>)> {
        Ok(self.inputs_of(binding, control, options, &binding.plan(control, options)?))
    }

    fn inputs_of<T: Scalar>(
        &self,
        binding: &Binding<T>,
        control: &[DVec3],
        options: &Preserve,
        plan: &Plan,
    ) -> (Frame, Vec<[f32; 4]>) {
        let controls = plan.displacement.iter().zip(&plan.mobility).map(|(d, w)| self.control(*d, *w));
        (self.frame(binding, control, options, plan), controls.collect())
    }

    /// The bytes of a buffer after a frame. For tests.
    ///
    /// # Errors
    /// That the device failed.
    pub fn inspect(&self, resource: crate::kernels::Resource) -> Result<Vec<u8>> {
        locked(&self.frames).fetch(&[resource], |parts| parts[0].to_vec())
    }

    fn run<R>(
        &self,
        frame: &Frame,
        controls: &[[f32; 4]],
        turns: usize,
        read: impl FnOnce(Reading<'_>) -> R,
    ) -> Result<R> {
        locked(&self.frames).run(frame, controls, turns, read)
    }

    fn control(&self, displacement: DVec3, mobility: f64) -> [f32; 4] {
        let [x, y, z] = (displacement / self.unit).to_array();
        [x, y, z, mobility].map(|value| value as f32)
    }

    /// What the device needs to know of a correction.
    fn frame<T: Scalar>(
        &self,
        binding: &Binding<T>,
        control: &[DVec3],
        options: &Preserve,
        plan: &Plan,
    ) -> Frame {
        let [to_frame, from_frame] = plan.maps();
        let centre = to_frame * binding.lattice().centre();
        let [x, y, z] = ((plan.middle - centre) / self.unit).to_array().map(|value| value as f32);
        let six_wanted = 6.0 * plan.wanted_in_all() / plan.determinant / self.unit.powi(3);
        let size = extent(control).max(self.size) / self.unit;
        Frame {
            to_frame: columns(to_frame),
            from_frame: columns(from_frame),
            turns: turns(plan.shares),
            middle: [x, y, z, 0.0],
            shape: shape(binding),
            wanted: two_float::from_f64(six_wanted),
            amount: options.amount as f32,
            balanced: u32::from(options.method == Method::Balanced),
            flat_axis: (6.0 * FLAT * size.powi(2)) as f32,
            no_volume: (6.0 * NO_VOLUME * size.powi(3)) as f32,
            negligible: (NEGLIGIBLE * six_wanted.abs()) as f32,
            ..Frame::default()
        }
    }

    /// The steps of the control points, or `None` where the CPU must do the call.
    fn found(&self, reading: &Reading<'_>, frame: &Frame, turns: usize) -> Option<Found> {
        let points = reading.delta.len() / frame.turns.len();
        let used = &reading.delta[..turns * points];
        let left = reading.status[..turns].iter().any(|status| status.left_to_cpu != 0);
        if left || used.iter().any(|delta| !delta.is_finite()) {
            return None;
        }
        let scaled = |row: &[f32]| row.iter().map(|&delta| f64::from(delta) * self.unit).collect();
        let steps = used.chunks_exact(points).zip(&frame.turns);
        Some(Found {
            steps: steps.map(|(row, turn)| (turn.axis as usize, scaled(row))).collect(),
            before: two_float::to_f64(reading.status[0].volume) / 6.0 * self.unit.powi(3),
            seconds: reading.seconds,
        })
    }

    /// Adds to every vertex as bound how far it moved, in float64; what does not move comes back bit for bit.
    fn add_moved<T: Scalar>(&self, binding: &Binding<T>, moved: &[[f32; 3]], out: &mut [[T; 3]]) {
        let bound = binding.vertices();
        out.par_iter_mut().enumerate().with_min_len(4096).for_each(|(v, to)| {
            // In a frame of directions, rounding moves even what the lattice leaves alone.
            let stays = self.is_still[v];
            for axis in 0..3 {
                let way = if stays { 0.0 } else { f64::from(moved[v][axis]) * self.unit };
                to[axis] = T::from_f64(bound[v][axis].to_f64() + way);
            }
        });
    }
}

/// Whether float32 is not enough for the coordinates.
fn is_double<T: Scalar>() -> bool {
    T::EPSILON < f64::from(f32::EPSILON)
}

/// Moves the control points by the steps found.
fn corrected(control: &[DVec3], options: &Preserve, plan: &Plan, found: &Found, before: f64) -> Preserved {
    let has_moved = found.steps.iter().any(|(_, step)| step.iter().any(|&distance| distance != 0.0));
    let mut control = control.to_vec();
    for (axis, step) in &found.steps {
        for (point, &distance) in control.iter_mut().zip(step) {
            plan.move_along(*axis, distance, point);
        }
    }
    let wanted = plan.wanted_in_all();
    let target = if options.amount == 1.0 { wanted } else { before + options.amount * (wanted - before) };
    Preserved {
        distance: plan.distance(&control),
        control,
        targets: vec![target],
        method: options.method,
        iterations: u32::from(has_moved),
        missing: 0.0,
    }
}

fn is_close<T: Scalar>(
    binding: &Binding<T>,
    preserved: &Preserved,
    out: &[[T; 3]],
) -> isochor_core::Result<bool> {
    if preserved.targets.is_empty() {
        return Ok(true);
    }
    let bodies = binding.measures(out)?;
    let is_met = |(body, target): (&Measure, &f64)| (body.volume - target).abs() <= TOLERANCE * target.abs();
    Ok(bodies.iter().zip(&preserved.targets).all(is_met))
}

/// A correction that the device has carried out.
struct Reached {
    preserved: Preserved,
    seconds: Option<f64>,
}

/// The correction on the CPU alone.
fn on_cpu<T: Scalar>(
    binding: &Binding<T>,
    control: &[DVec3],
    options: &Preserve,
    out: &mut [[T; 3]],
) -> std::result::Result<Outcome, Failure> {
    Ok(Outcome { preserved: binding.preserve(control, options, out)?, work: Work::Cpu, seconds: None })
}

/// What the device reached, made exact by one step along one axis; or by the CPU alone, where that axis is flat.
fn closed<T: Scalar>(
    binding: &Binding<T>,
    options: &Preserve,
    plan: &Plan,
    Reached { preserved, seconds }: Reached,
    axis: usize,
    out: &mut [[T; 3]],
) -> std::result::Result<Outcome, Failure> {
    match close(binding, options, plan, preserved, axis, out) {
        Ok(preserved) => Ok(Outcome { preserved, work: Work::DeviceAndClosing, seconds }),
        Err(isochor_core::Error::Volume(_)) => on_cpu(binding, &plan.control, options, out),
        Err(other) => Err(other.into()),
    }
}

/// One exact step along one axis, from the control points that the device found.
fn close<T: Scalar>(
    binding: &Binding<T>,
    options: &Preserve,
    plan: &Plan,
    preserved: Preserved,
    axis: usize,
    out: &mut [[T; 3]],
) -> isochor_core::Result<Preserved> {
    let mut axes = [0.0; 3];
    axes[axis] = 1.0;
    let closing = Preserve {
        axes,
        method: Method::Sweep,
        target: Some(preserved.targets.clone()),
        // Where nothing but pins was asked for, nothing but pins is closed.
        amount: if options.amount == 0.0 { 0.0 } else { 1.0 },
        ..options.clone()
    };
    let closed = binding.preserve(&preserved.control, &closing, out)?;
    Ok(Preserved {
        distance: plan.distance(&closed.control),
        control: closed.control,
        targets: closed.targets,
        iterations: preserved.iterations + closed.iterations,
        ..preserved
    })
}

/// The axes with a share, each with the sum of the shares up to it.
fn turns(shares: [f64; 3]) -> [Turn; 3] {
    let mut turns = [Turn::default(); 3];
    let active: Vec<usize> = (0..3).filter(|&axis| shares[axis] > 0.0).collect();
    let mut done = 0.0;
    for (number, &axis) in active.iter().enumerate() {
        done += shares[axis];
        turns[number] = Turn {
            axis: axis as u32,
            last: u32::from(number + 1 == active.len()),
            done: done as f32,
            unused: 0,
        };
    }
    turns
}

/// Largest side of the box around the control points.
fn extent(control: &[DVec3]) -> f64 {
    let low = control.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = control.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    (high - low).max_element()
}

fn columns(map: DMat3) -> [[f32; 4]; 3] {
    [map.x_axis, map.y_axis, map.z_axis]
        .map(|column| [column.x as f32, column.y as f32, column.z as f32, 0.0])
}

fn shape<T: Scalar>(binding: &Binding<T>) -> [u32; 4] {
    let [u, v, w] = binding.layout().shape();
    [u as u32, v as u32, w as u32, 0]
}
