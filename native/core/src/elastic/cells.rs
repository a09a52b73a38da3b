// SPDX-License-Identifier: GPL-3.0-or-later
//! The elastic forces between the control points: the corners of the lattice's cells, each with its own strain.

use glam::{DMat3, DQuat, DVec3};
use rayon::prelude::*;

use super::rotation;

/// No neighbour along an axis with one control point.
const NONE: u32 = u32::MAX;

/// Mass and stiffness of a cell with nothing inside, as a share of a full one.
const EMPTY_SHARE: f64 = 0.05;

/// Cells from which on less of each is looked at.
const MANY_CELLS: usize = 1000;

/// Corners that one thread takes at least.
const SHARE: usize = 1024;

/// One corner of one cell: a control point, and its neighbours along the cell's edges.
#[derive(Debug, Clone)]
struct Corner {
    point: u32,
    next: [u32; 3],
    /// Turns edge vectors into the deformation gradient: F = sum of edge ⊗ row.
    rows: [DVec3; 3],
    /// The directions in which the corner has edges: the identity, or a projection where the lattice is flat.
    span: DMat3,
    /// Share of the cell's volume.
    volume: f64,
}

/// All corners, with the rotations found last and the forces on their points.
#[derive(Debug, Clone)]
pub(super) struct Cells {
    corners: Vec<Corner>,
    rotations: Vec<DQuat>,
    /// What each corner adds to its own point and the three next.
    forces: Vec<[DVec3; 4]>,
    /// For each control point where `gather` starts, and the (corner, place) pairs there, in a fixed order.
    starts: Vec<usize>,
    gather: Vec<(u32, u8)>,
    pub(super) mass: Vec<f64>,
    /// Longest side of the lattice at rest.
    pub(super) extent: f64,
}

/// What the corners push with: squared wave speed, the time that damping of the strain rate takes, and the angular velocity of
/// the body, which is none of that rate.
#[derive(Debug, Clone, Copy)]
pub(super) struct Modulus {
    pub(super) speed_squared: f64,
    pub(super) relaxation: f64,
    pub(super) spin: DVec3,
}

impl Cells {
    /// The cells of a grid of `shape` with these points at rest, `k` fastest. Each is as heavy and as stiff as the share of
    /// it that is inside something, and a little where nothing is.
    pub(super) fn new(shape: [usize; 3], rest: &[DVec3], inside: impl Fn(DVec3) -> bool + Sync) -> Self {
        let corners = corners(shape, rest, inside);
        let mut mass = vec![0.0; rest.len()];
        corners.iter().for_each(|corner| mass[corner.point as usize] += corner.volume);
        if corners.is_empty() {
            mass.fill(1.0);
        }
        let (starts, gather) = gathering(&corners, rest.len());
        let forces = vec![[DVec3::ZERO; 4]; corners.len()];
        let rotations = vec![DQuat::IDENTITY; corners.len()];
        Self { corners, rotations, forces, starts, gather, mass, extent: extent(shape, rest) }
    }

    /// Finds the rotations of a state that nothing is known of.
    pub(super) fn start(&mut self, positions: &[DVec3]) {
        let corners = &self.corners;
        let found =
            corners.par_iter().with_min_len(SHARE).map(|c| rotation::nearest_of_all(c.gradient(positions)));
        found.collect_into_vec(&mut self.rotations);
    }

    /// Largest squared angular frequency of the grid, from above, for a squared wave speed of one: the largest row sum
    /// (Gershgorin) of M⁻¹ K. The strain energy bends upwards nowhere more than at rest, so this holds in every state.
    pub(super) fn fastest(&self) -> f64 {
        let mut sums = vec![0.0; self.mass.len()];
        for corner in &self.corners {
            let pulls = corner.pulls();
            let total: f64 = pulls.iter().map(|pull| pull.length()).sum();
            for (point, pull) in corner.points().into_iter().zip(pulls) {
                if point != NONE {
                    sums[point as usize] += corner.volume * pull.length() * total;
                }
            }
        }
        sums.iter().zip(&self.mass).map(|(sum, mass)| sum / mass).fold(0.0, f64::max)
    }

