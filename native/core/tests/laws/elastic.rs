// SPDX-License-Identifier: GPL-3.0-or-later
//! Laws of motion that the elastic lattice obeys.

use crate::shared::{Mesh, bumpy_ball};
use isochor_core::elastic::{Carried, Elastic, Ground, Material, Start};
use isochor_core::{AxisBasis, DMat3, DVec3, Error, Lattice, Outside};

const FRAME: f64 = 1.0 / 24.0;
const DOWN: DVec3 = DVec3::new(0.0, 0.0, -9.81);

fn cube(shape: [usize; 3]) -> Lattice {
    let axes = shape.map(|count| AxisBasis::bernstein(count).unwrap());
    Lattice::new(axes, DVec3::splat(-1.25), DMat3::IDENTITY * 2.5).unwrap()
}

fn material() -> Material {
    Material { frequency: 2.0, damping: 0.0, gravity: DVec3::ZERO, ground: None, volume: 1.0, substeps: 8 }
}

fn floor(height: f64, friction: f64) -> Option<Ground> {
    Some(Ground { point: DVec3::new(0.0, 0.0, height), normal: DVec3::Z, friction })
}

/// A symmetric ball.
fn ball() -> Mesh {
    let mut mesh = bumpy_ball(3);
    for vertex in &mut mesh.vertices {
        *vertex = DVec3::from_array(*vertex).normalize().to_array();
    }
    mesh
}

fn body(
    lattice: &Lattice,
    material: Material,
    mesh: &Mesh,
    control: Vec<DVec3>,
    velocity: Vec<DVec3>,
) -> Elastic {
    let carried = Carried {
        vertices: &mesh.vertices,
        triangles: &mesh.triangles,
        influence: None,
        outside: Outside::Extend,
    };
    let pinned = vec![false; control.len()];
    Elastic::new(lattice, material, carried, Start { control, velocity, pinned }).unwrap()
}

fn resting(lattice: &Lattice, material: Material, mesh: &Mesh) -> Elastic {
    body(lattice, material, mesh, lattice.rest(), vec![DVec3::ZERO; lattice.len()])
}

/// Vectors within a cube of half side `amount`.
fn noise(count: usize, amount: f64, seed: u64) -> Vec<DVec3> {
    let mut number = crate::shared::noise(seed);
    (0..count).map(|_| DVec3::new(number(), number(), number()) * amount).collect()
}

fn disturbed(lattice: &Lattice, amount: f64, seed: u64) -> Vec<DVec3> {
    let noise = noise(lattice.len(), amount, seed);
    lattice.rest().iter().zip(noise).map(|(rest, n)| *rest + n).collect()
}

fn energy(body: &Elastic) -> f64 {
    body.totals().energy.iter().sum()
}

#[test]
fn free_fall_is_the_exact_parabola() {
    let lattice = cube([4, 4, 4]);
    let start = DVec3::new(1.5, -0.5, 3.0);
    let material = Material { gravity: DOWN, ..material() };
    let mut falling = body(&lattice, material, &ball(), disturbed(&lattice, 0.2, 3), vec![start; 64]);
    let centre = falling.totals().centre;
    for frame in 1..=24 {
        falling.step(FRAME, None).unwrap();
        let t = f64::from(frame) * FRAME;
        let expected = centre + start * t + DOWN * (0.5 * t * t);
        assert!(falling.totals().centre.distance(expected) < 1e-11, "frame {frame}");
    }
}

#[test]
fn rest_stays_at_rest() {
    for shape in [[4, 4, 4], [2, 3, 5], [1, 4, 4], [4, 1, 1], [1, 1, 1], [2, 2, 2]] {
        let lattice = cube(shape);
        let mut still = resting(&lattice, material(), &ball());
        (0..48).for_each(|_| still.step(FRAME, None).unwrap());
        let moved =
            still.control().iter().zip(lattice.rest()).map(|(p, r)| p.distance(r)).fold(0.0, f64::max);
        assert!(moved < 1e-11, "{shape:?}: {moved:e}");
    }
}

