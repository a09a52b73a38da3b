// SPDX-License-Identifier: GPL-3.0-or-later
//! Adjacent lattices that stay joined: place and derivatives equal on both sides, by the least change.

use crate::shared::noise;
use isochor_core::{AxisBasis, DMat3, DVec3, Error, Face, Interpolation, Lattice, Side, Tie};

fn face(name: &str) -> Face {
    Face::named(name).unwrap()
}

fn bernstein(n: usize) -> AxisBasis {
    AxisBasis::bernstein(n).unwrap()
}

fn uniform(n: usize, degree: usize) -> AxisBasis {
    AxisBasis::uniform(n, degree).unwrap()
}

fn blender(n: usize, interpolation: Interpolation) -> AxisBasis {
    AxisBasis::blender(n, interpolation).unwrap()
}

/// A slanted face of 1.2 by 0.7; along it bases `p` and `q`, which are not symmetric.
const CORNER: DVec3 = DVec3::new(0.3, -0.2, 0.5);
const ALONG: [DVec3; 2] = [DVec3::new(1.2, 0.1, 0.0), DVec3::new(0.1, 0.7, 0.2)];
const ACROSS: DVec3 = DVec3::new(-0.2, 0.1, 0.9);

/// A pair of lattices that meet in that face with their axes in another order and direction, and the faces.
fn pair(across: [AxisBasis; 2], along: [AxisBasis; 2]) -> (Lattice, Face, Lattice, Face) {
    let [p, q] = along;
    let [first, second] = across;
    // Before the face, s and t along it, u towards it.
    let edges = DMat3::from_cols(ALONG[0], ALONG[1], ACROSS);
    let a = Lattice::new([p.clone(), q.clone(), first], CORNER - ACROSS, edges).unwrap();
    // Beyond it, s away from the face but twice as long, t along the second direction backwards, u along the first.
    let origin = CORNER + ALONG[1];
    let edges = DMat3::from_cols(2.0 * ACROSS, -ALONG[1], ALONG[0]);
    let b = Lattice::new([second, reversed(&q), p], origin, edges).unwrap();
    (a, face("u1"), b, face("s0"))
}

/// The same from the other end; Blender's are alike from both.
fn reversed(basis: &AxisBasis) -> AxisBasis {
    if basis.inner_count() != basis.count() {
        return basis.clone();
    }
    let knots = basis.knots().iter().rev().map(|knot| -knot).collect();
    AxisBasis::with_knots(basis.count(), basis.degree(), knots).unwrap()
}

fn shaken(lattice: &Lattice, seed: u64) -> Vec<DVec3> {
    let mut random = noise(seed);
    let mut jitter = || 0.3 * DVec3::new(random(), random(), random());
    lattice.rest().iter().map(|p| *p + jitter()).collect()
}

/// Place, and derivatives along `ACROSS` at a place of space on the face: by the polynomial through samples on the way `ACROSS * step`
/// that stays in one cell.
fn derivatives(lattice: &Lattice, control: &[DVec3], at: DVec3, step: f64, degree: usize) -> [DVec3; 3] {
    let count = degree + 1;
    let nodes: Vec<f64> = (0..count).map(|i| step * i as f64 / degree as f64).collect();
    let parameters: Vec<DVec3> = nodes.iter().map(|t| lattice.parameter(at + ACROSS * *t)).collect();
    let mut divided = lattice.evaluate(&parameters, control).unwrap();
    // Newton's divided differences, then the value and two derivatives at the first node.
    for order in 1..count {
        for i in (order..count).rev() {
            divided[i] = (divided[i] - divided[i - 1]) / (nodes[i] - nodes[i - order]);
        }
    }
    let mut found = [DVec3::ZERO; 3];
    for i in (0..count).rev() {
        let x = nodes[0] - nodes[i];
        found = [found[0] * x + divided[i], found[1] * x + found[0], found[2] * x + 2.0 * found[1]];
    }
    found
}

/// The largest continuity of a joint: Blender's spline repeats its ends, so two layers act on a face, not three.
fn most(name: &str) -> usize {
    if name.contains("Blender") { 1 } else { 2 }
}

fn acrosses() -> Vec<(&'static str, [AxisBasis; 2], f64)> {
    // The last: how far beyond the face the first cell reaches at least, in `ACROSS`.
    let clamped = |n| AxisBasis::clamped(n, 3).unwrap();
    vec![
        ("Bernstein 4 and 4", [bernstein(4), bernstein(4)], 1.0),
        ("Bernstein 5 and 3", [bernstein(5), bernstein(3)], 1.0),
        ("uniform cubic", [uniform(6, 3), uniform(7, 3)], 1.0 / 3.0),
        ("uniform quadratic and cubic", [uniform(6, 2), uniform(5, 3)], 0.25),
        ("clamped and Bernstein", [clamped(7), bernstein(4)], 0.25),
        ("clamped and uniform", [clamped(6), uniform(6, 3)], 1.0 / 3.0),
        ("Blender's", [blender(5, Interpolation::BSpline), blender(4, Interpolation::Cardinal)], 0.25),
        ("Bernstein and Blender's", [bernstein(4), blender(5, Interpolation::BSpline)], 0.5),
    ]
}

