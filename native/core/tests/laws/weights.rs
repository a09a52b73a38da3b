// SPDX-License-Identifier: GPL-3.0-or-later
//! Weights that keep a correction near chosen points, or where the volume went.

use crate::shared::{bases, bumpy_ball, slanted, volume};
use isochor_core::{AxisBasis, Binding, DMat3, DVec3, Lattice, Outside, Preserve};

#[test]
fn falloff_is_the_exponential_of_the_distance_to_the_nearest_point() {
    let lattice = slanted(bases().remove(0).1);
    let points = [DVec3::new(1.0, 0.5, -2.0), DVec3::new(-1.0, 0.0, 0.0)];
    let weights = lattice.falloff(&points, 0.7, None).unwrap();
    for (rest, weight) in lattice.rest().iter().zip(&weights) {
        let nearest = rest.distance(points[0]).min(rest.distance(points[1]));
        assert!((weight / (nearest / 0.7).exp() - 1.0).abs() < 1e-13);
    }
    let moved: Vec<DVec3> = lattice.rest().iter().map(|p| p + 3.0).collect();
    let shifted = points.map(|p| p + 3.0);
    let same = lattice.falloff(&shifted, 0.7, Some(&moved)).unwrap();
    assert!(same.iter().zip(&weights).all(|(a, b)| (a / b - 1.0).abs() < 1e-13));
}

#[test]
fn a_short_falloff_far_away_keeps_the_order_of_the_weights() {
    let lattice = slanted(bases().remove(0).1);
    let weights = lattice.falloff(&[DVec3::new(500.0, 0.0, 0.0)], 0.01, None).unwrap();
    let lightest = weights.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(lightest.is_finite() && weights.iter().all(|w| *w > 0.0) && weights.contains(&f64::INFINITY));
}

#[test]
fn without_a_change_of_volume_all_weights_are_one() {
    for (name, axes) in bases() {
        let lattice = slanted(axes);
        let shear = DMat3::from_cols(DVec3::X, DVec3::new(0.7, 1.0, 0.0), DVec3::new(-0.3, 0.2, 1.0));
        let shear = shear * DMat3::from_rotation_x(0.4);
        let control: Vec<DVec3> = lattice.rest().iter().map(|p| shear * *p + 2.0).collect();
        let weights = lattice.loss_weights(&control, None, 0.01).unwrap();
        assert!(weights.iter().all(|w| *w == 1.0), "{name}: {weights:?}");
        let squashed: Vec<DVec3> = lattice.rest().iter().map(|p| p * DVec3::new(1.0, 1.0, 0.3)).collect();
        let weights = lattice.loss_weights(&squashed, None, 0.01).unwrap();
        assert!(weights.iter().all(|w| (w - 1.0).abs() < 1e-12), "{name}: the same everywhere");
        let weights = lattice.loss_weights(&squashed, Some(&squashed), 0.01).unwrap();
        assert!(weights.iter().all(|w| *w == 1.0), "{name}: measured from itself");
    }
}

/// How far the correction of a bar squashed at its left end moves vertices in its left and right thirds, and the volume's
/// relative error.
fn reach(lattice: &Lattice, weights: Option<Vec<f64>>) -> [f64; 3] {
    let mesh = bumpy_ball(4);
    let along = |p: DVec3| DVec3::new(p.x * 4.0, p.y, p.z);
    let vertices: Vec<[f64; 3]> =
        mesh.vertices.iter().map(|v| along(DVec3::from_array(*v)).to_array()).collect();
    let target = volume(&vertices, &mesh.triangles);
    let binding =
        Binding::new(lattice.clone(), vertices.clone(), mesh.triangles.clone(), None, Outside::Extend)
            .unwrap();
    let options = Preserve { weights, ..Preserve::default() };
    let control = squashed_at_one_end(lattice);
    let (mut plain, mut out) = (vec![[0.0; 3]; vertices.len()], vec![[0.0; 3]; vertices.len()]);
    binding.deform(&control, &mut plain).unwrap();
    binding.preserve(&control, &options, &mut out).unwrap();
    let (mut left, mut right) = (0.0, 0.0);
    for ((v, a), b) in vertices.iter().zip(&plain).zip(&out) {
        let moved = DVec3::from_array(*a).distance(DVec3::from_array(*b));
        if v[0] < -1.5 {
            left = f64::max(left, moved);
        }
        if v[0] > 1.5 {
            right = f64::max(right, moved);
        }
    }
    [left, right, volume(&out, &mesh.triangles) / target - 1.0]
}

fn squashed_at_one_end(lattice: &Lattice) -> Vec<DVec3> {
    let squash = |p: DVec3| {
        let part = ((-p.x - 1.0) / 2.0).clamp(0.0, 1.0);
        DVec3::new(p.x, p.y, p.z * (1.0 - 0.7 * part))
    };
    lattice.rest().into_iter().map(squash).collect()
}

#[test]
fn the_correction_of_a_bar_squashed_at_one_end_stays_there() {
    for axes in [
        [AxisBasis::clamped(12, 3), AxisBasis::bernstein(4), AxisBasis::bernstein(4)],
        [AxisBasis::uniform(14, 3), AxisBasis::uniform(6, 3), AxisBasis::uniform(6, 3)],
    ] {
        let edges = DMat3::from_diagonal(DVec3::new(9.0, 2.4, 2.4));
        let axes = axes.map(Result::unwrap);
        let lattice = Lattice::new(axes, DVec3::new(-4.5, -1.2, -1.2), edges).unwrap();
        let control = squashed_at_one_end(&lattice);
        let [left, right, error] = reach(&lattice, None);
        assert!(error.abs() < 1e-12 && right > 0.3 * left, "without weights: {left} {right} {error}");
        let weights = lattice.loss_weights(&control, None, 0.01).unwrap();
        let [left, right, error] = reach(&lattice, Some(weights));
        assert!(error.abs() < 1e-12 && right < 0.05 * left, "with weights: {left} {right} {error}");
        println!("left end {left}, right end {right}");
    }
}

#[test]
fn wrong_arguments_are_refused_by_name() {
    let lattice = slanted(bases().remove(0).1);
    let rest = lattice.rest();
    let mut broken = rest.clone();
    broken[5].y = f64::NAN;
    let said = |result: isochor_core::Result<Vec<f64>>| result.unwrap_err().to_string();
    assert!(said(lattice.falloff(&[], 1.0, None)).starts_with("points: found none"));
    assert!(said(lattice.falloff(&[DVec3::NAN], 1.0, None)).starts_with("points: found NaN"));
    for distance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(said(lattice.falloff(&rest, distance, None)).starts_with("distance: found"));
    }
    assert!(said(lattice.falloff(&rest, 1.0, Some(&broken))).starts_with("control: found NaN"));
    for floor in [0.0, -1.0, 1.1, f64::NAN] {
        assert!(said(lattice.loss_weights(&rest, None, floor)).starts_with("floor: found"));
    }
    assert!(said(lattice.loss_weights(&rest, Some(&broken), 0.1)).starts_with("rest: found NaN"));
    assert!(said(lattice.loss_weights(&rest[1..], None, 0.1)).starts_with("control: found 63 points"));
}
