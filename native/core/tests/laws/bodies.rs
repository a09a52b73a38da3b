// SPDX-License-Identifier: GPL-3.0-or-later
//! Many volumes at once: islands, labelled parts that share vertices, and caps over holes.

use crate::shared::{Mesh, bases, bumpy_ball, noise, slanted, volume};
use isochor_core::{AxisBasis, Bind, Binding, Bodies, DVec3, Error, Lattice, Method, Preserve};

/// One mesh of several, each scaled about its origin and moved.
fn joined(parts: &[(&Mesh, f64, [f64; 3])]) -> Mesh {
    let mut all = Mesh { vertices: Vec::new(), triangles: Vec::new() };
    for (mesh, scale, [x, y, z]) in parts {
        let base = all.vertices.len() as u32;
        let moved = mesh.vertices.iter().map(|p| [p[0] * scale + x, p[1] * scale + y, p[2] * scale + z]);
        all.vertices.extend(moved);
        all.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + base)));
    }
    all
}

fn bind(lattice: &Lattice, mesh: &Mesh, bodies: Bodies, caps: bool) -> Binding<f64> {
    let options = Bind { bodies, caps, ..Bind::default() };
    Binding::with(lattice.clone(), mesh.vertices.clone(), mesh.triangles.clone(), options).unwrap()
}

fn shaken(lattice: &Lattice, seed: u64) -> Vec<DVec3> {
    let mut random = noise(seed);
    let nudge = |p: &DVec3| *p * DVec3::new(0.8, 1.1, 0.6) + 0.1 * DVec3::new(random(), random(), random());
    lattice.rest().iter().map(nudge).collect()
}

/// The ball without the triangles at some of its corners.
fn open_ball(levels: u32, corners: &[u32]) -> Mesh {
    let mut mesh = bumpy_ball(levels);
    mesh.triangles.retain(|t| !corners.iter().any(|corner| t.contains(corner)));
    mesh
}

/// Triangles of each body with real fans about further vertices at the means of the boundary loops.
fn really_closed(vertices: &[[f64; 3]], bodies: &[Vec<[u32; 3]>]) -> (Vec<[f64; 3]>, Vec<Vec<[u32; 3]>>) {
    let (mut all, mut closed) = (vertices.to_vec(), bodies.to_vec());
    for body in &mut closed {
        let edges: std::collections::HashSet<[u32; 2]> =
            body.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        let open = edges.iter().filter(|[a, b]| !edges.contains(&[*b, *a]));
        let mut next: std::collections::HashMap<u32, u32> = open.clone().map(|&[a, b]| (b, a)).collect();
        assert_eq!(next.len(), open.count(), "loops that touch are not for this closing");
        while let Some(&start) = next.keys().min() {
            let mut ring = vec![start];
            while let Some(to) = next.remove(ring.last().unwrap()).filter(|to| *to != start) {
                ring.push(to);
            }
            let mean = |axis: usize| {
                ring.iter().map(|&v| vertices[v as usize][axis]).sum::<f64>() / ring.len() as f64
            };
            let apex = all.len() as u32;
            all.push([mean(0), mean(1), mean(2)]);
            (0..ring.len()).for_each(|i| body.push([ring[i], ring[(i + 1) % ring.len()], apex]));
        }
    }
    (all, closed)
}

fn brute_volumes(vertices: &[[f64; 3]], bodies: &[Vec<[u32; 3]>]) -> Vec<f64> {
    let (all, closed) = really_closed(vertices, bodies);
    closed.iter().map(|body| volume(&all, body)).collect()
}

fn of_labels(mesh: &Mesh, labels: &[i32]) -> Vec<Vec<[u32; 3]>> {
    let body = |label| mesh.triangles.iter().zip(labels).filter(move |(_, l)| **l == label).map(|(t, _)| *t);
    (0..=*labels.iter().max().unwrap()).map(|label| body(label).collect()).collect()
}

