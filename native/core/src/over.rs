// SPDX-License-Identifier: GPL-3.0-or-later
//! The closed surfaces over a binding's points: volume and its gradient on combinations of the points, taken back to the points.
//!
//! With `x = S p` the volume's gradient at the points is `S' g`, `g` that at the surface's vertices. What closes holes is more of the
//! same: the apex of a cap is the mean of its loop, one more row of `S`.

use std::collections::{BTreeMap, HashMap};
use std::sync::OnceLock;

use rayon::prelude::*;

use crate::binding::Binding;
use crate::bodies::{Partition, edges_of};
use crate::combination::Surface;
use crate::error::Result;
use crate::sum::CompensatedSum;
use crate::vertices::Scalar;

/// Triangles, vertices or points that one thread works out at a time at least.
const RUN: usize = 2048;

/// The surface that a binding's triangles form over its points.
pub(crate) struct Over {
    pub(crate) surface: Surface,
    /// The points' own partition: none belongs to a body.
    pub(crate) whole: Partition,
    pub(crate) parts: OnceLock<Vec<Part>>,
}

/// The closed surface of one body: its rows, caps' apexes included, and what is around them.
pub(crate) struct Part {
    rows: Surface,
    triangles: Vec<[u32; 3]>,
    /// Triangles around each row.
    fans: Lists<u32>,
    /// Points that rows combine.
    points: Vec<u32>,
    /// Rows that each of these is in, with its weight there.
    pulls: Lists<(u32, f64)>,
}

/// Several lists, one after the other.
struct Lists<E> {
    offsets: Vec<usize>,
    entries: Vec<E>,
}

impl<E: Copy> Lists<E> {
    /// Sorts entries into `count` lists by number, in their order.
    fn sorted(count: usize, entries: impl Iterator<Item = (u32, E)> + Clone) -> Self {
        let mut offsets = vec![0; count + 1];
        entries.clone().for_each(|(list, _)| offsets[list as usize + 1] += 1);
        (0..count).for_each(|list| offsets[list + 1] += offsets[list]);
        let mut next = offsets.clone();
        let mut sorted: Vec<E> = entries.clone().map(|(_, entry)| entry).collect();
        for (list, entry) in entries {
            sorted[next[list as usize]] = entry;
            next[list as usize] += 1;
        }
        Self { offsets, entries: sorted }
    }

    fn list(&self, list: usize) -> &[E] {
        &self.entries[self.offsets[list]..self.offsets[list + 1]]
    }
}

impl Over {
    pub(crate) fn new(surface: Surface) -> Self {
        Self { surface, whole: Partition::whole(), parts: OnceLock::new() }
    }
}

impl Part {
    /// Triangles and loops by the surface's vertices.
    fn new(surface: &Surface, triangles: &[[u32; 3]], loops: &[Vec<u32>]) -> Self {
        let mut known: HashMap<u32, u32> = HashMap::new();
        let mut rows: Vec<Vec<(u32, f64)>> = Vec::new();
        let mut local = |vertex: u32, rows: &mut Vec<Vec<(u32, f64)>>| {
            *known.entry(vertex).or_insert_with(|| {
                rows.push(surface.row(vertex as usize).collect());
                rows.len() as u32 - 1
            })
        };
        let mut all: Vec<[u32; 3]> =
            triangles.iter().map(|corners| corners.map(|v| local(v, &mut rows))).collect();
        for each in loops {
            let around: Vec<u32> = each.iter().map(|&v| local(v, &mut rows)).collect();
            let apex = rows.len() as u32;
            rows.push(mean(&around, &rows));
            all.extend(edges_of(&around).map(|[a, b]| [a, b, apex]));
        }
        Self::of_rows(Surface::of_rows(surface.point_count(), rows), all)
    }

    fn of_rows(rows: Surface, triangles: Vec<[u32; 3]>) -> Self {
        let around = (0u32..).zip(&triangles).flat_map(|(face, corners)| corners.map(|v| (v, face)));
        let fans = Lists::sorted(rows.len(), around);
        let mut points = rows.columns().to_vec();
        points.sort_unstable();
        points.dedup();
        let place = |point: u32| points.partition_point(|&p| p < point) as u32;
        let uses = (0..rows.len())
            .flat_map(|row| rows.row(row).map(move |(point, weight)| (point, (row as u32, weight))));
        let pulls = Lists::sorted(points.len(), uses.map(|(point, entry)| (place(point), entry)));
        Self { rows, triangles, fans, points, pulls }
    }

