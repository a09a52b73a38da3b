// SPDX-License-Identifier: GPL-3.0-or-later
//! Corrections pass by pass on the device: pins and the volume at once, measured in float64 on the vertices that come out.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "../../core/tests/shared/mod.rs"]
mod shared;

mod device;

use isochor_core::{
    Bind, Binding, Bodies, DVec3, Lattice, Method, Outside, PinPoint, Pins, Preserve, Scalar,
};
use isochor_gpu::{Mesh, TOLERANCE, Work};
use shared::{bases, bumpy_ball, mapped, noise, slanted};

fn pushed(lattice: &Lattice, seed: u64) -> Vec<DVec3> {
    let mut random = noise(seed);
    lattice.rest().iter().map(|p| *p + 0.1 * DVec3::new(random(), random(), random())).collect()
}

/// A vertex and the middle of a face, each a tenth of the lattice away from where the lattice takes it.
fn two_pins<T: Scalar>(binding: &Binding<T>, control: &[DVec3]) -> Pins {
    let mut out = binding.vertices().to_vec();
    binding.deform(control, &mut out).unwrap();
    let at = |v: u32| DVec3::from_array(out[v as usize].map(T::to_f64));
    let face = binding.triangles()[40];
    let middle = face.map(at).into_iter().sum::<DVec3>() / 3.0;
    Pins {
        points: vec![PinPoint::Vertex(7), PinPoint::Face(40, [1.0 / 3.0; 3])],
        targets: vec![at(7) + DVec3::new(0.1, -0.05, 0.1), middle - DVec3::new(0.0, 0.1, 0.05)],
    }
}

fn check<T: Scalar>(vertices: &[[T; 3]], tolerance: f64) {
    let Some(device) = device::device() else { return };
    let mesh = bumpy_ball(3);
    for (number, (name, axes)) in bases().into_iter().enumerate() {
        let lattice = slanted(axes);
        let binding =
            Binding::new(lattice.clone(), vertices.to_vec(), mesh.triangles.clone(), None, Outside::Extend)
                .unwrap();
        let on_device = Mesh::new(device.clone(), &binding).unwrap();
        let control = pushed(&lattice, number as u64 + 1);
        let pins = two_pins(&binding, &control);
        let (mut out, mut cpu) = (vertices.to_vec(), vertices.to_vec());
        for axes in [[1.0, 1.0, 1.0], [1.0, 2.0, 0.0], [0.0, 0.0, 1.0]] {
            for (method, amount) in [(Method::Sweep, 1.0), (Method::Balanced, 0.5), (Method::Sweep, 0.0)] {
                let label = format!("{name} {axes:?} {method:?} {amount}");
                let options = Preserve { axes, method, amount, pins: pins.clone(), ..Preserve::default() };
                let outcome = on_device.preserve(&binding, &control, &options, &mut out).unwrap();
                assert_eq!(outcome.work == Work::Cpu, amount == 0.5 && tolerance < TOLERANCE, "{label}");
                let reference = binding.preserve(&control, &options, &mut cpu).unwrap();
                let target = outcome.preserved.target();
                assert!((target / reference.target() - 1.0).abs() < 1e-5, "{label}: {target}");
                let error = (binding.measure(&out).unwrap().volume / target - 1.0).abs();
                assert!(error <= tolerance, "{label}: volume off by {error:e}");
                let miss = binding.largest_miss(&pins, &out).unwrap();
                assert!(miss <= tolerance, "{label}: pins miss by {miss:e}");
                let way = outcome.preserved.distance / reference.distance;
                assert!((way - 1.0).abs() < 1e-3, "{label}: {way} times as far as on the CPU");
            }
        }
    }
}

#[test]
fn pins_and_volume_of_float32_vertices() {
    let single: Vec<[f32; 3]> = bumpy_ball(3).vertices.iter().map(|p| p.map(|c| c as f32)).collect();
    check(&single, TOLERANCE);
}

#[test]
fn pins_and_volume_of_float64_vertices() {
    check(&bumpy_ball(3).vertices, 1e-12);
}

/// Two balls side by side, the second a third as large, and the first few triangles of each left out if wanted.
fn two_balls(left_out: usize) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let ball = bumpy_ball(3);
    let count = ball.vertices.len() as u32;
    let placed = |size: f64, x: f64| {
        ball.vertices.iter().map(move |p| [x + size * p[0], size * p[1], size * p[2]].map(|c| c as f32))
    };
    let triangles =
        |first: u32| ball.triangles[left_out..].iter().map(move |t| t.map(|v| v + first)).collect::<Vec<_>>();
    (placed(0.6, -0.6).chain(placed(0.2, 0.7)).collect(), [triangles(0), triangles(count)].concat())
}

