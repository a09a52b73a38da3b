// SPDX-License-Identifier: GPL-3.0-or-later
//! Triangulated surfaces: the check that one encloses a volume, the closed walk around every vertex, and the volume.

use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;

use crate::bodies::{Partition, edges_of};
use crate::broken;
use crate::error::{Error, Result};
use crate::sum::CompensatedSum;

/// A closed, consistently oriented triangle surface, with the walk of neighbours around every vertex.
///
/// The triangles `(v, n_i, n_i+1)` around a vertex `v` chain up into closed walks `n_0, n_1, …`, because every edge is used
/// once in each direction. Where several fans meet in one vertex their walks are joined through their first
/// neighbours, there and back, which adds nothing to sums over the walk. So the gradient of the volume needs one look at
/// each neighbour, not two for each triangle.
///
/// Caps close what is open: at a hole's edge the fan `n_0, …, n_k` of a vertex is open, and its walk closes through the vertex
/// itself, which adds nothing to sums relative to the vertex; the caps' own part is added by [`crate::caps`].
#[derive(Debug, Clone)]
pub struct ClosedSurface {
    /// Start of every vertex's walk in `walk`; one more entry than vertices.
    offsets: Vec<u32>,
    walk: Vec<u32>,
    /// The loops that caps close, in the direction of the caps' own half-edges.
    loops: Vec<Vec<u32>>,
}

impl ClosedSurface {
    /// Checks that `triangles` over `vertex_count` vertices are closed, manifold along edges and consistently wound, and
    /// chains the neighbours. Indices must be in range. Vertices without triangles are allowed.
    ///
    /// # Errors
    /// [`Error::Mesh`] with the number of offending edges and the first of each kind.
    pub fn new(vertex_count: usize, triangles: &[[u32; 3]]) -> Result<Self> {
        Self::capped(vertex_count, triangles, false)
    }

    /// The same with holes closed by caps, if they are allowed.
    pub(crate) fn capped(vertex_count: usize, triangles: &[[u32; 3]], caps: bool) -> Result<Self> {
        if triangles.is_empty() {
            return Err(Error::Mesh(
                "triangles: found none, expected a closed surface; only a mesh with faces encloses a volume"
                    .into(),
            ));
        }
        broken::refuse_degenerate(triangles)?;
        let rings = Rings::new(vertex_count, triangles);
        if rings.0.iter().any(Option::is_none) {
            let faces = triangles.iter().enumerate();
            return Err(Error::Mesh(format!("the surface {}", broken::edges(faces, true))));
        }
        let surface = Self::of_rings(rings, |_| true);
        if !caps && !surface.loops.is_empty() {
            return Err(Error::Mesh(format!("the surface {}", broken::holes(&surface.loops))));
        }
        Ok(surface)
    }

    /// The surface of the vertices that are kept, whose rings must be sound.
    pub(crate) fn of_rings(rings: Rings, keep: impl Fn(usize) -> bool) -> Self {
        let steps: usize = rings.0.iter().flatten().map(|ring| ring.walk.len()).sum();
        let mut offsets = Vec::with_capacity(rings.0.len() + 1);
        let mut walk = Vec::with_capacity(steps);
        let mut edges = Vec::new();
        offsets.push(0);
        for (v, ring) in rings.0.into_iter().enumerate() {
            if let Some(ring) = ring.filter(|_| keep(v)) {
                walk.extend(ring.walk);
                edges.extend(ring.caps.iter().map(|&to| [v as u32, to]));
            }
            offsets.push(walk.len() as u32);
        }
        Self { offsets, walk, loops: simple_loops(edges) }
    }

    /// The surface of triangles whose half-edges cancel, how many ever meet in an edge.
    pub(crate) fn of_cycle(vertex_count: usize, triangles: &[[u32; 3]]) -> Self {
        let fans = Fans::new(vertex_count, triangles);
        let ring = |v| Some(Ring { walk: join_cycles(any_cycles(fans.around(v))), caps: Vec::new() });
        Self::of_rings(Rings((0..vertex_count).into_par_iter().map(ring).collect()), |_| true)
    }

