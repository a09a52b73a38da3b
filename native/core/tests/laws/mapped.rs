// SPDX-License-Identifier: GPL-3.0-or-later
//! What holds for every lattice holds for those whose control points are not the ones that the passes over a mesh know: rational ones,
//! and Blender's.

use crate::shared::{Mesh, bumpy_ball, mapped, noise, volume};
use isochor_core::{
    Accuracy, Bind, Binding, Bodies, Cost, DEPTH, DMat3, DVec3, FoldTest, Lattice, Limit, Method, Outside,
    PinPoint, Pins, Preserve, Verdict,
};

fn pushed(lattice: &Lattice, factor: DVec3, amount: f64, seed: u64) -> Vec<DVec3> {
    let mut random = noise(seed);
    let push = |p: &DVec3| *p * factor + amount * DVec3::new(random(), random(), random());
    lattice.rest().iter().map(push).collect()
}

fn bind(lattice: &Lattice, mesh: &Mesh, outside: Outside) -> Binding<f64> {
    Binding::new(lattice.clone(), mesh.vertices.clone(), mesh.triangles.clone(), None, outside).unwrap()
}

fn places(count: usize, seed: u64) -> Vec<DVec3> {
    let mut random = noise(seed);
    (0..count).map(|_| (DVec3::new(random(), random(), random()) + 1.0) * 0.5).collect()
}

/// A vertex and the middle of a face, each a tenth of the lattice away from where the lattice takes it.
fn two_pins(binding: &Binding<f64>, control: &[DVec3]) -> Pins {
    let mut out = binding.vertices().to_vec();
    binding.deform(control, &mut out).unwrap();
    let at = |v: u32| DVec3::from_array(out[v as usize]);
    let middle = binding.triangles()[40].map(at).into_iter().sum::<DVec3>() / 3.0;
    Pins {
        points: vec![PinPoint::Vertex(7), PinPoint::Face(40, [1.0 / 3.0; 3])],
        targets: vec![at(7) + DVec3::new(0.1, -0.05, 0.1), middle - DVec3::new(0.0, 0.1, 0.05)],
    }
}

#[test]
fn the_lattice_at_rest_moves_nothing_by_a_bit_and_a_rigid_translation_all() {
    let mesh = bumpy_ball(3);
    for (name, lattice) in mapped() {
        for outside in [Outside::Keep, Outside::Extend] {
            let binding = bind(&lattice, &mesh, outside);
            let mut out = mesh.vertices.clone();
            binding.deform(&lattice.rest(), &mut out).unwrap();
            assert_eq!(out, mesh.vertices, "{name}");
            let way = DVec3::new(30.0, -7.0, 0.5);
            let moved: Vec<DVec3> = lattice.rest().iter().map(|p| *p + way).collect();
            binding.deform(&moved, &mut out).unwrap();
            for (to, from) in out.iter().zip(&mesh.vertices) {
                let off = DVec3::from_array(*to) - DVec3::from_array(*from) - way;
                assert!(off.length() < 1e-13, "{name}: {off}");
            }
        }
    }
}

#[test]
fn a_step_along_one_axis_is_along_the_volume_s_own_slope() {
    let mesh = bumpy_ball(3);
    for (seed, (name, lattice)) in mapped().into_iter().enumerate() {
        let binding = bind(&lattice, &mesh, Outside::Extend);
        let control = pushed(&lattice, DVec3::new(1.0, 0.8, 0.6), 0.1, seed as u64);
        for axis in 0..3 {
            let axes = std::array::from_fn(|a| if a == axis { 1.0 } else { 0.0 });
            let mut out = mesh.vertices.clone();
            let options = Preserve { axes, method: Method::Sweep, ..Preserve::default() };
            let found = binding.preserve(&control, &options, &mut out).unwrap();
            let error = (volume(&out, &mesh.triangles) / found.target() - 1.0).abs();
            assert!(error < 1e-12, "{name}: {error:e}");
            // The volume is linear along one axis: differences give its slope to rounding.
            let slope = |p: usize| {
                let mut beside = control.clone();
                beside[p][axis] += 1.0;
                binding.volume(&beside).unwrap() - binding.volume(&control).unwrap()
            };
            let slopes: Vec<f64> = (0..lattice.len()).step_by(7).map(slope).collect();
            let steps: Vec<f64> =
                (0..lattice.len()).step_by(7).map(|p| found.control[p][axis] - control[p][axis]).collect();
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let along = dot(&slopes, &steps) / dot(&slopes, &slopes);
            let across = slopes.iter().zip(&steps).map(|(slope, step)| (step - along * slope).abs());
            let longest = steps.iter().map(|step| step.abs()).fold(0.0, f64::max);
            assert!(across.fold(0.0, f64::max) < 1e-9 * longest, "{name} {axis}");
        }
    }
}