#[test]
fn momentum_and_spin_are_kept_without_a_ground() {
    let lattice = cube([4, 4, 4]);
    let velocity = noise(64, 1.0, 9);
    let mut free = body(&lattice, material(), &ball(), disturbed(&lattice, 0.1, 4), velocity);
    let start = free.totals();
    for _ in 0..48 {
        free.step(FRAME, None).unwrap();
        let now = free.totals();
        assert!(now.momentum.distance(start.momentum) < 1e-11 * start.mass);
        assert!(
            now.angular_momentum.distance(start.angular_momentum) < 1e-9 * start.angular_momentum.length()
        );
    }
}

#[test]
fn what_turns_goes_on_turning_with_its_volume() {
    let lattice = cube([4, 4, 4]);
    let spin = DVec3::new(0.3, 0.4, 2.0);
    let velocity = lattice.rest().iter().map(|p| spin.cross(*p)).collect();
    let mut turning =
        body(&lattice, Material { damping: 0.1, ..material() }, &ball(), lattice.rest(), velocity);
    let start = turning.totals().angular_momentum;
    for _ in 0..96 {
        turning.step(FRAME, None).unwrap();
        assert!((turning.volume_ratio().unwrap() - 1.0).abs() < 1e-6);
    }
    let end = turning.totals().angular_momentum;
    assert!(end.distance(start) < 1e-2 * start.length(), "{start} {end}");
}

#[test]
fn energy_does_not_grow_and_damping_brings_rest() {
    for (damping, shape) in [(0.0, [4, 4, 4]), (0.1, [4, 4, 4]), (1.0, [3, 5, 4])] {
        let lattice = cube(shape);
        let material = Material { damping, gravity: DOWN, ground: floor(-2.5, 0.5), ..material() };
        let mut dropped = resting(&lattice, material, &ball());
        let start = energy(&dropped);
        let mut most = f64::NEG_INFINITY;
        for _ in 0..24 * 12 {
            dropped.step(FRAME, None).unwrap();
            most = most.max(energy(&dropped));
        }
        let drop = 9.81 * 1.5 * dropped.totals().mass;
        assert!(
            most - start < 2e-2 * drop,
            "damping {damping}: {} of the drop's energy gained",
            (most - start) / drop
        );
        let [kinetic, ..] = dropped.totals().energy;
        if damping > 0.0 {
            assert!(kinetic < 1e-3 * drop, "damping {damping}: {:e} {:?}", kinetic / drop, dropped.totals());
        }
    }
}

#[test]
fn the_surface_stays_above_the_ground_and_keeps_its_volume() {
    for frequency in [0.5, 2.0, 8.0] {
        let lattice = cube([4, 4, 4]);
        let material =
            Material { frequency, damping: 0.1, gravity: DOWN, ground: floor(-4.0, 0.5), ..material() };
        let mut dropped = resting(&lattice, material, &ball());
        let (mut lowest, mut worst) = (f64::INFINITY, 0.0_f64);
        for _ in 0..24 * 4 {
            dropped.step(FRAME, None).unwrap();
            lowest = lowest.min(dropped.lowest().unwrap());
            worst = worst.max((dropped.volume_ratio().unwrap() - 1.0).abs());
        }
        assert!(lowest > -1e-3 && lowest < 0.05, "{frequency} Hz: {lowest}");
        assert!(worst < 5e-3, "{frequency} Hz: volume off by {worst}");
        assert!(dropped.lowest().unwrap() < 1e-3, "{frequency} Hz: floats {}", dropped.lowest().unwrap());
    }
}

#[test]
fn a_symmetric_drop_stays_symmetric() {
    let lattice = cube([4, 4, 4]);
    let material = Material { damping: 0.05, gravity: DOWN, ground: floor(-2.0, 0.5), ..material() };
    let mut dropped = resting(&lattice, material, &ball());
    (0..72).for_each(|_| dropped.step(FRAME, None).unwrap());
    let control = dropped.control();
    let mut worst = 0.0_f64;
    for i in 0..4 {
        for j in 0..4 {
            for k in 0..4 {
                let here = control[(i * 4 + j) * 4 + k];
                let mirrored = control[((3 - i) * 4 + j) * 4 + k] * DVec3::new(-1.0, 1.0, 1.0);
                worst = worst.max(here.distance(mirrored));
            }
        }
    }
    assert!(worst < 2e-3, "{worst}");
    assert!(dropped.totals().centre.truncate().length() < 1e-3);
}

