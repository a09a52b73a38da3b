// SPDX-License-Identifier: GPL-3.0-or-later
//! Corrections of huge meshes on a coarse copy: how near they come, and that one exact step makes the volume exact.

use crate::shared::{Mesh, bases, bumpy_ball, noise, slanted};
use isochor_core::{
    Accuracy, AxisBasis, Bind, Binding, Bodies, DVec3, Lattice, Method, Outside, PinPoint, Pins, Preserve,
    Preserved, Scalar,
};

fn shaken(lattice: &Lattice, factor: DVec3) -> Vec<DVec3> {
    let mut random = noise(8);
    let rest = lattice.rest();
    rest.iter().map(|p| *p * factor + 0.04 * DVec3::new(random(), random(), random())).collect()
}

fn bind<T: Scalar>(lattice: &Lattice, mesh: &Mesh, influence: Option<Vec<f64>>) -> Binding<T> {
    let vertices = mesh.vertices.iter().map(|p| p.map(T::from_f64)).collect();
    Binding::new(lattice.clone(), vertices, mesh.triangles.clone(), influence, Outside::Keep).unwrap()
}

/// What came out, the vertices, and by how much of it they miss the volume aimed at.
fn run<T: Scalar>(
    binding: &Binding<T>,
    control: &[DVec3],
    options: &Preserve,
) -> (Preserved, Vec<[T; 3]>, f64) {
    let mut out = vec![[T::from_f64(0.0); 3]; binding.vertices().len()];
    let found = binding.preserve(control, options, &mut out).unwrap();
    let error = (binding.measure(&out).unwrap().volume / found.target() - 1.0).abs();
    (found, out, error)
}

fn apart(a: &Preserved, b: &Preserved) -> f64 {
    a.control.iter().zip(&b.control).map(|(p, q)| (*p - *q).length()).fold(0.0, f64::max)
}

#[test]
fn finished_is_exact_and_rough_is_near() {
    let mesh = bumpy_ball(7);
    for (name, axes) in bases() {
        let lattice = slanted(axes);
        let control = shaken(&lattice, DVec3::new(0.9, 1.0, 0.5));
        let binding: Binding<f64> = bind(&lattice, &mesh, None);
        for method in [Method::Balanced, Method::Gradient] {
            let [exact, finished, rough] =
                [Accuracy::Exact, Accuracy::Finished, Accuracy::Rough].map(|accuracy| {
                    run(&binding, &control, &Preserve { method, accuracy, ..Preserve::default() })
                });
            assert!(finished.2 < 1e-12, "{name}: {:e}", finished.2);
            assert!(rough.2 < 2e-3 && rough.2 > 1e-12, "{name}: {:e}", rough.2);
            assert_eq!(finished.0.targets, exact.0.targets);
            assert!((finished.0.distance / exact.0.distance - 1.0).abs() < 0.01, "{name}");
            for near in [&finished, &rough] {
                let apart = apart(&near.0, &exact.0);
                assert!(apart < 0.05 * exact.0.distance, "{name}: {apart:e} of {:e}", exact.0.distance);
            }
        }
    }
}

#[test]
fn float32_with_influence_pins_weights_and_an_amount() {
    let mesh = bumpy_ball(7);
    let mut random = noise(3);
    let influence =
        mesh.vertices.iter().map(|p| 0.75 + 0.2 * p[0] + 0.05 * random()).map(|s: f64| s.min(1.0));
    let lattice = slanted(std::array::from_fn(|_| AxisBasis::uniform(7, 3).unwrap()));
    let binding: Binding<f32> = bind(&lattice, &mesh, Some(influence.collect()));
    let control = shaken(&lattice, DVec3::new(0.8, 1.0, 0.6));
    let (vertex, target) = (4321, DVec3::new(0.1, -0.6, 0.9));
    let options = Preserve {
        weights: Some((0..lattice.len()).map(|p| 1.0 + (p % 5) as f64).collect()),
        pins: Pins { points: vec![PinPoint::Vertex(vertex)], targets: vec![target] },
        amount: 0.6,
        axes: [1.0, 0.0, 2.0],
        accuracy: Accuracy::Finished,
        ..Preserve::default()
    };
    let (finished, out, error) = run(&binding, &control, &options);
    let (exact, ..) = run(&binding, &control, &Preserve { accuracy: Accuracy::Exact, ..options });
    assert!(error < 1e-6, "{error:e}");
    assert!((finished.target() / exact.target() - 1.0).abs() < 1e-3);
    assert!((DVec3::from_array(out[vertex as usize].map(f64::from)) - target).length() < 1e-6);
    assert!((finished.distance / exact.distance - 1.0).abs() < 0.01);
}

#[test]
fn what_has_no_proxy_is_corrected_exactly() {
    let lattice = slanted(std::array::from_fn(|_| AxisBasis::bernstein(4).unwrap()));
    let control = shaken(&lattice, DVec3::new(0.9, 1.0, 0.5));
    let rough = Preserve { accuracy: Accuracy::Rough, ..Preserve::default() };
    let same = |binding: &Binding<f64>| {
        let (exact, ..) = run(binding, &control, &Preserve::default());
        let (asked, _, error) = run(binding, &control, &rough);
        assert!(asked == exact && error < 1e-12);
    };
    same(&bind(&lattice, &bumpy_ball(5), None));
    let large = bumpy_ball(7);
    let options = Bind { bodies: Bodies::Islands, ..Bind::default() };
    same(&Binding::with(lattice.clone(), large.vertices.clone(), large.triangles.clone(), options).unwrap());
    // A sheet much thinner than the copy's grid: its two sides fall together.
    let side = |mesh: &Mesh, z: f64| -> Vec<[f64; 3]> {
        mesh.vertices.iter().map(|p| [p[0], p[1], z * p[2]]).collect()
    };
    let sheet = Mesh { vertices: side(&large, 1e-5), triangles: large.triangles.clone() };
    let (_, _, error) = run(
        &bind::<f64>(&lattice, &sheet, None),
        &control,
        &Preserve { accuracy: Accuracy::Finished, ..rough },
    );
    assert!(error < 1e-9, "{error:e}");
}

#[test]
fn an_update_makes_a_new_one() {
    let mesh = bumpy_ball(7);
    let lattice = slanted(std::array::from_fn(|_| AxisBasis::bernstein(4).unwrap()));
    let control = shaken(&lattice, DVec3::new(0.9, 1.0, 0.5));
    let mut binding: Binding<f64> = bind(&lattice, &mesh, None);
    let rough = Preserve { accuracy: Accuracy::Rough, ..Preserve::default() };
    run(&binding, &control, &rough);
    let smaller: Vec<[f64; 3]> = mesh.vertices.iter().map(|p| p.map(|c| 0.9 * c)).collect();
    binding.update(Some(smaller), None, None, None).unwrap();
    let (_, _, error) = run(&binding, &control, &rough);
    assert!(error < 2e-3, "{error:e}");
}