    /// The closed walk around a vertex; empty for a vertex without triangles.
    pub fn around(&self, vertex: usize) -> &[u32] {
        &self.walk[self.offsets[vertex] as usize..self.offsets[vertex + 1] as usize]
    }

    /// The loops that caps close: vertices in the direction of the caps' own half-edges, from the smallest on.
    pub fn loops(&self) -> &[Vec<u32>] {
        &self.loops
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

/// What is around every vertex; `None` where an edge at the vertex is used twice in one direction.
pub(crate) struct Rings(pub(crate) Vec<Option<Ring>>);

/// The triangles around a vertex, chained.
pub(crate) struct Ring {
    /// Closed walk of neighbours.
    walk: Vec<u32>,
    /// Neighbours to which a cap's half-edge leads from here; none where the triangles around are closed.
    caps: Vec<u32>,
}

impl Rings {
    pub(crate) fn new(vertex_count: usize, triangles: &[[u32; 3]]) -> Self {
        let fans = Fans::new(vertex_count, triangles);
        Self((0..vertex_count).into_par_iter().map(|v| Ring::new(v as u32, fans.around(v))).collect())
    }
}

impl Ring {
    /// Chains the pairs of a vertex's fans.
    fn new(vertex: u32, fan: &[[u32; 2]]) -> Option<Self> {
        let mut pairs = fan.to_vec();
        pairs.sort_unstable();
        let is_twice = |two: &[[u32; 2]]| two[0][0] == two[1][0];
        let is_degenerate = |&[a, b]: &[u32; 2]| a == b || a == vertex || b == vertex;
        if pairs.windows(2).any(is_twice) || pairs.iter().any(is_degenerate) {
            return None;
        }
        let mut used = vec![false; pairs.len()];
        if let Some(cycles) = cycles(&pairs, &mut used) {
            return Some(Self { walk: join_cycles(cycles), caps: Vec::new() });
        }
        let mut ends: Vec<u32> = pairs.iter().map(|pair| pair[1]).collect();
        ends.sort_unstable();
        if ends.windows(2).any(|two| two[0] == two[1]) {
            return None;
        }
        used.fill(false);
        let (mut walks, mut caps) = (Vec::new(), Vec::new());
        for start in (0..pairs.len()).filter(|&start| ends.binary_search(&pairs[start][0]).is_err()) {
            let (mut chain, last) = chain(&pairs, &mut used, start);
            chain.extend([last, vertex]);
            walks.push(chain);
            caps.push(last);
        }
        walks.extend(cycles(&pairs, &mut used)?);
        Some(Self { walk: join_cycles(walks), caps })
    }

    pub(crate) fn is_open(&self) -> bool {
        !self.caps.is_empty()
    }
}

/// Cycles of pairs of which as many end as begin at each neighbour: whichever way one goes, it leads back.
fn any_cycles(fan: &[[u32; 2]]) -> Vec<Vec<u32>> {
    let mut pairs = fan.to_vec();
    pairs.sort_unstable();
    let mut used = vec![false; pairs.len()];
    let mut cycles = Vec::new();
    for start in 0..pairs.len() {
        let (mut cycle, mut at) = (Vec::new(), Some(start).filter(|&start| !used[start]));
        while let Some(pair) = at {
            used[pair] = true;
            let [from, to] = pairs[pair];
            cycle.push(from);
            let first = pairs.partition_point(|pair| pair[0] < to);
            at = (first..pairs.len()).take_while(|&next| pairs[next][0] == to).find(|&next| !used[next]);
        }
        if !cycle.is_empty() {
            cycles.push(cycle);
        }
    }
    cycles
}

/// All closed cycles of pairs not used yet; `None` where one does not close.
fn cycles(pairs: &[[u32; 2]], used: &mut [bool]) -> Option<Vec<Vec<u32>>> {
    let mut cycles = Vec::new();
    for start in 0..pairs.len() {
        if !used[start] {
            let (cycle, end) = chain(pairs, used, start);
            if end != pairs[start][0] {
                return None;
            }
            cycles.push(cycle);
        }
    }
    Some(cycles)
}

/// The first neighbours of pairs that follow one another, as far as they are not used yet, and the neighbour that ends them.
fn chain(pairs: &[[u32; 2]], used: &mut [bool], start: usize) -> (Vec<u32>, u32) {
    let mut chain = Vec::with_capacity(pairs.len() + 1);
    let mut at = start;
    loop {
        used[at] = true;
        chain.push(pairs[at][0]);
        let next = pairs[at][1];
        match pairs.binary_search_by_key(&next, |pair| pair[0]) {
            Ok(following) if !used[following] => at = following,
            _ => return (chain, next),
        }
    }
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

/// Loops that visit no vertex twice and use every half-edge once. As many half-edges must end at every vertex as start there.
fn simple_loops(mut edges: Vec<[u32; 2]>) -> Vec<Vec<u32>> {
    edges.sort_unstable();
    let mut next: HashMap<u32, usize> = HashMap::new();
    for (i, &[from, _]) in edges.iter().enumerate().rev() {
        next.insert(from, i);
    }
    let mut loops = Vec::new();
    let (mut path, mut place) = (Vec::new(), HashMap::new());
    for start in 0..edges.len() {
        let mut at = edges[start][0];
        if next[&at] > start {
            continue;
        }
        // Follow unused half-edges, and take out a loop as soon as the path meets itself.
        while let Some(edge) = next.get(&at).copied().filter(|&i| edges.get(i).is_some_and(|e| e[0] == at)) {
            next.insert(at, edge + 1);
            place.insert(at, path.len());
            path.push(at);
            at = edges[edge][1];
            if let Some(&first) = place.get(&at) {
                let found: Vec<u32> = path.drain(first..).collect();
                for v in &found {
                    place.remove(v);
                }
                loops.push(found);
            }
        }
    }
    for each in &mut loops {
        let smallest = (0..each.len()).min_by_key(|&i| each[i]).unwrap_or_default();
        each.rotate_left(smallest);
    }
    loops.sort_unstable();
    loops
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
    /// Largest absolute coordinate.
    pub reach: f64,
}

/// Vertices or triangles that are added up one after the other; more are shared between threads.
const PIECE: usize = 4096;

/// A box without points.
const NOWHERE: (DVec3, DVec3) = (DVec3::INFINITY, DVec3::NEG_INFINITY);

impl Measure {
    /// Measures the surface: the paper's equation (5) in its symmetric form `sum x_l . (x_m x x_n) / 6`, in fixed pieces
    /// whose results are added with compensation, so that the outcome does not depend on the number of threads.
    pub fn of(vertex: impl Fn(usize) -> DVec3 + Sync, vertex_count: usize, triangles: &[[u32; 3]]) -> Self {
        let bounds = (0..vertex_count.div_ceil(PIECE))
            .into_par_iter()
            .map(|piece| {
                let all = piece * PIECE..((piece + 1) * PIECE).min(vertex_count);
                all.map(&vertex).fold(NOWHERE, including)
            })
            .reduce(|| NOWHERE, joined);
        Self::within(bounds, vertex, triangles, &[])
    }

    /// The same for triangles that take a part of the vertices, with caps on loops.
    pub(crate) fn of_part(
        vertex: impl Fn(usize) -> DVec3 + Sync,
        triangles: &[[u32; 3]],
        loops: &[&[u32]],
    ) -> Self {
        let corners = |piece: &[[u32; 3]]| {
            piece.as_flattened().iter().map(|&v| vertex(v as usize)).fold(NOWHERE, including)
        };
        let bounds = triangles.par_chunks(PIECE).map(corners).reduce(|| NOWHERE, joined);
        Self::within(bounds, vertex, triangles, loops)
    }

    /// All bodies of a surface in parts.
    pub(crate) fn of_bodies(
        partition: &Partition,
        surface: &ClosedSurface,
        vertex: impl Fn(usize) -> DVec3 + Sync,
        vertex_count: usize,
    ) -> Vec<Self> {
        let mut loops: Vec<Vec<&[u32]>> = vec![Vec::new(); partition.count()];
        for each in surface.loops() {
            loops[partition.of_node(each[0] as usize) as usize].push(each);
        }
        let node = |node: usize| vertex(partition.vertex(node, vertex_count));
        let body = |(body, loops): (usize, &Vec<&[u32]>)| {
            Self::of_part(node, partition.triangles(body).unwrap_or_default(), loops)
        };
        loops.par_iter().enumerate().map(body).collect()
    }

    /// Several bodies as one.
    pub(crate) fn sum(bodies: &[Self]) -> Self {
        let largest = |pick: fn(&Self) -> f64| bodies.iter().map(pick).fold(0.0, f64::max);
        Self {
            volume: bodies.iter().map(|body| body.volume).collect::<CompensatedSum>().value(),
            area: bodies.iter().map(|body| body.area).sum(),
            radius: largest(|body| body.radius),
            reach: largest(|body| body.reach),
        }
    }

    fn within(
        (low, high): (DVec3, DVec3),
        vertex: impl Fn(usize) -> DVec3 + Sync,
        triangles: &[[u32; 3]],
        loops: &[&[u32]],
    ) -> Self {
        let is_empty = low.x > high.x;
        let middle = if is_empty { DVec3::ZERO } else { (low + high) * 0.5 };
        let at = |v: u32| vertex(v as usize) - middle;
        let measured = |faces: &mut dyn Iterator<Item = [DVec3; 3]>| {
            let (mut six_volumes, mut two_areas) = (CompensatedSum::default(), 0.0);
            for [a, b, c] in faces {
                six_volumes.add(a.dot(b.cross(c)));
                two_areas += (b - a).cross(c - a).length();
            }
            (six_volumes.value(), two_areas)
        };
        let mut pieces: Vec<(f64, f64)> = triangles
            .par_chunks(PIECE)
            .map(|piece| measured(&mut piece.iter().map(|corners| corners.map(at))))
            .collect();
        pieces.extend(loops.iter().map(|each| {
            let apex = each.iter().map(|&v| at(v)).sum::<DVec3>() / each.len() as f64;
            measured(&mut edges_of(each).map(|[a, b]| [at(a), at(b), apex]))
        }));
        let six_volumes: CompensatedSum = pieces.iter().map(|piece| piece.0).collect();
        Self {
            volume: six_volumes.value() / 6.0,
            area: pieces.iter().map(|piece| piece.1).sum::<f64>() / 2.0,
            radius: if is_empty { 0.0 } else { (high - middle).max_element() },
            reach: if is_empty { 0.0 } else { low.abs().max(high.abs()).max_element() },
        }
    }

    /// Whether the volume is no more than what rounding of coordinates of relative precision `epsilon` can make of zero:
    /// `4 epsilon area radius`.
    pub fn is_flat(&self, epsilon: f64) -> bool {
        self.volume.abs() <= 4.0 * epsilon * self.area * self.radius
    }

    /// Whether the volume is no more than coordinates rounded where they stand can make of a flat piece: moving every vertex by a
    /// distance changes it by the area times that at most.
    pub(crate) fn is_rounding(&self, epsilon: f64) -> bool {
        self.volume.abs() <= epsilon * self.area * self.reach
    }
}

fn including((low, high): (DVec3, DVec3), p: DVec3) -> (DVec3, DVec3) {
    (low.min(p), high.max(p))
}

fn joined(a: (DVec3, DVec3), b: (DVec3, DVec3)) -> (DVec3, DVec3) {
    (a.0.min(b.0), a.1.max(b.1))
}
