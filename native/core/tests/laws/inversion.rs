// SPDX-License-Identifier: GPL-3.0-or-later
//! Laws of the way back through a shaped lattice, and of meshes bound in one.

use crate::shared::{bases, bumpy_ball, noise, slanted, volume};
use isochor_core::{AxisBasis, Binding, DMat3, DVec3, Lattice, Outside, Preserve};

/// Control points moved at random by so little that nothing folds.
fn noisy(lattice: &Lattice, seed: u64) -> Vec<DVec3> {
    let mut random = noise(seed);
    let points = lattice.shape().into_iter().max().unwrap() as f64;
    let amount = 0.9 / points;
    lattice.rest().iter().map(|p| p + amount * DVec3::new(random(), random(), random())).collect()
}

/// Bent about y by `angle` from one end of x to the other, as a bar is: z becomes the radius.
fn bent(p: DVec3, angle: f64) -> DVec3 {
    let radius = 3.0 / angle - p.z;
    DVec3::new(radius * (p.x / 3.0 * angle).sin(), p.y, 3.0 / angle - radius * (p.x / 3.0 * angle).cos())
}

fn random_parameters(count: usize, seed: u64) -> Vec<DVec3> {
    let mut random = noise(seed);
    (0..count).map(|_| DVec3::new(random(), random(), random()) * 0.5 + 0.5).collect()
}

fn bound(lattice: &Lattice, rest: Vec<DVec3>, outside: Outside) -> Binding<f64> {
    let mesh = bumpy_ball(3);
    Binding::shaped(lattice.clone(), mesh.vertices, mesh.triangles, None, outside, Some(rest)).unwrap()
}

fn deformed(binding: &Binding<f64>, control: &[DVec3]) -> Vec<DVec3> {
    let mut out = vec![[0.0; 3]; binding.vertices().len()];
    binding.deform(control, &mut out).unwrap();
    out.into_iter().map(DVec3::from_array).collect()
}

#[test]
fn inverting_what_was_evaluated_gives_the_parameters() {
    for (name, axes) in bases() {
        let lattice = slanted(axes);
        for seed in 1..4 {
            let control = noisy(&lattice, seed);
            let parameters = random_parameters(400, seed + 10);
            let points = lattice.evaluate(&parameters, &control).unwrap();
            for (found, wanted) in lattice.invert(&points, &control).unwrap().iter().zip(&parameters) {
                assert!(found.inside, "{name}");
                let error = (found.parameter - wanted).abs().max_element();
                assert!(error < 1e-12, "{name}: {error:e}");
            }
        }
    }
}

#[test]
fn every_point_of_a_strongly_bent_lattice_is_found() {
    let uniform = || std::array::from_fn(|axis| AxisBasis::uniform([12, 5, 5][axis], 3).unwrap());
    let bernstein = || std::array::from_fn(|axis| AxisBasis::bernstein([9, 3, 3][axis]).unwrap());
    for (name, axes) in [("uniform", uniform()), ("Bernstein", bernstein())] {
        let lattice = Lattice::new(axes, DVec3::splat(-0.5), DMat3::IDENTITY).unwrap();
        for angle in [1.0, 3.0, 5.0] {
            let long = |p: &DVec3| bent(DVec3::new(3.0 * p.x, 0.6 * p.y, 0.6 * p.z), angle);
            let control: Vec<DVec3> = lattice.rest().iter().map(long).collect();
            let parameters = random_parameters(1000, 5);
            let points = lattice.evaluate(&parameters, &control).unwrap();
            let found = lattice.invert(&points, &control).unwrap();
            let lost: Vec<_> = found.iter().zip(&parameters).filter(|(found, _)| !found.inside).collect();
            assert!(lost.is_empty(), "{name}, {angle}: {lost:?}");
            let back: Vec<DVec3> = found.iter().map(|found| found.parameter).collect();
            for (there, point) in lattice.evaluate(&back, &control).unwrap().iter().zip(&points) {
                assert!((there - point).length() < 1e-12, "{name}, {angle}");
            }
        }
    }
}