#[test]
fn every_method_and_cost_keeps_volume_and_pins() {
    let mesh = bumpy_ball(3);
    for (seed, (name, lattice)) in mapped().into_iter().enumerate() {
        let binding = bind(&lattice, &mesh, Outside::Extend);
        let control = pushed(&lattice, DVec3::new(1.1, 0.9, 0.6), 0.1, seed as u64 + 20);
        let pins = two_pins(&binding, &control);
        let mut out = mesh.vertices.clone();
        let mut shortest = f64::INFINITY;
        for method in [Method::Sweep, Method::Balanced, Method::Gradient, Method::Nearest] {
            for pins in [Pins::default(), pins.clone()] {
                let alone = pins.points.is_empty();
                let options = Preserve { method, pins: pins.clone(), ..Preserve::default() };
                let found = binding.preserve(&control, &options, &mut out).unwrap();
                let error = (volume(&out, &mesh.triangles) / found.target() - 1.0).abs();
                assert!(error < 1e-12, "{name} {method:?}: {error:e}");
                let miss = binding.largest_miss(&pins, &out).unwrap();
                assert!(miss < 1e-12, "{name} {method:?}: {miss:e}");
                if alone && method == Method::Nearest {
                    assert!(found.distance <= shortest * (1.0 + 1e-9), "{name}");
                } else if alone {
                    shortest = shortest.min(found.distance);
                }
            }
        }
        if lattice.len() > 400 {
            continue;
        }
        for cost in [Cost::Surface, Cost::Bending] {
            let options = Preserve { cost, pins: pins.clone(), ..Preserve::default() };
            let found = binding.preserve(&control, &options, &mut out).unwrap();
            let error = (volume(&out, &mesh.triangles) / found.target() - 1.0).abs();
            assert!(error < 1e-12, "{name} {cost:?}: {error:e}");
            assert!(binding.largest_miss(&pins, &out).unwrap() < 1e-12, "{name} {cost:?}");
        }
    }
}

/// Moves of the surface by two corrections compared.
fn surface_way(binding: &Binding<f64>, control: &[DVec3], cost: Cost) -> f64 {
    let (mut from, mut to) = (binding.vertices().to_vec(), binding.vertices().to_vec());
    binding.deform(control, &mut from).unwrap();
    let options = Preserve { axes: [0.0, 0.0, 1.0], cost, method: Method::Sweep, ..Preserve::default() };
    binding.preserve(control, &options, &mut to).unwrap();
    from.iter().zip(&to).map(|(a, b)| (DVec3::from_array(*a) - DVec3::from_array(*b)).length_squared()).sum()
}

#[test]
fn the_surface_s_cost_moves_the_surface_less() {
    let mesh = bumpy_ball(3);
    for (name, lattice) in mapped().into_iter().filter(|(_, lattice)| lattice.len() <= 400) {
        let binding = bind(&lattice, &mesh, Outside::Extend);
        let control = pushed(&lattice, DVec3::new(1.0, 1.0, 0.5), 0.05, 3);
        let [points, surface] =
            [Cost::Points, Cost::Surface].map(|cost| surface_way(&binding, &control, cost));
        assert!(surface < points * (1.0 + 1e-9), "{name}: {surface} {points}");
    }
}

fn single(mesh: &Mesh) -> Vec<[f32; 3]> {
    mesh.vertices.iter().map(|p| p.map(|c| c as f32)).collect()
}

