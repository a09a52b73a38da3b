// SPDX-License-Identifier: GPL-3.0-or-later
//! Corrections from the control points alone agree with those over the mesh.

use crate::shared::{Mesh, bases, bumpy_ball, noise, slanted};
use isochor_core::{
    AxisBasis, Binding, DVec3, Error, Lattice, Method, Outside, PinPoint, Pins, Preserve, Scalar,
};

/// The same binding twice: over the mesh, and by the tensor.
struct Pair<T> {
    direct: Binding<T>,
    prepared: Binding<T>,
}

impl<T: Scalar> Pair<T> {
    fn new(bind: impl Fn() -> Binding<T>) -> Self {
        let (direct, prepared) = (bind(), bind());
        assert!(prepared.prepare().unwrap());
        assert!(prepared.tensor_bytes() > 0 && direct.tensor_bytes() == 0);
        Self { direct, prepared }
    }

    /// Corrects both ways: control points, vertices, and how far they are from the volume aimed at, relative, over what rounding
    /// allows.
    fn run(&self, control: &[DVec3], options: &Preserve) -> [(Vec<DVec3>, Vec<[T; 3]>, f64); 2] {
        [&self.direct, &self.prepared].map(|binding| {
            let mut out = vec![[T::from_f64(0.0); 3]; binding.vertices().len()];
            let outcome = binding.preserve(control, options, &mut out).unwrap();
            let measure = binding.measure(&out).unwrap();
            // Vertices round in proportion to their distance from the origin.
            let radius = out.iter().flatten().map(|c| c.to_f64().abs()).fold(0.0, f64::max);
            let tightest = if T::EPSILON > f64::EPSILON { 1e-6 } else { 1e-12 };
            let allowed = (4.0 * T::EPSILON * measure.area * radius).max(tightest * outcome.target().abs());
            let error = (measure.volume - outcome.target()).abs() / allowed;
            (outcome.control, out, error)
        })
    }

    fn agree(&self, control: &[DVec3], options: &Preserve, name: &str) {
        let [(direct, _, over_mesh), (control, _, error)] = self.run(control, options);
        let size = direct.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
        let apart = direct.iter().zip(&control).map(|(a, b)| (*a - *b).abs().max_element());
        let apart = apart.fold(0.0, f64::max) / size;
        let allowed = if T::EPSILON > f64::EPSILON { 1e-6 } else { 1e-10 };
        assert!(apart < allowed, "{name}: {apart:e} apart");
        // Influence that varies stretches what was moved far away to a needle, where rounding is larger than allowed over the
        // mesh too.
        assert!(error < over_mesh.max(1.0), "{name}: volume off by {error} of what is allowed");
    }
}

fn shaken(lattice: &Lattice, factor: DVec3, shake: f64, seed: u64) -> Vec<DVec3> {
    let mut random = noise(seed);
    let rest = lattice.rest();
    rest.iter().map(|p| *p * factor + shake * DVec3::new(random(), random(), random())).collect()
}

fn small_enough(axes: &[AxisBasis; 3]) -> bool {
    axes.iter().map(AxisBasis::count).product::<usize>() <= 216
}

#[test]
fn every_basis_method_share_frame_and_weight() {
    let mesh = bumpy_ball(4);
    let frame = [DVec3::new(1.0, 1.0, 0.0), DVec3::new(-4.0, 4.0, 1.0), DVec3::new(0.5, 0.0, -3.0)];
    for (name, axes) in bases().into_iter().filter(|(_, axes)| small_enough(axes)) {
        let lattice = slanted(axes);
        let pair = Pair::new(|| {
            let (vertices, triangles) = (mesh.vertices.clone(), mesh.triangles.clone());
            Binding::new(lattice.clone(), vertices, triangles, None, Outside::Keep).unwrap()
        });
        let weights: Vec<f64> =
            (0..lattice.len()).map(|p| if p % 7 == 0 { f64::INFINITY } else { 1.0 + p as f64 }).collect();
        for (seed, factor) in [0.2, 0.7, 1.0, 3.0].into_iter().enumerate() {
            let control = shaken(&lattice, DVec3::new(1.0, factor, factor), 0.05, seed as u64);
            for method in [Method::Sweep, Method::Balanced] {
                for axes in [[1.0, 1.0, 1.0], [0.0, 2.0, 1.0], [0.0, 0.0, 1.0]] {
                    let plain = Preserve { axes, method, ..Preserve::default() };
                    pair.agree(&control, &plain, name);
                    pair.agree(&control, &Preserve { frame: Some(frame), ..plain.clone() }, name);
                    pair.agree(&control, &Preserve { weights: Some(weights.clone()), ..plain }, name);
                }
            }
        }
    }
}

