// SPDX-License-Identifier: GPL-3.0-or-later
//! Deformation of the plane, and areas that are kept.

use crate::shared::noise;
use isochor_core::{
    AxisBasis, DMat2, DMat3, DVec2, DVec3, Lattice, Method, Outside, PinPoint, Pins, Planar, Preserve, Scalar,
};

fn bases() -> Vec<[AxisBasis; 2]> {
    let bernstein = |n| AxisBasis::bernstein(n).unwrap();
    vec![
        [bernstein(4), bernstein(3)],
        [AxisBasis::uniform(6, 3).unwrap(), AxisBasis::clamped(7, 2).unwrap()],
        [bernstein(5), bernstein(1)],
    ]
}

fn frame() -> DMat2 {
    DMat2::from_cols(DVec2::new(3.0, 0.4), DVec2::new(-0.5, 2.0))
}

fn lattice(axes: [AxisBasis; 2]) -> Lattice {
    Lattice::planar(axes, DVec2::new(-0.3, 0.2), frame()).unwrap()
}

type Mesh = (Vec<[f64; 2]>, Vec<[u32; 3]>);

/// A grid of squares in the middle of the lattice, those left out for which `hole` says so.
fn grid(n: u32, hole: impl Fn(u32, u32) -> bool) -> Mesh {
    let at = |i: u32| 0.1 + 0.8 * f64::from(i) / f64::from(n);
    let point = |k: u32| DVec2::new(-0.3, 0.2) + frame() * DVec2::new(at(k / (n + 1)), at(k % (n + 1)));
    let vertices = (0..(n + 1) * (n + 1)).map(|k| point(k).to_array()).collect();
    let squares = (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).filter(|&(i, j)| !hole(i, j));
    let triangles = squares.flat_map(|(i, j)| {
        let [a, b, c, d] = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| i * (n + 1) + j);
        [[a, b, c], [a, c, d]]
    });
    (vertices, triangles.collect())
}

/// Grids without a hole, with two, with squares that meet at corners only, and of two parts.
fn meshes() -> Vec<Mesh> {
    vec![
        grid(8, |_, _| false),
        grid(9, |i, j| (i, j) == (4, 4) || (1..3).contains(&i) && j == 2),
        grid(6, |i, j| (i + j) % 2 == 0),
        grid(7, |i, _| i == 3),
    ]
}

fn shoelace<T: Scalar>(vertices: &[[T; 2]], triangles: &[[u32; 3]]) -> f64 {
    let at = |v: u32| DVec2::from_array(vertices[v as usize].map(T::to_f64));
    triangles.iter().map(|&[a, b, c]| (at(b) - at(a)).perp_dot(at(c) - at(a)) / 2.0).sum()
}

fn flat<T: Scalar>(planar: &Planar<T>, rows: &[[T; 3]]) -> Vec<[T; 2]> {
    rows[..planar.count()].iter().map(|&[x, y, _]| [x, y]).collect()
}

fn deformed(planar: &Planar<f64>, control: &[DVec3]) -> Vec<[f64; 2]> {
    let mut rows = vec![[0.0; 3]; planar.binding().vertices().len()];
    planar.binding().deform(control, &mut rows).unwrap();
    flat(planar, &rows)
}

fn bent(lattice: &Lattice, amount: f64, seed: u64) -> Vec<DVec3> {
    let mut random = noise(seed);
    lattice.rest().iter().map(|p| p + amount * DVec3::new(random(), random(), 0.0)).collect()
}

fn planar_preserve(method: Method, axes: [f64; 2]) -> Preserve {
    Preserve { axes: [axes[0], axes[1], 0.0], method, ..Preserve::default() }
}

#[test]
fn rest_is_the_identity_and_affine_maps_are_reproduced() {
    for axes in bases() {
        let lattice = lattice(axes);
        assert!(lattice.rest().iter().all(|p| p.z == 0.0));
        let (vertices, triangles) = grid(8, |_, _| false);
        let planar = Planar::new(lattice.clone(), &vertices, triangles, None, Outside::Keep).unwrap();
        assert_eq!(deformed(&planar, &lattice.rest()), vertices);
        let turn = DMat3::from_cols(DVec3::new(0.3, 1.0, 0.0), DVec3::new(-1.2, 0.5, 0.0), DVec3::Z);
        // An axis with one point follows in displacements: no linear part across it.
        if lattice.shape()[1] > 1 {
            let control: Vec<DVec3> = lattice.rest().iter().map(|p| turn * *p + DVec3::X).collect();
            for (found, rest) in deformed(&planar, &control).iter().zip(&vertices) {
                let expected = turn * DVec2::from_array(*rest).extend(0.0) + DVec3::X;
                assert!(DVec2::from_array(*found).distance(expected.truncate()) < 1e-13);
            }
        }
    }
}