fn assert_close(found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len());
    for (body, (found, expected)) in found.iter().zip(expected).enumerate() {
        let error = (found / expected - 1.0).abs();
        assert!(error <= tolerance, "body {body}: {found} instead of {expected}, {error:e}");
    }
}

/// Corrects with several options, and measures every body by brute force.
fn assert_kept(lattice: &Lattice, mesh: &Mesh, binding: &Binding<f64>, tolerance: f64) {
    let bodies = of_labels(mesh, &binding.body_of_triangle());
    let own = brute_volumes(&mesh.vertices, &bodies);
    let references: Vec<f64> = binding.references().unwrap().iter().map(|body| body.volume).collect();
    assert_close(&references, &own, 1e-12);
    let control = shaken(lattice, 5);
    let mut out = mesh.vertices.clone();
    binding.deform(&control, &mut out).unwrap();
    assert_close(&binding.volumes(&control).unwrap(), &brute_volumes(&out, &bodies), 1e-12);
    let frame = [DVec3::new(1.0, 1.0, 0.0), DVec3::new(-1.0, 1.0, 0.2), DVec3::new(0.1, 0.0, 1.0)];
    for method in [Method::Sweep, Method::Balanced] {
        for (axes, frame) in [([1.0; 3], None), ([1.0, 1.0, 0.0], None), ([1.0; 3], Some(frame))] {
            let options = Preserve { method, axes, frame, ..Preserve::default() };
            let outcome = binding.preserve(&control, &options, &mut out).unwrap();
            assert_close(&brute_volumes(&out, &bodies), &own, tolerance);
            assert_close(&outcome.targets, &own, 1e-12);
        }
    }
    let wanted: Vec<f64> = own.iter().enumerate().map(|(i, v)| v * (0.8 + 0.1 * (i % 5) as f64)).collect();
    let options = Preserve { target: Some(wanted.clone()), ..Preserve::default() };
    binding.preserve(&control, &options, &mut out).unwrap();
    assert_close(&brute_volumes(&out, &bodies), &wanted, tolerance);
}

fn three_islands() -> Mesh {
    let mut hollow = bumpy_ball(2);
    hollow.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    joined(&[
        (&bumpy_ball(3), 0.4, [-0.7, 0.0, 0.0]),
        (&hollow, 0.3, [0.5, 0.5, 0.2]),
        (&bumpy_ball(2), 0.05, [0.9, -0.8, -0.6]),
    ])
}

#[test]
fn islands_keep_their_volumes_for_every_basis() {
    let mesh = three_islands();
    for (name, axes) in bases() {
        println!("{name}");
        let lattice = slanted(axes);
        let binding = bind(&lattice, &mesh, Bodies::Islands, false);
        assert_eq!(binding.body_count(), 3);
        assert_kept(&lattice, &mesh, &binding, 1e-11);
    }
}

#[test]
fn labelled_parts_share_their_border_and_add_up() {
    let mesh = bumpy_ball(4);
    let lattice = slanted(bases().swap_remove(2).1);
    // Three wedges: three bodies share the poles.
    let label = |t: &[u32; 3]| {
        let at = |axis: usize| t.iter().map(|&v| mesh.vertices[v as usize][axis]).sum::<f64>();
        if at(0) < 0.0 {
            0
        } else if at(1) < 0.0 {
            1
        } else {
            2
        }
    };
    let mut labels: Vec<i32> = mesh.triangles.iter().map(label).collect();
    let binding = bind(&lattice, &mesh, Bodies::Labels(labels.clone()), false);
    assert_eq!(binding.body_of_triangle(), labels);
    assert!(binding.has_caps());
    assert!(binding.layout().slots() > mesh.vertices.len());
    assert_kept(&lattice, &mesh, &binding, 1e-11);
    // A part of no body, in the middle of another: its border is closed as well.
    for (label, t) in labels.iter_mut().zip(&mesh.triangles) {
        if t.contains(&1) {
            *label = -1;
        }
    }
    let binding = bind(&lattice, &mesh, Bodies::Labels(labels), false);
    assert_kept(&lattice, &mesh, &binding, 1e-11);
}

