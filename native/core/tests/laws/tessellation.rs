// SPDX-License-Identifier: GPL-3.0-or-later
//! Adaptive tessellation: as close to the deformed space as it says, without cracks, and everything carried along.

use std::collections::{HashMap, HashSet};

use crate::shared::{Mesh, bases, bumpy_ball, slanted, volume};
use isochor_core::{AxisBasis, Binding, ClosedSurface, DVec3, Deformation, Error, Lattice, Outside, Refined};

/// A bar of twelve triangles, long in x.
fn bar() -> Mesh {
    let vertices = (0..8).map(|i| {
        let side = |bit: u32, size: f64| if i >> bit & 1 == 1 { size } else { -size };
        [side(0, 1.0), side(1, 0.2), side(2, 0.3)]
    });
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let halves = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    Mesh { vertices: vertices.collect(), triangles: halves.collect() }
}

fn around(mesh: &Mesh) -> Lattice {
    let points: Vec<DVec3> = mesh.vertices.iter().map(|p| DVec3::from_array(*p)).collect();
    let axes =
        [AxisBasis::bernstein(5), AxisBasis::bernstein(2), AxisBasis::bernstein(2)].map(Result::unwrap);
    Lattice::around(axes, &points, 0.0).unwrap()
}

/// Bends x into an arc of the plane of x and z.
fn bent(lattice: &Lattice, angle: f64) -> Vec<DVec3> {
    let at = |p: &DVec3| {
        let (radius, turn) = (2.0 / angle + p.z, p.x * angle / 2.0);
        DVec3::new(radius * turn.sin(), p.y, radius * turn.cos() - 2.0 / angle)
    };
    lattice.rest().iter().map(at).collect()
}

fn deformation<'a>(lattice: &'a Lattice, control: &'a [DVec3]) -> Deformation<'a> {
    Deformation { lattice, control, outside: Outside::Keep, rest: None }
}

fn edges(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let all: HashSet<[u32; 2]> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    let mut all: Vec<_> = all.into_iter().collect();
    all.sort_unstable();
    all
}

