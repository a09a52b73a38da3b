// SPDX-License-Identifier: GPL-3.0-or-later
//! Refinement changes nothing; derivatives and blends are what differences and sums say.

use crate::shared::{bases, noise, slanted};
use isochor_core::{AxisBasis, DVec3, Lattice, RefineAxis};

fn bent(lattice: &Lattice, seed: u64) -> Vec<DVec3> {
    let mut random = noise(seed);
    lattice.rest().iter().map(|p| p + DVec3::new(random(), random(), random())).collect()
}

fn parameters(seed: u64) -> Vec<DVec3> {
    let mut random = noise(seed);
    let inside = (0..300).map(|_| (DVec3::new(random(), random(), random()) + 1.0) * 0.5);
    let corners = (0..8).map(|c| DVec3::new(f64::from(c & 1), f64::from(c >> 1 & 1), f64::from(c >> 2)));
    let mut all: Vec<DVec3> = inside.chain(corners).collect();
    all.extend([DVec3::new(-0.3, 0.4, 1.7), DVec3::splat(0.5), DVec3::splat(0.25)]);
    all
}

/// Refines, and checks that the map stays and that rest goes to rest.
fn unchanged(name: &str, lattice: &Lattice, to: &[RefineAxis; 3]) -> Lattice {
    let refinement = lattice.refine(to).unwrap();
    let fine = refinement.lattice();
    let control = bent(lattice, 3);
    let finer = refinement.control(&control).unwrap();
    let parameters = parameters(5);
    let before = lattice.evaluate(&parameters, &control).unwrap();
    let after = fine.evaluate(&parameters, &finer).unwrap();
    let largest = before.iter().zip(&after).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
    assert!(largest < 4.0 * 1e-13, "{name}: moved by {largest:e}");
    assert_eq!(refinement.control(&lattice.rest()).unwrap(), fine.rest(), "{name}");
    fine.clone()
}

fn to(degree: Option<usize>, insert: &[f64], count: Option<usize>) -> RefineAxis {
    RefineAxis { degree, insert: insert.to_vec(), count }
}

/// Knot vectors without any order: repeated inside, repeated a little at the ends, spans of very different length.
fn odd_axes() -> [AxisBasis; 3] {
    let knots = |count, degree, knots: &[f64]| AxisBasis::with_knots(count, degree, knots.to_vec()).unwrap();
    [
        knots(7, 3, &[-2.0, -0.5, -0.5, 0.0, 0.2, 0.2, 0.9, 1.0, 1.0, 1.5, 7.0]),
        knots(6, 2, &[0.0, 0.0, 0.0, 0.001, 0.5, 0.5, 1.0, 1.0, 3.0]),
        knots(5, 1, &[-1.0, 0.0, 0.1, 0.7, 0.8, 1.0, 1.0]),
    ]
}

fn cases() -> Vec<(&'static str, [AxisBasis; 3])> {
    let mut cases = bases();
    cases.push(("any knots", odd_axes()));
    let flat = [AxisBasis::uniform(5, 3), AxisBasis::bernstein(1), AxisBasis::clamped(6, 2)];
    cases.push(("one point along t", flat.map(Result::unwrap)));
    cases
}

#[test]
fn raising_the_degree_changes_nothing() {
    for (name, axes) in cases() {
        let lattice = slanted(axes);
        for more in [1, 2, 5] {
            let raise = lattice.axes().each_ref().map(|axis| to(Some(axis.degree() + more), &[], None));
            let fits = |axis: &AxisBasis| axis.count() + more * axis.cells() <= 64;
            if !lattice.axes().iter().all(fits) {
                assert!(lattice.refine(&raise).is_err(), "{name}");
                continue;
            }
            let fine = unchanged(name, &lattice, &raise);
            for (fine, coarse) in fine.axes().iter().zip(lattice.axes()).filter(|(_, c)| c.count() > 1) {
                assert_eq!(fine.degree(), coarse.degree() + more);
                assert_eq!(fine.cells(), coarse.cells());
            }
        }
    }
}

#[test]
fn degree_three_may_become_twenty() {
    for axis in [AxisBasis::bernstein(4), AxisBasis::uniform(5, 3), AxisBasis::clamped(5, 3)] {
        let axis = axis.unwrap();
        let lattice = slanted(std::array::from_fn(|_| axis.clone()));
        let fine = unchanged("3 to 20", &lattice, &std::array::from_fn(|_| to(Some(20), &[], None)));
        assert_eq!(fine.axes()[0].degree(), 20);
    }
}