#[test]
fn every_island_keeps_its_volume_on_the_device() {
    let Some(device) = device::device() else { return };
    for (caps, left_out) in [(false, 0), (true, 3)] {
        let (vertices, triangles) = two_balls(left_out);
        for (name, axes) in bases() {
            let lattice = slanted(axes);
            let how = Bind { outside: Outside::Extend, bodies: Bodies::Islands, caps, ..Bind::default() };
            let binding = Binding::with(lattice.clone(), vertices.clone(), triangles.clone(), how).unwrap();
            let on_device = Mesh::new(device.clone(), &binding).unwrap();
            let control = pushed(&lattice, 5);
            let mut out = vertices.clone();
            let options = Preserve::default();
            let outcome = on_device.preserve(&binding, &control, &options, &mut out).unwrap();
            assert_ne!(outcome.work, Work::Cpu, "{name}");
            assert_eq!(outcome.preserved.targets.len(), 2, "{name}");
            for (body, reference) in binding.measures(&out).unwrap().iter().zip(binding.references().unwrap())
            {
                let error = (body.volume / reference.volume - 1.0).abs();
                assert!(error <= TOLERANCE, "{name}, caps {caps}: {error:e}");
            }
        }
    }
}

/// Vertices as deformed, and as corrected by every method with and without pins, of lattices whose control points are not those that the
/// device knows.
fn check_mapped<T: Scalar>(vertices: &[[T; 3]], tolerance: f64) {
    let Some(device) = device::device() else { return };
    let mesh = bumpy_ball(3);
    for (number, (name, lattice)) in mapped().into_iter().enumerate() {
        let binding =
            Binding::new(lattice.clone(), vertices.to_vec(), mesh.triangles.clone(), None, Outside::Extend)
                .unwrap();
        let on_device = Mesh::new(device.clone(), &binding).unwrap();
        let control = pushed(&lattice, number as u64 + 1);
        let (mut out, mut cpu) = (vertices.to_vec(), vertices.to_vec());
        on_device.deform(&binding, &control, &mut out).unwrap();
        binding.deform(&control, &mut cpu).unwrap();
        let at = |p: &[T; 3]| DVec3::from_array(p.map(T::to_f64));
        let apart = out.iter().zip(&cpu).map(|(a, b)| (at(a) - at(b)).length()).fold(0.0, f64::max);
        assert!(apart < 2e-5, "{name}: {apart:e}");
        let pins = two_pins(&binding, &control);
        for method in [Method::Sweep, Method::Balanced, Method::Gradient, Method::Nearest] {
            for pins in [Pins::default(), pins.clone()] {
                let label = format!("{name} {method:?} {} pins", pins.points.len());
                let options = Preserve { method, pins: pins.clone(), ..Preserve::default() };
                let outcome = on_device.preserve(&binding, &control, &options, &mut out).unwrap();
                assert_ne!(outcome.work, Work::Cpu, "{label}");
                let reference = binding.preserve(&control, &options, &mut cpu).unwrap();
                let target = outcome.preserved.target();
                let error = (binding.measure(&out).unwrap().volume / target - 1.0).abs();
                assert!(error <= tolerance, "{label}: volume off by {error:e}");
                let miss = binding.largest_miss(&pins, &out).unwrap();
                assert!(miss <= tolerance, "{label}: pins miss by {miss:e}");
                let way = outcome.preserved.distance / reference.distance;
                assert!((way - 1.0).abs() < 5e-3, "{label}: {way} times as far as on the CPU");
            }
        }
    }
}

#[test]
fn rational_and_blender_lattices_with_float32_vertices() {
    let single: Vec<[f32; 3]> = bumpy_ball(3).vertices.iter().map(|p| p.map(|c| c as f32)).collect();
    check_mapped(&single, TOLERANCE);
}

#[test]
fn rational_and_blender_lattices_with_float64_vertices() {
    check_mapped(&bumpy_ball(3).vertices, 1e-12);
}

#[test]
fn what_float32_calls_flat_is_left_to_the_cpu() {
    let Some(device) = device::device() else { return };
    let mesh = bumpy_ball(3);
    let (_, axes) = bases().remove(0);
    let lattice = slanted(axes);
    let binding =
        Binding::new(lattice.clone(), mesh.vertices.clone(), mesh.triangles.clone(), None, Outside::Extend)
            .unwrap();
    let on_device = Mesh::new(device, &binding).unwrap();
    let thin: Vec<DVec3> = lattice.rest().iter().map(|p| DVec3::new(1e-7 * p.x, p.y, p.z)).collect();
    let mut out = mesh.vertices.clone();
    binding.deform(&thin, &mut out).unwrap();
    let pins = Pins { points: vec![PinPoint::Vertex(7)], targets: vec![DVec3::from_array(out[7])] };
    // Farther off than float32's rounding explains.
    let target = 1e-3;
    let options = Preserve { axes: [0.0, 0.0, 1.0], target: Some(vec![target]), pins, ..Preserve::default() };
    let outcome = on_device.preserve(&binding, &thin, &options, &mut out).unwrap();
    assert_eq!(outcome.work, Work::Cpu);
    let measured = binding.measure(&out).unwrap();
    let allowed = 4.0 * f64::EPSILON * measured.area * measured.radius;
    assert!((measured.volume - target).abs() <= allowed, "{} for {target}", measured.volume);
}
