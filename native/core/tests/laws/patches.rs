// SPDX-License-Identifier: GPL-3.0-or-later
//! Bézier patches: evaluated as de Casteljau does, closed at every level, and their volume kept by their control points alone.

use std::collections::HashSet;

use crate::shared::patch_model::urn;
use crate::shared::{noise, slanted, volume};
use isochor_core::{
    AxisBasis, Bind, Binding, Bodies, ClosedSurface, DVec3, Error, Lattice, Method, Patches, PinPoint, Pins,
    Preserve, Surface, Tessellation,
};

/// De Casteljau's scheme.
fn casteljau(mut points: Vec<DVec3>, t: f64) -> DVec3 {
    while points.len() > 1 {
        points = points.windows(2).map(|two| two[0].lerp(two[1], t)).collect();
    }
    points[0]
}

fn by_casteljau(patches: &Patches, patch: usize, [u, v]: [f64; 2]) -> DVec3 {
    let rows = patches.patch(patch).chunks(patches.shape()[1]);
    let at = |&p: &u32| patches.points()[p as usize];
    casteljau(rows.map(|row| casteljau(row.iter().map(at).collect(), v)).collect(), u)
}

fn places(patches: &Patches, count: usize) -> Vec<(u32, [f64; 2])> {
    let mut random = noise(5);
    let mut place = |i: usize| ((i % patches.len()) as u32, [0, 1].map(|_| 0.5 + 0.5 * random()));
    (0..count).map(&mut place).collect()
}

#[test]
fn patches_are_where_de_casteljau_puts_them() {
    for degree in [1, 2, 3, 7, 24] {
        let patches = urn(degree, 2);
        let places = places(&patches, 80);
        for (&(patch, uv), found) in places.iter().zip(patches.evaluate(&places).unwrap()) {
            let apart = (found - by_casteljau(&patches, patch as usize, uv)).length();
            assert!(apart < 4e-15 * degree as f64, "degree {degree}: {apart:e}");
        }
    }
}

#[test]
fn derivatives_and_normals_are_those_of_the_surface() {
    let patches = urn(3, 2);
    let places = places(&patches, 80);
    let step = 1e-6;
    let normals = patches.normals(&places).unwrap();
    for ((&(patch, [u, v]), [du, dv]), normal) in
        places.iter().zip(patches.derivatives(&places).unwrap()).zip(normals)
    {
        let slope = |a, b| {
            (by_casteljau(&patches, patch as usize, a) - by_casteljau(&patches, patch as usize, b))
                / (2.0 * step)
        };
        assert!((du - slope([u + step, v], [u - step, v])).length() < 1e-7);
        assert!((dv - slope([u, v + step], [u, v - step])).length() < 1e-7);
        assert!((normal - du.cross(dv).normalize()).length() < 1e-12);
    }
}

#[test]
fn a_collapsed_edge_has_the_normal_of_the_surface_around_it() {
    let patches = urn(3, 2);
    // The first patch runs up to the pole; so close to it the surface is flat.
    let pole = patches.normals(&[(0, [1.0, 0.3])]).unwrap()[0];
    let near = patches.normals(&[(0, [1.0 - 1e-7, 0.3])]).unwrap()[0];
    assert!((pole - near).length() < 1e-5, "{pole} {near}");
    let flat = Patches::new(vec![DVec3::ONE], [2, 2], vec![0; 4]).unwrap();
    assert_eq!(flat.normals(&[(0, [0.5, 0.5])]).unwrap()[0], DVec3::ZERO);
}

/// Area of the smallest triangle.
fn smallest(mesh: &Tessellation, vertices: &[DVec3]) -> f64 {
    let area = |&[a, b, c]: &[u32; 3]| {
        let [a, b, c] = [a, b, c].map(|v| vertices[v as usize]);
        0.5 * (b - a).cross(c - a).length()
    };
    mesh.triangles.iter().map(area).fold(f64::INFINITY, f64::min)
}

#[test]
fn a_closed_model_is_a_closed_mesh_at_every_level() {
    let patches = urn(3, 2);
    for level in 1..=9 {
        let mesh = patches.tessellate(level).unwrap();
        let vertices = mesh.surface.apply(patches.points()).unwrap();
        ClosedSurface::new(vertices.len(), &mesh.triangles).unwrap();
        assert!(smallest(&mesh, &vertices) > 0.0);
        // A sphere: vertices - edges + triangles, where every triangle has three halves of edges.
        assert_eq!(vertices.len() as i64 - mesh.triangles.len() as i64 / 2, 2);
        let used: HashSet<u32> = mesh.triangles.iter().flatten().copied().collect();
        assert_eq!(used.len(), vertices.len());
        let by_place: Vec<(u32, [f64; 2])> =
            mesh.patch_of_vertex.iter().copied().zip(mesh.parameters.iter().copied()).collect();
        for (vertex, place) in vertices.iter().zip(patches.evaluate(&by_place).unwrap()) {
            assert!((*vertex - place).length() < 1e-14);
        }
        let three = mesh.quads.iter().filter(|quad| quad[3] == isochor_core::NO_CORNER).count();
        assert_eq!((mesh.quads.len(), three), (8 * level * level, 8 * level));
        assert_eq!(mesh.patch_of_quad.len(), mesh.quads.len());
    }
}

