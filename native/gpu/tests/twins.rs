// SPDX-License-Identifier: GPL-3.0-or-later
//! float64 reference <-> CPU twin <-> WGSL, stage by stage, and that these comparisons can fail.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "../../core/tests/shared/mod.rs"]
mod shared;

mod device;

use bytemuck::Pod;
use isochor_core::{AxisBasis, Binding, DVec3, Lattice, Outside, Preserve};
use isochor_gpu::kernels::Resource;
use isochor_gpu::pack::Packed;
use isochor_gpu::twins::two_float::{TwoFloat, to_f64};
use isochor_gpu::twins::{deform, gather, gradient, reduce, shift, solve, write};
use isochor_gpu::types::{Frame, Status};
use isochor_gpu::{Mesh, Work};
use shared::{bases, bumpy_ball, noise, slanted};

/// Largest difference of a stage between twin and WGSL, as a fraction of the stage's largest number: a device may fuse
/// products into sums, and each stage feeds the next.
const TWIN_TO_WGSL: f64 = 4e-6;

/// The same between the float64 core and a twin: float32 rounds each of a few dozen operations by 6e-8 at most, and a basis of
/// degree 20 adds a few hundred.
const REFERENCE_TO_TWIN: f64 = 1e-5;

/// What every stage gave, by its name.
type Stages = Vec<(&'static str, Vec<f64>)>;

struct Case {
    name: &'static str,
    binding: Binding<f32>,
    influence: Vec<f64>,
    control: Vec<DVec3>,
    axis: usize,
}

impl Case {
    fn new(name: &'static str, axes: [AxisBasis; 3], axis: usize) -> Self {
        let mesh = bumpy_ball(4);
        let lattice = slanted(axes);
        let single = mesh.vertices.iter().map(|p| p.map(|c| c as f32)).collect();
        let influence: Vec<f64> = mesh.vertices.iter().map(|p| (0.6 + 0.5 * p[1]).clamp(0.0, 1.0)).collect();
        let mut random = noise(9);
        let mut nudge = || 0.05 * DVec3::new(random(), random(), random());
        let control = lattice.rest().iter().map(|p| *p * DVec3::new(1.1, 0.9, 0.6) + nudge()).collect();
        let binding =
            Binding::new(lattice, single, mesh.triangles, Some(influence.clone()), Outside::Keep).unwrap();
        Self { name, binding, influence, control, axis }
    }

    fn options(&self) -> Preserve {
        let mut axes = [0.0; 3];
        axes[self.axis] = 1.0;
        let weights = (0..self.binding.lattice().len()).map(|p| 1.0 + (p % 5) as f64).collect();
        Preserve { axes, weights: Some(weights), ..Preserve::default() }
    }
}

fn cases() -> Vec<Case> {
    bases().into_iter().enumerate().map(|(i, (name, axes))| Case::new(name, axes, i % 3)).collect()
}

fn numbers(values: &[f32]) -> Vec<f64> {
    values.iter().map(|&value| f64::from(value)).collect()
}

fn sums(values: &[TwoFloat]) -> Vec<f64> {
    values.iter().map(|&value| to_f64(value)).collect()
}

fn status(found: &Status) -> Vec<f64> {
    vec![to_f64(found.volume), f64::from(found.left_to_cpu)]
}

/// A frame of one turn by the twins.
fn by_twins(packed: &Packed<'_>, frame: &Frame, controls: &[[f32; 4]]) -> Stages {
    let mut state = deform::deform(packed, frame, controls);
    let (pull, volumes) = gradient::gradient(packed, frame, 0, &state);
    let partials = reduce::reduce(packed, &pull);
    let coefficients = gather::gather(packed, &partials);
    let (delta, found) = solve::solve(frame, 0, &volumes, &coefficients, controls, None);
    shift::shift(packed, frame, 0, &delta, &mut state);
    let moved = write::write(packed, frame, &state);
    vec![
        ("gradient: pull", numbers(&pull)),
        ("gradient: volumes", sums(&volumes)),
        ("reduce: partials", numbers(&partials)),
        ("gather: coefficients", sums(&coefficients)),
        ("solve: status", status(&found)),
        ("solve: delta", numbers(&delta)),
        ("shift: state", numbers(&state)),
        ("write: moved", numbers(moved.as_flattened())),
    ]
}

/// What the same frame left on the device.
fn on_device(mesh: &Mesh) -> Stages {
    let points = read::<TwoFloat>(mesh, Resource::Coefficients).len();
    vec![
        ("gradient: pull", numbers(&read(mesh, Resource::Pull))),
        ("gradient: volumes", sums(&read::<TwoFloat>(mesh, Resource::Volumes))),
        ("reduce: partials", numbers(&read(mesh, Resource::Partials))),
        ("gather: coefficients", sums(&read::<TwoFloat>(mesh, Resource::Coefficients))),
        ("solve: status", status(&read::<Status>(mesh, Resource::Status)[0])),
        ("solve: delta", numbers(&read(mesh, Resource::Delta)[..points])),
        ("shift: state", numbers(&read(mesh, Resource::State))),
        ("write: moved", numbers(&read(mesh, Resource::Moved))),
    ]
}

fn read<T: Pod>(mesh: &Mesh, resource: Resource) -> Vec<T> {
    bytemuck::pod_collect_to_vec(&mesh.inspect(resource).unwrap())
}

/// Every stage whose numbers are further apart than the tolerance, as a fraction of the largest of them.
fn differences(left: &Stages, right: &Stages, tolerance: f64) -> Vec<String> {
    left.iter()
        .zip(right)
        .filter_map(|((name, left), (_, right))| {
            assert_eq!(left.len(), right.len(), "{name}");
            let scale = right.iter().fold(0.0, |scale: f64, value| scale.max(value.abs()));
            let apart = left.iter().zip(right).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            // A NaN on either side counts as a difference.
            let close = apart <= tolerance * scale && left.iter().chain(right).all(|value| value.is_finite());
            (!close).then(|| format!("{name}: {:e} of {scale:e}", apart / scale))
        })
        .collect()
}

fn inputs(case: &Case, mesh: &Mesh) -> (Frame, Vec<[f32; 4]>) {
    mesh.inputs(&case.binding, &case.control, &case.options()).unwrap()
}

#[test]
fn every_kernel_does_what_its_twin_does() {
    let Some(device) = device::device() else { return };
    for case in cases() {
        let mesh = Mesh::new(device.clone(), &case.binding).unwrap();
        let mut out = case.binding.vertices().to_vec();
        let outcome = mesh.preserve(&case.binding, &case.control, &case.options(), &mut out).unwrap();
        assert_ne!(outcome.work, Work::Cpu, "{}", case.name);
        let (frame, controls) = inputs(&case, &mesh);
        let twins = by_twins(&Packed::new(&case.binding), &frame, &controls);
        let found = differences(&on_device(&mesh), &twins, TWIN_TO_WGSL);
        assert!(found.is_empty(), "{}: {found:?}", case.name);
    }
}

#[test]
fn the_twins_agree_with_the_float64_core() {
    let Some(device) = device::device() else { return };
    for case in cases() {
        let mesh = Mesh::new(device.clone(), &case.binding).unwrap();
        let (frame, controls) = inputs(&case, &mesh);
        let packed = Packed::new(&case.binding);
        let twins = by_twins(&packed, &frame, &controls);
        let of = |name: &str| twins.iter().find(|stage| stage.0 == name).unwrap().1.clone();

        let double: Vec<[f64; 3]> = case.binding.vertices().iter().map(|p| p.map(f64::from)).collect();
        let of_vertex = case.influence.clone();
        let reference = Binding::new(
            case.binding.lattice().clone(),
            double.clone(),
            case.binding.triangles().to_vec(),
            Some(of_vertex),
            Outside::Keep,
        )
        .unwrap();
        let mut corrected = double.clone();
        let wanted = case.binding.reference().unwrap().volume;
        let options = Preserve { target: Some(vec![wanted]), ..case.options() };
        let outcome = reference.preserve(&case.control, &options, &mut corrected).unwrap();
        let delta =
            outcome.control.iter().zip(&case.control).map(|(a, b)| (*a - *b)[case.axis] / packed.unit);
        let moved =
            corrected.iter().flatten().zip(double.iter().flatten()).map(|(a, b)| (a - b) / packed.unit);
        let volume = 6.0 * reference.volume(&case.control).unwrap() / packed.unit.powi(3);
        let right: Stages =
            vec![("volume", vec![volume]), ("delta", delta.collect()), ("moved", moved.collect())];
        let left: Stages = vec![
            ("volume", vec![of("solve: status")[0]]),
            ("delta", of("solve: delta")),
            ("moved", of("write: moved")),
        ];
        let found = differences(&left, &right, REFERENCE_TO_TWIN);
        assert!(found.is_empty(), "{}: {found:?}", case.name);
    }
}

#[test]
fn tripwire_a_perturbed_value_is_found() {
    let Some(device) = device::device() else { return };
    let case = cases().swap_remove(2);
    let mesh = Mesh::new(device, &case.binding).unwrap();
    let mut out = case.binding.vertices().to_vec();
    mesh.preserve(&case.binding, &case.control, &case.options(), &mut out).unwrap();
    let (frame, controls) = inputs(&case, &mesh);
    let packed = Packed::new(&case.binding);
    let truth = on_device(&mesh);
    // In each stage's result, one number off by a hundred times the tolerance.
    for stage in 0..truth.len() {
        let mut wrong = by_twins(&packed, &frame, &controls);
        let scale = wrong[stage].1.iter().fold(0.0, |scale: f64, value| scale.max(value.abs()));
        wrong[stage].1[0] += 100.0 * TWIN_TO_WGSL * scale;
        let found = differences(&truth, &wrong, TWIN_TO_WGSL);
        assert_eq!(found.len(), 1, "{}: {found:?}", wrong[stage].0);
    }
    // In the inputs: one control point, one knot, one step of a walk.
    let mut nudged = controls.clone();
    nudged[60][0] += 1e-3;
    assert!(!differences(&truth, &by_twins(&packed, &frame, &nudged), TWIN_TO_WGSL).is_empty());
    let mut packed = Packed::new(&case.binding);
    packed.knots[3][1] *= 1.001;
    assert!(!differences(&truth, &by_twins(&packed, &frame, &controls), TWIN_TO_WGSL).is_empty());
}

#[test]
fn two_floats_carry_what_floats_lose() {
    use isochor_gpu::twins::two_float::{add, add_float, two_sum};
    assert_eq!(two_sum(1.0, 1e-10), [1.0, 1e-10]);
    let terms = (1..=200_000).map(|i| 1.0 / f64::from(i)).map(|term| term as f32);
    let exact: f64 = terms.clone().map(f64::from).sum();
    let carried = terms.clone().fold([0.0; 2], add_float);
    assert!((to_f64(carried) / exact - 1.0).abs() < 1e-12, "{carried:?} {exact}");
    assert!((f64::from(terms.sum::<f32>()) / exact - 1.0).abs() > 1e-7);
    assert_eq!(add([1.0, 1e-9], [-1.0, 1e-9]), [2e-9, 0.0]);
}

#[test]
fn small_cells_keep_their_precision() {
    // 61 cells along an axis: parameters relative to the cell, not the domain, keep the basis to float32's rounding.
    let axis = || AxisBasis::uniform(64, 3).unwrap();
    let lattice = Lattice::around([axis(), axis(), axis()], &[DVec3::splat(-1.0), DVec3::ONE], 0.0).unwrap();
    let vertices: Vec<[f32; 3]> = (0..1000).map(|i| [-0.999 + 0.002 * i as f32, 0.3, -0.7]).collect();
    let binding = Binding::new(lattice, vertices, Vec::new(), None, Outside::Keep).unwrap();
    let packed = Packed::new(&binding);
    for tile in &packed.tiles {
        for slot in tile.first_slot..tile.first_slot + tile.slots {
            let t = packed.places[slot as usize][0];
            let found = isochor_gpu::twins::basis::basis(&packed.knots, tile.knots_u, 4, t);
            let t = f64::from(t);
            let exact =
                [(1.0 - t).powi(3), 3.0 * t.powi(3) - 6.0 * t * t + 4.0, 0.0, t.powi(3)].map(|b| b / 6.0);
            for i in [0, 1, 3] {
                assert!((f64::from(found[i]) - exact[i]).abs() < 3e-7, "{t} {i}: {} {}", found[i], exact[i]);
            }
        }
    }
}