#[test]
fn points_beyond_the_domain_stay_or_follow() {
    let lattice = lattice(bases().remove(0));
    let points: Vec<[f64; 2]> = vec![[0.5, 0.9], [-5.0, 0.0], [9.0, 9.0]];
    let moved: Vec<DVec3> = lattice.rest().iter().map(|p| p + DVec3::X).collect();
    for (outside, expected) in [(Outside::Keep, 0.0), (Outside::Extend, 1.0)] {
        let planar = Planar::new(lattice.clone(), &points, Vec::new(), None, outside).unwrap();
        let found = deformed(&planar, &moved);
        assert!((found[0][0] - 1.5).abs() < 1e-14);
        assert_eq!(found[1], [-5.0 + expected, 0.0]);
        assert_eq!(found[2], [9.0 + expected, 9.0]);
    }
}

#[test]
fn the_area_is_kept_by_every_method_and_share() {
    for axes in bases() {
        let lattice = lattice(axes);
        for (vertices, triangles) in meshes() {
            let area = shoelace(&vertices, &triangles);
            let planar =
                Planar::new(lattice.clone(), &vertices, triangles.clone(), None, Outside::Keep).unwrap();
            let reference = planar.binding().reference().unwrap().volume / planar.height();
            assert!((reference / area - 1.0).abs() < 1e-13);
            assert!((planar.area(&vertices).unwrap() / area - 1.0).abs() < 1e-13);
            for method in [Method::Sweep, Method::Balanced, Method::Gradient, Method::Nearest] {
                for shares in [[1.0, 1.0], [1.0, 0.0], [0.0, 1.0], [0.2, 0.8]] {
                    let control = bent(&lattice, 0.3, 5);
                    let mut rows = vec![[0.0; 3]; planar.binding().vertices().len()];
                    let options = planar_preserve(method, shares);
                    let result = planar.binding().preserve(&control, &options, &mut rows).unwrap();
                    let found = shoelace(&flat(&planar, &rows), &triangles);
                    assert!((found / area - 1.0).abs() < 1e-12, "{method:?} {shares:?}: {found} for {area}");
                    assert!(result.control.iter().all(|p| p.z == 0.0));
                    for (row, bound) in rows.iter().zip(planar.binding().vertices()) {
                        assert_eq!(row[2], bound[2]);
                    }
                }
            }
        }
    }
}

#[test]
fn one_axis_is_corrected_by_the_closed_form() {
    // Along x alone the area is linear in the control points: delta = a c / c.c with c its gradient, by differences here.
    let lattice = lattice(bases().remove(0));
    let (vertices, triangles) = grid(6, |_, _| false);
    let planar = Planar::new(lattice.clone(), &vertices, triangles.clone(), None, Outside::Keep).unwrap();
    let control = bent(&lattice, 0.4, 9);
    let before = shoelace(&deformed(&planar, &control), &triangles);
    let gradient: Vec<f64> = (0..control.len())
        .map(|i| {
            let mut moved = control.clone();
            moved[i].x += 1.0;
            shoelace(&deformed(&planar, &moved), &triangles) - before
        })
        .collect();
    let length: f64 = gradient.iter().map(|c| c * c).sum();
    let missing = shoelace(&vertices, &triangles) - before;
    let mut rows = vec![[0.0; 3]; planar.binding().vertices().len()];
    let options = planar_preserve(Method::Sweep, [1.0, 0.0]);
    let result = planar.binding().preserve(&control, &options, &mut rows).unwrap();
    for (i, c) in gradient.iter().enumerate() {
        let expected = control[i].x + missing * c / length;
        assert!((result.control[i].x - expected).abs() < 1e-12);
        assert_eq!(result.control[i].y, control[i].y);
    }
}

#[test]
fn size_and_place_of_the_plane_do_not_matter() {
    for (size, place) in [(1e-4, 0.0), (1e5, 0.0), (1.0, 1e4), (1e-3, 1.0)] {
        let offset = DVec2::splat(place);
        let scaled =
            Lattice::planar(bases().remove(0), offset + DVec2::new(-0.3, 0.2) * size, frame() * size)
                .unwrap();
        let (vertices, triangles) = grid(8, |i, j| i == j);
        let vertices: Vec<[f64; 2]> =
            vertices.iter().map(|&v| (offset + DVec2::from_array(v) * size).to_array()).collect();
        let planar = Planar::new(scaled.clone(), &vertices, triangles, None, Outside::Keep).unwrap();
        let area = planar.area(&vertices).unwrap();
        let mut rows = vec![[0.0; 3]; planar.binding().vertices().len()];
        let control = bent(&scaled, 0.3 * size, 3);
        planar
            .binding()
            .preserve(&control, &planar_preserve(Method::Balanced, [1.0, 1.0]), &mut rows)
            .unwrap();
        let found = planar.area(&flat(&planar, &rows)).unwrap();
        // Stored coordinates carry errors of epsilon of where they stand.
        let tolerance = 1e-12 + 4.0 * f64::EPSILON * (1.0 + place / size);
        assert!((found / area - 1.0).abs() < tolerance, "{size} {place}: {:e}", found / area - 1.0);
    }
}

