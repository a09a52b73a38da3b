// SPDX-License-Identifier: GPL-3.0-or-later
//! The volume is kept, in float64, on the vertices that come out.

use crate::shared::{Mesh, bases, bumpy_ball, noise, slanted, volume};
use isochor_core::{AxisBasis, Binding, ClosedSurface, DVec3, Error, Lattice, Method, Outside, Preserve};

const SHARES: [[f64; 3]; 4] = [[1.0, 1.0, 1.0], [1.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 2.0, 0.0]];

fn bind(lattice: &Lattice, mesh: &Mesh) -> Binding<f64> {
    Binding::new(lattice.clone(), mesh.vertices.clone(), mesh.triangles.clone(), None, Outside::Keep).unwrap()
}

fn squash(lattice: &Lattice, factor: f64) -> Vec<DVec3> {
    let mut random = noise(3);
    lattice
        .rest()
        .iter()
        .map(|p| {
            DVec3::new(p.x * factor.sqrt(), p.y, p.z * factor)
                + 0.03 * DVec3::new(random(), random(), random())
        })
        .collect()
}

#[test]
fn volume_is_kept_for_every_basis_method_and_share() {
    let mesh = bumpy_ball(4);
    let reference = volume(&mesh.vertices, &mesh.triangles);
    for (name, axes) in bases() {
        let lattice = slanted(axes);
        let binding = bind(&lattice, &mesh);
        for factor in [0.28, 0.6, 1.0, 2.5] {
            let control = squash(&lattice, factor);
            for method in [Method::Sweep, Method::Balanced] {
                for axes in SHARES {
                    let mut out = vec![[0.0; 3]; mesh.vertices.len()];
                    let options = Preserve { axes, method, ..Preserve::default() };
                    let outcome = binding.preserve(&control, &options, &mut out).unwrap();
                    let error = (volume(&out, &mesh.triangles) / reference - 1.0).abs();
                    assert!(error < 1e-12, "{name} {factor} {method:?} {axes:?}: {error:e}");
                    for (corrected, asked) in outcome.control.iter().zip(&control) {
                        for axis in (0..3).filter(|&a| axes[a] == 0.0) {
                            assert_eq!(corrected[axis].to_bits(), asked[axis].to_bits());
                        }
                    }
                    let mut again = out.clone();
                    binding.deform(&outcome.control, &mut again).unwrap();
                    let apart = out.iter().flatten().zip(again.iter().flatten()).map(|(a, b)| (a - b).abs());
                    assert!(apart.fold(0.0, f64::max) < 1e-13, "{name}");
                }
            }
        }
    }
}

#[test]
fn float32_vertices_keep_the_volume_as_they_come_out() {
    let mesh = bumpy_ball(5);
    let vertices: Vec<[f32; 3]> = mesh.vertices.iter().map(|p| p.map(|c| c as f32)).collect();
    let exact =
        |vertices: &[[f32; 3]]| -> Vec<[f64; 3]> { vertices.iter().map(|p| p.map(f64::from)).collect() };
    let reference = volume(&exact(&vertices), &mesh.triangles);
    for (name, axes) in bases() {
        let lattice = slanted(axes);
        let binding =
            Binding::new(lattice.clone(), vertices.clone(), mesh.triangles.clone(), None, Outside::Keep)
                .unwrap();
        for factor in [0.15, 0.6, 2.5] {
            let mut out = vec![[0.0; 3]; vertices.len()];
            binding.preserve(&squash(&lattice, factor), &Preserve::default(), &mut out).unwrap();
            let error = (volume(&exact(&out), &mesh.triangles) / reference - 1.0).abs();
            assert!(error < 1e-6, "{name} {factor}: {error:e}");
        }
    }
}

#[test]
fn a_small_float32_mesh_in_a_large_lattice_is_deformed_as_finely() {
    let mesh = bumpy_ball(4);
    let axes = std::array::from_fn(|_| AxisBasis::uniform(6, 3).unwrap());
    let lattice = Lattice::around(axes, &[DVec3::splat(-3000.0), DVec3::splat(1000.0)], 0.0).unwrap();
    let mut random = noise(5);
    let control: Vec<DVec3> =
        lattice.rest().iter().map(|p| p + 800.0 * DVec3::new(random(), random(), random())).collect();
    let vertices: Vec<[f32; 3]> = mesh.vertices.iter().map(|p| p.map(|c| c as f32)).collect();
    let single = Binding::new(lattice.clone(), vertices.clone(), Vec::new(), None, Outside::Keep).unwrap();
    let mut found = vec![[0.0f32; 3]; vertices.len()];
    single.deform(&control, &mut found).unwrap();
    let double = vertices.iter().map(|p| p.map(f64::from)).collect();
    let double = Binding::new(lattice, double, Vec::new(), None, Outside::Keep).unwrap();
    let mut expected = vec![[0.0f64; 3]; vertices.len()];
    double.deform(&control, &mut expected).unwrap();
    for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
        assert_eq!(*found, *expected as f32);
    }
}

