// SPDX-License-Identifier: GPL-3.0-or-later
//! The sizes of the volume paper's tables, the same bits twice, and several bindings and threads on one device.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod device;

use std::sync::Arc;

use isochor_core::{AxisBasis, Binding, DVec3, Lattice, Outside, Preserve};
use isochor_gpu::{Device, Mesh, TOLERANCE, Work};

/// Vertex counts of the paper's tables 1 and 2.
const SIZES: [usize; 9] = [2_562, 5_247, 19_851, 31_947, 52_971, 137_062, 327_323, 437_645, 543_652];

/// A bumpy sphere of rings with exactly so many vertices: those beyond full rings split triangles.
fn sphere(vertex_count: usize) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let around = ((vertex_count - 2) as f64 * 2.0).sqrt() as u32;
    let rings = (vertex_count as u32 - 2) / around;
    let mut points = vec![DVec3::Z, DVec3::NEG_Z];
    for ring in 0..rings {
        let height = std::f64::consts::PI * f64::from(ring + 1) / f64::from(rings + 1);
        for i in 0..around {
            let turn = std::f64::consts::TAU * f64::from(i) / f64::from(around);
            points.push(DVec3::new(height.sin() * turn.cos(), height.sin() * turn.sin(), height.cos()));
        }
    }
    let at = |ring: u32, i: u32| 2 + ring * around + i % around;
    let mut triangles = Vec::new();
    for i in 0..around {
        triangles.push([0, at(0, i), at(0, i + 1)]);
        triangles.push([1, at(rings - 1, i + 1), at(rings - 1, i)]);
        for ring in 1..rings {
            triangles.push([at(ring - 1, i), at(ring, i), at(ring, i + 1)]);
            triangles.push([at(ring - 1, i), at(ring, i + 1), at(ring - 1, i + 1)]);
        }
    }
    for face in 0..vertex_count - points.len() {
        let [a, b, c] = triangles[face];
        let middle = points.len() as u32;
        points.push((points[a as usize] + points[b as usize] + points[c as usize]) / 3.0);
        triangles[face] = [a, b, middle];
        triangles.extend([[b, c, middle], [c, a, middle]]);
    }
    let bump = |p: DVec3| p * (1.0 + 0.1 * (7.0 * p.x + 3.0 * p.y).sin() * (5.0 * p.z).cos());
    (points.into_iter().map(|p| bump(p).as_vec3().to_array()).collect(), triangles)
}

fn bound(vertex_count: usize, points: usize) -> Binding<f32> {
    let (vertices, triangles) = sphere(vertex_count);
    assert_eq!(vertices.len(), vertex_count);
    let axes = std::array::from_fn(|_| AxisBasis::uniform(points, 3).unwrap());
    let lattice = Lattice::around(axes, &[DVec3::splat(-1.2), DVec3::splat(1.2)], 0.0).unwrap();
    Binding::new(lattice, vertices, triangles, None, Outside::Keep).unwrap()
}

/// A twist and a squash, further at each step.
fn pose(binding: &Binding<f32>, step: f64) -> Vec<DVec3> {
    let turned = |p: &DVec3| {
        let (sin, cos) = (0.5 * step * p.z).sin_cos();
        DVec3::new(cos * p.x - sin * p.y, sin * p.x + cos * p.y, p.z * (1.0 - 0.5 * step))
    };
    binding.lattice().rest().iter().map(turned).collect()
}

fn run(binding: &Binding<f32>, mesh: &Mesh, step: f64) -> Vec<[f32; 3]> {
    let mut out = binding.vertices().to_vec();
    let outcome = mesh.preserve(binding, &pose(binding, step), &Preserve::default(), &mut out).unwrap();
    assert_eq!(outcome.work, Work::Device);
    let error = (binding.measure(&out).unwrap().volume / outcome.preserved.target() - 1.0).abs();
    assert!(error <= TOLERANCE, "{}: {error:e}", out.len());
    out
}

#[test]
fn every_size_of_the_papers_tables() {
    let Some(device) = device::device() else { return };
    for size in SIZES {
        let binding = bound(size, 10);
        let mesh = Mesh::new(device.clone(), &binding).unwrap();
        let mut cpu = binding.vertices().to_vec();
        binding.preserve(&pose(&binding, 0.8), &Preserve::default(), &mut cpu).unwrap();
        let out = run(&binding, &mesh, 0.8);
        let apart = out.iter().flatten().zip(cpu.iter().flatten()).map(|(a, b)| (a - b).abs());
        let apart = apart.fold(0.0, f32::max);
        assert!(apart < 5e-6, "{size}: {apart:e} from the CPU");
    }
}

#[test]
fn two_runs_give_the_same_bits() {
    let Some(device) = device::device() else { return };
    let binding = bound(52_971, 6);
    let bits = |mesh: &Mesh| {
        let other = run(&binding, mesh, 0.3);
        let found = run(&binding, mesh, 0.8);
        assert_ne!(other, found);
        found
    };
    let first = bits(&Mesh::new(device.clone(), &binding).unwrap());
    assert_eq!(first, bits(&Mesh::new(device, &binding).unwrap()));
}

fn alone(device: &Arc<Device>, binding: &Binding<f32>) -> Vec<Vec<[f32; 3]>> {
    let mesh = Mesh::new(device.clone(), binding).unwrap();
    (1..10).map(|step| run(binding, &mesh, 0.1 * f64::from(step))).collect()
}

#[test]
fn two_bindings_at_once_from_two_threads() {
    let Some(device) = device::device() else { return };
    let bindings = [bound(5_247, 10), bound(19_851, 6)];
    let one_by_one = bindings.each_ref().map(|binding| alone(&device, binding));
    let at_once = std::thread::scope(|scope| {
        let threads = bindings.each_ref().map(|binding| scope.spawn(|| alone(&device, binding)));
        threads.map(|thread| thread.join().unwrap())
    });
    assert_eq!(one_by_one, at_once);
}

#[test]
fn one_binding_from_two_threads() {
    let Some(device) = device::device() else { return };
    let binding = bound(5_247, 6);
    let mesh = Mesh::new(device, &binding).unwrap();
    let steps = [0.2, 0.9];
    let one_by_one = steps.map(|step| run(&binding, &mesh, step));
    std::thread::scope(|scope| {
        for (step, expected) in steps.iter().zip(&one_by_one) {
            let (binding, mesh) = (&binding, &mesh);
            scope.spawn(move || (0..10).for_each(|_| assert_eq!(&run(binding, mesh, *step), expected)));
        }
    });
}