#[test]
fn the_slowest_stretch_has_the_frequency_asked_for() {
    let lattice = cube([2, 2, 9]);
    let nothing = Mesh { vertices: vec![], triangles: vec![] };
    // The free-free mode cos(pi z / L), stretched a little and let go: it is back after one period.
    let mode = |p: &DVec3| DVec3::Z * (std::f64::consts::PI * (p.z + 1.25) / 2.5).cos();
    let control: Vec<DVec3> = lattice.rest().iter().map(|p| *p + mode(p) * 0.02).collect();
    let mut bar = body(&lattice, material(), &nothing, control, vec![DVec3::ZERO; lattice.len()]);
    let along = |bar: &Elastic| -> f64 {
        bar.control().iter().zip(lattice.rest()).map(|(p, r)| (*p - r).dot(mode(&r))).sum()
    };
    let (mut before, mut crossings) = (along(&bar), vec![]);
    for step in 1..=400 {
        bar.step(0.005, None).unwrap();
        let now = along(&bar);
        if before.signum() != now.signum() {
            crossings.push(0.005 * (f64::from(step) - now.abs() / (now.abs() + before.abs())));
        }
        before = now;
    }
    let half_period = (crossings[crossings.len() - 1] - crossings[0]) / (crossings.len() - 1) as f64;
    assert!((0.5 / half_period - 2.0).abs() < 0.03, "{} Hz", 0.5 / half_period);
}

#[test]
fn friction_brings_a_sliding_body_to_rest_and_ice_does_not() {
    let slid = |friction: f64| {
        let lattice = cube([3, 3, 3]);
        let side = |corner: u32, axis: u32| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
        let vertices = (0..8).map(|corner| [0, 1, 2].map(|axis| side(corner, axis))).collect();
        let mesh = Mesh { vertices, triangles: vec![] };
        let material = Material {
            frequency: 10.0,
            damping: 0.5,
            gravity: DOWN,
            ground: floor(-1.0, friction),
            ..material()
        };
        let mut sliding = body(&lattice, material, &mesh, lattice.rest(), vec![DVec3::X * 2.0; 27]);
        (0..48).for_each(|_| sliding.step(FRAME, None).unwrap());
        (sliding.totals().centre.x, sliding.totals().momentum.x / sliding.totals().mass)
    };
    let (far, speed) = slid(0.0);
    assert!((far - 4.0).abs() < 1e-6 && (speed - 2.0).abs() < 1e-6, "{far} {speed}");
    // A rigid block: v² / (2 μ g) = 0.51 m.
    let (near, speed) = slid(0.4);
    assert!((0.35..0.7).contains(&near) && speed.abs() < 0.05, "{near} {speed}");
}

#[test]
fn pinned_points_go_where_they_are_led_and_carry_the_rest_along() {
    let lattice = cube([4, 4, 4]);
    let pinned: Vec<bool> = lattice.rest().iter().map(|p| p.z > 1.0).collect();
    let mesh = ball();
    let carried = Carried {
        vertices: &mesh.vertices,
        triangles: &mesh.triangles,
        influence: None,
        outside: Outside::Extend,
    };
    let start = Start { control: lattice.rest(), velocity: vec![DVec3::ZERO; 64], pinned: pinned.clone() };
    let material = Material { frequency: 6.0, damping: 0.5, gravity: DOWN, ..material() };
    let mut hung = Elastic::new(&lattice, material, carried, start).unwrap();
    for frame in 1..=72 {
        let shift = DVec3::X * (f64::from(frame.min(24)) / 24.0);
        let targets: Vec<DVec3> = lattice.rest().iter().map(|p| *p + shift).collect();
        hung.step(FRAME, Some(&targets)).unwrap();
        let off = hung.control().iter().zip(&targets).zip(&pinned).filter(|(_, pinned)| **pinned);
        assert!(off.map(|((p, t), _)| p.distance(*t)).fold(0.0, f64::max) < 1e-15);
    }
    let rest = lattice.rest();
    let sag = hung.control().iter().zip(&rest).map(|(p, r)| r.z - p.z).fold(0.0, f64::max);
    assert!((hung.totals().centre.x - 1.0).abs() < 0.05, "{}", hung.totals().centre.x);
    assert!((0.01..0.5).contains(&sag), "{sag}");
}

