// SPDX-License-Identifier: GPL-3.0-or-later
//! Lattices one after the other: the same as each in turn, and the volume of them all kept by the last.

use crate::shared::{bumpy_ball, noise, slanted, volume};
use isochor_core::{
    AxisBasis, Bind, Binding, Bodies, Chain, DVec3, Error, Lattice, Method, Outside, PinPoint, Pins, Preserve,
};

fn cubic(n: usize) -> AxisBasis {
    AxisBasis::uniform(n, 3).unwrap()
}

/// A lattice around all, a small one within that moves what is in it, and one more around all.
fn three() -> Vec<(Lattice, Bind)> {
    let bernstein = AxisBasis::bernstein(4).unwrap();
    let around = slanted([cubic(5), cubic(4), cubic(6)]);
    let points = [DVec3::new(0.0, -0.4, -0.3), DVec3::new(0.9, 0.7, 0.6)];
    let local = Lattice::around([cubic(6), cubic(6), cubic(6)], &points, 0.0).unwrap();
    let last = slanted([bernstein.clone(), bernstein.clone(), bernstein]);
    let extend = Bind { outside: Outside::Extend, ..Bind::default() };
    vec![(around, extend.clone()), (local, Bind::default()), (last, extend)]
}

fn controls(links: &[(Lattice, Bind)], seed: u64) -> Vec<Vec<DVec3>> {
    let mut random = noise(seed);
    let mut jitter = || 0.1 * DVec3::new(random(), random(), random());
    let scale = DVec3::new(1.1, 0.9, 0.6);
    links.iter().map(|(lattice, _)| lattice.rest().iter().map(|p| *p * scale + jitter()).collect()).collect()
}

#[test]
fn a_chain_deforms_as_its_lattices_in_turn() {
    let mesh = bumpy_ball(3);
    let links = three();
    let controls = controls(&links, 5);
    let mut expected = mesh.vertices.clone();
    for ((lattice, options), control) in links.iter().zip(&controls) {
        let entering = expected.clone();
        let binding = Binding::with(lattice.clone(), entering, Vec::new(), options.clone()).unwrap();
        binding.deform(control, &mut expected).unwrap();
    }
    let mut chain = Chain::new(links.clone(), mesh.vertices.clone(), mesh.triangles.clone()).unwrap();
    let mut out = mesh.vertices.clone();
    chain.deform(&controls, &mut out).unwrap();
    assert_eq!(out, expected);
    assert!((chain.volume(&controls).unwrap() / volume(&expected, &mesh.triangles) - 1.0).abs() < 1e-13);
    // The order counts: the same lattices the other way round do something else.
    let reversed: Vec<_> = links.into_iter().rev().collect();
    let back: Vec<_> = controls.into_iter().rev().collect();
    Chain::new(reversed, mesh.vertices.clone(), mesh.triangles).unwrap().deform(&back, &mut out).unwrap();
    let apart = out.iter().flatten().zip(expected.iter().flatten()).map(|(a, b)| (a - b).abs());
    assert!(apart.fold(0.0, f64::max) > 1e-3);
}

#[test]
fn the_volume_of_what_enters_is_kept_by_the_last_alone() {
    let mesh = bumpy_ball(3);
    let wanted = volume(&mesh.vertices, &mesh.triangles);
    let links = three();
    let controls = controls(&links, 6);
    for method in [Method::Sweep, Method::Balanced, Method::Gradient, Method::Nearest] {
        let mut chain = Chain::new(links.clone(), mesh.vertices.clone(), mesh.triangles.clone()).unwrap();
        let mut out = mesh.vertices.clone();
        let options = Preserve { method, ..Preserve::default() };
        let found = chain.preserve(&controls, &options, &mut out).unwrap();
        assert!((volume(&out, &mesh.triangles) / wanted - 1.0).abs() < 1e-12, "{method:?}");
        assert!((found.target() / wanted - 1.0).abs() < 1e-14);
        // Only the last lattice's points moved: with them in place of its own the chain deforms to the same.
        let mut corrected = controls.clone();
        corrected[2] = found.control;
        let mut again = out.clone();
        chain.deform(&corrected, &mut again).unwrap();
        let apart = out.iter().flatten().zip(again.iter().flatten()).map(|(a, b)| (a - b).abs());
        assert!(apart.fold(0.0, f64::max) < 1e-13);
    }
}