#[test]
fn two_halves_add_up_to_the_whole() {
    let mesh = bumpy_ball(3);
    let lattice = slanted(bases().swap_remove(0).1);
    let half = |t: &[u32; 3]| i32::from(t.iter().map(|&v| mesh.vertices[v as usize][0]).sum::<f64>() > 0.0);
    let labels = mesh.triangles.iter().map(half).collect();
    let halves = bind(&lattice, &mesh, Bodies::Labels(labels), false);
    let control = shaken(&lattice, 3);
    let whole = bind(&lattice, &mesh, Bodies::Whole, false).volume(&control).unwrap();
    assert_close(&[halves.volume(&control).unwrap()], &[whole], 1e-13);
}

#[test]
fn caps_are_fans_about_the_means_of_their_loops() {
    for (name, axes) in bases() {
        println!("{name}");
        let lattice = slanted(axes);
        let mesh = open_ball(3, &[0, 3, 4]);
        let binding = bind(&lattice, &mesh, Bodies::Whole, true);
        assert_kept(&lattice, &mesh, &binding, 1e-12);
        let parts = joined(&[(&mesh, 0.4, [-0.7, 0.0, 0.0]), (&open_ball(2, &[1]), 0.3, [0.6, 0.1, 0.2])]);
        assert_kept(&lattice, &parts, &bind(&lattice, &parts, Bodies::Islands, true), 1e-11);
    }
}

#[test]
fn holes_that_touch_in_a_vertex_are_two() {
    // Two triangles that share vertex 2 only, and so the vertices around it have several fans.
    let mut mesh = bumpy_ball(2);
    let at = mesh.triangles.iter().position(|t| t.contains(&2)).unwrap();
    let first = mesh.triangles.remove(at);
    let apart = |t: &[u32; 3]| t.contains(&2) && t.iter().filter(|v| first.contains(v)).count() == 1;
    let at = mesh.triangles.iter().position(apart).unwrap();
    mesh.triangles.remove(at);
    let lattice = slanted(bases().swap_remove(0).1);
    let binding = bind(&lattice, &mesh, Bodies::Whole, true);
    let loops = binding.surface().unwrap().loops();
    assert_eq!(loops.len(), 2);
    assert!(loops.iter().all(|each| each.len() == 3 && each.contains(&2)));
    // Flat caps of triangles: the volume is that of the ball.
    let own = volume(&mesh.vertices, &bumpy_ball(2).triangles);
    assert_close(&[binding.reference().unwrap().volume], &[own], 1e-13);
    let mut out = mesh.vertices.clone();
    binding.preserve(&shaken(&lattice, 7), &Preserve::default(), &mut out).unwrap();
    assert_close(&[volume(&out, &bumpy_ball(2).triangles)], &[own], 1e-12);
}

#[test]
fn positions_from_control_points_give_the_caps_too() {
    let lattice = slanted(bases().swap_remove(4).1);
    let mesh = open_ball(3, &[0, 5]);
    let binding = bind(&lattice, &mesh, Bodies::Whole, true);
    let control = shaken(&lattice, 2);
    let mut out = mesh.vertices.clone();
    binding.deform(&control, &mut out).unwrap();
    let displacement = binding.displacement(&control).unwrap();
    let positions = binding.cap_positions(&displacement, isochor_core::DMat3::IDENTITY).unwrap();
    let expected = binding.surface().unwrap().loops().iter().flatten().map(|&v| out[v as usize]);
    for (found, expected) in positions.iter().zip(expected) {
        assert!(found.distance(DVec3::from_array(expected)) < 1e-14);
    }
}

