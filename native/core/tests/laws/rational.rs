// SPDX-License-Identifier: GPL-3.0-or-later
//! Laws of rational lattices.

use crate::shared::{bases, bumpy_ball, noise, slanted, weighted};
use isochor_core::{AxisBasis, Binding, DMat3, DVec3, Lattice, Outside, Preserve};

fn pushed(lattice: &Lattice, amount: f64, seed: u64) -> Vec<DVec3> {
    let mut random = noise(seed);
    lattice.rest().iter().map(|p| *p + amount * DVec3::new(random(), random(), random())).collect()
}

fn places(count: usize, seed: u64) -> Vec<DVec3> {
    let mut random = noise(seed);
    (0..count).map(|_| (DVec3::new(random(), random(), random()) + 1.0) * 0.5).collect()
}

/// Bernstein polynomials by the binomial formula.
fn bernstein(count: usize, t: f64) -> Vec<f64> {
    let degree = count - 1;
    let mut binomial = 1.0;
    (0..count)
        .map(|i| {
            let value = binomial * t.powi(i as i32) * (1.0 - t).powi((degree - i) as i32);
            binomial *= (degree - i) as f64 / (i + 1) as f64;
            value
        })
        .collect()
}

/// Sederberg's equation (14.1), written out: `w B / sum w B` of all control points, `k` fastest.
fn published(shape: [usize; 3], weights: &[f64], at: DVec3) -> Vec<f64> {
    let along = [0, 1, 2].map(|axis| bernstein(shape[axis], at[axis]));
    let mut functions = Vec::new();
    for i in 0..shape[0] {
        for j in 0..shape[1] {
            for k in 0..shape[2] {
                let product = along[0][i] * along[1][j] * along[2][k];
                functions.push(product * weights[functions.len()]);
            }
        }
    }
    let sum: f64 = functions.iter().sum();
    functions.into_iter().map(|function| function / sum).collect()
}

#[test]
fn the_map_and_the_deformation_are_as_published() {
    let axes = [4, 3, 6].map(|count| AxisBasis::bernstein(count).unwrap());
    let lattice = weighted(slanted(axes), 3);
    let (control, at) = (pushed(&lattice, 0.4, 1), places(200, 2));
    let weights = lattice.weights().unwrap().to_vec();
    let (found, rest) = (lattice.evaluate(&at, &control).unwrap(), lattice.rest());
    let vertices: Vec<[f64; 3]> = at.iter().map(|&s| lattice.point(s).to_array()).collect();
    let binding = Binding::new(lattice.clone(), vertices.clone(), Vec::new(), None, Outside::Keep).unwrap();
    let mut moved = vertices.clone();
    binding.deform(&control, &mut moved).unwrap();
    for (v, &s) in at.iter().enumerate() {
        let functions = published([4, 3, 6], &weights, s);
        let map: DVec3 = functions.iter().zip(&control).map(|(r, p)| *r * *p).sum();
        assert!((found[v] - map).length() < 1e-14, "{}", found[v] - map);
        let way: DVec3 = functions.iter().zip(&control).zip(&rest).map(|((r, p), q)| *r * (p - q)).sum();
        let expected = DVec3::from_array(vertices[v]) + way;
        assert!((DVec3::from_array(moved[v]) - expected).length() < 1e-14);
    }
}

#[test]
fn equal_weights_change_nothing_to_the_bit() {
    let mesh = bumpy_ball(3);
    for (name, axes) in bases() {
        let plain = slanted(axes);
        let equal = plain.clone().with_weights(vec![0.7; plain.len()]).unwrap();
        let control = pushed(&plain, 0.2, 4);
        let [one, other] = [plain, equal].map(|lattice| {
            let at = lattice.evaluate(&places(50, 1), &control).unwrap();
            let back = lattice.invert(&at, &control).unwrap();
            let binding =
                Binding::new(lattice, mesh.vertices.clone(), mesh.triangles.clone(), None, Outside::Keep)
                    .unwrap();
            let mut out = mesh.vertices.clone();
            let found = binding.preserve(&control, &Preserve::default(), &mut out).unwrap();
            (at, back, found, out)
        });
        assert_eq!(one, other, "{name}");
    }
}