#[test]
fn float32_vertices_keep_their_volume() {
    let mesh = bumpy_ball(4);
    let vertices = single(&mesh);
    for (seed, (name, lattice)) in mapped().into_iter().enumerate() {
        let binding =
            Binding::new(lattice.clone(), vertices.clone(), mesh.triangles.clone(), None, Outside::Extend)
                .unwrap();
        let exact = bind(&lattice, &mesh, Outside::Extend);
        let control = pushed(&lattice, DVec3::new(1.0, 0.8, 0.6), 0.1, seed as u64);
        let (mut out, mut precise) = (vertices.clone(), mesh.vertices.clone());
        binding.deform(&control, &mut out).unwrap();
        exact.deform(&control, &mut precise).unwrap();
        for (a, b) in out.iter().zip(&precise) {
            let apart = DVec3::from_array(a.map(f64::from)) - DVec3::from_array(*b);
            assert!(apart.length() < 1e-5, "{name}: {apart}");
        }
        let found = binding.preserve(&control, &Preserve::default(), &mut out).unwrap();
        let wide: Vec<[f64; 3]> = out.iter().map(|p| p.map(f64::from)).collect();
        let error = (volume(&wide, &mesh.triangles) / found.target() - 1.0).abs();
        assert!(error < 1e-6, "{name}: {error:e}");
    }
}

#[test]
fn corrections_by_the_control_points_alone_agree() {
    let mesh = bumpy_ball(3);
    let mut random = noise(9);
    let influence: Vec<f64> = mesh.vertices.iter().map(|_| 0.5 + 0.5 * random()).collect();
    for (seed, (name, lattice)) in mapped().into_iter().enumerate() {
        for (influence, far) in [(None, 0.0), (Some(influence.clone()), 0.0), (None, 1e4)] {
            let of = || {
                let options = (mesh.vertices.clone(), mesh.triangles.clone(), influence.clone());
                Binding::new(lattice.clone(), options.0, options.1, options.2, Outside::Extend).unwrap()
            };
            let [direct, prepared] = [of(), of()];
            if lattice.map().inner_shape().iter().product::<usize>() > 216 {
                assert!(!prepared.prepare().unwrap());
                continue;
            }
            assert!(prepared.prepare().unwrap(), "{name}");
            let mut control = pushed(&lattice, DVec3::new(1.0, 0.8, 0.7), 0.1, seed as u64);
            control.iter_mut().for_each(|p| *p += DVec3::splat(far));
            let [one, other] = [&direct, &prepared].map(|binding| {
                let mut out = mesh.vertices.clone();
                let found = binding.preserve(&control, &Preserve::default(), &mut out).unwrap();
                let middle = DVec3::from_array(out[0]);
                let near: Vec<[f64; 3]> =
                    out.iter().map(|p| (DVec3::from_array(*p) - middle).to_array()).collect();
                let error = (volume(&near, &mesh.triangles) / found.target() - 1.0).abs();
                let allowed = 1e-12 + 1e-15 * far;
                assert!(error < allowed, "{name}, {far}: {error:e}");
                found.control
            });
            let apart = one.iter().zip(&other).map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max);
            assert!(apart < 1e-10 + 1e-13 * far, "{name}: {apart:e}");
        }
    }
}

#[test]
fn evaluated_points_come_back() {
    for (seed, (name, lattice)) in mapped().into_iter().enumerate() {
        let control = pushed(&lattice, DVec3::new(1.1, 0.9, 0.8), 0.03, seed as u64);
        if FoldTest::new(&lattice, Some(&lattice.rest())).unwrap().folds(&control, DEPTH).unwrap().verdict
            != Verdict::Unfolded
        {
            println!("{name}: not unfolded");
        }
        let at = places(300, 4);
        let found = lattice.evaluate(&at, &control).unwrap();
        let back = lattice.invert(&found, &control).unwrap();
        let again: Vec<DVec3> = back.iter().map(|back| back.parameter).collect();
        let again = lattice.evaluate(&again, &control).unwrap();
        for (v, back) in back.iter().enumerate() {
            assert!(back.inside, "{name} at {}", at[v]);
            assert!((again[v] - found[v]).length() < 1e-12, "{name}: {}", again[v] - found[v]);
        }
        // What is far outside is not inside, and its nearest place is on the border.
        let far = [lattice.centre() + DVec3::new(9.0, 0.0, 0.0)];
        let [beyond] = lattice.invert(&far, &control).unwrap()[..] else { return };
        assert!(!beyond.inside, "{name}");
        let nearest = lattice.evaluate(&[beyond.parameter], &control).unwrap()[0];
        let closest = found.iter().map(|p| p.distance(far[0])).fold(f64::INFINITY, f64::min);
        assert!(nearest.distance(far[0]) < closest + 1e-9, "{name}");
    }
}