#[test]
fn points_of_a_folded_lattice_have_parameters_that_lead_back_to_them() {
    let lattice = slanted(std::array::from_fn(|_| AxisBasis::bernstein(4).unwrap()));
    let mut random = noise(3);
    let control: Vec<DVec3> =
        lattice.rest().iter().map(|p| p + 1.5 * DVec3::new(random(), random(), random())).collect();
    let points = lattice.evaluate(&random_parameters(500, 8), &control).unwrap();
    let found = lattice.invert(&points, &control).unwrap();
    assert!(found.iter().all(|found| found.inside));
    let back: Vec<DVec3> = found.iter().map(|found| found.parameter).collect();
    for (there, point) in lattice.evaluate(&back, &control).unwrap().iter().zip(&points) {
        assert!((there - point).length() < 1e-11);
    }
}

#[test]
fn a_point_outside_gets_the_nearest_parameters() {
    let axes = std::array::from_fn(|_| AxisBasis::bernstein(4).unwrap());
    let lattice = Lattice::new(axes, DVec3::splat(-0.5), DMat3::IDENTITY).unwrap();
    let control: Vec<DVec3> = lattice.rest().iter().map(|&p| bent(2.0 * p, 1.5)).collect();
    let mut random = noise(4);
    let points: Vec<DVec3> =
        (0..60).map(|_| 6.0 * DVec3::new(random(), random(), random()).normalize()).collect();
    let many = random_parameters(20_000, 6);
    let places = lattice.evaluate(&many, &control).unwrap();
    let found = lattice.invert(&points, &control).unwrap();
    let parameters: Vec<DVec3> = found.iter().map(|found| found.parameter).collect();
    for ((found, at), point) in
        found.iter().zip(lattice.evaluate(&parameters, &control).unwrap()).zip(&points)
    {
        assert!(!found.inside);
        assert_eq!(found.parameter, found.parameter.clamp(DVec3::ZERO, DVec3::ONE));
        let nearest = places.iter().map(|place| (place - point).length()).fold(f64::INFINITY, f64::min);
        assert!((at - point).length() <= nearest + 1e-9);
    }
}

#[test]
fn nearest_in_a_skewed_box_is_the_nearest_of_all() {
    let mut random = noise(12);
    for _ in 0..40 {
        let axes = [3, 2, 3].map(|count| AxisBasis::bernstein(count).unwrap());
        let mut vector = || DVec3::new(random(), random(), random());
        let edges = DMat3::from_cols(vector(), vector(), vector());
        let lengths: f64 = (0..3).map(|axis| edges.col(axis).length()).product();
        if edges.determinant().abs() < 0.2 * lengths {
            continue;
        }
        let lattice = Lattice::new(axes, DVec3::ZERO, edges).unwrap();
        let middle = edges * DVec3::splat(0.5);
        let points: Vec<DVec3> = (0..30).map(|_| middle + 3.0 * vector()).collect();
        for (point, found) in points.iter().zip(lattice.invert(&points, &lattice.rest()).unwrap()) {
            // The nearest point of a convex body: nothing in it lies further the way of what is left.
            let left = point - edges * found.parameter;
            let reach = (0..8).map(|corner| {
                let corner = DVec3::from_array(std::array::from_fn(|axis| f64::from(corner >> axis & 1)));
                left.dot(edges * (corner - found.parameter))
            });
            assert!(reach.fold(0.0, f64::max) <= 1e-6 * left.length() + 1e-12, "{point} {found:?}");
        }
    }
}

#[test]
fn an_axis_with_one_point_has_no_end() {
    let axes = [4, 5, 1].map(|count| AxisBasis::bernstein(count).unwrap());
    let lattice = slanted(axes);
    let control = noisy(&lattice, 9);
    let parameters: Vec<DVec3> =
        random_parameters(200, 2).iter().map(|p| DVec3::new(p.x, p.y, 40.0 * p.z - 20.0)).collect();
    let points = lattice.evaluate(&parameters, &control).unwrap();
    for (found, wanted) in lattice.invert(&points, &control).unwrap().iter().zip(&parameters) {
        assert!(found.inside);
        assert!((found.parameter - wanted).abs().max_element() < 1e-11);
    }
}