    /// Accelerations of all points, elastic and by the damping of the strain rate, into `out`.
    pub(super) fn accelerations(
        &mut self,
        positions: &[DVec3],
        velocities: &[DVec3],
        modulus: Modulus,
        out: &mut [DVec3],
    ) {
        let each = self.corners.par_iter().zip(&mut self.rotations).zip(&mut self.forces).with_min_len(SHARE);
        each.for_each(|((corner, rotation), forces)| {
            *rotation = rotation::nearest(corner.gradient(positions), *rotation);
            *forces = corner.forces(positions, velocities, DMat3::from_quat(*rotation), modulus);
        });
        let (starts, gather, forces, mass) = (&self.starts, &self.gather, &self.forces, &self.mass);
        out.par_iter_mut().enumerate().with_min_len(SHARE).for_each(|(point, acceleration)| {
            let parts = gather[starts[point]..starts[point + 1]].iter();
            let force = parts.fold(DVec3::ZERO, |sum, &(c, place)| sum + forces[c as usize][place as usize]);
            *acceleration = force / mass[point];
        });
    }

    /// Elastic energy for a squared wave speed of one, with the rotations found last brought up to date.
    pub(super) fn energy(&self, positions: &[DVec3]) -> f64 {
        let of = |(corner, &start): (&Corner, &DQuat)| {
            let gradient = corner.gradient(positions);
            let rotation = DMat3::from_quat(rotation::nearest(gradient, start));
            0.5 * corner.volume * squares(gradient - rotation * corner.span)
        };
        self.corners.iter().zip(&self.rotations).map(of).sum()
    }
}

impl Corner {
    fn points(&self) -> [u32; 4] {
        [self.point, self.next[0], self.next[1], self.next[2]]
    }

    /// How much the deformation gradient changes with each of the four points.
    fn pulls(&self) -> [DVec3; 4] {
        let [a, b, c] = self.rows;
        [-(a + b + c), a, b, c]
    }

    /// Deformation gradient of the positions, or its rate where velocities are given.
    fn gradient(&self, values: &[DVec3]) -> DMat3 {
        let base = values[self.point as usize];
        let mut sum = DMat3::ZERO;
        for (&next, &row) in self.next.iter().zip(&self.rows) {
            if next != NONE {
                sum += outer(values[next as usize] - base, row);
            }
        }
        sum
    }

    fn forces(
        &self,
        positions: &[DVec3],
        velocities: &[DVec3],
        rotation: DMat3,
        modulus: Modulus,
    ) -> [DVec3; 4] {
        let gradient = self.gradient(positions);
        let strain = gradient - rotation * self.span;
        let turning = DMat3::from_cols_array_2d(&[
            [0.0, modulus.spin.z, -modulus.spin.y],
            [-modulus.spin.z, 0.0, modulus.spin.x],
            [modulus.spin.y, -modulus.spin.x, 0.0],
        ]);
        let growth = rotation.transpose() * (self.gradient(velocities) - turning * gradient);
        let rate = rotation * (growth + growth.transpose()) * self.span * (0.5 * modulus.relaxation);
        let stress = (strain + rate) * (modulus.speed_squared * self.volume);
        self.pulls().map(|pull| -(stress * pull))
    }
}

fn outer(column: DVec3, row: DVec3) -> DMat3 {
    DMat3::from_cols(column * row.x, column * row.y, column * row.z)
}

fn squares(matrix: DMat3) -> f64 {
    matrix.x_axis.length_squared() + matrix.y_axis.length_squared() + matrix.z_axis.length_squared()
}

fn extent(shape: [usize; 3], rest: &[DVec3]) -> f64 {
    let [nu, nv, nw] = shape;
    let ends = [(nu - 1) * nv * nw, (nv - 1) * nw, nw - 1];
    let longest = ends.iter().map(|&end| rest[end].distance(rest[0])).fold(0.0, f64::max);
    if longest > 0.0 { longest } else { 1.0 }
}

/// Every corner of every cell, cell by cell.
fn corners(shape: [usize; 3], rest: &[DVec3], inside: impl Fn(DVec3) -> bool + Sync) -> Vec<Corner> {
    if shape == [1; 3] {
        return Vec::new();
    }
    let cells: Vec<[usize; 3]> = positions_in(shape.map(|count| (count - 1).max(1))).collect();
    let looks = if cells.len() > MANY_CELLS { 2 } else { 4 };
    let found = cells.par_iter().map(|&cell| corners_of(shape, rest, cell, looks, &inside));
    found.collect::<Vec<_>>().concat()
}

