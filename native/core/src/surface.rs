// SPDX-License-Identifier: GPL-3.0-or-later
//! Triangulated surfaces: the check that one encloses a volume, the closed walk around every vertex, and the volume.

use std::fmt::Write as _;

use glam::DVec3;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::sum::CompensatedSum;

/// A closed, consistently oriented triangle surface, with the walk of neighbours around every vertex.
///
/// The triangles `(v, n_i, n_i+1)` around a vertex `v` chain up into closed walks `n_0, n_1, …`, because every edge is used
/// once in each direction. Where several fans meet in one vertex their walks are joined through their first
/// neighbours, there and back, which adds nothing to sums over the walk. So the gradient of the volume needs one look at
/// each neighbour, not two for each triangle.
#[derive(Debug, Clone)]
pub struct ClosedSurface {
    /// Start of every vertex's walk in `walk`; one more entry than vertices.
    offsets: Vec<u32>,
    walk: Vec<u32>,
}

impl ClosedSurface {
    /// Checks that `triangles` over `vertex_count` vertices are closed, manifold along edges and consistently wound, and
    /// chains the neighbours. Indices must be in range. Vertices without triangles are allowed.
    ///
    /// # Errors
    /// [`Error::Mesh`] with the first offending edge and the number of them.
    pub fn new(vertex_count: usize, triangles: &[[u32; 3]]) -> Result<Self> {
        if triangles.is_empty() {
            return Err(Error::Mesh(
                "triangles: found none, expected a closed surface; only a mesh with faces encloses a volume"
                    .into(),
            ));
        }
        if let Some(f) = triangles.iter().position(|[a, b, c]| a == b || b == c || c == a) {
            let count = triangles.iter().filter(|[a, b, c]| a == b || b == c || c == a).count();
            return Err(Error::Mesh(format!(
                "triangles: {count} repeat a vertex, the first is triangle {f} {:?}; expected three different vertices; remove degenerate faces",
                triangles[f]
            )));
        }
        let fans = Fans::new(vertex_count, triangles);
        let walks: Vec<Option<Vec<u32>>> =
            (0..vertex_count).into_par_iter().map(|v| closed_walk(fans.around(v))).collect();
        if walks.iter().any(Option::is_none) {
            return Err(Error::Mesh(describe_broken_edges(triangles)));
        }
        let mut offsets = Vec::with_capacity(vertex_count + 1);
        let mut walk = Vec::with_capacity(triangles.len() * 3);
        offsets.push(0);
        for ring in walks.into_iter().flatten() {
            walk.extend(ring);
            offsets.push(walk.len() as u32);
        }
        Ok(Self { offsets, walk })
    }

    /// The closed walk around a vertex; empty for a vertex without triangles.
    pub fn around(&self, vertex: usize) -> &[u32] {
        &self.walk[self.offsets[vertex] as usize..self.offsets[vertex + 1] as usize]
    }
}

/// For every vertex `v` the pairs `(a, b)` of its triangles `(v, a, b)`.
struct Fans {
    offsets: Vec<u32>,
    pairs: Vec<[u32; 2]>,
}

impl Fans {
    fn new(vertex_count: usize, triangles: &[[u32; 3]]) -> Self {
        let mut offsets = vec![0u32; vertex_count + 1];
        for &v in triangles.as_flattened() {
            offsets[v as usize + 1] += 1;
        }
        for v in 0..vertex_count {
            offsets[v + 1] += offsets[v];
        }
        let mut next = offsets.clone();
        let mut pairs = vec![[0u32; 2]; triangles.len() * 3];
        for &[a, b, c] in triangles {
            for [v, m, n] in [[a, b, c], [b, c, a], [c, a, b]] {
                pairs[next[v as usize] as usize] = [m, n];
                next[v as usize] += 1;
            }
        }
        Self { offsets, pairs }
    }

    fn around(&self, v: usize) -> &[[u32; 2]] {
        &self.pairs[self.offsets[v] as usize..self.offsets[v + 1] as usize]
    }
}

/// Chains the pairs of a fan into one closed walk, or `None` where an edge at the vertex is not used exactly once in each
/// direction.
fn closed_walk(fan: &[[u32; 2]]) -> Option<Vec<u32>> {
    let mut pairs = fan.to_vec();
    pairs.sort_unstable();
    if pairs.windows(2).any(|two| two[0][0] == two[1][0]) {
        return None;
    }
    let mut used = vec![false; pairs.len()];
    let mut cycles = Vec::new();
    for start in 0..pairs.len() {
        if used[start] {
            continue;
        }
        let mut cycle = Vec::with_capacity(pairs.len());
        let mut at = start;
        loop {
            used[at] = true;
            cycle.push(pairs[at][0]);
            let next = pairs[at][1];
            if next == pairs[start][0] {
                break;
            }
            at = pairs.binary_search_by_key(&next, |pair| pair[0]).ok().filter(|&i| !used[i])?;
        }
        cycles.push(cycle);
    }
    Some(join_cycles(cycles))
}

