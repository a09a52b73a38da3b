// SPDX-License-Identifier: GPL-3.0-or-later
//! Layers of control points that hold still for a smooth joint: what moves vanishes towards the face as fast as promised, and would not
//! with a layer less.

use crate::shared::{Mesh, bases, bumpy_ball, mapped, noise, slanted, volume};
use isochor_core::{AxisBasis, Bind, Binding, DVec3, Interpolation, Lattice, Method, Outside, Preserve};

/// Distance from a face, in cells, at which it is looked at how fast the motion vanishes, and at half of which again.
const NEAR: f64 = 2e-3;

/// Motions below this are nothing but rounding.
const NOTHING: f64 = 1e-12;

fn all() -> Vec<(String, Lattice)> {
    let plain = bases().into_iter().map(|(name, axes)| (name.to_owned(), slanted(axes)));
    plain.chain(mapped()).collect()
}

fn shaken(lattice: &Lattice, seed: u64) -> Vec<DVec3> {
    let mut random = noise(seed);
    lattice.rest().iter().map(|p| p + 0.3 * DVec3::new(random(), random(), random())).collect()
}

/// Parameters at a distance from a face and at half of it, and one beyond the face.
fn beside(lattice: &Lattice, axis: usize, upper: bool, seed: u64) -> Vec<[DVec3; 2]> {
    let mut random = noise(seed);
    let basis = &lattice.axes()[axis];
    // The uniform cell of Blender's; knots of the others are evenly spaced.
    let length = basis.knots()[basis.knots().len() / 2 + 1] - basis.knots()[basis.knots().len() / 2 - 1];
    let near = NEAR * length.max(1.0 / basis.cells() as f64).min(1.0);
    (0..40)
        .map(|_| {
            let at = (DVec3::new(random(), random(), random()) + 1.0) * 0.5;
            [near, 0.5 * near].map(|distance| {
                let mut place = at;
                place[axis] = if upper { 1.0 - distance } else { distance };
                place
            })
        })
        .collect()
}

/// A cloud of these places and one point beyond each of the faces, bound so.
fn cloud(
    lattice: &Lattice,
    places: &[[DVec3; 2]],
    faces: &[(usize, bool)],
    continuity: Option<usize>,
) -> Binding<f64> {
    let beyond = faces.iter().map(|&(axis, upper)| {
        let mut place = DVec3::splat(0.5);
        place[axis] = if upper { 1.5 } else { -0.5 };
        place
    });
    let places = places.as_flattened().iter().copied().chain(beyond);
    let vertices = places.map(|place| lattice.point(place).to_array()).collect();
    let options = Bind { continuity, ..Bind::default() };
    Binding::with(lattice.clone(), vertices, Vec::new(), options).unwrap()
}

/// How far points move at a distance from the face and at half of it, at most over all.
fn ways(binding: &Binding<f64>, control: &[DVec3]) -> Vec<[f64; 2]> {
    let mut out = binding.vertices().to_vec();
    binding.deform(control, &mut out).unwrap();
    let way = |v: usize| (DVec3::from_array(out[v]) - DVec3::from_array(binding.vertices()[v])).length();
    (0..out.len() / 2).map(|pair| [way(2 * pair), way(2 * pair + 1)]).collect()
}

/// What vanishes with all derivatives up to an order shrinks by that many powers of 2 and one.
fn vanishes(ways: &[[f64; 2]], continuity: usize, label: &str) {
    let share = 0.5f64.powi(continuity as i32 + 1);
    for &[far, near] in ways {
        assert!(near < NOTHING || near < 1.2 * share * far, "{label}: {near:e} after {far:e}");
    }
}

#[test]
fn the_moved_part_joins_with_the_continuity_asked_for() {
    for (seed, (name, lattice)) in all().into_iter().enumerate() {
        let control = shaken(&lattice, seed as u64);
        for continuity in 0..=2 {
            for (axis, upper) in [(0, false), (1, true), (2, false), (2, true)] {
                let places = beside(&lattice, axis, upper, 3);
                let binding = cloud(&lattice, &places, &[(axis, upper)], Some(continuity));
                let label = format!("{name} C{continuity} axis {axis} upper {upper}");
                let ways = ways(&binding, &control);
                vanishes(&ways[..places.len()], continuity, &label);
            }
        }
    }
}

#[test]
fn one_layer_less_would_not_do() {
    for (name, lattice) in all() {
        let shape = lattice.shape();
        for continuity in 0..=2 {
            for (axis, upper) in [(0, false), (0, true), (1, true), (2, false)] {
                let layers = lattice.axes()[axis].end_layers(upper, continuity);
                let layer = if upper { shape[axis] - layers } else { layers - 1 };
                let mut control = lattice.rest();
                for (p, point) in control.iter_mut().enumerate() {
                    let index = [p / (shape[1] * shape[2]), p / shape[2] % shape[1], p % shape[2]];
                    if index[axis] == layer {
                        *point += DVec3::X;
                    }
                }
                let places = beside(&lattice, axis, upper, 3);
                let binding = cloud(&lattice, &places, &[], None);
                let share = 0.5f64.powi(continuity as i32);
                let jumps = ways(&binding, &control).iter().any(|[far, near]| *near > 0.8 * share * far);
                assert!(jumps, "{name} C{continuity} axis {axis} upper {upper}: {layers} layers");
            }
        }
    }
}