#[test]
fn finer_meshes_come_closer_to_the_volume_of_the_patches() {
    let patches = urn(3, 2);
    let at = |level: usize| {
        let mesh = patches.tessellate(level).unwrap();
        let vertices = mesh.surface.apply(patches.points()).unwrap();
        volume(&vertices.iter().map(|p| p.to_array()).collect::<Vec<_>>(), &mesh.triangles)
    };
    let [coarse, middle, fine] = [8, 16, 32].map(at);
    // The error falls with the square of the level.
    let ratio = (middle - coarse) / (fine - middle);
    assert!((3.8..4.2).contains(&ratio), "{ratio}");
}

#[test]
fn what_has_one_side_only_is_refused() {
    let points: Vec<DVec3> =
        (0..6).map(|i| DVec3::new(f64::from(i), f64::from(i * i), f64::from(i % 2))).collect();
    // A strip of three bilinear patches whose ends meet turned over.
    let band = Patches::new(points, [2, 2], vec![0, 1, 2, 3, 2, 3, 4, 5, 4, 5, 1, 0]).unwrap();
    let Err(Error::Mesh(text)) = band.tessellate(2) else { unreachable!("a Möbius band was wound") };
    assert!(text.contains("cannot be wound alike"), "{text}");
    assert!(band.tessellate(0).is_err() && band.tessellate(1025).is_err());
}

fn lattices() -> Vec<Lattice> {
    let cubic = |n| AxisBasis::uniform(n, 3).unwrap();
    let bernstein = |n| AxisBasis::bernstein(n).unwrap();
    vec![slanted([bernstein(4), bernstein(4), bernstein(4)]), slanted([cubic(6), cubic(5), bernstein(3)])]
}

fn squashed(lattice: &Lattice) -> Vec<DVec3> {
    let mut random = noise(3);
    let mut jitter = || 0.05 * DVec3::new(random(), random(), random());
    lattice.rest().iter().map(|p| *p * DVec3::new(0.8, 1.1, 0.5) + jitter()).collect()
}

fn bound<T: isochor_core::Scalar>(
    lattice: &Lattice,
    points: &[DVec3],
    mesh: &Tessellation,
    options: Bind,
) -> Binding<T> {
    let points = points.iter().map(|p| p.to_array().map(T::from_f64)).collect();
    let options = Bind { surface: Some(mesh.surface.clone()), ..options };
    Binding::with(lattice.clone(), points, mesh.triangles.clone(), options).unwrap()
}

fn surface_volume(mesh: &Tessellation, points: &[[f64; 3]]) -> f64 {
    let points: Vec<DVec3> = points.iter().map(|p| DVec3::from_array(*p)).collect();
    let vertices = mesh.surface.apply(&points).unwrap();
    volume(&vertices.iter().map(|p| p.to_array()).collect::<Vec<_>>(), &mesh.triangles)
}

#[test]
fn the_volume_of_the_tessellation_is_kept_by_the_control_points() {
    let patches = urn(3, 2);
    let mesh = patches.tessellate(6).unwrap();
    for lattice in lattices() {
        let binding: Binding<f64> = bound(&lattice, patches.points(), &mesh, Bind::default());
        let wanted = binding.reference().unwrap().volume;
        let start: Vec<[f64; 3]> = patches.points().iter().map(|p| p.to_array()).collect();
        assert!((wanted / surface_volume(&mesh, &start) - 1.0).abs() < 1e-13);
        let control = squashed(&lattice);
        let frame = [DVec3::new(1.0, 1.0, 0.0), DVec3::new(-4.0, 4.0, 1.0), DVec3::new(0.5, 0.0, -3.0)];
        for method in [Method::Sweep, Method::Balanced, Method::Gradient, Method::Nearest] {
            for frame in [None, Some(frame)] {
                let options = Preserve { method, frame, ..Preserve::default() };
                let mut out = vec![[0.0; 3]; start.len()];
                let found = binding.preserve(&control, &options, &mut out).unwrap();
                let error = (surface_volume(&mesh, &out) / wanted - 1.0).abs();
                assert!(error < 1e-13, "{method:?}: {error:e}");
                // The points are the lattice's: nothing but its control points moved.
                let mut again = out.clone();
                binding.deform(&found.control, &mut again).unwrap();
                assert_eq!(again, out);
                let places = binding.surface_over(&out).unwrap().unwrap();
                assert_eq!(places.len(), mesh.surface.len());
            }
        }
    }
}