#[test]
fn any_frame_of_directions_keeps_the_volume() {
    let mesh = bumpy_ball(4);
    let reference = volume(&mesh.vertices, &mesh.triangles);
    let lattice = slanted(bases().swap_remove(2).1);
    let binding = bind(&lattice, &mesh);
    let control = squash(&lattice, 0.5);
    let frame = [DVec3::new(1.0, 1.0, 0.0), DVec3::new(-4.0, 4.0, 1.0), DVec3::new(0.5, 0.0, -3.0)];
    let mut out = vec![[0.0; 3]; mesh.vertices.len()];
    let options = Preserve { axes: [1.0, 1.0, 0.0], frame: Some(frame), ..Preserve::default() };
    let outcome = binding.preserve(&control, &options, &mut out).unwrap();
    assert!((volume(&out, &mesh.triangles) / reference - 1.0).abs() < 1e-12);
    let across = frame[0].cross(frame[1]).normalize();
    for (corrected, asked) in outcome.control.iter().zip(&control) {
        assert!((*corrected - *asked).dot(across).abs() < 1e-13);
    }
}

#[test]
fn amount_target_and_weights_do_what_they_say() {
    let mesh = bumpy_ball(4);
    let lattice = slanted(bases().swap_remove(0).1);
    let binding = bind(&lattice, &mesh);
    let control = squash(&lattice, 0.5);
    let before = binding.volume(&control).unwrap();
    let mut out = vec![[0.0; 3]; mesh.vertices.len()];
    let mut run = |options: Preserve| {
        let outcome = binding.preserve(&control, &options, &mut out).unwrap();
        (outcome.control, volume(&out, &mesh.triangles))
    };
    let (kept, found) = run(Preserve { amount: 0.0, ..Preserve::default() });
    assert_eq!(kept, control);
    assert!((found / before - 1.0).abs() < 1e-13);
    let (_, found) = run(Preserve { target: Some(vec![7.0]), amount: 0.25, ..Preserve::default() });
    assert!((found / (before + 0.25 * (7.0 - before)) - 1.0).abs() < 1e-12);
    let weights: Vec<f64> = (0..64).map(|p| if p < 32 { f64::INFINITY } else { 1.0 + p as f64 }).collect();
    let (moved, found) = run(Preserve { weights: Some(weights), ..Preserve::default() });
    assert_eq!(moved[..32], control[..32]);
    assert!((found / volume(&mesh.vertices, &mesh.triangles) - 1.0).abs() < 1e-12);
}

#[test]
fn a_flat_axis_passes_its_share_on() {
    let mesh = bumpy_ball(3);
    let reference = volume(&mesh.vertices, &mesh.triangles);
    let axes = std::array::from_fn(|_| AxisBasis::bernstein(4).unwrap());
    let lattice = Lattice::around(axes, &[DVec3::splat(-1.2), DVec3::splat(1.2)], 0.0).unwrap();
    let binding = bind(&lattice, &mesh);
    let flat: Vec<DVec3> = lattice.rest().iter().map(|p| DVec3::new(p.x, p.y, 0.0)).collect();
    let mut out = vec![[0.0; 3]; mesh.vertices.len()];
    for method in [Method::Sweep, Method::Balanced] {
        let outcome = binding.preserve(&flat, &Preserve { method, ..Preserve::default() }, &mut out).unwrap();
        assert_eq!((outcome.method, outcome.iterations), (Method::Sweep, 2));
        assert!((volume(&out, &mesh.triangles) / reference - 1.0).abs() < 1e-12);
    }
    let stuck = binding.preserve(&flat, &Preserve { axes: [1.0, 1.0, 0.0], ..Preserve::default() }, &mut out);
    assert!(matches!(stuck, Err(Error::Volume(_))), "{stuck:?}");
}