#[test]
fn flat_inverted_and_crumpled_starts_recover() {
    let lattice = cube([4, 4, 4]);
    let starts: Vec<(&str, Vec<DVec3>)> = vec![
        ("flat", lattice.rest().iter().map(|p| *p * DVec3::new(1.0, 1.0, 0.0)).collect()),
        ("a point", vec![DVec3::ZERO; 64]),
        ("a mirror image", lattice.rest().iter().map(|p| *p * DVec3::new(1.0, 1.0, -1.0)).collect()),
        ("a half turn", lattice.rest().iter().map(|p| *p * DVec3::new(-1.0, -1.0, 1.0)).collect()),
        ("crumpled", disturbed(&lattice, 3.0, 5)),
        ("below the ground", lattice.rest().iter().map(|p| *p - DVec3::Z * 6.0).collect()),
        ("huge", lattice.rest().iter().map(|p| *p * 100.0).collect()),
    ];
    for (name, control) in starts {
        let material = Material { damping: 0.2, gravity: DOWN, ground: floor(-2.0, 0.5), ..material() };
        let mut body = body(&lattice, material, &ball(), control, vec![DVec3::ZERO; 64]);
        for _ in 0..96 {
            body.step(FRAME, None).unwrap();
            let reach = body.control().iter().map(|p| p.length()).fold(0.0, f64::max);
            assert!(reach.is_finite() && reach < 1e5, "{name}: {reach:e}");
        }
        assert!(body.lowest().unwrap() > -0.01, "{name}: {}", body.lowest().unwrap());
    }
}

#[test]
fn no_setting_in_range_explodes() {
    for shape in [[2, 2, 2], [4, 4, 4], [1, 5, 5], [7, 3, 2]] {
        for frequency in [0.1, 2.0, 50.0] {
            for damping in [0.0, 2.0] {
                let lattice = cube(shape);
                let material = Material {
                    frequency,
                    damping,
                    gravity: DOWN * 3.0,
                    ground: floor(-1.5, 1.0),
                    ..material()
                };
                let velocity = noise(lattice.len(), 20.0, 8);
                let mut body = body(&lattice, material, &ball(), disturbed(&lattice, 0.5, 2), velocity);
                let start = energy(&body) + 30.0 * 1.5 * body.totals().mass;
                for _ in 0..12 {
                    body.step(FRAME, None).unwrap();
                }
                let end = energy(&body) + 30.0 * 1.5 * body.totals().mass;
                assert!(
                    end < 1.3 * start,
                    "{shape:?} {frequency} Hz, damping {damping}: {start:e} to {end:e}"
                );
            }
        }
    }
}

#[test]
fn the_same_bits_on_any_number_of_threads() {
    let run = |threads: usize| {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| {
            let lattice = cube([9, 9, 9]);
            let material = Material { damping: 0.1, gravity: DOWN, ground: floor(-1.2, 0.5), ..material() };
            let mut body = body(&lattice, material, &ball(), disturbed(&lattice, 0.1, 2), noise(729, 1.0, 1));
            (0..6).for_each(|_| body.step(FRAME, None).unwrap());
            body.control().iter().flat_map(|p| p.to_array().map(f64::to_bits)).collect::<Vec<_>>()
        })
    };
    let once = run(1);
    assert!(once == run(1) && once == run(2) && once == run(5));
}

#[test]
fn what_is_no_material_is_refused_and_nothing_moves() {
    let lattice = cube([3, 3, 3]);
    let refused = |material: Material| {
        let carried = Carried { vertices: &[], triangles: &[], influence: None, outside: Outside::Keep };
        let velocity = vec![DVec3::ZERO; 27];
        let start = Start { control: lattice.rest(), velocity, pinned: vec![false; 27] };
        matches!(Elastic::new(&lattice, material, carried, start), Err(Error::Elastic(_)))
    };
    assert!(!refused(material()));
    assert!(refused(Material { frequency: 0.0, ..material() }));
    assert!(refused(Material { damping: f64::NAN, ..material() }));
    assert!(refused(Material { gravity: DVec3::INFINITY, ..material() }));
    assert!(refused(Material { volume: -1.0, ..material() }));
    assert!(refused(Material { substeps: 0, ..material() }));
    let flat = Ground { point: DVec3::ZERO, normal: DVec3::ZERO, friction: 0.0 };
    assert!(refused(Material { ground: Some(flat), ..material() }));
    let mut body = resting(&lattice, material(), &ball());
    assert!(matches!(body.step(0.0, None), Err(Error::Elastic(_))));
    assert!(matches!(body.step(1e9, None), Err(Error::Elastic(_))));
    assert!(matches!(body.step(FRAME, Some(&[DVec3::ZERO])), Err(Error::Lattice(_))));
    assert_eq!(body.control(), lattice.rest());
}

