// SPDX-License-Identifier: GPL-3.0-or-later
//! Boxes that stand any way: made by hand, and found around points.

use crate::shared::{bases, bumpy_ball, noise};
use isochor_core::{AxisBasis, DMat3, DVec3, Lattice, OrientedBox};

fn cubic() -> [AxisBasis; 3] {
    std::array::from_fn(|_| AxisBasis::bernstein(4).unwrap())
}

/// A rotation that looks random: the orthonormalised columns of noise.
fn turn(random: &mut impl FnMut() -> f64) -> DMat3 {
    let one = DVec3::new(random(), random(), random()).normalize();
    let other = one.cross(DVec3::new(random(), random(), random())).normalize();
    DMat3::from_cols(one, other, one.cross(other))
}

fn corners(size: DVec3) -> Vec<DVec3> {
    let sign = |c: u32, bit: u32| if c >> bit & 1 == 0 { -0.5 } else { 0.5 };
    (0..8).map(|c| DVec3::new(sign(c, 0), sign(c, 1), sign(c, 2)) * size).collect()
}

fn sorted(size: DVec3) -> [f64; 3] {
    let mut all = size.to_array();
    all.sort_by(f64::total_cmp);
    all
}

fn holds(found: &OrientedBox, points: &[DVec3], room: f64) -> bool {
    points.iter().all(|p| {
        let place = (found.axes.transpose() * (*p - found.centre)).abs();
        place.cmple(found.half_widths + room).all()
    })
}

fn is_rotation(axes: DMat3) -> bool {
    let unit = axes.transpose() * axes - DMat3::IDENTITY;
    axes.determinant() > 0.0 && unit.to_cols_array().iter().all(|e| e.abs() < 1e-14)
}

#[test]
fn a_box_is_found_however_it_is_turned() {
    let mut random = noise(3);
    let sizes = [
        [4.0, 1.0, 0.5],
        [3.0, 1.0, 1.0],
        [2.0, 2.0, 2.0],
        [1.0, 1.0, 1e-3],
        [1e3, 1.0, 1.0],
        [9.0, 8.0, 7.0],
    ];
    for round in 0..300 {
        let size = DVec3::from_array(sizes[round % sizes.len()]);
        let rotation = turn(&mut random);
        let centre = DVec3::new(random(), random(), random()) * 10.0;
        // Uneven: many points in one corner, so that the principal axes are not the box's.
        let inside = (0..round).map(|_| (DVec3::new(random(), random(), random()) * 0.1 + 0.3) * size);
        let points: Vec<DVec3> =
            corners(size).into_iter().chain(inside).map(|p| centre + rotation * p).collect();
        let found = OrientedBox::around(&points, None).unwrap();
        for (found, expected) in sorted(found.half_widths * 2.0).iter().zip(sorted(size)) {
            assert!((found - expected).abs() < 1e-11 * size.max_element(), "{round}: {found} for {expected}");
        }
        assert!(found.centre.distance(centre) < 1e-11 * size.max_element());
        assert!(is_rotation(found.axes));
        assert!(holds(&found, &points, 1e-11 * size.max_element()));
    }
}

#[test]
fn flat_and_single_and_straight_points_have_sensible_boxes() {
    let mut random = noise(5);
    for _ in 0..50 {
        let rotation = turn(&mut random);
        let flat: Vec<DVec3> =
            corners(DVec3::new(2.0, 1.0, 0.0)).iter().map(|p| rotation * *p + 7.0).collect();
        let found = OrientedBox::around(&flat, None).unwrap();
        let [thin, short, long] = sorted(found.half_widths * 2.0);
        assert!(thin < 1e-13 && (short - 1.0).abs() < 1e-13 && (long - 2.0).abs() < 1e-13, "{found:?}");
        let line: Vec<DVec3> = (0..20).map(|_| rotation.x_axis * random() + 3.0).collect();
        let found = OrientedBox::around(&line, None).unwrap();
        let [thin, thinner, length] = sorted(found.half_widths);
        assert!(thin < 1e-13 && thinner < 1e-13 && length > 0.5);
        assert!(holds(&found, &line, 1e-13));
        let lattice = Lattice::around_oriented(cubic(), &line, 0.1).unwrap();
        for point in &line {
            assert!((lattice.parameter(*point) - 0.5).abs().max_element() <= 0.5 / 1.2 + 1e-12);
        }
    }
    let single = OrientedBox::around(&[DVec3::new(1.0, 2.0, 3.0); 4], None).unwrap();
    assert_eq!((single.centre, single.half_widths), (DVec3::new(1.0, 2.0, 3.0), DVec3::ZERO));
    assert_eq!(single.axes, DMat3::IDENTITY);
    let around = Lattice::around_oriented(cubic(), &[DVec3::ONE], 0.0).unwrap();
    assert_eq!((around.centre(), around.edges()), (DVec3::ONE, DMat3::IDENTITY));
}