#[test]
fn coefficients_are_the_change_of_the_volume_with_each_control_point() {
    let patches = urn(2, 2);
    let mesh = patches.tessellate(3).unwrap();
    let lattice = &lattices()[0];
    let binding: Binding<f64> = bound(lattice, patches.points(), &mesh, Bind::default());
    let control = squashed(lattice);
    let before = binding.volume(&control).unwrap();
    // One point alone may move, so the sweep's step is the missing volume over its coefficient.
    let mut weights = vec![f64::INFINITY; lattice.len()];
    weights[21] = 1.0;
    let target = before * 1.001;
    let options = Preserve {
        axes: [0.0, 1.0, 0.0],
        method: Method::Sweep,
        weights: Some(weights),
        target: Some(vec![target]),
        ..Preserve::default()
    };
    let mut out = vec![[0.0; 3]; patches.points().len()];
    let found = binding.preserve(&control, &options, &mut out).unwrap();
    let step = found.control[21].y - control[21].y;
    let nudge = 1e-3;
    let mut moved = control.clone();
    moved[21].y += nudge;
    let slope = (binding.volume(&moved).unwrap() - before) / nudge;
    assert!((step * slope / (target - before) - 1.0).abs() < 1e-9);
}

#[test]
fn pins_hold_vertices_of_the_surface() {
    let patches = urn(3, 2);
    let mesh = patches.tessellate(5).unwrap();
    let lattice = &lattices()[1];
    let binding: Binding<f64> = bound(lattice, patches.points(), &mesh, Bind::default());
    let rest = mesh.surface.apply(patches.points()).unwrap();
    let (a, b) = (7, rest.len() / 2);
    let [p, q, r] = mesh.triangles[40].map(|v| rest[v as usize]);
    let middle = p * 0.2 + q * 0.3 + r * 0.5;
    let pins = Pins {
        points: vec![
            PinPoint::Vertex(a as u32),
            PinPoint::Vertex(b as u32),
            PinPoint::Face(40, [0.2, 0.3, 0.5]),
        ],
        targets: vec![rest[a] + DVec3::new(0.05, 0.0, 0.02), rest[b], middle],
    };
    let options = Preserve { pins: pins.clone(), ..Preserve::default() };
    let mut out = vec![[0.0; 3]; patches.points().len()];
    binding.preserve(&squashed(lattice), &options, &mut out).unwrap();
    assert!(binding.largest_miss(&pins, &out).unwrap() < 1e-12);
    let places = binding.surface_over(&out).unwrap().unwrap();
    assert!((places[a] - pins.targets[0]).length() < 1e-12);
    let [p, q, r] = mesh.triangles[40].map(|v| places[v as usize]);
    assert!((p * 0.2 + q * 0.3 + r * 0.5 - middle).length() < 1e-12);
    let wanted = binding.reference().unwrap().volume;
    assert!((surface_volume(&mesh, &out) / wanted - 1.0).abs() < 1e-13);
    let beyond = Pins { points: vec![PinPoint::Vertex(rest.len() as u32)], targets: vec![DVec3::ZERO] };
    let wrong = Preserve { pins: beyond, ..Preserve::default() };
    assert!(matches!(binding.preserve(&squashed(lattice), &wrong, &mut out), Err(Error::Pin(_))));
}

/// Two urns apart, one of them open at its lowest cells.
fn two() -> (Vec<DVec3>, Tessellation) {
    let patches = urn(3, 2);
    let size = patches.points().len() as u32;
    let scaled = |offset: f64| patches.points().iter().map(move |p| *p * 0.4 + DVec3::splat(offset));
    let points: Vec<DVec3> = scaled(-0.5).chain(scaled(0.5)).collect();
    let indices = patches.indices().iter().copied();
    let both = indices.clone().chain(indices.map(|i| i + size)).collect();
    let mesh = Patches::new(points.clone(), [4, 4], both).unwrap().tessellate(4).unwrap();
    (points, mesh)
}