#[test]
fn an_open_surface_is_refused_with_its_edges() {
    let lattice = cube([3, 3, 3]);
    let mut mesh = ball();
    mesh.triangles.pop();
    let carried = Carried {
        vertices: &mesh.vertices,
        triangles: &mesh.triangles,
        influence: None,
        outside: Outside::Keep,
    };
    let start = Start { control: lattice.rest(), velocity: vec![DVec3::ZERO; 27], pinned: vec![false; 27] };
    let found = Elastic::new(&lattice, material(), carried, start);
    assert!(matches!(&found, Err(Error::Mesh(text)) if text.contains("3 edges")), "{found:?}");
}

#[test]
fn a_surface_that_encloses_nothing_is_refused() {
    let lattice = cube([3, 3, 3]);
    let mut mesh = ball();
    mesh.vertices.iter_mut().for_each(|vertex| vertex[2] = 0.0);
    let carried = Carried {
        vertices: &mesh.vertices,
        triangles: &mesh.triangles,
        influence: None,
        outside: Outside::Keep,
    };
    let start = Start { control: lattice.rest(), velocity: vec![DVec3::ZERO; 27], pinned: vec![false; 27] };
    let found = Elastic::new(&lattice, material(), carried, start);
    assert!(matches!(&found, Err(Error::Mesh(text)) if text.contains("volume")), "{found:?}");
}

#[test]
fn what_leaves_the_range_of_numbers_is_refused_and_nothing_has_moved() {
    let lattice = cube([3, 3, 3]);
    let wild = Material { gravity: DVec3::splat(1e300), ..material() };
    let mut body = resting(&lattice, wild, &ball());
    assert!(matches!(body.step(FRAME, None), Err(Error::Elastic(_))));
    assert_eq!((body.control(), body.time()), (&lattice.rest()[..], 0.0));
    assert!(body.velocity().iter().all(|velocity| *velocity == DVec3::ZERO));

    let mut pinned = vec![false; 27];
    pinned[0] = true;
    let carried = Carried { vertices: &[], triangles: &[], influence: None, outside: Outside::Keep };
    let start = Start { control: lattice.rest(), velocity: vec![DVec3::X; 27], pinned };
    let mut tried = Elastic::new(&lattice, material(), carried, start).unwrap();
    let mut untried = tried.clone();
    assert!(matches!(tried.step(FRAME, Some(&[DVec3::splat(1e308); 27])), Err(Error::Elastic(_))));
    tried.step(FRAME, None).unwrap();
    untried.step(FRAME, None).unwrap();
    let apart = tried.control().iter().zip(untried.control()).map(|(a, b)| a.distance(*b));
    assert!(apart.fold(0.0, f64::max) < 1e-12);
}

#[test]
fn times_so_short_that_rounding_would_stop_the_body_are_refused() {
    let lattice = cube([3, 3, 3]);
    let carried = Carried { vertices: &[], triangles: &[], influence: None, outside: Outside::Keep };
    let start = Start { control: lattice.rest(), velocity: vec![DVec3::X; 27], pinned: vec![false; 27] };
    let mut body = Elastic::new(&lattice, material(), carried, start).unwrap();
    for seconds in [5e-324, 1e-300, 1e-17, 1e-10] {
        assert!(matches!(body.step(seconds, None), Err(Error::Elastic(_))));
    }
    body.step(1e-9, None).unwrap();
    assert!(body.velocity().iter().all(|velocity| velocity.distance(DVec3::X) < 1e-4));
}