#[test]
fn influence_vertices_outside_and_a_shaped_rest() {
    let mesh = bumpy_ball(4);
    let mut random = noise(11);
    let influence: Vec<f64> = mesh.vertices.iter().map(|_| 0.5 + 0.5 * random()).collect();
    for basis in [AxisBasis::bernstein(4).unwrap(), AxisBasis::uniform(5, 2).unwrap()] {
        let axes = || std::array::from_fn(|_| basis.clone());
        let half = Lattice::around(axes(), &[DVec3::splat(-1.2), DVec3::new(1.2, 1.2, 0.3)], 0.0).unwrap();
        let shape = shaken(&slanted(axes()), DVec3::ONE, 0.1, 5);
        for influence in [None, Some(influence.clone())] {
            for outside in [Outside::Keep, Outside::Extend] {
                let (vertices, triangles) = (&mesh.vertices, &mesh.triangles);
                let pair = Pair::new(|| {
                    let (vertices, triangles) = (vertices.clone(), triangles.clone());
                    Binding::new(half.clone(), vertices, triangles, influence.clone(), outside).unwrap()
                });
                pair.agree(&shaken(&half, DVec3::splat(0.8), 0.1, 6), &Preserve::default(), "half outside");
                let pair = Pair::new(|| {
                    let (vertices, triangles) = (vertices.clone(), triangles.clone());
                    let (lattice, rest) = (slanted(axes()), Some(shape.clone()));
                    Binding::shaped(lattice, vertices, triangles, influence.clone(), outside, rest).unwrap()
                });
                pair.agree(&shaken(&half, DVec3::splat(0.8), 0.1, 7), &Preserve::default(), "shaped");
            }
        }
    }
}

#[test]
fn an_axis_with_one_control_point() {
    let mesh = bumpy_ball(3);
    let axes = [
        AxisBasis::bernstein(4).unwrap(),
        AxisBasis::bernstein(1).unwrap(),
        AxisBasis::bernstein(3).unwrap(),
    ];
    let lattice = slanted(axes);
    let pair = Pair::new(|| {
        let (vertices, triangles) = (mesh.vertices.clone(), mesh.triangles.clone());
        Binding::new(lattice.clone(), vertices, triangles, None, Outside::Keep).unwrap()
    });
    pair.agree(&shaken(&lattice, DVec3::new(0.6, 1.0, 0.8), 0.1, 1), &Preserve::default(), "one point");
}

/// Far from the origin, tiny, nearly flat, moved far away: with the same influence everywhere and with another.
#[test]
fn hard_places_and_shapes() {
    let ball = bumpy_ball(4);
    let mut random = noise(21);
    let influence: Vec<f64> = ball.vertices.iter().map(|_| 0.9 + 0.1 * random()).collect();
    for (offset, size) in [(0.0, 1.0), (1e4, 1.0), (-3e6, 10.0), (5.0, 1e-5), (0.0, 1e8)] {
        let at = |p: &[f64; 3]| p.map(|c| c * size + offset);
        let mesh =
            Mesh { vertices: ball.vertices.iter().map(at).collect(), triangles: ball.triangles.clone() };
        let points: Vec<DVec3> = mesh.vertices.iter().map(|p| DVec3::from_array(*p)).collect();
        let axes = std::array::from_fn(|_| AxisBasis::bernstein(4).unwrap());
        let lattice = Lattice::around(axes, &points, 0.1).unwrap();
        let centre = lattice.centre();
        for influence in [None, Some(influence.clone())] {
            let pair = Pair::new(|| {
                let (vertices, triangles) = (mesh.vertices.clone(), mesh.triangles.clone());
                Binding::new(lattice.clone(), vertices, triangles, influence.clone(), Outside::Keep).unwrap()
            });
            for (factor, moved) in [
                (DVec3::new(1.0, 1.0, 1e-3), 0.0),
                (DVec3::splat(1e-2), 0.0),
                (DVec3::splat(30.0), 0.0),
                (DVec3::new(0.7, 0.8, 0.9), 1e5),
            ] {
                let control: Vec<DVec3> = shaken(&lattice, DVec3::ONE, 0.02 * size, 4)
                    .iter()
                    .map(|p| centre + (*p - centre) * factor + moved * size)
                    .collect();
                let name = format!("offset {offset}, size {size}, factor {factor}, moved {moved}");
                pair.agree(&control, &Preserve::default(), &name);
            }
        }
    }
}