/// A quadratic block whose middle weighs as much as makes its edges circular arcs of an angle.
fn arc(angle: f64, layers: [usize; 2]) -> (Lattice, Vec<DVec3>) {
    let axes = [3, layers[0], layers[1]].map(|count| AxisBasis::bernstein(count).unwrap());
    let lattice = Lattice::new(axes, DVec3::ZERO, DMat3::IDENTITY).unwrap();
    let half = 0.5 * angle;
    let (mut weights, mut control) = (Vec::new(), Vec::new());
    for i in 0..3 {
        for j in 0..layers[0] {
            for k in 0..layers[1] {
                let radius = 1.0 + j as f64;
                let turn = half * f64::from(i);
                let reach = if i == 1 { radius / half.cos() } else { radius };
                control.push(DVec3::new(reach * turn.cos(), reach * turn.sin(), 2.0 * k as f64));
                weights.push(if i == 1 { half.cos() } else { 1.0 });
            }
        }
    }
    (lattice.with_weights(weights).unwrap(), control)
}

#[test]
fn a_rational_quadratic_block_is_an_exact_circular_arc() {
    for angle in [0.3, 1.0, std::f64::consts::FRAC_PI_2, 2.0] {
        let (lattice, control) = arc(angle, [2, 2]);
        let at = places(300, 8);
        let found = lattice.evaluate(&at, &control).unwrap();
        for (s, p) in at.iter().zip(&found) {
            assert!((p.x.hypot(p.y) - (1.0 + s.y)).abs() < 4e-16 * 4.0, "{angle}: {p}");
            assert!((p.z - 2.0 * s.z).abs() < 1e-15);
        }
        // What lies on the arc of the middle radius comes back, and so does its radius.
        let back = lattice.invert(&found, &control).unwrap();
        for (s, found) in at.iter().zip(back) {
            assert!(found.inside && (found.parameter - *s).length() < 1e-12, "{angle} {s}");
        }
    }
}

#[test]
fn an_axis_with_one_control_point_keeps_its_thickness() {
    let (lattice, control) = arc(1.0, [2, 1]);
    let at = [DVec3::new(0.3, 0.5, 0.5), DVec3::new(0.3, 0.5, 0.9)];
    let [middle, above] = lattice.evaluate(&at, &control).unwrap()[..] else { return };
    assert!((middle.x.hypot(middle.y) - 1.5).abs() < 1e-15 && middle.z.abs() < 1e-15);
    assert!((above - middle - DVec3::Z * 0.4).length() < 1e-15);
    let back = lattice.invert(&[middle, above], &control).unwrap();
    assert!(back.iter().zip(at).all(|(found, at)| (found.parameter - at).length() < 1e-12));
}

#[test]
fn weights_that_are_none_are_refused_by_name() {
    let lattice = slanted([4, 4, 4].map(|count| AxisBasis::bernstein(count).unwrap()));
    let said = |weights: Vec<f64>| lattice.clone().with_weights(weights).unwrap_err().to_string();
    assert!(said(vec![1.0; 63]).starts_with("weights: found 63 values, expected 64"));
    for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let mut weights = vec![1.0; 64];
        weights[5] = wrong;
        assert!(said(weights).contains("the first of 1 that are not positive, finite"), "{wrong}");
    }
    let mut weights = vec![1.0; 64];
    weights[5] = 1e-7;
    assert!(said(weights).contains("at most"));
}

#[test]
fn a_heavy_point_pulls_more_and_the_whole_follows_a_translation() {
    let axes = || [4, 4, 4].map(|count| AxisBasis::bernstein(count).unwrap());
    let (at, i) = (vec![DVec3::new(0.4, 0.35, 0.3)], 21);
    let mut last = 0.0;
    for heavy in [0.01, 0.1, 1.0, 10.0, 1e4] {
        let mut weights = vec![1.0; 64];
        weights[i] = heavy;
        let lattice = slanted(axes()).with_weights(weights).unwrap();
        let vertices: Vec<[f64; 3]> = at.iter().map(|&s| lattice.point(s).to_array()).collect();
        let binding =
            Binding::new(lattice.clone(), vertices.clone(), Vec::new(), None, Outside::Keep).unwrap();
        let mut control = lattice.rest();
        control[i] += DVec3::X;
        let mut out = vertices.clone();
        binding.deform(&control, &mut out).unwrap();
        let way = out[0][0] - vertices[0][0];
        assert!(way > last && way < 1.0, "{heavy}: {way}");
        last = way;
        let control: Vec<DVec3> = lattice.rest().iter().map(|p| p + DVec3::new(3.0, -2.0, 5.0)).collect();
        binding.deform(&control, &mut out).unwrap();
        let moved = DVec3::from_array(out[0]) - DVec3::from_array(vertices[0]);
        assert!((moved - DVec3::new(3.0, -2.0, 5.0)).length() < 1e-14, "{heavy}: {moved}");
    }
    assert!(last > 0.99);
}