#[test]
fn bound_in_a_shape_the_lattice_moves_what_is_inside_with_its_affine_motion() {
    let mesh = bumpy_ball(3);
    let matrix =
        DMat3::from_cols(DVec3::new(0.3, 1.1, -0.2), DVec3::new(-0.9, 0.4, 0.1), DVec3::new(0.2, 0.3, 2.0));
    for (name, lattice) in mapped().into_iter().filter(|(name, _)| name.starts_with("rational")) {
        let rest = pushed(&lattice, DVec3::splat(1.3), 0.03, 5);
        let binding = Binding::shaped(
            lattice.clone(),
            mesh.vertices.clone(),
            mesh.triangles.clone(),
            None,
            Outside::Keep,
            Some(rest.clone()),
        )
        .unwrap();
        let mut out = mesh.vertices.clone();
        binding.deform(&rest, &mut out).unwrap();
        assert_eq!(out, mesh.vertices, "{name}");
        let inside: Vec<bool> = lattice
            .invert(&mesh.vertices.iter().map(|p| DVec3::from_array(*p)).collect::<Vec<_>>(), &rest)
            .unwrap()
            .iter()
            .map(|found| found.inside)
            .collect();
        let moved: Vec<DVec3> = rest.iter().map(|p| matrix * *p + DVec3::X).collect();
        binding.deform(&moved, &mut out).unwrap();
        let mut count = 0;
        for ((to, from), _) in out.iter().zip(&mesh.vertices).zip(&inside).filter(|(_, inside)| **inside) {
            let off = DVec3::from_array(*to) - (matrix * DVec3::from_array(*from) + DVec3::X);
            assert!(off.length() < 1e-12, "{name}: {off}");
            count += 1;
        }
        assert!(count > mesh.vertices.len() / 2, "{name}: {count}");
    }
}

/// The determinant of the derivative of what a mesh bound to the lattice at rest does, or of the lattice's map, by central differences.
fn determinant(lattice: &Lattice, control: &[DVec3], is_map: bool, at: DVec3) -> f64 {
    let step = 1e-6;
    let at = at.clamp(DVec3::splat(step), DVec3::splat(1.0 - step));
    let sides: Vec<DVec3> =
        DVec3::AXES.iter().flat_map(|axis| [at + axis * step, at - axis * step]).collect();
    let points =
        if is_map { lattice.evaluate(&sides, control).unwrap() } else { carried(lattice, control, &sides) };
    let [s, t, u] = [0, 2, 4].map(|i| (points[i] - points[i + 1]) / (2.0 * step));
    DMat3::from_cols(s, t, u).determinant() / lattice.edges().determinant()
}

fn carried(lattice: &Lattice, control: &[DVec3], at: &[DVec3]) -> Vec<DVec3> {
    let vertices: Vec<[f64; 3]> = at.iter().map(|&s| lattice.point(s).to_array()).collect();
    let binding = Binding::new(lattice.clone(), vertices.clone(), Vec::new(), None, Outside::Keep).unwrap();
    let mut out = vertices;
    binding.deform(control, &mut out).unwrap();
    out.into_iter().map(DVec3::from_array).collect()
}