/// Largest distance of edges at their quarters and of faces' centres from the deformed space, by the lattice's own map.
fn deviation(lattice: &Lattice, control: &[DVec3], vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> f64 {
    let at = |v: u32| DVec3::from_array(vertices[v as usize]);
    let map = |p: DVec3| lattice.evaluate(&[lattice.parameter(p)], control).unwrap()[0];
    let mut largest = 0.0f64;
    for [a, b] in edges(triangles) {
        let (from, to) = (map(at(a)), map(at(b)));
        for t in [0.25, 0.5, 0.75] {
            let way = map(at(a).lerp(at(b), t)) - from;
            let along = (to - from) * (way.dot(to - from) / (to - from).length_squared()).clamp(0.0, 1.0);
            largest = largest.max((way - along).length());
        }
    }
    for face in triangles {
        let [a, b, c] = face.map(|v| map(at(v)));
        let centre = map(face.iter().map(|&v| at(v)).sum::<DVec3>() / 3.0);
        largest = largest.max((centre - a).dot((b - a).cross(c - a).normalize()).abs());
    }
    largest
}

fn split(mesh: &Mesh, lattice: &Lattice, control: &[DVec3], tolerance: f64, levels: usize) -> Refined<f64> {
    deformation(lattice, control)
        .tessellate(&mesh.vertices, &mesh.triangles, None, tolerance, levels)
        .unwrap()
}

#[test]
fn a_bent_bar_comes_as_close_as_wanted_without_cracks() {
    let mesh = bar();
    let lattice = around(&mesh);
    let control = bent(&lattice, 2.0);
    for tolerance in [0.05, 0.01, 0.001] {
        let found = split(&mesh, &lattice, &control, tolerance, 8);
        assert!(found.after <= tolerance && found.before > 0.2, "{} {}", found.before, found.after);
        let [before, after] = [(&mesh.vertices, &mesh.triangles), (&found.vertices, &found.triangles)]
            .map(|(vertices, triangles)| deviation(&lattice, &control, vertices, triangles));
        assert!((before - found.before).abs() < 1e-13 && (after - found.after).abs() < 1e-13);
        ClosedSurface::new(found.vertices.len(), &found.triangles).unwrap();
        assert_eq!(found.vertices.len() as i64 - found.triangles.len() as i64 / 2, 2);
        // The shape before the deformation is what it was.
        assert!((volume(&found.vertices, &found.triangles) / 0.48 - 1.0).abs() < 1e-13);
    }
}

#[test]
fn nothing_is_split_that_stays_straight() {
    let mesh = bar();
    let lattice = around(&mesh);
    let affine: Vec<DVec3> =
        lattice.rest().iter().map(|p| DVec3::new(p.x + p.z, 2.0 * p.y, p.z - p.x)).collect();
    let found = split(&mesh, &lattice, &affine, 1e-9, 6);
    assert_eq!((&found.vertices, &found.triangles, found.levels), (&mesh.vertices, &mesh.triangles, 0));
    // A bend of x and z leaves what runs along y as it is, so it takes far fewer than splitting everything would.
    let found = split(&mesh, &lattice, &bent(&lattice, 2.0), 0.001, 8);
    let everything = mesh.triangles.len() << (2 * found.levels);
    assert!(found.triangles.len() < everything / 4, "{} of {everything}", found.triangles.len());
}

#[test]
fn the_cap_on_levels_is_told() {
    let mesh = bar();
    let lattice = around(&mesh);
    let control = bent(&lattice, 2.0);
    for levels in 0..4 {
        let found = split(&mesh, &lattice, &control, 1e-4, levels);
        assert_eq!(found.levels, levels);
        let measured = deviation(&lattice, &control, &found.vertices, &found.triangles);
        assert!(found.after > 1e-4 && (found.after - measured).abs() < 1e-13);
    }
}

#[test]
fn vertices_are_the_combinations_of_given_ones_that_parents_say() {
    let mesh = bumpy_ball(2);
    for (name, axes) in bases() {
        let lattice = slanted(axes);
        let control: Vec<DVec3> =
            lattice.rest().iter().map(|p| *p + DVec3::new(0.0, 0.2 * p.x * p.x, 0.1 * p.y * p.x)).collect();
        let found = split(&mesh, &lattice, &control, 0.005, 4);
        let given: Vec<DVec3> = mesh.vertices.iter().map(|p| DVec3::from_array(*p)).collect();
        for (vertex, carried) in found.vertices.iter().zip(found.parents.apply(&given).unwrap()) {
            assert!((DVec3::from_array(*vertex) - carried).length() < 1e-15, "{name}");
        }
        assert_eq!(found.parents.unbalanced(), None);
        let mut areas = vec![0.0; mesh.triangles.len()];
        let normal = |at: &dyn Fn(u32) -> DVec3, [a, b, c]: [u32; 3]| (at(b) - at(a)).cross(at(c) - at(a));
        for (face, &parent) in found.triangles.iter().zip(&found.parent_triangle) {
            let corners = mesh.triangles[parent as usize];
            for &v in face {
                assert!(found.parents.row(v as usize).all(|(point, _)| corners.contains(&point)));
            }
            let own = normal(&|v| DVec3::from_array(found.vertices[v as usize]), *face);
            let parents = normal(&|v| given[v as usize], corners);
            assert!(own.dot(parents) > 0.0, "{name}: turned over");
            areas[parent as usize] += own.length() / parents.length();
        }
        assert!(
            areas.iter().all(|area| (area - 1.0).abs() < 1e-12),
            "{name}: triangles are not covered once"
        );
    }
}

/// Smallest angle of all triangles.
fn sharpest(vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> f64 {
    let at = |v: u32| DVec3::from_array(vertices[v as usize]);
    let corners = |&[a, b, c]: &[u32; 3]| [[a, b, c], [b, c, a], [c, a, b]];
    let angle = |[a, b, c]: [u32; 3]| (at(b) - at(a)).angle_between(at(c) - at(a));
    triangles.iter().flat_map(corners).map(angle).fold(f64::INFINITY, f64::min)
}

#[test]
fn corners_do_not_become_ever_sharper() {
    let mesh = bumpy_ball(1);
    let lattice = slanted(bases().swap_remove(0).1);
    let control: Vec<DVec3> =
        lattice.rest().iter().map(|p| *p + DVec3::new(0.0, 0.0, 0.5 * (2.0 * p.x).sin())).collect();
    let given = sharpest(&mesh.vertices, &mesh.triangles);
    let found = split(&mesh, &lattice, &control, 1e-4, 8);
    assert!(found.triangles.len() > 20 * mesh.triangles.len());
    assert!(sharpest(&found.vertices, &found.triangles) > 0.45 * given);
}

#[test]
fn the_same_mesh_comes_out_of_any_number_of_threads() {
    let mesh = bumpy_ball(2);
    let lattice = slanted(bases().swap_remove(2).1);
    let control = bent(&lattice, 1.0);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| split(&mesh, &lattice, &control, 0.002, 6))
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn influence_runs_from_end_to_end_of_edges() {
    let mesh = bar();
    let lattice = around(&mesh);
    let control = bent(&lattice, 2.0);
    let influence: Vec<f64> = mesh.vertices.iter().map(|p| 0.5 + 0.5 * p[2] / 0.3).collect();
    let deformation = deformation(&lattice, &control);
    let found = deformation.tessellate(&mesh.vertices, &mesh.triangles, Some(&influence), 0.005, 8).unwrap();
    let carried = found.parents.carry(&influence, 1).unwrap();
    // What has no influence stays a straight line, and no face there is split but where the others force it.
    let binding = Binding::new(
        lattice.clone(),
        found.vertices.clone(),
        found.triangles.clone(),
        Some(carried.clone()),
        Outside::Keep,
    )
    .unwrap();
    let mut out = found.vertices.clone();
    binding.deform(&control, &mut out).unwrap();
    for ((moved, vertex), influence) in out.iter().zip(&found.vertices).zip(&carried) {
        assert_eq!(*influence == 0.0, moved == vertex);
    }
    let deviations =
        deformation.edge_deviations(&found.vertices, Some(&carried), &edges(&found.triangles)).unwrap();
    assert!(deviations.iter().copied().fold(0.0, f64::max) <= found.after && found.after <= 0.005);
    let all = split(&mesh, &lattice, &control, 0.005, 8);
    assert!(found.triangles.len() < all.triangles.len());
}

#[test]
fn a_shaped_lattice_and_outside_points_count_as_in_a_binding() {
    let mesh = bar();
    let lattice = around(&mesh);
    let rest = bent(&lattice, 0.5);
    let control = bent(&lattice, 2.0);
    let at_rest =
        Deformation { lattice: &lattice, control: &rest, outside: Outside::Extend, rest: Some(&rest) };
    assert_eq!(at_rest.tessellate(&mesh.vertices, &mesh.triangles, None, 1e-9, 3).unwrap().levels, 0);
    let shaped = Deformation { control: &control, ..at_rest };
    let found = shaped.tessellate(&mesh.vertices, &mesh.triangles, None, 0.01, 8).unwrap();
    assert!(found.after <= 0.01 && found.before > 0.05, "{} {} {}", found.before, found.after, found.levels);
    let far: Vec<[f64; 3]> = mesh.vertices.iter().map(|p| [p[0] + 10.0, p[1], p[2]]).collect();
    let kept = deformation(&lattice, &control).tessellate(&far, &mesh.triangles, None, 1e-9, 3).unwrap();
    assert!(kept.before < 1e-14 && kept.levels == 0);
}

#[test]
fn edges_are_judged_alone_as_in_the_mesh() {
    let mesh = bar();
    let lattice = around(&mesh);
    let control = bent(&lattice, 2.0);
    let edges = edges(&mesh.triangles);
    let found = deformation(&lattice, &control).edge_deviations(&mesh.vertices, None, &edges).unwrap();
    let by_edge: HashMap<[u32; 2], f64> = edges.iter().copied().zip(found).collect();
    for ([a, b], deviation) in by_edge {
        let [p, q] = [a, b].map(|v| mesh.vertices[v as usize]);
        // What runs along y or z is straight in this bend, everything else is not.
        assert_eq!(deviation > 0.05, p[0] != q[0], "{a} {b}: {deviation}");
    }
    assert_eq!(deformation(&lattice, &control).edge_deviations(&mesh.vertices, None, &[]).unwrap(), []);
}

#[test]
fn what_makes_no_sense_is_refused() {
    let mesh = bar();
    let lattice = around(&mesh);
    let control = lattice.rest();
    let deformation = deformation(&lattice, &control);
    let run =
        |tolerance, levels| deformation.tessellate(&mesh.vertices, &mesh.triangles, None, tolerance, levels);
    for found in [run(0.0, 1), run(f64::NAN, 1), run(-1.0, 1), run(0.1, 13)] {
        assert!(matches!(found, Err(Error::Mesh(_))));
    }
    let repeated = deformation.tessellate(&mesh.vertices, &[[0, 1, 1]], None, 0.1, 1);
    let beyond = deformation.tessellate(&mesh.vertices, &[[0, 1, 8]], None, 0.1, 1);
    let influence = deformation.tessellate(&mesh.vertices, &mesh.triangles, Some(&[1.0]), 0.1, 1);
    assert!(repeated.is_err() && beyond.is_err() && influence.is_err());
    assert!(deformation.edge_deviations(&mesh.vertices, None, &[[0, 8]]).is_err());
    let few = Deformation { control: &control[1..], ..deformation.clone() };
    assert!(matches!(few.tessellate(&mesh.vertices, &mesh.triangles, None, 0.1, 1), Err(Error::Lattice(_))));
}