fn along() -> [AxisBasis; 2] {
    let knots = vec![0.0, 0.0, 0.0, 0.0, 0.3, 1.0, 1.0, 1.0, 1.0];
    [bernstein(3), AxisBasis::with_knots(5, 3, knots).unwrap()]
}

#[test]
fn places_and_derivatives_are_equal_on_both_sides() {
    for (name, across, reach) in acrosses() {
        let (a, face_a, b, face_b) = pair(across, along());
        for continuity in 0..=most(name) {
            let tie = Tie::new(&a, face_a, &b, face_b, continuity).unwrap();
            assert_eq!(tie.continuity(), continuity);
            for leader in [Side::A, Side::B] {
                let (mut ca, mut cb) = (shaken(&a, 1), shaken(&b, 2));
                let before = tie.gaps([&ca, &cb]).unwrap();
                assert!(before.iter().all(|gap| *gap > 0.1));
                match leader {
                    Side::A => cb = tie.apply([&ca, &cb], leader).unwrap(),
                    Side::B => ca = tie.apply([&ca, &cb], leader).unwrap(),
                }
                let gaps = tie.gaps([&ca, &cb]).unwrap();
                assert!(gaps.iter().all(|gap| *gap < 1e-12), "{name} {continuity}: {gaps:?}");
                for k in 0..25 {
                    let [p, q] = [k % 5, k / 5].map(|i| f64::from(i) / 4.0);
                    let at = CORNER + ALONG[0] * p + ALONG[1] * q;
                    let [da, db] = [
                        derivatives(&a, &ca, at, -0.9 * reach, a.axes()[2].degree()),
                        derivatives(&b, &cb, at, 0.9 * reach, b.axes()[0].degree()),
                    ];
                    // What the samples themselves lose grows with the order.
                    for (order, allowed) in [1e-12, 1e-11, 1e-9].into_iter().enumerate().take(continuity + 1)
                    {
                        let apart = (da[order] - db[order]).length();
                        assert!(apart < allowed, "{name}, C{continuity}, order {order}: {apart:e}");
                    }
                }
            }
        }
    }
}

#[test]
fn first_derivatives_agree_with_the_lattices_own() {
    for (name, across, _) in acrosses().into_iter().filter(|(name, ..)| most(name) == 2) {
        let (a, face_a, b, face_b) = pair(across, along());
        let tie = Tie::new(&a, face_a, &b, face_b, 1).unwrap();
        let ca = shaken(&a, 3);
        let cb = tie.apply([&ca, &shaken(&b, 4)], Side::A).unwrap();
        for k in 0..16 {
            let at = CORNER + ALONG[0] * (f64::from(k % 4) / 3.0) + ALONG[1] * (f64::from(k / 4) / 3.0);
            // In space: what a step along each coordinate of space gives.
            let [ja, jb] = [(&a, &ca), (&b, &cb)].map(|(lattice, control)| {
                let parameter = lattice.parameter(at).clamp(DVec3::ZERO, DVec3::ONE);
                lattice.derivative(&[parameter], control).unwrap()[0] * lattice.edges().inverse()
            });
            let apart = (ja - jb).to_cols_array().iter().fold(0.0f64, |most, c| most.max(c.abs()));
            assert!(apart < 1e-12, "{name}: {apart:e}");
        }
    }
}

#[test]
fn only_outer_layers_change_and_no_more_than_needed() {
    let (a, face_a, b, face_b) = pair([bernstein(4), bernstein(6)], along());
    let [_, nv, nw] = b.shape();
    for continuity in 0..=2 {
        let tie = Tie::new(&a, face_a, &b, face_b, continuity).unwrap();
        let (ca, cb) = (shaken(&a, 5), shaken(&b, 6));
        let tied = tie.apply([&ca, &cb], Side::A).unwrap();
        for (i, (new, old)) in tied.iter().zip(&cb).enumerate() {
            assert_eq!(new != old, i / (nv * nw) <= continuity);
        }
        // What is joined already stays, to rounding.
        let again = tie.apply([&ca, &tied], Side::A).unwrap();
        assert!(again.iter().zip(&tied).all(|(p, q)| (*p - *q).length() < 1e-13));
    }
    // C0 of a uniform cubic: three layers act on the face, with weights 1, 4, 1 sixths, so the least change is in that proportion.
    let (a, face_a, b, face_b) = pair([bernstein(4), uniform(6, 3)], along());
    let (ca, cb) = (shaken(&a, 5), shaken(&b, 6));
    let tied = Tie::new(&a, face_a, &b, face_b, 0).unwrap().apply([&ca, &cb], Side::A).unwrap();
    let [_, nv, nw] = b.shape();
    for line in 0..nv * nw {
        let change = |layer: usize| tied[layer * nv * nw + line] - cb[layer * nv * nw + line];
        assert!((change(1) - 4.0 * change(0)).length() < 1e-13 && (change(2) - change(0)).length() < 1e-13);
        assert_eq!(change(3), DVec3::ZERO);
    }
}