/// One closed walk through all cycles: each is closed, and the walk returns to its anchor before the next, so that every
/// connecting step is taken once in each direction.
fn join_cycles(mut cycles: Vec<Vec<u32>>) -> Vec<u32> {
    if cycles.len() == 1 {
        return cycles.swap_remove(0);
    }
    let anchor = cycles.first().map(|cycle| cycle[0]);
    cycles
        .into_iter()
        .flat_map(|cycle| [cycle.clone(), vec![cycle[0]], Vec::from_iter(anchor)])
        .flatten()
        .collect()
}

/// Counts the edges that are not used once in each direction, by kind, and names the first of each kind.
fn describe_broken_edges(triangles: &[[u32; 3]]) -> String {
    let mut edges: Vec<(u32, u32, bool, u32)> = Vec::with_capacity(triangles.len() * 3);
    for (f, &[a, b, c]) in triangles.iter().enumerate() {
        edges.extend([(a, b), (b, c), (c, a)].map(|(m, n)| (m.min(n), m.max(n), m < n, f as u32)));
    }
    edges.par_sort_unstable();
    let mut kinds: [Option<(usize, u32, u32, u32)>; 3] = [None; 3];
    for group in edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
        let forward = group.iter().filter(|edge| edge.2).count();
        let kind = match (group.len(), forward) {
            (2, 1) => continue,
            (1, _) => 0,
            (2, _) => 2,
            _ => 1,
        };
        let face = group.iter().map(|edge| edge.3).min().unwrap_or_default();
        let (count, ..) = *kinds[kind].get_or_insert((0, group[0].0, group[0].1, face));
        kinds[kind] = kinds[kind].map(|(_, a, b, first)| (count + 1, a, b, first));
    }
    let names = [
        "open (used by one triangle only; close the holes)",
        "non-manifold (used by more than two triangles; remove inner faces)",
        "inconsistently wound (used twice in one direction; recalculate the normals)",
    ];
    let mut text = String::from(
        "the surface does not enclose a volume, expected every edge to be used once in each direction:",
    );
    for (name, found) in names.iter().zip(kinds) {
        if let Some((count, a, b, face)) = found {
            let _ = write!(text, " {count} edges are {name}, the first is edge {a}-{b} of triangle {face};");
        }
    }
    text.pop();
    text
}

/// Volume, area and extent of a triangulated surface, measured in float64 about the middle of its bounding box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measure {
    /// Signed volume: positive where the triangles wind counter-clockwise seen from outside.
    pub volume: f64,
    /// Sum of the triangles' areas.
    pub area: f64,
    /// Largest absolute coordinate about the middle.
    pub radius: f64,
}

impl Measure {
    /// Measures the surface: the paper's equation (5) in its symmetric form `sum x_l . (x_m x x_n) / 6`, in fixed pieces
    /// whose results are added with compensation, so that the outcome does not depend on the number of threads.
    pub fn of(vertex: impl Fn(usize) -> DVec3 + Sync, vertex_count: usize, triangles: &[[u32; 3]]) -> Self {
        const PIECE: usize = 4096;
        let (low, high) = (0..vertex_count.div_ceil(PIECE))
            .into_par_iter()
            .map(|piece| {
                let all = piece * PIECE..((piece + 1) * PIECE).min(vertex_count);
                all.map(&vertex)
                    .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)))
            })
            .reduce(|| (DVec3::INFINITY, DVec3::NEG_INFINITY), |a, b| (a.0.min(b.0), a.1.max(b.1)));
        let middle = if vertex_count == 0 { DVec3::ZERO } else { (low + high) * 0.5 };
        let pieces: Vec<(f64, f64)> = triangles
            .par_chunks(PIECE)
            .map(|piece| {
                let (mut six_volumes, mut two_areas) = (CompensatedSum::default(), 0.0);
                for corners in piece {
                    let [a, b, c] = corners.map(|v| vertex(v as usize) - middle);
                    six_volumes.add(a.dot(b.cross(c)));
                    two_areas += (b - a).cross(c - a).length();
                }
                (six_volumes.value(), two_areas)
            })
            .collect();
        let six_volumes: CompensatedSum = pieces.iter().map(|piece| piece.0).collect();
        let radius = if vertex_count == 0 { 0.0 } else { (high - middle).max_element() };
        Self {
            volume: six_volumes.value() / 6.0,
            area: pieces.iter().map(|piece| piece.1).sum::<f64>() / 2.0,
            radius,
        }
    }

    /// Whether the volume is no more than what rounding of coordinates of relative precision `epsilon` can make of zero:
    /// `4 epsilon area radius`.
    pub fn is_flat(&self, epsilon: f64) -> bool {
        self.volume.abs() <= 4.0 * epsilon * self.area * self.radius
    }
}