    /// One coordinate of all rows by that of each point.
    pub(crate) fn column(&self, coordinate: impl Fn(usize) -> f64 + Sync) -> Vec<f64> {
        let row = |row: usize| self.rows.row(row).map(|(p, weight)| coordinate(p as usize) * weight).sum();
        (0..self.rows.len()).into_par_iter().with_min_len(RUN).map(row).collect()
    }

    /// The volume of the rows' places, and its gradient along one axis at the points, by [`Part::points`].
    ///
    /// With `n` twice the area vector of a triangle the volume is `sum n_a (a + b + c)_a / 6` and the gradient at a corner is the
    /// sum of `n_a / 6` around it, for the surface is closed.
    pub(crate) fn flux(&self, places: &[Vec<f64>; 3], axis: usize) -> (f64, Vec<f64>) {
        let [along, p, q] = [0, 1, 2].map(|i| &places[(axis + i) % 3]);
        let normal = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|v| v as usize);
            (p[b] - p[a]) * (q[c] - q[a]) - (q[b] - q[a]) * (p[c] - p[a])
        };
        let normals: Vec<f64> = self.triangles.par_iter().with_min_len(RUN).map(normal).collect();
        let middle = along.iter().sum::<f64>() / along.len().max(1) as f64;
        let volume: CompensatedSum = self
            .triangles
            .iter()
            .zip(&normals)
            .map(|(corners, n)| n * corners.iter().map(|&v| along[v as usize] - middle).sum::<f64>())
            .collect();
        let around = |row: usize| {
            let six: f64 = self.fans.list(row).iter().map(|&face| normals[face as usize]).sum();
            six / 6.0
        };
        let gradient: Vec<f64> = (0..self.rows.len()).into_par_iter().with_min_len(RUN).map(around).collect();
        let pulled = |point: usize| {
            self.pulls.list(point).iter().map(|&(row, weight)| gradient[row as usize] * weight).sum()
        };
        let pulls = (0..self.points.len()).into_par_iter().with_min_len(RUN).map(pulled).collect();
        (volume.value() / 6.0, pulls)
    }

    /// Points that the rows combine.
    pub(crate) fn points(&self) -> &[u32] {
        &self.points
    }
}

/// The mean of some rows.
fn mean(around: &[u32], rows: &[Vec<(u32, f64)>]) -> Vec<(u32, f64)> {
    let mut sums: BTreeMap<u32, f64> = BTreeMap::new();
    for &row in around {
        for &(point, weight) in &rows[row as usize] {
            *sums.entry(point).or_default() += weight / around.len() as f64;
        }
    }
    sums.into_iter().collect()
}

impl<T: Scalar> Binding<T> {
    /// The surface that the triangles form over the vertices bound, if it is not these themselves.
    pub fn over(&self) -> Option<&Surface> {
        self.over.as_ref().map(|over| &over.surface)
    }

    /// Number of vertices that triangles and pins can name: the surface's, or those bound.
    pub fn corner_count(&self) -> usize {
        self.over().map_or(self.vertices().len(), Surface::len)
    }

    /// The vertices bound that one corner is combined of.
    pub(crate) fn corner(&self, corner: u32) -> Vec<(u32, f64)> {
        self.over().map_or_else(|| vec![(corner, 1.0)], |surface| surface.row(corner as usize).collect())
    }

    /// The closed surfaces of all bodies over the points.
    ///
    /// # Errors
    /// [`crate::Error::Mesh`] where the triangles enclose no volume.
    pub(crate) fn parts(&self) -> Result<&[Part]> {
        let Some(over) = &self.over else { return Ok(&[]) };
        let closed = self.surface()?;
        let (count, partition) = (self.corner_count(), self.partition());
        let vertex = |node: u32| partition.vertex(node as usize, count) as u32;
        let part = |body: usize| {
            let own = |each: &&Vec<u32>| partition.of_node(each[0] as usize) as usize == body;
            let by_vertex = |each: &Vec<u32>| each.iter().map(|&node| vertex(node)).collect();
            let loops: Vec<Vec<u32>> = closed.loops().iter().filter(own).map(by_vertex).collect();
            let triangles = partition.triangles(body).unwrap_or(self.triangles());
            let triangles: Vec<[u32; 3]> = triangles.iter().map(|corners| corners.map(vertex)).collect();
            Part::new(&over.surface, &triangles, &loops)
        };
        Ok(over.parts.get_or_init(|| (0..partition.count()).map(part).collect()))
    }
}