#[test]
fn open_and_flat_islands_deform_along() {
    let flat = Mesh {
        vertices: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2], [0, 2, 1]],
    };
    let mesh = joined(&[
        (&flat, 0.3, [0.5, 0.5, 0.5]),
        (&bumpy_ball(2), 0.5, [-0.5, -0.5, 0.0]),
        (&open_ball(2, &[0]), 0.3, [0.6, -0.6, 0.0]),
    ]);
    let lattice = slanted(bases().swap_remove(0).1);
    let binding = bind(&lattice, &mesh, Bodies::Islands, false);
    assert_eq!(binding.body_count(), 1);
    let labels = binding.body_of_triangle();
    assert_eq!((labels[0], labels[1], labels[2], labels.last()), (-1, -1, 0, Some(&-1)));
    assert_kept(&lattice, &mesh, &binding, 1e-12);
    // With caps the open one keeps its volume too, and the flat one stays without.
    assert_eq!(bind(&lattice, &mesh, Bodies::Islands, true).body_count(), 2);
    let none = bind(&lattice, &open_ball(2, &[0]), Bodies::Islands, false);
    assert_eq!(none.body_count(), 0);
    let message = none.references().unwrap_err().to_string();
    assert!(message.contains("none of 1 islands") && message.contains("edges are open"), "{message}");
}

#[test]
fn holes_are_told_with_their_places_and_edges() {
    let lattice = slanted(bases().swap_remove(0).1);
    let mesh = open_ball(2, &[0, 3]);
    let message = bind(&lattice, &mesh, Bodies::Whole, false).references().unwrap_err().to_string();
    let loops = bind(&lattice, &mesh, Bodies::Whole, true).surface().unwrap().loops().to_vec();
    assert!(message.contains("8 edges are open") && message.contains("2 holes"), "{message}");
    for each in &loops {
        assert!(message.contains(&format!("4 edges from vertex {}", each[0])), "{message}");
    }
    // Of labelled parts a hole counts, their borders do not.
    let half = |t: &[u32; 3]| i32::from(t.iter().map(|&v| mesh.vertices[v as usize][2]).sum::<f64>() > 0.0);
    let labels: Vec<i32> = mesh.triangles.iter().map(half).collect();
    let halves = bind(&lattice, &mesh, Bodies::Labels(labels.clone()), false);
    assert!(halves.references().unwrap_err().to_string().contains("body"));
    assert!(bind(&lattice, &mesh, Bodies::Labels(labels), true).references().is_ok());
    // Caps close holes, not what is broken otherwise.
    let mut fin = bumpy_ball(1);
    fin.vertices.push([2.0, 2.0, 2.0]);
    let [a, b, _] = fin.triangles[0];
    fin.triangles.push([a, b, fin.vertices.len() as u32 - 1]);
    let message = bind(&lattice, &fin, Bodies::Whole, true).references().unwrap_err().to_string();
    assert!(message.contains("non-manifold"), "{message}");
}

#[test]
fn labels_that_fit_no_triangles_are_refused() {
    let (lattice, mesh) = (slanted(bases().swap_remove(0).1), bumpy_ball(1));
    let count = mesh.triangles.len();
    let mut gap = vec![0; count];
    gap[3] = 2;
    for (labels, says) in [
        (vec![0; 3], "expected 32"),
        (vec![-2; count], "label -2 at triangle 0"),
        (vec![-1; count], "at least one body"),
        (gap, "no triangle labelled 1"),
    ] {
        let options = Bind { bodies: Bodies::Labels(labels), ..Bind::default() };
        let found =
            Binding::with(lattice.clone(), mesh.vertices.clone(), mesh.triangles.clone(), options).err();
        assert!(matches!(&found, Some(Error::Mesh(text)) if text.contains(says)), "{says}: {found:?}");
    }
}