#[test]
fn no_proof_against_a_sample_and_no_fold_without_a_wrong_determinant() {
    let mut verdicts = [0; 3];
    for (case, (name, lattice)) in mapped().into_iter().enumerate() {
        // Products of twenty-one by eight by two coefficients take their time.
        let (steps, span) = if lattice.len() > 300 { (3, 5.0) } else { (16, 1.0) };
        let spacing = lattice.shape().map(|count| 1.0 / count as f64);
        let rest = lattice.rest();
        for (is_map, test) in [
            (false, FoldTest::new(&lattice, None).unwrap()),
            (true, FoldTest::new(&lattice, Some(&rest)).unwrap()),
        ] {
            for step in 0..steps {
                let mut random = noise(100 * case as u64 + step);
                let amount = 0.1 * span * (step + 1) as f64;
                let mut any =
                    || amount * DVec3::new(random(), random(), random()) * DVec3::from_array(spacing);
                let control: Vec<DVec3> = rest.iter().map(|p| p + lattice.edges() * any()).collect();
                let found = test.folds(&control, DEPTH).unwrap();
                verdicts[found.verdict as usize] += 1;
                if found.verdict == Verdict::Undecided {
                    println!("{name} {is_map} {step} {}", found.undecided.len());
                }
                assert_eq!(test.is_unfolded(&control).unwrap(), found.verdict == Verdict::Unfolded);
                for at in places(60, step + 7) {
                    let here = determinant(&lattice, &control, is_map, at);
                    assert!(
                        found.verdict == Verdict::Folded || here > -1e-7,
                        "{name} {step}: {here} at {at}"
                    );
                }
                for (&at, &place) in found.parameters.iter().zip(&found.points).step_by(97) {
                    let here = determinant(&lattice, &control, is_map, at);
                    assert!(here < 1e-3, "{name} {step}: {here} at {at}");
                    let points = match is_map {
                        true => lattice.evaluate(&[at], &control).unwrap(),
                        false => carried(&lattice, &control, &[at]),
                    };
                    assert!((points[0] - place).length() < 1e-12, "{name}");
                }
            }
        }
    }
    let [unfolded, folded, undecided] = verdicts;
    assert!(unfolded > 60 && folded > 60 && undecided < 4, "{verdicts:?}");
}

#[test]
fn a_limited_correction_folds_nothing() {
    let mesh = bumpy_ball(3);
    for (name, lattice) in mapped().into_iter().filter(|(_, lattice)| lattice.len() <= 130) {
        let binding = bind(&lattice, &mesh, Outside::Extend);
        let control = pushed(&lattice, DVec3::new(1.0, 1.0, 0.8), 0.0, 1);
        let test = FoldTest::new(&lattice, None).unwrap();
        assert!(test.is_unfolded(&control).unwrap(), "{name}");
        let mut out = mesh.vertices.clone();
        let target = Some(vec![-binding.reference().unwrap().volume]);
        let options = Preserve {
            limit: Some(Limit::Unfolded),
            target,
            axes: [0.0, 0.0, 1.0],
            method: Method::Sweep,
            ..Preserve::default()
        };
        let found = binding.preserve(&control, &options, &mut out).unwrap();
        assert!(test.is_unfolded(&found.control).unwrap(), "{name}");
        let missing = found.target() - volume(&out, &mesh.triangles);
        assert!((missing - found.missing).abs() < 1e-11 && missing < 0.0, "{name}: {missing}");
    }
}

#[test]
fn weights_go_where_volume_was_lost() {
    for (name, lattice) in mapped() {
        let even = lattice.loss_weights(&lattice.rest(), None, 0.01).unwrap();
        assert!(even.iter().all(|weight| *weight == 1.0), "{name}");
        // Squashed beyond the middle of x only.
        let squash = |p: &DVec3| DVec3::new(p.x, p.y, if p.x > 0.0 { p.z * (1.0 - 0.4 * p.x) } else { p.z });
        let control: Vec<DVec3> = lattice.rest().iter().map(squash).collect();
        for rest in [None, Some(lattice.rest())] {
            let weights = lattice.loss_weights(&control, rest.as_deref(), 0.01).unwrap();
            assert!(weights.iter().all(|weight| (1.0..=100.0 + 1e-9).contains(weight)), "{name}");
            let mean = |is_far: bool| {
                let of = lattice.rest();
                let all =
                    of.iter().zip(&weights).filter(|(p, _)| (p.x > 0.9) == is_far && (is_far || p.x < -0.9));
                let all: Vec<f64> = all.map(|(_, weight)| weight.ln()).collect();
                all.iter().sum::<f64>() / all.len() as f64
            };
            assert!(mean(true) < mean(false), "{name}");
        }
    }
}