#[test]
fn float32_points_keep_their_area_to_a_millionth() {
    let lattice = lattice(bases().remove(1));
    let (vertices, triangles) = grid(20, |i, j| (i, j) == (3, 3));
    let vertices: Vec<[f32; 2]> = vertices.iter().map(|v| v.map(|c| c as f32)).collect();
    let planar = Planar::new(lattice.clone(), &vertices, triangles.clone(), None, Outside::Keep).unwrap();
    let mut rows = vec![[0.0_f32; 3]; planar.binding().vertices().len()];
    let control = bent(&lattice, 0.3, 21);
    planar.binding().preserve(&control, &planar_preserve(Method::Balanced, [1.0, 1.0]), &mut rows).unwrap();
    let found = shoelace(&flat(&planar, &rows), &triangles);
    assert!((found / shoelace(&vertices, &triangles) - 1.0).abs() < 1e-6);
}

#[test]
fn pins_and_influence_and_amount_work_in_the_plane() {
    let lattice = lattice(bases().remove(0));
    let (vertices, triangles) = grid(8, |_, _| false);
    let influence = vec![0.5; vertices.len()];
    let half =
        Planar::new(lattice.clone(), &vertices, triangles.clone(), Some(influence), Outside::Keep).unwrap();
    let control = bent(&lattice, 0.3, 33);
    let planar = Planar::new(lattice, &vertices, triangles, None, Outside::Keep).unwrap();
    let (whole, halved) = (deformed(&planar, &control), deformed(&half, &control));
    for ((rest, whole), half) in vertices.iter().zip(&whole).zip(&halved) {
        assert!((half[0] - (rest[0] + whole[0]) / 2.0).abs() < 1e-14);
    }
    let target = DVec2::from_array(vertices[40]) + 0.1;
    let pins = Pins { points: vec![PinPoint::Vertex(40)], targets: vec![planar.lifted(target)] };
    for amount in [0.0, 1.0] {
        let options =
            Preserve { pins: pins.clone(), amount, ..planar_preserve(Method::Balanced, [1.0, 1.0]) };
        let mut rows = vec![[0.0; 3]; planar.binding().vertices().len()];
        planar.binding().preserve(&control, &options, &mut rows).unwrap();
        let found = flat(&planar, &rows);
        assert!(DVec2::from_array(found[40]).distance(target) < 1e-13);
        let kept = planar.area(&found).unwrap() / planar.area(&vertices).unwrap();
        assert_eq!((kept - 1.0).abs() < 1e-12, amount == 1.0);
    }
}

#[test]
fn what_is_no_flat_mesh_is_refused_by_name() {
    let lattice = lattice(bases().remove(0));
    let points = [[0.5, 0.5], [1.0, 0.5], [1.0, 1.0], [0.5, 1.0]];
    let message = |triangles: Vec<[u32; 3]>| {
        let planar = Planar::new(lattice.clone(), &points, triangles, None, Outside::Keep);
        planar.err().map(|error| error.to_string()).unwrap_or_default()
    };
    assert!(message(vec![[0, 1, 2], [0, 2, 3]]).is_empty());
    assert!(message(vec![[0, 1, 2], [0, 3, 2]]).contains("edge 2-0 is used more than once in one direction"));
    assert!(message(vec![[0, 1, 2], [2, 0, 3], [0, 1, 3]]).contains("edge 0-1 is used more than once"));
    assert!(message(vec![[0, 1, 1]]).contains("repeat a vertex"));
    assert!(message(vec![[0, 1, 4]]).contains("out of range"));
    let line = DMat2::from_cols(DVec2::X, DVec2::X);
    let flat = Lattice::planar(bases().remove(0), DVec2::ZERO, line);
    assert!(flat.unwrap_err().to_string().contains("on one line"));
    let points_only = Planar::new(lattice.clone(), &points, Vec::new(), None, Outside::Keep).unwrap();
    assert!(points_only.area(&points).unwrap_err().to_string().contains("triangles: found none"));
}