#[test]
fn several_bodies_and_caps_over_points_keep_their_volumes() {
    let (points, mut mesh) = two();
    // The four cells around one pole go.
    let pole = mesh.surface.len() as u32 - 1;
    let pole = (0..=pole).rev().find(|&v| mesh.surface.row(v as usize).count() == 1).unwrap();
    let around = mesh.triangles.iter().filter(|corners| corners.contains(&pole)).count();
    assert!(around > 2);
    mesh.triangles.retain(|corners| !corners.contains(&pole));
    let lattice = &lattices()[1];
    let options = Bind { bodies: Bodies::Islands, caps: true, ..Bind::default() };
    let binding: Binding<f64> = bound(lattice, &points, &mesh, options);
    assert_eq!(binding.body_count(), 2);
    let wanted: Vec<f64> = binding.references().unwrap().iter().map(|body| body.volume).collect();
    let mut out = vec![[0.0; 3]; points.len()];
    for method in [Method::Balanced, Method::Gradient, Method::Nearest] {
        let options = Preserve { method, ..Preserve::default() };
        binding.preserve(&squashed(lattice), &options, &mut out).unwrap();
        for (body, wanted) in binding.measures(&out).unwrap().iter().zip(&wanted) {
            assert!((body.volume / wanted - 1.0).abs() < 1e-12, "{method:?}");
        }
    }
    // The whole with its hole capped, by triangles to the mean of the loop, told apart from what the library measures.
    let whole: Binding<f64> = bound(lattice, &points, &mesh, Bind { caps: true, ..Bind::default() });
    let target = whole.reference().unwrap().volume;
    whole.preserve(&squashed(lattice), &Preserve::default(), &mut out).unwrap();
    assert!((capped(&mesh, &out) / target - 1.0).abs() < 1e-13);
    let open: Binding<f64> = bound(lattice, &points, &mesh, Bind::default());
    assert!(matches!(open.preserve(&squashed(lattice), &Preserve::default(), &mut out), Err(Error::Mesh(_))));
}

/// Volume with the one hole closed by a fan.
fn capped(mesh: &Tessellation, points: &[[f64; 3]]) -> f64 {
    let points: Vec<DVec3> = points.iter().map(|p| DVec3::from_array(*p)).collect();
    let mut vertices: Vec<[f64; 3]> =
        mesh.surface.apply(&points).unwrap().iter().map(|p| p.to_array()).collect();
    let halves: HashSet<[u32; 2]> =
        mesh.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    let open: Vec<[u32; 2]> = halves.iter().filter(|&&[a, b]| !halves.contains(&[b, a])).copied().collect();
    let mean: DVec3 = open.iter().map(|e| DVec3::from_array(vertices[e[0] as usize])).sum();
    vertices.push((mean / open.len() as f64).to_array());
    let apex = vertices.len() as u32 - 1;
    let mut triangles = mesh.triangles.clone();
    triangles.extend(open.iter().map(|&[a, b]| [b, a, apex]));
    volume(&vertices, &triangles)
}

#[test]
fn float32_points_keep_the_volume_as_they_come_out() {
    let patches = urn(3, 2);
    let mesh = patches.tessellate(6).unwrap();
    let lattice = &lattices()[0];
    let binding: Binding<f32> = bound(lattice, patches.points(), &mesh, Bind::default());
    let wanted = binding.reference().unwrap().volume;
    let mut out = vec![[0.0f32; 3]; patches.points().len()];
    binding.preserve(&squashed(lattice), &Preserve::default(), &mut out).unwrap();
    let exact: Vec<[f64; 3]> = out.iter().map(|p| p.map(f64::from)).collect();
    assert!((surface_volume(&mesh, &exact) / wanted - 1.0).abs() < 1e-6);
}

#[test]
fn rows_that_make_no_sense_are_refused() {
    let new = Surface::new;
    for (found, part) in [
        (new(2, vec![0, 1], vec![2], vec![1.0]), "point 2 in row 0"),
        (new(2, vec![0, 1], vec![0], vec![f64::NAN]), "weight NaN in row 0"),
        (new(2, vec![0, 1, 1], vec![0], vec![1.0]), "row 1 runs from"),
        (new(2, vec![0, 2], vec![0], vec![1.0]), "offsets run from"),
        (new(2, vec![], vec![], vec![]), "offsets run from"),
        (new(2, vec![0, 1], vec![0], vec![]), "1 columns and 0 weights"),
    ] {
        let Err(Error::Mesh(text)) = found else { unreachable!("{part}: accepted") };
        assert!(text.contains(part), "{text}");
    }
    let surface = Surface::new(2, vec![0, 1, 3], vec![0, 0, 1], vec![1.0, 0.5, 0.75]).unwrap();
    assert_eq!(surface.unbalanced(), Some((1, 1, 1.25)));
    assert_eq!(surface.carry(&[1.0, 10.0, 2.0, 20.0], 2).unwrap(), [1.0, 10.0, 2.0, 20.0]);
    assert!(surface.apply(&[DVec3::ZERO]).is_err());
    let lattice = lattices().swap_remove(0);
    let bound = Binding::<f64>::with(
        lattice,
        vec![[0.0; 3]],
        Vec::new(),
        Bind { surface: Some(surface), ..Bind::default() },
    );
    assert!(matches!(bound, Err(Error::Mesh(_))));
}