#[test]
fn lattices_at_rest_are_joined() {
    for (name, across, _) in acrosses() {
        let (a, face_a, b, face_b) = pair(across, along());
        let tie = Tie::new(&a, face_a, &b, face_b, most(name)).unwrap();
        assert!(tie.gaps([&a.rest(), &b.rest()]).unwrap().iter().all(|gap| *gap == 0.0), "{name}");
        assert_eq!(tie.apply([&a.rest(), &b.rest()], Side::B).unwrap(), a.rest(), "{name}");
    }
}

#[test]
fn blenders_axes_may_run_along_the_joint() {
    let axes = [blender(4, Interpolation::BSpline), blender(3, Interpolation::Cardinal)];
    let (a, face_a, b, face_b) = pair([bernstein(4), bernstein(4)], axes);
    let tie = Tie::new(&a, face_a, &b, face_b, 1).unwrap();
    let ca = shaken(&a, 3);
    let cb = tie.apply([&ca, &shaken(&b, 4)], Side::A).unwrap();
    for k in 0..36 {
        let at = CORNER + ALONG[0] * (f64::from(k % 6) / 5.0) + ALONG[1] * (f64::from(k / 6) / 5.0);
        let [da, db] = [derivatives(&a, &ca, at, -0.9, 3), derivatives(&b, &cb, at, 0.9, 3)];
        assert!((da[0] - db[0]).length() < 1e-12 && (da[1] - db[1]).length() < 1e-11);
    }
}

#[test]
fn an_affine_motion_of_the_leader_is_followed_at_the_joint() {
    let (a, face_a, b, face_b) = pair([bernstein(4), bernstein(4)], along());
    let turn = DMat3::from_rotation_y(0.7);
    let moved =
        |lattice: &Lattice| -> Vec<DVec3> { lattice.rest().iter().map(|p| turn * *p + DVec3::X).collect() };
    let tie = Tie::new(&a, face_a, &b, face_b, 2).unwrap();
    let tied = tie.apply([&moved(&a), &b.rest()], Side::A).unwrap();
    let [_, nv, nw] = b.shape();
    for (p, q) in tied[..3 * nv * nw].iter().zip(&moved(&b)) {
        assert!((*p - *q).length() < 1e-13);
    }
}

#[test]
fn what_cannot_be_joined_is_refused_with_the_reason() {
    let cube = |x: f64, axes: [AxisBasis; 3]| Lattice::new(axes, DVec3::X * x, DMat3::IDENTITY).unwrap();
    let four = || [bernstein(4), bernstein(4), bernstein(4)];
    let (a, s1, s0) = (cube(0.0, four()), face("s1"), face("s0"));
    let refused = |b: &Lattice, face_b: Face, continuity: usize, said: &str| {
        let Err(Error::Lattice(text)) = Tie::new(&a, s1, b, face_b, continuity) else {
            unreachable!("{said}: accepted")
        };
        assert!(text.contains(said), "{text}");
    };
    refused(&cube(1.25, four()), s0, 0, "up to 0.25 apart");
    refused(&cube(1.0, four()), face("s1"), 0, "up to 1 apart");
    refused(&cube(0.0, four()), s1, 0, "same side");
    refused(&cube(1.0, [bernstein(4), bernstein(3), bernstein(4)]), s0, 0, "3 points of degree 2");
    refused(&cube(1.0, four()).with_weights((1..65).map(f64::from).collect()).unwrap(), s0, 0, "rational");
    let other = blender(4, Interpolation::BSpline);
    refused(&cube(1.0, [bernstein(4), other, bernstein(4)]), s0, 0, "along them");
    refused(&cube(1.0, [bernstein(2), bernstein(4), bernstein(4)]), s0, 2, "at most 1");
    let spline = blender(4, Interpolation::BSpline);
    refused(&cube(1.0, [spline, bernstein(4), bernstein(4)]), s0, 2, "too few control points");
    let leaning = DMat3::from_cols(DVec3::new(1.0, 1.0, 0.0), DVec3::Y, DVec3::Z);
    let leaning = Lattice::new(four(), DVec3::X, leaning).unwrap();
    refused(&leaning, s0, 1, "45 degrees apart");
    Tie::new(&a, s1, &leaning, s0, 0).unwrap();
    let tie = Tie::new(&a, s1, &cube(1.0, four()), s0, 1).unwrap();
    assert!(tie.apply([&a.rest()[1..], &a.rest()], Side::A).is_err());
    assert_eq!(Face::named("v0"), None);
    assert!(isochor_core::FACES.iter().all(|name| face(name).name() == *name));
}
