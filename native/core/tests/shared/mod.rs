// SPDX-License-Identifier: GPL-3.0-or-later
//! Meshes and measures that the tests share.
#![allow(
    dead_code,
    unreachable_pub,
    clippy::unwrap_used,
    reason = "each test crate uses its own part, and fails by panicking"
)]

pub mod patch_model;

use isochor_core::{AxisBasis, DMat3, DVec3, Interpolation, Lattice};

/// A closed surface with consistent winding, outward.
pub struct Mesh {
    pub vertices: Vec<[f64; 3]>,
    pub triangles: Vec<[u32; 3]>,
}

/// Octahedron whose faces are split `levels` times, on a sphere with bumps.
pub fn bumpy_ball(levels: u32) -> Mesh {
    let mut vertices: Vec<DVec3> =
        [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z].to_vec();
    let mut triangles: Vec<[u32; 3]> =
        vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    for _ in 0..levels {
        let mut middles = std::collections::HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                vertices.push((vertices[a as usize] + vertices[b as usize]).normalize());
                vertices.len() as u32 - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let (m, n, o) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, m, o], [m, b, n], [o, n, c], [m, n, o]]
            })
            .collect();
    }
    let bump = |p: DVec3| p * (1.0 + 0.1 * (7.0 * p.x + 3.0 * p.y).sin() * (5.0 * p.z).cos());
    Mesh { vertices: vertices.into_iter().map(|p| bump(p).to_array()).collect(), triangles }
}

/// Signed volume, triangle by triangle, about the origin.
pub fn volume(vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> f64 {
    let at = |v: u32| DVec3::from_array(vertices[v as usize]);
    triangles.iter().map(|&[a, b, c]| at(a).dot(at(b).cross(at(c)))).sum::<f64>() / 6.0
}

/// A lattice with a slanted frame around the ball.
pub fn slanted(axes: [AxisBasis; 3]) -> Lattice {
    let edges =
        DMat3::from_cols(DVec3::new(3.0, 0.2, 0.1), DVec3::new(-0.3, 3.1, 0.2), DVec3::new(0.1, 0.4, 2.9));
    Lattice::new(axes, edges * DVec3::splat(-0.5), edges).unwrap()
}

/// Bases that the laws are tried on.
pub fn bases() -> Vec<(&'static str, [AxisBasis; 3])> {
    let bernstein = |n| AxisBasis::bernstein(n).unwrap();
    let uniform = |n, d| AxisBasis::uniform(n, d).unwrap();
    let clamped = |n, d| AxisBasis::clamped(n, d).unwrap();
    vec![
        ("Bernstein 4^3", [bernstein(4), bernstein(4), bernstein(4)]),
        ("Bernstein of degrees 1, 7, 20", [bernstein(2), bernstein(8), bernstein(21)]),
        ("uniform cubic 6^3", [uniform(6, 3), uniform(6, 3), uniform(6, 3)]),
        ("clamped cubic 10^3", [clamped(10, 3), clamped(10, 3), clamped(10, 3)]),
        ("mixed", [uniform(5, 2), clamped(7, 4), bernstein(3)]),
        ("degrees 1 and 5", [uniform(4, 1), uniform(9, 5), clamped(6, 5)]),
    ]
}

/// The same lattice with weights from 1/4 to 4.
pub fn weighted(lattice: Lattice, seed: u64) -> Lattice {
    let mut random = noise(seed);
    let weights = (0..lattice.len()).map(|_| 4f64.powf(random())).collect();
    lattice.with_weights(weights).unwrap()
}

/// Lattices whose control points are not those that the passes over a mesh know: rational ones and Blender's.
pub fn mapped() -> Vec<(String, Lattice)> {
    let blender = |shape: [usize; 3], kinds: [Interpolation; 3]| {
        let axis = |a: usize| AxisBasis::blender(shape[a], kinds[a]).unwrap();
        slanted([axis(0), axis(1), axis(2)])
    };
    let rational = bases()
        .into_iter()
        .enumerate()
        .map(|(seed, (name, axes))| (format!("rational {name}"), weighted(slanted(axes), seed as u64 + 1)));
    let [linear, cardinal, rounded, spline] = INTERPOLATIONS;
    let native = [
        ("Blender's spline 5^3".to_owned(), blender([5; 3], [spline; 3])),
        ("Blender's spline 2^3".to_owned(), blender([2; 3], [spline; 3])),
        ("Blender's cardinal 4, 3, 6".to_owned(), blender([4, 3, 6], [cardinal; 3])),
        ("Blender's mixed 4, 2, 5".to_owned(), blender([4, 2, 5], [rounded, linear, spline])),
        ("Blender's spline, rational".to_owned(), weighted(blender([4; 3], [spline, linear, spline]), 9)),
    ];
    rational.chain(native).collect()
}

/// All of Blender's interpolations.
pub const INTERPOLATIONS: [Interpolation; 4] =
    [Interpolation::Linear, Interpolation::Cardinal, Interpolation::CatmullRom, Interpolation::BSpline];

/// Numbers in [-1, 1] that look random and are the same everywhere.
pub fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}
