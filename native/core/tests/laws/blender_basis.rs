// SPDX-License-Identifier: GPL-3.0-or-later
//! Blender's bases against the formulas of Blender's own lattice, written out here.

use crate::shared::{INTERPOLATIONS, noise, slanted};
use isochor_core::{AxisBasis, Binding, DMat3, DVec3, Interpolation, Lattice, Outside};

/// Factors of the four points around a place, `t` in units of their spacing beyond the second.
fn factors(kind: Interpolation, t: f64) -> [f64; 4] {
    let hermite = |fc: f64| {
        let (t2, t3) = (t * t, t * t * t);
        [
            -fc * t3 + 2.0 * fc * t2 - fc * t,
            (2.0 - fc) * t3 + (fc - 3.0) * t2 + 1.0,
            (fc - 2.0) * t3 + (3.0 - 2.0 * fc) * t2 + fc * t,
            fc * t3 - fc * t2,
        ]
    };
    match kind {
        Interpolation::Linear => [0.0, 1.0 - t, t, 0.0],
        Interpolation::Cardinal => hermite(0.71),
        Interpolation::CatmullRom => hermite(0.5),
        Interpolation::BSpline => {
            let (t2, t3) = (t * t, t * t * t);
            [
                -t3 / 6.0 + t2 / 2.0 - t / 2.0 + 1.0 / 6.0,
                t3 / 2.0 - t2 + 2.0 / 3.0,
                -t3 / 2.0 + t2 / 2.0 + t / 2.0 + 1.0 / 6.0,
                t3 / 6.0,
            ]
        }
    }
}

/// The points that act along one axis and their factors.
fn along(kind: Interpolation, count: usize, s: f64) -> Vec<(usize, f64)> {
    if count == 1 {
        return vec![(0, 1.0)];
    }
    let place = s * (count - 1) as f64;
    let cell = place.floor();
    let index = |step: i64| (cell as i64 + step).clamp(0, count as i64 - 1) as usize;
    let factors = factors(kind, place - cell);
    (0..4).map(|tap| (index(tap - 1), factors[tap as usize])).collect()
}

/// How far a point moves.
fn way(shape: [usize; 3], kinds: [Interpolation; 3], moved: &[DVec3], s: DVec3) -> DVec3 {
    let [u, v, w] = [0, 1, 2].map(|axis| along(kinds[axis], shape[axis], s[axis]));
    let mut way = DVec3::ZERO;
    for &(i, a) in &u {
        for &(j, b) in &v {
            for &(k, c) in &w {
                way += moved[(i * shape[1] + j) * shape[2] + k] * (a * b * c);
            }
        }
    }
    way
}

fn lattice(shape: [usize; 3], kinds: [Interpolation; 3]) -> Lattice {
    slanted(std::array::from_fn(|axis| AxisBasis::blender(shape[axis], kinds[axis]).unwrap()))
}

/// Places in and far around the lattice, its faces and points among them.
fn places(shape: [usize; 3], seed: u64) -> Vec<DVec3> {
    let mut random = noise(seed);
    let mut places: Vec<DVec3> =
        (0..400).map(|_| DVec3::new(random(), random(), random()) * 2.0 + 0.5).collect();
    let grid = |i: i64, axis: usize| i as f64 / (shape[axis] - 1).max(1) as f64;
    for i in -3..=shape[0] as i64 + 2 {
        places.push(DVec3::new(grid(i, 0), grid(i, 1), grid(1 - i, 2)));
    }
    places
}