#[test]
fn float32_vertices_keep_the_volume_as_they_come_out() {
    let mesh = bumpy_ball(5);
    let vertices: Vec<[f32; 3]> = mesh.vertices.iter().map(|p| p.map(|c| c as f32)).collect();
    for (name, axes) in bases().into_iter().filter(|(_, axes)| small_enough(axes)) {
        let lattice = slanted(axes);
        let pair = Pair::new(|| {
            let (vertices, triangles) = (vertices.clone(), mesh.triangles.clone());
            Binding::new(lattice.clone(), vertices, triangles, None, Outside::Keep).unwrap()
        });
        for factor in [0.15, 0.6, 2.5] {
            let control = shaken(&lattice, DVec3::new(1.0, 1.0, factor), 0.03, 3);
            pair.agree(&control, &Preserve::default(), name);
        }
    }
}

#[test]
fn pins_a_target_and_an_amount() {
    let mesh = bumpy_ball(4);
    let lattice = slanted(std::array::from_fn(|_| AxisBasis::bernstein(5).unwrap()));
    let pair = Pair::new(|| {
        let (vertices, triangles) = (mesh.vertices.clone(), mesh.triangles.clone());
        Binding::new(lattice.clone(), vertices, triangles, None, Outside::Keep).unwrap()
    });
    let points = vec![PinPoint::Vertex(3), PinPoint::Vertex(700)];
    let targets = vec![DVec3::new(0.0, -1.5, 0.2), DVec3::new(0.3, 0.4, 0.9)];
    let control = shaken(&lattice, DVec3::new(0.9, 0.8, 0.7), 0.05, 2);
    for amount in [0.0, 0.4, 1.0] {
        let pins = Pins { points: points.clone(), targets: targets.clone() };
        let options = Preserve { pins, target: Some(vec![3.0]), amount, ..Preserve::default() };
        pair.agree(&control, &options, "pins");
        let [_, (_, out, _)] = pair.run(&control, &options);
        for (vertex, target) in [(3, targets[0]), (700, targets[1])] {
            assert!((DVec3::from_array(out[vertex]) - target).length() < 1e-12);
        }
    }
}

/// The nearest is found by iterations that end within a tolerance; the others are closed forms.
#[test]
fn methods_that_search() {
    let mesh = bumpy_ball(4);
    let lattice = slanted(std::array::from_fn(|_| AxisBasis::bernstein(4).unwrap()));
    let pair = Pair::new(|| {
        let (vertices, triangles) = (mesh.vertices.clone(), mesh.triangles.clone());
        Binding::new(lattice.clone(), vertices, triangles, None, Outside::Keep).unwrap()
    });
    for factor in [0.4, 0.9, 2.0] {
        let control = shaken(&lattice, DVec3::new(1.0, 1.0, factor), 0.05, 9);
        let options = |method| Preserve { method, ..Preserve::default() };
        pair.agree(&control, &options(Method::Gradient), "gradient");
        let [(direct, ..), (nearest, _, error)] = pair.run(&control, &options(Method::Nearest));
        let length = |found: &[DVec3]| -> f64 {
            found.iter().zip(&control).map(|(a, b)| (*a - *b).length_squared()).sum::<f64>().sqrt()
        };
        assert!(error < 1.0 && (length(&nearest) / length(&direct) - 1.0).abs() < 1e-10);
    }
}

#[test]
fn flat_axes_and_refusals_are_the_same() {
    let mesh = bumpy_ball(3);
    let axes = std::array::from_fn(|_| AxisBasis::bernstein(4).unwrap());
    let lattice = Lattice::around(axes, &[DVec3::splat(-1.2), DVec3::splat(1.2)], 0.0).unwrap();
    let pair = Pair::new(|| {
        let (vertices, triangles) = (mesh.vertices.clone(), mesh.triangles.clone());
        Binding::new(lattice.clone(), vertices, triangles, None, Outside::Keep).unwrap()
    });
    let flat: Vec<DVec3> = lattice.rest().iter().map(|p| DVec3::new(p.x, p.y, 0.0)).collect();
    pair.agree(&flat, &Preserve::default(), "flat");
    let mut out = vec![[0.0; 3]; mesh.vertices.len()];
    let outcome = pair.prepared.preserve(&flat, &Preserve::default(), &mut out).unwrap();
    assert_eq!((outcome.method, outcome.iterations), (Method::Sweep, 2));
    let stuck = Preserve { axes: [1.0, 1.0, 0.0], ..Preserve::default() };
    let refused = pair.prepared.preserve(&flat, &stuck, &mut out);
    assert!(matches!(refused, Err(Error::Volume(_))), "{refused:?}");
}

