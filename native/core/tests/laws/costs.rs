// SPDX-License-Identifier: GPL-3.0-or-later
//! What a correction keeps small, other than the control points' own distance.

use crate::shared::{Mesh, bases, bumpy_ball, noise, slanted, volume};
use isochor_core::{
    AxisBasis, Binding, Cost, DVec3, Error, Lattice, Method, Outside, PinPoint, Pins, Preserve,
};

const METHODS: [Method; 4] = [Method::Sweep, Method::Balanced, Method::Gradient, Method::Nearest];

fn bind(lattice: &Lattice, mesh: &Mesh) -> Binding<f64> {
    Binding::new(lattice.clone(), mesh.vertices.clone(), mesh.triangles.clone(), None, Outside::Keep).unwrap()
}

fn shaken(lattice: &Lattice, seed: u64) -> Vec<DVec3> {
    let mut random = noise(seed);
    let mut shake = || 0.1 * DVec3::new(random(), random(), random());
    lattice.rest().iter().map(|p| *p * DVec3::new(0.9, 0.7, 0.5) + shake()).collect()
}

/// Square root of the sum of the vertices' squared ways.
fn moved(binding: &Binding<f64>, from: &[DVec3], to: &[DVec3]) -> f64 {
    let deformed = |control: &[DVec3]| {
        let mut out = vec![[0.0; 3]; binding.vertices().len()];
        binding.deform(control, &mut out).unwrap();
        out
    };
    let (from, to) = (deformed(from), deformed(to));
    let squares = from.as_flattened().iter().zip(to.as_flattened()).map(|(a, b)| (a - b) * (a - b));
    squares.sum::<f64>().sqrt()
}

#[test]
fn every_cost_and_method_keeps_volume_pins_and_frozen_points() {
    let mesh = bumpy_ball(4);
    for (name, axes) in bases() {
        let lattice = slanted(axes);
        let binding = bind(&lattice, &mesh);
        let control = shaken(&lattice, 3);
        let pins = Pins {
            points: vec![PinPoint::Vertex(7)],
            targets: vec![DVec3::from_array(mesh.vertices[7]) * 1.1],
        };
        let is_frozen = |p: usize| p.is_multiple_of(7);
        let weights =
            (0..lattice.len()).map(|p| if is_frozen(p) { f64::INFINITY } else { 1.0 + (p % 5) as f64 });
        let weights: Vec<f64> = weights.collect();
        for cost in [Cost::Surface, Cost::Bending] {
            for method in METHODS {
                let options = Preserve {
                    cost,
                    method,
                    pins: pins.clone(),
                    weights: Some(weights.clone()),
                    ..Preserve::default()
                };
                let mut out = vec![[0.0; 3]; mesh.vertices.len()];
                let outcome = binding.preserve(&control, &options, &mut out).unwrap();
                let error = (volume(&out, &mesh.triangles) / outcome.target() - 1.0).abs();
                assert!(error < 1e-12, "{name} {cost:?} {method:?}: {error:e}");
                let off = (DVec3::from_array(out[7]) - pins.targets[0]).length();
                assert!(off < 1e-12, "{name} {cost:?} {method:?}: {off:e}");
                (0..lattice.len())
                    .filter(|&p| is_frozen(p))
                    .for_each(|p| assert_eq!(outcome.control[p], control[p]));
            }
        }
    }
}

#[test]
fn the_surface_moves_least_where_that_is_the_cost() {
    let mesh = bumpy_ball(4);
    for (name, axes) in bases() {
        let lattice = slanted(axes);
        let binding = bind(&lattice, &mesh);
        let control = shaken(&lattice, 5);
        let run = |cost: Cost, method: Method| {
            let mut out = vec![[0.0; 3]; mesh.vertices.len()];
            binding.preserve(&control, &Preserve { cost, method, ..Preserve::default() }, &mut out).unwrap()
        };
        let costs = [Cost::Surface, Cost::Points, Cost::Bending];
        let [by_surface, by_points, by_bending] = costs.map(|cost| run(cost, Method::Nearest));
        let ways =
            [&by_surface, &by_points, &by_bending].map(|found| moved(&binding, &control, &found.control));
        assert!(ways[0] < ways[1] * 1.0001 && ways[0] < ways[2] * 1.0001, "{name}: {ways:?}");
        assert!(by_points.distance <= by_surface.distance && by_points.distance <= by_bending.distance);
        for method in METHODS {
            let other = moved(&binding, &control, &run(Cost::Surface, method).control);
            assert!(ways[0] < other * 1.0001, "{name} {method:?}: {} {other}", ways[0]);
        }
    }
}

#[test]
fn what_bends_least_is_affine() {
    let mesh = bumpy_ball(4);
    let axes = std::array::from_fn(|_| AxisBasis::uniform(7, 3).unwrap());
    let lattice = Lattice::around(axes, &[DVec3::splat(-1.2), DVec3::splat(1.2)], 0.0).unwrap();
    let binding = bind(&lattice, &mesh);
    let control: Vec<DVec3> = lattice.rest().iter().map(|p| *p * DVec3::new(1.0, 1.0, 0.5)).collect();
    for method in METHODS {
        let mut out = vec![[0.0; 3]; mesh.vertices.len()];
        let options = Preserve { cost: Cost::Bending, method, ..Preserve::default() };
        let found = binding.preserve(&control, &options, &mut out).unwrap().control;
        let delta: Vec<DVec3> = found.iter().zip(&control).map(|(new, old)| *new - *old).collect();
        let size = delta.iter().map(|d| d.length()).fold(0.0, f64::max);
        for step in [1, 7, 49] {
            for p in (step..343 - step).filter(|p| (1..6).contains(&(p / step % 7))) {
                let bend = (delta[p - step] - 2.0 * delta[p] + delta[p + step]).length();
                assert!(bend < 1e-3 * size, "{method:?} {p} {step}: {bend} of {size}");
            }
        }
    }
}

#[test]
fn a_lattice_too_large_to_factorise_is_an_error_in_words() {
    let axes = std::array::from_fn(|_| AxisBasis::bernstein(20).unwrap());
    let lattice = slanted(axes);
    let binding = bind(&lattice, &bumpy_ball(2));
    let mut out = vec![[0.0; 3]; binding.vertices().len()];
    let options = Preserve { cost: Cost::Bending, ..Preserve::default() };
    match binding.preserve(&lattice.rest(), &options, &mut out) {
        Err(Error::Lattice(message)) => assert!(message.contains("use fewer control points"), "{message}"),
        other => unreachable!("{other:?}"),
    }
}