#[test]
fn the_box_holds_all_points_of_large_clouds_and_is_no_larger_than_that_along_given_axes() {
    let mut random = noise(7);
    let shear =
        DMat3::from_cols(DVec3::new(1.0, 0.8, 0.1), DVec3::new(0.0, 0.6, 0.4), DVec3::new(0.0, 0.0, 0.3));
    let cloud: Vec<DVec3> = (0..20_000).map(|_| shear * DVec3::new(random(), random(), random())).collect();
    let found = OrientedBox::around(&cloud, None).unwrap();
    assert!(holds(&found, &cloud, 1e-14));
    let (low, high) = cloud
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
    assert!((found.half_widths * 2.0).element_product() < 0.8 * (high - low).element_product());
    let again = OrientedBox::around(&cloud, Some(found.axes)).unwrap();
    for axis in 0..3 {
        assert!(again.axes.col(axis).distance(found.axes.col(axis)) < 1e-14);
    }
}

#[test]
fn axes_come_in_the_order_that_is_wanted() {
    let mut random = noise(11);
    let rotation = turn(&mut random);
    let points: Vec<DVec3> = corners(DVec3::new(4.0, 2.0, 1.0)).iter().map(|p| rotation * *p).collect();
    for order in [[0, 1, 2], [1, 2, 0], [2, 0, 1]] {
        let like = DMat3::from_cols(rotation.col(order[0]), rotation.col(order[1]), rotation.col(order[2]));
        let tilted = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 2.0) / 3.0, 0.1) * like;
        let found = OrientedBox::around(&points, Some(tilted)).unwrap();
        for axis in 0..3 {
            assert!(found.axes.col(axis).dot(like.col(axis)) > 1.0 - 1e-12);
        }
    }
}

#[test]
fn hoff_s_box_is_the_lattice_s_domain() {
    let mut random = noise(13);
    for (name, axes) in bases() {
        let rotation = turn(&mut random);
        let (centre, half_widths) = (DVec3::new(3.0, -1.0, 2.0), DVec3::new(2.0, 0.5, 1.0));
        let lengths = DMat3::from_diagonal(DVec3::new(3.0, 0.1, 7.0));
        let lattice =
            Lattice::boxed(axes, OrientedBox { centre, axes: rotation * lengths, half_widths }).unwrap();
        assert!(lattice.centre().distance(centre) < 1e-14, "{name}");
        let expected = centre - rotation * half_widths;
        assert!(lattice.origin().distance(expected) < 1e-14, "{name}");
        // Hoff: s = (p - centre) . axis / half-width, from -1 to 1.
        let point = DVec3::new(random(), random(), random());
        let hoff = (rotation.transpose() * (point - centre)) / half_widths;
        assert!(((lattice.parameter(point) * 2.0 - 1.0) - hoff).length() < 1e-13, "{name}");
    }
}

#[test]
fn wrong_boxes_are_refused_by_name() {
    let boxed = |axes, half_widths| {
        let domain = OrientedBox { centre: DVec3::ZERO, axes, half_widths };
        Lattice::boxed(cubic(), domain).unwrap_err().to_string()
    };
    assert!(boxed(DMat3::IDENTITY, DVec3::new(1.0, 0.0, 1.0)).contains("half_widths: found 0 along axis t"));
    assert!(boxed(DMat3::IDENTITY, DVec3::splat(f64::NAN)).contains("half_widths: found NaN"));
    let nowhere = OrientedBox { centre: DVec3::NAN, axes: DMat3::IDENTITY, half_widths: DVec3::ONE };
    assert!(Lattice::boxed(cubic(), nowhere).unwrap_err().to_string().contains("centre: found (NaN"));
    let flat = DMat3::from_cols(DVec3::X, DVec3::X, DVec3::Z);
    assert!(boxed(flat, DVec3::ONE).contains("axes: found (1, 0, 0)"));
    assert!(OrientedBox::around(&[], None).unwrap_err().to_string().contains("points: found none"));
    let like = OrientedBox::around(&[DVec3::ONE], Some(DMat3::NAN));
    assert!(like.unwrap_err().to_string().contains("like: found (NaN"));
    assert!(OrientedBox::around(&[DVec3::NAN], None).is_err());
}

#[test]
fn a_ball_s_box_is_about_as_large_as_the_ball() {
    let ball: Vec<DVec3> = bumpy_ball(4).vertices.into_iter().map(DVec3::from_array).collect();
    let found = OrientedBox::around(&ball, None).unwrap();
    assert!(holds(&found, &ball, 1e-14));
    assert!(found.half_widths.max_element() < 1.1 && found.half_widths.min_element() > 0.9);
}
