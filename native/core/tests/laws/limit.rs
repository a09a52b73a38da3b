// SPDX-License-Identifier: GPL-3.0-or-later
//! A correction under the limit "unfolded" folds nothing, and says what is missing.

use crate::shared::{bumpy_ball, noise, volume};
use isochor_core::{
    AxisBasis, Binding, DVec3, Lattice, Limit, Method, Outside, PinPoint, Pins, Preserve, Preserved,
};

const METHODS: [Method; 4] = [Method::Sweep, Method::Balanced, Method::Gradient, Method::Nearest];

fn ball() -> Binding<f64> {
    let mesh = bumpy_ball(4);
    let axes = std::array::from_fn(|_| AxisBasis::clamped(6, 3).unwrap());
    let lattice = Lattice::around(axes, &[DVec3::splat(-1.2), DVec3::splat(1.2)], 0.0).unwrap();
    Binding::new(lattice, mesh.vertices, mesh.triangles, None, Outside::Keep).unwrap()
}

fn run(binding: &Binding<f64>, control: &[DVec3], options: &Preserve) -> (Preserved, f64) {
    let mut out = vec![[0.0; 3]; binding.vertices().len()];
    let outcome = binding.preserve(control, options, &mut out).unwrap();
    (outcome, volume(&out, binding.triangles()))
}

#[test]
fn what_would_fold_stops_before_and_says_what_is_missing() {
    let binding = ball();
    let mut random = noise(3);
    let mut shake = || 0.05 * DVec3::new(random(), random(), random());
    let control: Vec<DVec3> =
        binding.rest().iter().map(|p| *p * DVec3::new(1.0, 1.0, 0.6) + shake()).collect();
    let at = |v: usize| DVec3::from_array(binding.vertices()[v]);
    let pins = Pins { points: vec![PinPoint::Vertex(9)], targets: vec![at(9) * DVec3::new(1.0, 1.0, 0.7)] };
    for method in METHODS {
        for pins in [Pins::default(), pins.clone()] {
            // Through a volume of zero to its mirror image.
            let free = Preserve {
                method,
                pins,
                target: Some(vec![-1.0]),
                axes: [0.0, 0.0, 1.0],
                ..Preserve::default()
            };
            let (unlimited, _) = run(&binding, &control, &free);
            assert!(!binding.lattice().is_unfolded(&unlimited.control, None).unwrap());
            assert_eq!(unlimited.missing, 0.0);
            let limited = Preserve { limit: Some(Limit::Unfolded), ..free };
            let (limited, found) = run(&binding, &control, &limited);
            assert!(binding.lattice().is_unfolded(&limited.control, None).unwrap(), "{method:?}");
            assert!(limited.missing < -0.1 && found > 0.0);
            assert!((limited.missing - (limited.target() - found)).abs() < 1e-12);
            // Not held back for nothing: a little farther it folds.
            let beyond: Vec<DVec3> = limited
                .control
                .iter()
                .zip(&unlimited.control)
                .map(|(here, there)| *here + 0.01 * (*there - *here))
                .collect();
            assert!(!binding.lattice().is_unfolded(&beyond, None).unwrap(), "{method:?}");
        }
    }
}

#[test]
fn what_folds_nothing_is_the_same_with_the_limit() {
    let binding = ball();
    let control: Vec<DVec3> = binding.rest().iter().map(|p| *p * DVec3::new(1.0, 0.99, 0.95)).collect();
    for method in METHODS {
        let free = Preserve { method, ..Preserve::default() };
        let held = Preserve { limit: Some(Limit::Unfolded), ..free.clone() };
        assert_eq!(run(&binding, &control, &free), run(&binding, &control, &held));
    }
}

#[test]
fn a_fold_that_is_there_already_does_not_hold_the_rest() {
    let binding = ball();
    let mut control = binding.rest();
    // A corner pulled through to the far side of its neighbours.
    control[0] += DVec3::splat(1.4);
    assert!(!binding.lattice().is_unfolded(&control, None).unwrap());
    let options = Preserve {
        limit: Some(Limit::Unfolded),
        target: Some(vec![1.1 * binding.reference().unwrap().volume]),
        ..Preserve::default()
    };
    let (outcome, found) = run(&binding, &control, &options);
    assert_eq!(outcome.missing, 0.0);
    assert!((found / outcome.target() - 1.0).abs() < 1e-12);
}
