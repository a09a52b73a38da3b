// SPDX-License-Identifier: GPL-3.0-or-later
//! Laws of the bases and of the deformation.

use crate::shared::{bases, bumpy_ball, noise, slanted};
use isochor_core::{AxisBasis, Binding, DMat3, DVec3, Lattice, Outside};

fn bound(lattice: &Lattice, outside: Outside) -> Binding<f64> {
    let mesh = bumpy_ball(3);
    Binding::new(lattice.clone(), mesh.vertices, mesh.triangles, None, outside).unwrap()
}

#[test]
fn basis_functions_are_a_partition_of_unity_and_not_negative() {
    for degree in 1..=40 {
        for basis in [
            AxisBasis::bernstein(degree + 1).unwrap(),
            AxisBasis::clamped(degree + 5, degree).unwrap(),
            AxisBasis::uniform(degree + 5, degree).unwrap(),
        ] {
            for step in 0..=64 {
                let t = f64::from(step) / 64.0;
                let mut weights = vec![0.0; degree + 1];
                basis.span(basis.cell(t)).evaluate(t, &mut weights);
                let sum: f64 = weights.iter().sum();
                assert!((sum - 1.0).abs() < 1e-14, "degree {degree} at {t}: {sum}");
                assert!(weights.iter().all(|w| *w >= 0.0), "degree {degree} at {t}: {weights:?}");
            }
        }
    }
}

#[test]
fn bernstein_values_match_the_binomial_formula() {
    let mut binomial = 1.0;
    for i in 0..=20 {
        let basis = AxisBasis::bernstein(21).unwrap();
        let mut weights = vec![0.0; 21];
        basis.span(0).evaluate(0.25, &mut weights);
        let expected = binomial * 0.25f64.powi(i) * 0.75f64.powi(20 - i);
        assert!((weights[i as usize] - expected).abs() <= 1e-14 * expected);
        binomial = binomial * f64::from(20 - i) / f64::from(i + 1);
    }
}

#[test]
fn uniform_cubic_is_the_paper_s_matrix() {
    let basis = AxisBasis::uniform(10, 3).unwrap();
    assert_eq!(basis.cells(), 7);
    let (cell, t) = (2, 0.3);
    let mut weights = [0.0; 4];
    basis.span(cell).evaluate((cell as f64 + t) / 7.0, &mut weights);
    let paper = [
        1.0 - 3.0 * t + 3.0 * t * t - t * t * t,
        4.0 - 6.0 * t * t + 3.0 * t * t * t,
        1.0 + 3.0 * t + 3.0 * t * t - 3.0 * t * t * t,
        t * t * t,
    ];
    for (found, expected) in weights.iter().zip(paper) {
        assert!((found - expected / 6.0).abs() < 1e-15);
    }
}

#[test]
fn the_rest_lattice_is_the_identity_to_the_bit() {
    for (name, axes) in bases() {
        let lattice = slanted(axes);
        let binding = bound(&lattice, Outside::Keep);
        let mut out = vec![[0.0; 3]; binding.vertices().len()];
        binding.deform(&lattice.rest(), &mut out).unwrap();
        assert_eq!(out, binding.vertices(), "{name}");
    }
}

#[test]
fn affine_maps_of_the_control_points_are_reproduced() {
    let matrix =
        DMat3::from_cols(DVec3::new(0.3, 1.1, -0.2), DVec3::new(-0.9, 0.4, 0.1), DVec3::new(0.2, 0.3, 2.0));
    let map = |p: DVec3| matrix * p + DVec3::new(5.0, -3.0, 0.5);
    for (name, axes) in bases() {
        let lattice = slanted(axes);
        let binding = bound(&lattice, Outside::Keep);
        let control: Vec<DVec3> = lattice.rest().into_iter().map(map).collect();
        let mut out = vec![[0.0; 3]; binding.vertices().len()];
        binding.deform(&control, &mut out).unwrap();
        for (found, rest) in out.iter().zip(binding.vertices()) {
            let expected = map(DVec3::from_array(*rest));
            assert!((DVec3::from_array(*found) - expected).length() < 1e-13, "{name}");
        }
    }
}

#[test]
fn deforming_equals_evaluating_at_the_parameters() {
    for (name, axes) in bases() {
        let lattice = slanted(axes);
        let mut random = noise(7);
        let control: Vec<DVec3> =
            lattice.rest().iter().map(|p| p + 0.4 * DVec3::new(random(), random(), random())).collect();
        let binding = bound(&lattice, Outside::Extend);
        let mut out = vec![[0.0; 3]; binding.vertices().len()];
        binding.deform(&control, &mut out).unwrap();
        let parameters: Vec<DVec3> =
            binding.vertices().iter().map(|v| lattice.parameter(DVec3::from_array(*v))).collect();
        let expected = lattice.evaluate(&parameters, &control).unwrap();
        for (found, expected) in out.iter().zip(expected) {
            assert!((DVec3::from_array(*found) - expected).length() < 1e-14, "{name}");
        }
    }
}

#[test]
fn vertices_beyond_the_domain_stay_or_follow() {
    let axes = || std::array::from_fn(|_| AxisBasis::bernstein(4).unwrap());
    let lattice = Lattice::new(axes(), DVec3::splat(-0.5), DMat3::IDENTITY).unwrap();
    let shifted: Vec<DVec3> = lattice.rest().iter().map(|p| p + DVec3::X).collect();
    for outside in [Outside::Keep, Outside::Extend] {
        let binding = bound(&lattice, outside);
        let mut out = vec![[0.0; 3]; binding.vertices().len()];
        binding.deform(&shifted, &mut out).unwrap();
        let mut beyond = 0;
        for (found, rest) in out.iter().zip(binding.vertices()) {
            let inside = rest.iter().all(|c| c.abs() <= 0.5);
            beyond += usize::from(!inside);
            let moved = if inside || outside == Outside::Extend { 1.0 } else { 0.0 };
            assert!((found[0] - rest[0] - moved).abs() < 1e-14);
        }
        assert_eq!(binding.outside_count(), beyond);
        assert!(beyond > 0);
    }
}

#[test]
fn wrong_lattices_are_refused_by_name() {
    let cube = || std::array::from_fn(|_| AxisBasis::bernstein(4).unwrap());
    let message = |result: isochor_core::Result<Lattice>| result.unwrap_err().to_string();
    assert!(AxisBasis::bernstein(0).is_err());
    assert!(AxisBasis::bernstein(65).is_err());
    assert!(AxisBasis::uniform(3, 3).is_err());
    assert!(AxisBasis::with_knots(4, 3, vec![0.0; 8]).is_err());
    assert!(AxisBasis::with_knots(4, 3, vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.5, 1.0]).is_err());
    assert!(message(Lattice::new(cube(), DVec3::ZERO, DMat3::ZERO)).contains("edge s has length 0"));
    let flat = DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::X + DVec3::Y);
    assert!(message(Lattice::new(cube(), DVec3::ZERO, flat)).contains("in one plane"));
    assert!(message(Lattice::new(cube(), DVec3::NAN, DMat3::IDENTITY)).contains("NaN"));
    assert!(message(Lattice::around(cube(), &[], 0.0)).contains("points"));
}