#[test]
fn raised_bernstein_is_bernstein_and_follows_the_formula() {
    let lattice = slanted(std::array::from_fn(|_| AxisBasis::bernstein(4).unwrap()));
    let refinement = lattice.refine(&std::array::from_fn(|_| to(Some(4), &[], None))).unwrap();
    assert_eq!(refinement.lattice().axes()[0], AxisBasis::bernstein(5).unwrap());
    // Along one axis Q_i = i/4 P_(i-1) + (1 - i/4) P_i (Sederberg, degree elevation), with the others at their first points.
    let control = bent(&lattice, 11);
    let finer = refinement.control(&control).unwrap();
    for i in 0..=4usize {
        let share = i as f64 / 4.0;
        let at = |i: usize| control.get(16 * i).copied().unwrap_or_default();
        let expected = at(i.saturating_sub(1)) * share + at(i) * (1.0 - share);
        assert!(finer[25 * i].distance(expected) < 1e-14);
    }
}

#[test]
fn inserting_knots_changes_nothing() {
    for (name, axes) in cases() {
        let lattice = slanted(axes);
        let insert = |axis: &AxisBasis, knots: &[f64]| match axis.count() {
            1 => RefineAxis::default(),
            _ => to(None, knots, None),
        };
        for knots in [&[0.3][..], &[0.9, 0.05, 0.31], &[0.123, 0.6, 0.6001, 0.01, 0.99]] {
            let fine = unchanged(name, &lattice, &lattice.axes().each_ref().map(|axis| insert(axis, knots)));
            for (fine, coarse) in fine.axes().iter().zip(lattice.axes()).filter(|(_, c)| c.count() > 1) {
                assert_eq!(fine.count(), coarse.count() + knots.len());
            }
        }
    }
}

#[test]
fn more_points_are_reached_evenly_and_change_nothing() {
    for (name, axes) in cases() {
        let lattice = slanted(axes);
        for more in [1, 3, 8] {
            let wanted = |axis: &AxisBasis| if axis.count() == 1 { 1 } else { axis.count() + more };
            let fine = unchanged(
                name,
                &lattice,
                &lattice.axes().each_ref().map(|axis| to(None, &[], Some(wanted(axis)))),
            );
            let counts = lattice.axes().each_ref().map(wanted);
            assert_eq!(fine.shape(), counts, "{name}");
        }
    }
}

#[test]
fn everything_at_once_changes_nothing() {
    let lattice = slanted(odd_axes());
    let all =
        [to(Some(5), &[0.2, 0.55], Some(24)), to(Some(4), &[0.6, 0.6], None), to(Some(3), &[0.33], Some(20))];
    let fine = unchanged("all", &lattice, &all);
    assert_eq!((fine.shape()[0], fine.shape()[2]), (24, 20));
}

#[test]
fn a_uniform_axis_divided_alike_is_uniform() {
    for (count, degree) in [(6, 3), (5, 2), (4, 1), (9, 5)] {
        let uniform = |count| AxisBasis::uniform(count, degree).unwrap();
        let lattice = slanted(std::array::from_fn(|_| uniform(count)));
        let cells = count - degree;
        for parts in [2, 4] {
            let wanted = parts * cells + degree;
            let fine = unchanged("halves", &lattice, &std::array::from_fn(|_| to(None, &[], Some(wanted))));
            assert_eq!(fine.axes()[0], uniform(wanted));
        }
        let thirds: Vec<f64> =
            (1..3 * cells).filter(|i| i % 3 > 0).map(|i| i as f64 / (3 * cells) as f64).collect();
        let fine = unchanged("thirds", &lattice, &std::array::from_fn(|_| to(None, &thirds, None)));
        assert_eq!(fine.axes()[0], uniform(3 * cells + degree));
    }
}

#[test]
fn refining_in_two_steps_is_refining_in_one() {
    let lattice = slanted(std::array::from_fn(|_| AxisBasis::clamped(6, 3).unwrap()));
    let control = bent(&lattice, 17);
    let once = lattice.refine(&std::array::from_fn(|_| to(Some(5), &[0.2, 0.7], None))).unwrap();
    let first = lattice.refine(&std::array::from_fn(|_| to(Some(4), &[], None))).unwrap();
    let then = first.lattice().refine(&std::array::from_fn(|_| to(Some(5), &[0.7, 0.2], None))).unwrap();
    assert_eq!(then.lattice().axes(), once.lattice().axes());
    let twice = then.control(&first.control(&control).unwrap()).unwrap();
    for (a, b) in twice.iter().zip(once.control(&control).unwrap()) {
        assert!(a.distance(b) < 1e-13);
    }
}