/// The corners of one cell.
fn corners_of(
    shape: [usize; 3],
    rest: &[DVec3],
    cell: [usize; 3],
    looks: usize,
    inside: &(impl Fn(DVec3) -> bool + Sync),
) -> Vec<Corner> {
    let strides = [shape[1] * shape[2], shape[2], 1];
    let sides = shape.map(|count| if count > 1 { 2 } else { 1 });
    let base: usize = (0..3).map(|axis| cell[axis] * strides[axis]).sum();
    let edges = (0..3).map(|axis| match shape[axis] {
        1 => DVec3::ZERO,
        _ => rest[base + strides[axis]] - rest[base],
    });
    let edges: Vec<DVec3> = edges.collect();
    let at = |look: [usize; 3]| {
        let along = |axis: usize| edges[axis] * ((look[axis] as f64 + 0.5) / looks as f64);
        rest[base] + along(0) + along(1) + along(2)
    };
    let full = positions_in([looks; 3]).filter(|&look| inside(at(look))).count() as f64 / looks.pow(3) as f64;
    let share = full.max(EMPTY_SHARE) / sides.iter().product::<usize>() as f64;
    let corner_at = |side: [usize; 3]| {
        let point: usize = (0..3).map(|axis| (cell[axis] + side[axis]) * strides[axis]).sum();
        let next: [Option<usize>; 3] = std::array::from_fn(|axis| {
            let there =
                if side[axis] == 0 { point + strides[axis] } else { point.wrapping_sub(strides[axis]) };
            (shape[axis] > 1).then_some(there)
        });
        corner(point, next, share, rest)
    };
    positions_in(sides).map(corner_at).collect()
}

fn corner(point: usize, next: [Option<usize>; 3], share: f64, rest: &[DVec3]) -> Corner {
    let edges = filled(next.map(|next| next.map(|next| rest[next] - rest[point])));
    let inverse = edges.inverse().transpose();
    let present = |axis: usize| next[axis].is_some();
    let row = |axis: usize| if present(axis) { inverse.col(axis) } else { DVec3::ZERO };
    let rows = [row(0), row(1), row(2)];
    let span =
        (0..3).map(|axis| outer(edges.col(axis), rows[axis])).fold(DMat3::ZERO, |sum, part| sum + part);
    let index = |next: Option<usize>| next.map_or(NONE, |next| next as u32);
    Corner {
        point: point as u32,
        next: next.map(index),
        rows,
        span,
        volume: share * edges.determinant().abs(),
    }
}

/// The edges as columns; those that are missing replaced by unit vectors across the others.
fn filled(edges: [Option<DVec3>; 3]) -> DMat3 {
    let present: Vec<DVec3> = edges.iter().flatten().copied().collect();
    let across = match present[..] {
        [one] => {
            let (first, second) = one.normalize().any_orthonormal_pair();
            [first, second]
        }
        [one, other] => [one.cross(other).normalize(); 2],
        _ => [DVec3::ZERO; 2],
    };
    let mut across = across.into_iter();
    let columns = edges.map(|edge| edge.unwrap_or_else(|| across.next().unwrap_or(DVec3::ZERO)));
    DMat3::from_cols(columns[0], columns[1], columns[2])
}

fn positions_in(counts: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    let [nu, nv, nw] = counts;
    (0..nu).flat_map(move |i| (0..nv).flat_map(move |j| (0..nw).map(move |k| [i, j, k])))
}

fn gathering(corners: &[Corner], points: usize) -> (Vec<usize>, Vec<(u32, u8)>) {
    let mut lists: Vec<Vec<(u32, u8)>> = vec![Vec::new(); points];
    for (number, corner) in corners.iter().enumerate() {
        for (place, point) in corner.points().into_iter().enumerate() {
            if point != NONE {
                lists[point as usize].push((number as u32, place as u8));
            }
        }
    }
    let mut starts = vec![0];
    starts.extend(lists.iter().scan(0, |end, list| {
        *end += list.len();
        Some(*end)
    }));
    (starts, lists.concat())
}