#[test]
fn frames_do_not_depend_on_those_before_and_repeated_ones_embed_nothing() {
    let mesh = bumpy_ball(2);
    let links = three();
    let fresh = |controls: &[Vec<DVec3>]| {
        let mut chain = Chain::new(links.clone(), mesh.vertices.clone(), mesh.triangles.clone()).unwrap();
        let mut out = mesh.vertices.clone();
        chain.preserve(controls, &Preserve::default(), &mut out).unwrap();
        out
    };
    let (first, mut second) = (controls(&links, 7), controls(&links, 8));
    let mut chain = Chain::new(links.clone(), mesh.vertices.clone(), mesh.triangles.clone()).unwrap();
    let mut out = mesh.vertices.clone();
    for frame in [&first, &second, &first] {
        chain.preserve(frame, &Preserve::default(), &mut out).unwrap();
        assert_eq!(out, fresh(frame));
    }
    let chain = Chain::new(links.clone(), mesh.vertices.clone(), mesh.triangles.clone()).unwrap();
    let (mut before, mut last) = chain.into_parts();
    assert!(before.feed(&first, &mut last).unwrap().is_new);
    let vertices = last.vertices().to_vec();
    second[..2].clone_from_slice(&first[..2]);
    assert!(!before.feed(&second, &mut last).unwrap().is_new);
    assert_eq!(last.vertices(), vertices);
    second[1][3] += DVec3::X;
    assert!(before.feed(&second, &mut last).unwrap().is_new);
}

#[test]
fn new_vertices_are_those_of_a_new_chain() {
    let mesh = bumpy_ball(2);
    let links = three();
    let controls = controls(&links, 9);
    let moved: Vec<[f64; 3]> = mesh.vertices.iter().map(|p| p.map(|c| 0.9 * c + 0.02)).collect();
    let mut chain = Chain::new(links.clone(), mesh.vertices.clone(), mesh.triangles.clone()).unwrap();
    let [mut out, mut expected] = [mesh.vertices.clone(), mesh.vertices.clone()];
    chain.preserve(&controls, &Preserve::default(), &mut out).unwrap();
    chain.update(moved.clone()).unwrap();
    chain.preserve(&controls, &Preserve::default(), &mut out).unwrap();
    let mut fresh = Chain::new(links, moved.clone(), mesh.triangles.clone()).unwrap();
    fresh.preserve(&controls, &Preserve::default(), &mut expected).unwrap();
    assert_eq!(out, expected);
    assert!((volume(&out, &mesh.triangles) / volume(&moved, &mesh.triangles) - 1.0).abs() < 1e-12);
}

#[test]
fn pins_bodies_and_float32_go_through_a_chain() {
    let ball = bumpy_ball(3);
    let count = ball.vertices.len() as u32;
    let half = |sign: f64| ball.vertices.iter().map(move |p| p.map(|c| (0.4 * c + 0.5 * sign) as f32));
    let vertices: Vec<[f32; 3]> = half(-1.0).chain(half(1.0)).collect();
    let other = ball.triangles.iter().map(|face| face.map(|v| v + count));
    let triangles: Vec<[u32; 3]> = ball.triangles.iter().copied().chain(other).collect();
    let mut links = three();
    links[2].0 = slanted([cubic(6), cubic(6), cubic(6)]);
    links[2].1.bodies = Bodies::Islands;
    let controls = controls(&links, 10);
    let mut chain = Chain::new(links, vertices.clone(), triangles).unwrap();
    let wanted: Vec<f64> = chain.last().measures(&vertices).unwrap().iter().map(|body| body.volume).collect();
    let mut out = vertices.clone();
    let target = DVec3::new(0.3, 0.2, 0.1);
    let pins = Pins { points: vec![PinPoint::Vertex(count + 5)], targets: vec![target] };
    chain.preserve(&controls, &Preserve { pins: pins.clone(), ..Preserve::default() }, &mut out).unwrap();
    for (body, wanted) in chain.last().measures(&out).unwrap().iter().zip(&wanted) {
        assert!((body.volume / wanted - 1.0).abs() < 1e-6);
    }
    let held = DVec3::from_array(out[count as usize + 5].map(f64::from));
    assert!((held - target).length() < 1e-6);
    chain.preserve(&controls, &Preserve { pins, amount: 0.0, ..Preserve::default() }, &mut out).unwrap();
}

#[test]
fn wrong_chains_and_controls_are_refused() {
    let mesh = bumpy_ball(1);
    let none = Chain::new(Vec::new(), mesh.vertices.clone(), mesh.triangles.clone());
    assert!(matches!(none.err(), Some(Error::Lattice(_))));
    let links = three();
    let mut controls = controls(&links, 11);
    let mut chain = Chain::new(links, mesh.vertices.clone(), mesh.triangles).unwrap();
    let mut out = mesh.vertices.clone();
    let Err(Error::Lattice(text)) = chain.deform(&controls[..2], &mut out) else { unreachable!("accepted") };
    assert!(text.contains("found 2 sets") && text.contains("expected 3"), "{text}");
    let good = controls.clone();
    controls[1].pop();
    assert!(matches!(chain.deform(&controls, &mut out), Err(Error::Lattice(_))));
    chain.deform(&good, &mut out).unwrap();
}