#[test]
fn a_collapsed_lattice_holds_nothing_and_breaks_nothing() {
    let lattice = slanted(std::array::from_fn(|_| AxisBasis::bernstein(3).unwrap()));
    let flat: Vec<DVec3> = lattice.rest().iter().map(|p| DVec3::new(p.x, p.y, 0.0)).collect();
    for control in [flat, vec![DVec3::ZERO; 27], vec![DVec3::splat(1e300); 27]] {
        let found = lattice.invert(&[DVec3::splat(0.3), DVec3::new(0.1, 0.2, 9.0)], &control).unwrap();
        assert!(found.iter().all(|found| !found.inside && found.parameter.is_finite()));
        bound(&lattice, control, Outside::Keep);
    }
}

#[test]
fn a_bound_shape_is_the_identity_to_the_bit() {
    for (name, axes) in bases() {
        let lattice = slanted(axes);
        let rest = noisy(&lattice, 2);
        for outside in [Outside::Keep, Outside::Extend] {
            let binding = bound(&lattice, rest.clone(), outside);
            let mut out = vec![[0.0; 3]; binding.vertices().len()];
            binding.deform(&rest, &mut out).unwrap();
            assert_eq!(out, binding.vertices(), "{name}");
        }
    }
}

#[test]
fn affine_motion_of_a_bound_shape_moves_the_mesh_by_just_that() {
    let matrix =
        DMat3::from_cols(DVec3::new(0.3, 1.1, -0.2), DVec3::new(-0.9, 0.4, 0.1), DVec3::new(0.2, 0.3, 2.0));
    let map = |p: DVec3| matrix * p + DVec3::new(5.0, -3.0, 0.5);
    for (name, axes) in bases() {
        let lattice = slanted(axes);
        let rest = noisy(&lattice, 7);
        let binding = bound(&lattice, rest.clone(), Outside::Keep);
        assert_eq!(binding.outside_count(), 0, "{name}");
        let control: Vec<DVec3> = rest.iter().map(|&p| map(p)).collect();
        for (found, at) in deformed(&binding, &control).iter().zip(binding.vertices()) {
            assert!((found - map(DVec3::from_array(*at))).length() < 1e-12, "{name}");
        }
    }
}

#[test]
fn bound_at_the_lattice_s_own_points_deforms_as_without() {
    let mesh = bumpy_ball(3);
    for (name, axes) in bases() {
        let lattice = slanted(axes);
        let plain =
            Binding::new(lattice.clone(), mesh.vertices.clone(), mesh.triangles.clone(), None, Outside::Keep)
                .unwrap();
        let shaped = bound(&lattice, lattice.rest(), Outside::Keep);
        let control = noisy(&lattice, 4);
        for (one, other) in deformed(&plain, &control).iter().zip(deformed(&shaped, &control)) {
            assert!((one - other).length() < 1e-13, "{name}");
        }
    }
}

#[test]
fn vertices_nowhere_in_the_shape_stay_or_follow() {
    let axes = || std::array::from_fn(|_| AxisBasis::bernstein(4).unwrap());
    let lattice = Lattice::new(axes(), DVec3::splat(-0.5), DMat3::IDENTITY).unwrap();
    let rest: Vec<DVec3> = lattice.rest().iter().map(|&p| bent(1.8 * p, 1.0)).collect();
    let shifted: Vec<DVec3> = rest.iter().map(|p| p + DVec3::X).collect();
    for outside in [Outside::Keep, Outside::Extend] {
        let binding = bound(&lattice, rest.clone(), outside);
        let beyond = binding.outside_count();
        assert!(beyond > 50 && beyond + 50 < binding.vertices().len(), "{beyond}");
        let moved = deformed(&binding, &shifted);
        let stayed = moved.iter().zip(binding.vertices()).filter(|(p, at)| p.to_array() == **at).count();
        assert_eq!(stayed, if outside == Outside::Keep { beyond } else { 0 });
    }
}