#[test]
fn as_many_layers_as_known() {
    let layers = |basis: AxisBasis| -> Vec<usize> {
        (0..5)
            .map(|k| {
                assert_eq!(basis.end_layers(false, k), basis.end_layers(true, k));
                basis.end_layers(false, k)
            })
            .collect()
    };
    assert_eq!(layers(AxisBasis::bernstein(6).unwrap()), [1, 2, 3, 4, 5]);
    assert_eq!(layers(AxisBasis::clamped(9, 3).unwrap()), [1, 2, 3, 4, 4]);
    assert_eq!(layers(AxisBasis::uniform(9, 3).unwrap()), [3, 3, 3, 4, 4]);
    assert_eq!(layers(AxisBasis::uniform(9, 2).unwrap()), [2, 2, 3, 3, 3]);
    assert_eq!(layers(AxisBasis::uniform(3, 2).unwrap()), [2, 2, 3, 3, 3]);
    let blender = |kind| layers(AxisBasis::blender(6, kind).unwrap());
    assert_eq!(blender(Interpolation::Linear), [1, 2, 2, 2, 2]);
    assert_eq!(blender(Interpolation::Cardinal), [1, 2, 3, 3, 3]);
    assert_eq!(blender(Interpolation::CatmullRom), [1, 2, 3, 3, 3]);
    assert_eq!(blender(Interpolation::BSpline), [2, 2, 2, 3, 3]);
}

/// A ball half of which sticks out of the lattice, through two of its faces.
fn sticking_out(lattice: &Lattice) -> Mesh {
    let mut mesh = bumpy_ball(3);
    let corner = lattice.point(DVec3::new(0.15, 0.5, 0.9));
    mesh.vertices.iter_mut().for_each(|p| *p = (DVec3::from_array(*p) + corner).to_array());
    mesh
}

#[test]
fn corrections_hold_the_layers_too_and_keep_the_volume() {
    let faces = [[true, false], [false, false], [false, true]];
    for (seed, (name, lattice)) in all().into_iter().enumerate() {
        let mesh = sticking_out(&lattice);
        let control = shaken(&lattice, seed as u64 + 9);
        for continuity in [0, 1, 2] {
            let options = Bind { continuity: Some(continuity), ..Bind::default() };
            let binding = Binding::with(
                lattice.clone(),
                mesh.vertices.clone(),
                mesh.triangles.clone(),
                options.clone(),
            )
            .unwrap();
            let frozen = lattice.frozen(continuity, faces);
            let held = binding.held(&control).unwrap().into_owned();
            for (p, (found, rest)) in held.iter().zip(lattice.rest()).enumerate() {
                assert_eq!(*found, if frozen[p] { rest } else { control[p] }, "{name} {p}");
            }
            for method in [Method::Balanced, Method::Nearest] {
                let mut out = mesh.vertices.clone();
                let preserve = Preserve { method, ..Preserve::default() };
                if frozen.iter().all(|frozen| *frozen) {
                    binding.deform(&control, &mut out).unwrap();
                    assert_eq!(out, mesh.vertices, "{name}");
                    continue;
                }
                let found = binding.preserve(&control, &preserve, &mut out).unwrap();
                let error = (volume(&out, &mesh.triangles) / found.target() - 1.0).abs();
                assert!(error < 1e-12, "{name} C{continuity} {method:?}: {error:e}");
                for (p, (found, rest)) in found.control.iter().zip(lattice.rest()).enumerate() {
                    assert!(!frozen[p] || *found == rest, "{name} {p}");
                }
                for (to, from) in out.iter().zip(&mesh.vertices) {
                    let s = lattice.parameter(DVec3::from_array(*from));
                    assert!((s.x >= -1e-9 && s.z <= 1.0 + 1e-9) || to == from, "{name}");
                }
                for (axis, upper) in [(0, false), (2, true)] {
                    let places = beside(&lattice, axis, upper, 5);
                    let around = cloud(&lattice, &places, &[], None);
                    vanishes(&ways(&around, &found.control), continuity, &format!("{name} {method:?}"));
                }
            }
        }
    }
}

#[test]
fn without_a_continuity_nobody_but_the_correction_is_held() {
    for (seed, (name, lattice)) in all().into_iter().enumerate() {
        let mesh = sticking_out(&lattice);
        let control = shaken(&lattice, seed as u64);
        let bound = |outside, continuity| {
            let options = Bind { outside, continuity, ..Bind::default() };
            Binding::with(lattice.clone(), mesh.vertices.clone(), mesh.triangles.clone(), options).unwrap()
        };
        let held = |binding: Binding<f64>| binding.held(&control).unwrap().into_owned();
        assert_eq!(held(bound(Outside::Keep, None)), control, "{name}");
        assert_eq!(held(bound(Outside::Extend, Some(2))), control, "{name}");
    }
}