#[test]
fn every_interpolation_and_resolution_is_blender_s() {
    let shapes = (1..=8).map(|n| [n, (3 * n) % 8 + 1, (5 * n + 2) % 8 + 1]).chain([[64, 2, 3]]);
    for (seed, shape) in shapes.enumerate() {
        for first in 0..4 {
            for kinds in [[first; 3], [first, (first + 1) % 4, (first + 3) % 4]] {
                let kinds = kinds.map(|kind| INTERPOLATIONS[kind]);
                let lattice = lattice(shape, kinds);
                let mut random = noise(seed as u64);
                let moved: Vec<DVec3> =
                    (0..lattice.len()).map(|_| DVec3::new(random(), random(), random())).collect();
                let control: Vec<DVec3> = lattice.rest().iter().zip(&moved).map(|(p, d)| p + d).collect();
                let places = places(shape, seed as u64 + 50);
                let evaluated = lattice.evaluate(&places, &control).unwrap();
                let vertices: Vec<[f64; 3]> = places.iter().map(|&s| lattice.point(s).to_array()).collect();
                let binding =
                    Binding::new(lattice.clone(), vertices.clone(), Vec::new(), None, Outside::Extend)
                        .unwrap();
                let mut out = vertices.clone();
                binding.deform(&control, &mut out).unwrap();
                for (v, &s) in places.iter().enumerate() {
                    let way = way(shape, kinds, &moved, s);
                    let label = format!("{shape:?} {kinds:?} at {s}");
                    let found = DVec3::from_array(out[v]) - DVec3::from_array(vertices[v]);
                    assert!((found - way).length() < 1e-12, "{label}: {found} for {way}");
                    let found = evaluated[v] - lattice.point(s);
                    assert!((found - way).length() < 1e-12, "{label}: {found} for {way}");
                }
            }
        }
    }
}

#[test]
fn kept_points_beyond_the_grid_stay_and_those_inside_move_as_blender_s() {
    let (shape, kinds) = ([4, 5, 3], [INTERPOLATIONS[3], INTERPOLATIONS[1], INTERPOLATIONS[2]]);
    let lattice = lattice(shape, kinds);
    let mut random = noise(3);
    let moved: Vec<DVec3> = (0..60).map(|_| DVec3::new(random(), random(), random())).collect();
    let control: Vec<DVec3> = lattice.rest().iter().zip(&moved).map(|(p, d)| p + d).collect();
    let places: Vec<DVec3> = (0..500)
        .map(|_| DVec3::new(random(), random(), random()) * 0.7 + 0.5)
        .chain(places(shape, 6))
        .collect();
    let vertices: Vec<[f64; 3]> = places.iter().map(|&s| lattice.point(s).to_array()).collect();
    let binding = Binding::new(lattice, vertices.clone(), Vec::new(), None, Outside::Keep).unwrap();
    let mut out = vertices.clone();
    binding.deform(&control, &mut out).unwrap();
    let mut counts = [0; 2];
    for (v, &s) in places.iter().enumerate() {
        let inside = s.cmpge(DVec3::splat(-1e-9)).all() && s.cmple(DVec3::splat(1.0 + 1e-9)).all();
        counts[usize::from(inside)] += 1;
        let way = if inside { way(shape, kinds, &moved, s) } else { DVec3::ZERO };
        let found = DVec3::from_array(out[v]) - DVec3::from_array(vertices[v]);
        assert!((found - way).length() < 1e-12, "{s}");
    }
    assert!(counts[0] > 100 && counts[1] > 20 && binding.outside_count() == counts[0], "{counts:?}");
}

#[test]
fn control_points_at_rest_are_evenly_spaced_from_face_to_face() {
    for kind in INTERPOLATIONS {
        let axes = [3, 1, 5].map(|count| AxisBasis::blender(count, kind).unwrap());
        let rest = Lattice::new(axes, DVec3::ZERO, DMat3::IDENTITY).unwrap().rest();
        let expected = (0..15).map(|p| DVec3::new((p / 5) as f64 / 2.0, 0.5, (p % 5) as f64 / 4.0));
        assert!(rest.iter().zip(expected).all(|(found, expected)| (*found - expected).length() < 1e-15));
    }
}

#[test]
fn negative_functions_take_no_weights() {
    for kind in INTERPOLATIONS {
        let of = || lattice([4; 3], [kind; 3]);
        let mut weights = vec![1.0; 64];
        assert!(of().with_weights(weights.clone()).is_ok());
        weights[0] = 2.0;
        let refused = matches!(kind, Interpolation::Cardinal | Interpolation::CatmullRom);
        assert_eq!(of().with_weights(weights).is_err(), refused, "{kind:?}");
    }
}