#[test]
fn what_cannot_be_refined_is_refused_by_name() {
    let lattice = slanted(std::array::from_fn(|_| AxisBasis::uniform(6, 3).unwrap()));
    let message = |s: RefineAxis| {
        lattice.refine(&[s, RefineAxis::default(), RefineAxis::default()]).unwrap_err().to_string()
    };
    assert!(message(to(Some(2), &[], None)).contains("degree: found 2 on axis s"));
    assert!(message(to(None, &[], Some(5))).contains("shape: found 5"));
    assert!(message(to(None, &[], Some(65))).contains("more than 64"));
    assert!(message(to(Some(64), &[], None)).contains("more than 64"));
    assert!(message(to(None, &[0.5, 1.0], None)).contains("insert: found 1"));
    assert!(message(to(None, &[f64::NAN], None)).contains("insert: found NaN"));
    assert!(message(to(None, &[0.5; 4], None)).contains("repeated more than 3 times"));
    let flat =
        [AxisBasis::bernstein(1), AxisBasis::bernstein(4), AxisBasis::bernstein(4)].map(Result::unwrap);
    let flat = slanted(flat).refine(&[to(None, &[], Some(2)), RefineAxis::default(), RefineAxis::default()]);
    assert!(flat.unwrap_err().to_string().contains("axis s has one control point"));
}

#[test]
fn derivatives_are_limits_of_differences() {
    for (name, axes) in cases() {
        let lattice = slanted(axes);
        let control = bent(&lattice, 23);
        let inside: Vec<DVec3> = parameters(29).into_iter().take(300).map(|p| p * 0.98 + 0.01).collect();
        let found = lattice.derivative(&inside, &control).unwrap();
        let step = 1e-6;
        for axis in 0..3 {
            let way = DVec3::from_array(std::array::from_fn(|a| if a == axis { step } else { 0.0 }));
            let at = |sign: f64| inside.iter().map(|p| p + way * sign).collect::<Vec<DVec3>>();
            let above = lattice.evaluate(&at(1.0), &control).unwrap();
            let below = lattice.evaluate(&at(-1.0), &control).unwrap();
            for ((p, found), (a, b)) in inside.iter().zip(&found).zip(above.iter().zip(&below)) {
                let basis = &lattice.axes()[axis];
                if basis.cell(p[axis] + step) != basis.cell(p[axis] - step) {
                    continue;
                }
                let difference = (a - b) / (2.0 * step);
                let size = 1.0 + found.col(axis).length();
                assert!(found.col(axis).distance(difference) < 1e-4 * size, "{name} at {p}");
            }
        }
    }
}

#[test]
fn beyond_the_domain_the_derivative_is_the_edge() {
    let lattice = slanted(bases().remove(2).1);
    let control = bent(&lattice, 31);
    let found = lattice.derivative(&[DVec3::new(1.5, 0.3, -0.2)], &control).unwrap()[0];
    assert_eq!((found.x_axis, found.z_axis), (lattice.edges().x_axis, lattice.edges().z_axis));
    assert_ne!(found.y_axis, lattice.edges().y_axis);
}

#[test]
fn blends_are_relative_to_rest() {
    let lattice = slanted(bases().remove(0).1);
    let (a, b) = (bent(&lattice, 37), bent(&lattice, 41));
    assert_eq!(lattice.blend(&[], &[]).unwrap(), lattice.rest());
    assert_eq!(lattice.blend(&[&a, &b], &[0.0, 0.0]).unwrap(), lattice.rest());
    let mixed = lattice.blend(&[&a, &b], &[0.25, 0.75]).unwrap();
    let both = lattice.blend(&[&a, &b], &[1.0, -0.5]).unwrap();
    for (i, rest) in lattice.rest().iter().enumerate() {
        assert!(mixed[i].distance(a[i] * 0.25 + b[i] * 0.75) < 1e-14);
        assert!(both[i].distance(rest + (a[i] - rest) - (b[i] - rest) * 0.5) < 1e-14);
    }
    assert!(lattice.blend(&[&a], &[1.0, 2.0]).unwrap_err().to_string().contains("weights: found 2"));
    assert!(lattice.blend(&[&a], &[f64::NAN]).unwrap_err().to_string().contains("weights: found NaN"));
    assert!(lattice.blend(&[&a[1..]], &[1.0]).unwrap_err().to_string().contains("sets: found"));
}