#[test]
fn bodies_and_caps_keep_their_volumes() {
    let ball = bumpy_ball(3);
    let count = ball.vertices.len() as u32;
    let placed =
        |size: f64, x: f64| ball.vertices.iter().map(move |p| [x + size * p[0], size * p[1], size * p[2]]);
    let triangles =
        |first: u32| ball.triangles[3..].iter().map(move |t| t.map(|v| v + first)).collect::<Vec<_>>();
    let vertices: Vec<[f64; 3]> = placed(0.6, -0.6).chain(placed(0.2, 0.7)).collect();
    let triangles = [triangles(0), triangles(count)].concat();
    for (name, lattice) in mapped() {
        let how = Bind { outside: Outside::Extend, bodies: Bodies::Islands, caps: true, ..Bind::default() };
        let binding = Binding::with(lattice.clone(), vertices.clone(), triangles.clone(), how).unwrap();
        let control = pushed(&lattice, DVec3::new(0.9, 1.0, 0.8), 0.1, 5);
        let mut out = vertices.clone();
        let found = binding.preserve(&control, &Preserve::default(), &mut out).unwrap();
        for (body, target) in binding.measures(&out).unwrap().iter().zip(&found.targets) {
            assert!((body.volume / target - 1.0).abs() < 1e-11, "{name}: {} {target}", body.volume);
        }
    }
}

#[test]
fn a_coarse_copy_finds_nearly_the_same() {
    let mesh = bumpy_ball(6);
    for (name, lattice) in
        mapped().into_iter().filter(|(name, _)| name.contains("6^3") || name.contains("mixed"))
    {
        let [exact, coarse] = [Accuracy::Exact, Accuracy::Finished].map(|accuracy| {
            let binding = bind(&lattice, &mesh, Outside::Extend);
            let control = pushed(&lattice, DVec3::new(1.0, 0.9, 0.6), 0.05, 2);
            let mut out = mesh.vertices.clone();
            let found =
                binding.preserve(&control, &Preserve { accuracy, ..Preserve::default() }, &mut out).unwrap();
            assert!((volume(&out, &mesh.triangles) / found.target() - 1.0).abs() < 1e-12, "{name}");
            found
        });
        assert!((exact.distance / coarse.distance - 1.0).abs() < 1e-2, "{name}");
    }
}

#[test]
fn influence_scales_and_masks() {
    let mesh = bumpy_ball(3);
    for (name, lattice) in mapped() {
        let influence: Vec<f64> = (0..mesh.vertices.len()).map(|v| (v % 3) as f64 / 2.0).collect();
        let whole = bind(&lattice, &mesh, Outside::Extend);
        let masked = Binding::new(
            lattice.clone(),
            mesh.vertices.clone(),
            mesh.triangles.clone(),
            Some(influence.clone()),
            Outside::Extend,
        )
        .unwrap();
        let control = pushed(&lattice, DVec3::ONE, 0.2, 8);
        let (mut all, mut part) = (mesh.vertices.clone(), mesh.vertices.clone());
        whole.deform(&control, &mut all).unwrap();
        masked.deform(&control, &mut part).unwrap();
        for v in 0..influence.len() {
            let at = |rows: &[[f64; 3]]| DVec3::from_array(rows[v]);
            let expected = at(&mesh.vertices).lerp(at(&all), influence[v]);
            assert!((at(&part) - expected).length() < 1e-14, "{name}");
        }
        let options = Preserve::default();
        masked.preserve(&control, &options, &mut part).unwrap();
        assert!((0..influence.len()).step_by(3).all(|v| part[v] == mesh.vertices[v]), "{name}");
    }
}