#[test]
fn kept_vertices_do_not_tear_off() {
    let mesh = bumpy_ball(5);
    let inside = |v: &[f64; 3]| v[2] <= 0.4;
    for basis in [AxisBasis::bernstein(6).unwrap(), AxisBasis::uniform(8, 3).unwrap()] {
        let axes = std::array::from_fn(|_| basis.clone());
        let lattice = Lattice::around(axes, &[DVec3::splat(-1.2), DVec3::new(1.2, 1.2, 0.4)], 0.0).unwrap();
        let binding = bind(&lattice, &mesh);
        let held = basis.count() - basis.end_layers(true, 0);
        let control: Vec<DVec3> = lattice
            .rest()
            .iter()
            .enumerate()
            .map(|(p, at)| if p % basis.count() < held { at * 0.8 + DVec3::new(0.0, 0.0, -0.1) } else { *at })
            .collect();
        let mut out = vec![[0.0; 3]; mesh.vertices.len()];
        let outcome = binding.preserve(&control, &Preserve::default(), &mut out).unwrap();
        assert!(
            (volume(&out, &mesh.triangles) / volume(&mesh.vertices, &mesh.triangles) - 1.0).abs() < 1e-12
        );
        for (p, (corrected, asked)) in outcome.control.iter().zip(&control).enumerate() {
            assert!(p % basis.count() < held || corrected == asked);
        }
        for (found, rest) in out.iter().zip(&mesh.vertices) {
            assert!(inside(rest) || found == rest);
        }
    }
}

#[test]
fn walks_of_vertices_with_several_fans_add_nothing() {
    // Three tetrahedra that share one vertex only.
    let mut vertices = vec![[0.0; 3]];
    let mut triangles = Vec::new();
    for turn in 0..3 {
        let base = vertices.len() as u32;
        let at = |angle: f64, height: f64| {
            let angle = angle + f64::from(turn) * std::f64::consts::TAU / 3.0;
            [2.0 * angle.cos(), 2.0 * angle.sin(), height]
        };
        vertices.extend([at(-0.4, -0.5), at(0.4, -0.5), at(0.0, 0.7)]);
        let [a, b, c] = [base, base + 1, base + 2];
        triangles.extend([[0, b, a], [0, c, b], [0, a, c], [a, b, c]]);
    }
    ClosedSurface::new(vertices.len(), &triangles).unwrap();
    let axes = std::array::from_fn(|_| AxisBasis::bernstein(3).unwrap());
    let lattice = Lattice::around(axes, &[DVec3::splat(-2.5), DVec3::splat(2.5)], 0.0).unwrap();
    let mesh = Mesh { vertices, triangles };
    let binding = bind(&lattice, &mesh);
    let control = squash(&lattice, 0.4);
    let mut out = vec![[0.0; 3]; mesh.vertices.len()];
    binding.preserve(&control, &Preserve::default(), &mut out).unwrap();
    assert!((volume(&out, &mesh.triangles) / volume(&mesh.vertices, &mesh.triangles) - 1.0).abs() < 1e-13);
}

#[test]
fn broken_surfaces_are_named() {
    let mesh = bumpy_ball(1);
    let message = |triangles: &[[u32; 3]]| ClosedSurface::new(18, triangles).unwrap_err().to_string();
    assert!(message(&mesh.triangles[1..]).contains("3 edges are open"));
    let mut flipped = mesh.triangles.clone();
    flipped[4].swap(0, 1);
    assert!(message(&flipped).contains("3 edges are inconsistently wound"));
    let mut doubled = mesh.triangles.clone();
    doubled.push(mesh.triangles[0]);
    assert!(message(&doubled).contains("3 edges are non-manifold"));
    assert!(message(&[[0, 1, 1]]).contains("repeat a vertex"));
    assert!(message(&[]).contains("found none"));
}

#[test]
fn threads_do_not_change_a_bit() {
    let mesh = bumpy_ball(5);
    let lattice = slanted(bases().swap_remove(3).1);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut out = vec![[0.0; 3]; mesh.vertices.len()];
            bind(&lattice, &mesh).preserve(&squash(&lattice, 0.4), &Preserve::default(), &mut out).unwrap();
            out
        })
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn update_equals_a_new_binding() {
    let mesh = bumpy_ball(3);
    let lattice = slanted(bases().swap_remove(2).1);
    let mut updated = bind(&lattice, &mesh);
    updated.volume(&lattice.rest()).unwrap();
    let moved: Vec<[f64; 3]> = mesh.vertices.iter().map(|[x, y, z]| [y * 0.9, *x, -z * 0.8]).collect();
    updated.update(Some(moved.clone()), None, None, None).unwrap();
    let fresh = bind(&lattice, &Mesh { vertices: moved, triangles: mesh.triangles.clone() });
    let control = squash(&lattice, 0.5);
    let mut out = [vec![[0.0; 3]; mesh.vertices.len()], vec![[0.0; 3]; mesh.vertices.len()]];
    updated.preserve(&control, &Preserve::default(), &mut out[0]).unwrap();
    fresh.preserve(&control, &Preserve::default(), &mut out[1]).unwrap();
    assert_eq!(out[0], out[1]);
    assert!(updated.update(Some(vec![[0.0; 3]]), None, None, None).is_err());
}