#[test]
fn a_tiny_island_beside_a_large_one_keeps_its_volume() {
    let mesh = joined(&[(&bumpy_ball(4), 0.9, [-0.3, 0.0, 0.0]), (&bumpy_ball(2), 1e-4, [1.2, 1.0, 1.0])]);
    let lattice = slanted(bases().swap_remove(2).1);
    let binding = bind(&lattice, &mesh, Bodies::Islands, false);
    let control = shaken(&lattice, 9);
    let mut out = mesh.vertices.clone();
    let outcome = binding.preserve(&control, &Preserve::default(), &mut out).unwrap();
    assert_eq!((outcome.method, outcome.iterations), (Method::Balanced, 1));
    let own: Vec<f64> = binding.references().unwrap().iter().map(|body| body.volume).collect();
    let found: Vec<f64> = binding.measures(&out).unwrap().iter().map(|body| body.volume).collect();
    // 4 epsilon A R / |V| of the tiny one is about 1e-11.
    assert_close(&found, &own, 1e-11);
    assert!(outcome.distance < 5.0);
    // Float32 coordinates are a thousandth of a larger small one apart, and its volume as far from what was aimed at.
    let mesh = joined(&[(&bumpy_ball(4), 0.9, [-0.3, 0.0, 0.0]), (&bumpy_ball(2), 4e-4, [1.2, 1.0, 1.0])]);
    let vertices: Vec<[f32; 3]> = mesh.vertices.iter().map(|p| p.map(|c| c as f32)).collect();
    let options = Bind { bodies: Bodies::Islands, ..Bind::default() };
    let binding = Binding::with(lattice.clone(), vertices.clone(), mesh.triangles.clone(), options).unwrap();
    let mut out = vertices;
    let outcome = binding.preserve(&control, &Preserve::default(), &mut out).unwrap();
    assert_eq!((outcome.method, outcome.iterations), (Method::Balanced, 1));
    let found: Vec<f64> = binding.measures(&out).unwrap().iter().map(|body| body.volume).collect();
    assert_close(&found[..1], &outcome.targets[..1], 1e-6);
    assert_close(&found[1..], &outcome.targets[1..], 1e-3);
}

#[test]
fn a_hundred_islands_keep_their_volumes() {
    let ball = bumpy_ball(1);
    let place = |i: usize| [i / 25, i / 5 % 5, i % 5].map(|k| -1.1 + 0.55 * k as f64);
    let places: Vec<[f64; 3]> = (0..125).map(place).collect();
    let parts: Vec<(&Mesh, f64, [f64; 3])> = places.iter().map(|&at| (&ball, 0.2, at)).collect();
    let mesh = joined(&parts);
    let lattice = slanted(std::array::from_fn(|_| AxisBasis::clamped(8, 3).unwrap()));
    let binding = bind(&lattice, &mesh, Bodies::Islands, false);
    assert_eq!(binding.body_count(), 125);
    assert_kept(&lattice, &mesh, &binding, 1e-11);
    // One more that stands where another does: row by row it is found to want what that wants.
    let mesh = joined(&[parts, vec![(&ball, 0.2, places[7])]].concat());
    assert_kept_alike(&lattice, &mesh, &bind(&lattice, &mesh, Bodies::Islands, false));
}

#[test]
fn one_target_is_shared_in_proportion() {
    let mesh = three_islands();
    let lattice = slanted(bases().swap_remove(2).1);
    let binding = bind(&lattice, &mesh, Bodies::Islands, false);
    let own: Vec<f64> = binding.references().unwrap().iter().map(|body| body.volume).collect();
    let mut out = mesh.vertices.clone();
    let target = Some(vec![1.5 * own.iter().sum::<f64>()]);
    let options = Preserve { target, ..Preserve::default() };
    let outcome = binding.preserve(&lattice.rest(), &options, &mut out).unwrap();
    let wanted: Vec<f64> = own.iter().map(|volume| 1.5 * volume).collect();
    assert_close(&outcome.targets, &wanted, 1e-14);
    let found: Vec<f64> = binding.measures(&out).unwrap().iter().map(|body| body.volume).collect();
    assert_close(&found, &wanted, 1e-12);
    let wrong = Preserve { target: Some(vec![1.0, 2.0]), ..Preserve::default() };
    let message = binding.preserve(&lattice.rest(), &wrong, &mut out).unwrap_err().to_string();
    assert!(message.contains("found 2") && message.contains('3'), "{message}");
}