#[test]
fn same_bits_on_any_number_of_threads() {
    let mesh = bumpy_ball(5);
    let lattice = slanted(std::array::from_fn(|_| AxisBasis::uniform(5, 3).unwrap()));
    let control = shaken(&lattice, DVec3::new(0.9, 0.8, 0.7), 0.05, 2);
    let bits = [1, 2, 5].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let (vertices, triangles) = (mesh.vertices.clone(), mesh.triangles.clone());
            let binding = Binding::new(lattice.clone(), vertices, triangles, None, Outside::Keep).unwrap();
            assert!(binding.prepare().unwrap());
            let mut out = vec![[0.0; 3]; mesh.vertices.len()];
            binding.preserve(&control, &Preserve::default(), &mut out).unwrap();
            out.iter().flatten().map(|c| c.to_bits()).collect::<Vec<_>>()
        })
    });
    assert!(bits[0] == bits[1] && bits[1] == bits[2]);
}

#[test]
fn large_lattices_and_open_surfaces_have_none() {
    let mesh = bumpy_ball(3);
    let (vertices, triangles) = (mesh.vertices.clone(), mesh.triangles.clone());
    let large = slanted(std::array::from_fn(|_| AxisBasis::clamped(7, 3).unwrap()));
    let binding = Binding::new(large, vertices.clone(), triangles, None, Outside::Keep).unwrap();
    assert!(!binding.prepare().unwrap());
    let small = slanted(std::array::from_fn(|_| AxisBasis::bernstein(3).unwrap()));
    let open = Binding::new(small, vertices, mesh.triangles[1..].to_vec(), None, Outside::Keep).unwrap();
    assert!(matches!(open.prepare(), Err(Error::Mesh(_))));
}

#[test]
fn it_comes_by_itself_where_it_pays_and_goes_with_an_update() {
    // The only test here that depends on the switch.
    isochor_core::prepare_in_background(false);
    let mesh = bumpy_ball(6);
    let lattice = slanted(std::array::from_fn(|_| AxisBasis::bernstein(4).unwrap()));
    let bind = |mesh: &Mesh| {
        let (vertices, triangles) = (mesh.vertices.clone(), mesh.triangles.clone());
        Binding::new(lattice.clone(), vertices, triangles, None, Outside::Keep).unwrap()
    };
    let control = shaken(&lattice, DVec3::new(0.9, 0.8, 0.7), 0.05, 2);
    let small = bumpy_ball(2);
    let (mut binding, tiny) = (bind(&mesh), bind(&small));
    let mut out = vec![[0.0; 3]; mesh.vertices.len()];
    let first = binding.preserve(&control, &Preserve::default(), &mut out).unwrap();
    for _ in 0..300 {
        let again = binding.preserve(&control, &Preserve::default(), &mut out).unwrap();
        assert!(again == first && binding.tensor_bytes() == 0);
    }
    isochor_core::prepare_in_background(true);
    binding.update(None, None, None, None).unwrap();
    let patience = std::time::Instant::now();
    let mut corrections = 1;
    while binding.tensor_bytes() == 0 && patience.elapsed().as_secs() < 60 {
        let again = binding.preserve(&control, &Preserve::default(), &mut out).unwrap();
        let same = again.control == first.control;
        assert!(same || binding.tensor_bytes() > 0);
        corrections += 1;
    }
    assert!(binding.tensor_bytes() > 0, "not there after {corrections} corrections");
    assert!(corrections > 20, "worth it after {corrections} corrections already");
    let by_tensor = binding.preserve(&control, &Preserve::default(), &mut out).unwrap();
    let apart = by_tensor.control.iter().zip(&first.control).map(|(a, b)| (*a - *b).abs().max_element());
    assert!(apart.fold(0.0, f64::max) < 1e-10);

    let larger: Vec<[f64; 3]> = mesh.vertices.iter().map(|p| p.map(|c| 1.1 * c)).collect();
    binding.update(Some(larger.clone()), None, None, None).unwrap();
    assert_eq!(binding.tensor_bytes(), 0);
    binding.preserve(&control, &Preserve::default(), &mut out).unwrap();
    let expected = binding.reference().unwrap().volume;
    assert!((binding.measure(&out).unwrap().volume / expected - 1.0).abs() < 1e-12);

    let mut out = vec![[0.0; 3]; small.vertices.len()];
    for _ in 0..1000 {
        tiny.preserve(&control, &Preserve::default(), &mut out).unwrap();
    }
    assert_eq!(tiny.tensor_bytes(), 0);
}