/// With vertices kept beyond some faces of the shape, the correction holds the control points on those faces still.
#[test]
fn the_correction_does_not_tear_at_faces_with_vertices_beyond() {
    let axes = || std::array::from_fn(|_| AxisBasis::bernstein(5).unwrap());
    let low = DVec3::new(-2.0, -2.0, -0.4);
    let lattice = Lattice::new(axes(), low, DMat3::from_diagonal(DVec3::new(4.0, 4.0, 2.4))).unwrap();
    let rest: Vec<DVec3> = lattice.rest().iter().map(|&p| bent(p, 0.3)).collect();
    let binding = bound(&lattice, rest.clone(), Outside::Keep);
    assert!(binding.outside_count() > 20);
    let squash = |(i, p): (usize, &DVec3)| if i % 5 == 0 { *p } else { DVec3::new(p.x, 0.7 * p.y, p.z) };
    let control: Vec<DVec3> = rest.iter().enumerate().map(squash).collect();
    let mut out = vec![[0.0; 3]; binding.vertices().len()];
    let result = binding.preserve(&control, &Preserve::default(), &mut out).unwrap();
    for (i, (found, asked)) in result.control.iter().zip(&control).enumerate() {
        assert_eq!(found == asked, i % 5 == 0, "{i}");
    }
    let wanted = volume(binding.vertices(), binding.triangles());
    assert!((volume(&out, binding.triangles()) / wanted - 1.0).abs() < 1e-12);
}

#[test]
fn the_volume_is_kept_from_a_bound_shape_on() {
    for (name, axes) in bases() {
        let lattice = slanted(axes);
        let rest = noisy(&lattice, 3);
        let binding = bound(&lattice, rest.clone(), Outside::Keep);
        let control: Vec<DVec3> = rest.iter().map(|p| DVec3::new(p.x, p.y + 0.2 * p.z, 0.5 * p.z)).collect();
        let mut out = vec![[0.0; 3]; binding.vertices().len()];
        let result = binding.preserve(&control, &Preserve::default(), &mut out).unwrap();
        let wanted = volume(binding.vertices(), binding.triangles());
        let found = volume(&out, binding.triangles());
        assert!((found / wanted - 1.0).abs() < 1e-12, "{name}: {found} {wanted}");
        for (one, other) in deformed(&binding, &result.control).iter().zip(&out) {
            assert!((one - DVec3::from_array(*other)).length() < 1e-12, "{name}");
        }
    }
}

#[test]
fn updating_is_binding_anew() {
    let lattice = slanted(std::array::from_fn(|_| AxisBasis::bernstein(4).unwrap()));
    let finer = slanted(std::array::from_fn(|_| AxisBasis::uniform(6, 3).unwrap()));
    let mut binding = bound(&lattice, noisy(&lattice, 1), Outside::Keep);
    let moved: Vec<[f64; 3]> = binding.vertices().iter().map(|[x, y, z]| [0.9 * x, *y, z + 0.1]).collect();
    let (rest, control) = (noisy(&finer, 5), noisy(&finer, 6));
    assert!(binding.update(None, Some(finer.clone()), None, None).is_err());
    assert_eq!(binding.lattice(), &lattice);
    binding.update(Some(moved.clone()), Some(finer.clone()), None, Some(rest.clone())).unwrap();
    let triangles = binding.triangles().to_vec();
    let anew = Binding::shaped(finer, moved, triangles, None, Outside::Keep, Some(rest)).unwrap();
    assert_eq!(deformed(&binding, &control), deformed(&anew, &control));
}

#[test]
fn wrong_shapes_are_refused() {
    let lattice = slanted(std::array::from_fn(|_| AxisBasis::bernstein(4).unwrap()));
    let mesh = bumpy_ball(1);
    for rest in [vec![DVec3::ZERO; 5], vec![DVec3::NAN; 64], vec![DVec3::splat(1e308); 64]] {
        let refused = Binding::shaped(
            lattice.clone(),
            mesh.vertices.clone(),
            Vec::new(),
            None,
            Outside::Keep,
            Some(rest.clone()),
        );
        assert!(refused.is_err_and(|error| error.to_string().starts_with("rest")));
    }
    assert!(lattice.invert(&[DVec3::NAN], &lattice.rest()).is_err());
    assert!(lattice.invert(&[DVec3::ZERO], &[DVec3::ZERO]).is_err());
}