#[test]
fn islands_in_one_place_have_one_change() {
    let ball = bumpy_ball(2);
    let mesh = joined(&[(&ball, 0.8, [0.1, 0.0, 0.0]), (&ball, 0.8, [0.1, 0.0, 0.0])]);
    let lattice = slanted(bases().swap_remove(2).1);
    let binding = bind(&lattice, &mesh, Bodies::Islands, false);
    assert_kept_alike(&lattice, &mesh, &binding);
    let own = binding.references().unwrap()[0].volume;
    let options = Preserve { target: Some(vec![own, 1.1 * own]), ..Preserve::default() };
    let mut out = mesh.vertices.clone();
    let found = binding.preserve(&shaken(&lattice, 1), &options, &mut out);
    let message = found.unwrap_err().to_string();
    assert!(message.contains("body 1") && message.contains("cannot be reached"), "{message}");
}

fn assert_kept_alike(lattice: &Lattice, mesh: &Mesh, binding: &Binding<f64>) {
    let mut out = mesh.vertices.clone();
    let outcome = binding.preserve(&shaken(lattice, 1), &Preserve::default(), &mut out).unwrap();
    assert_eq!(outcome.iterations, 1);
    let found: Vec<f64> = binding.measures(&out).unwrap().iter().map(|body| body.volume).collect();
    assert_close(&found, &outcome.targets, 1e-13);
}

#[test]
fn more_bodies_than_control_points_are_out_of_reach() {
    let ball = bumpy_ball(0);
    let mut random = noise(4);
    let places: Vec<[f64; 3]> = (0..12).map(|_| std::array::from_fn(|_| 1.1 * random())).collect();
    let parts: Vec<(&Mesh, f64, [f64; 3])> = places.iter().map(|&at| (&ball, 0.1, at)).collect();
    let mesh = joined(&parts);
    let axes = std::array::from_fn(|_| AxisBasis::bernstein(2).unwrap());
    let lattice = slanted(axes);
    let binding = bind(&lattice, &mesh, Bodies::Islands, false);
    let own: Vec<f64> = binding.references().unwrap().iter().map(|body| body.volume).collect();
    let target = own.iter().enumerate().map(|(i, v)| v * (1.0 + 0.3 * (i as f64).sin())).collect();
    let mut out = mesh.vertices.clone();
    let options = Preserve { target: Some(target), ..Preserve::default() };
    let found = binding.preserve(&lattice.rest(), &options, &mut out);
    assert!(matches!(&found, Err(Error::Volume(text)) if text.contains("body")), "{found:?}");
}

#[test]
fn a_flat_body_is_named() {
    let flat = Mesh {
        vertices: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2], [0, 2, 1]],
    };
    let mesh = joined(&[(&bumpy_ball(1), 0.5, [-0.5, 0.0, 0.0]), (&flat, 0.3, [0.5, 0.5, 0.5])]);
    let lattice = slanted(bases().swap_remove(0).1);
    let mut labels = vec![0; mesh.triangles.len()];
    labels[32..].fill(1);
    let binding = bind(&lattice, &mesh, Bodies::Labels(labels), false);
    let mut out = mesh.vertices.clone();
    let found = binding.preserve(&lattice.rest(), &Preserve::default(), &mut out);
    assert!(matches!(&found, Err(Error::Volume(text)) if text.contains("body 1 as bound")), "{found:?}");
}

#[test]
fn threads_and_update_change_nothing_of_bodies() {
    let mesh = three_islands();
    let lattice = slanted(bases().swap_remove(3).1);
    let control = shaken(&lattice, 8);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut out = mesh.vertices.clone();
            let mut binding = bind(&lattice, &mesh, Bodies::Islands, false);
            binding.update(Some(mesh.vertices.clone()), None, None, None).unwrap();
            binding.preserve(&control, &Preserve::default(), &mut out).unwrap();
            out
        })
    };
    assert_eq!(run(1), run(3));
}
