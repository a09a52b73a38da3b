// SPDX-License-Identifier: GPL-3.0-or-later
//! Patches as a mesh: samples that patches share along their edges, so that a closed model is a closed mesh at every level.

use std::collections::{BTreeMap, HashMap};

use crate::combination::Surface;
use crate::error::{Error, Result};
use crate::patches::Patches;

/// Segments along a patch at most: what a level costs grows with its square.
const FINEST: usize = 1024;

/// Marks the missing corner of a cell with three.
pub const NO_CORNER: u32 = u32::MAX;

/// A mesh whose vertices are fixed combinations of the patches' control points.
#[derive(Debug, Clone, PartialEq)]
pub struct Tessellation {
    /// The vertices over the control points.
    pub surface: Surface,
    /// Triangles, counter-clockwise seen from the side of the normals.
    pub triangles: Vec<[u32; 3]>,
    /// The cells that they halve; the last corner of one with three is [`NO_CORNER`].
    pub quads: Vec<[u32; 4]>,
    /// Patch of each cell.
    pub patch_of_quad: Vec<u32>,
    /// A patch that each vertex is on.
    pub patch_of_vertex: Vec<u32>,
    /// Its parameters there.
    pub parameters: Vec<[f64; 2]>,
}

/// What makes a sample the same as one of another patch.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
enum Sample {
    /// A control point.
    Point(u32),
    /// So many segments along an edge, from that of its ends where its control points in order are the smaller.
    Edge(Vec<u32>, usize),
    /// Within a patch.
    Within(u32, usize, usize),
}

/// The four edges of a patch in the direction in which they run around it.
fn edges(patches: &Patches, patch: usize) -> [Vec<u32>; 4] {
    let ([m, n], points) = (patches.shape(), patches.patch(patch));
    let along_u = |j: usize| (0..m).map(move |i| points[i * n + j]);
    let along_v = |i: usize| (0..n).map(move |j| points[i * n + j]);
    [
        along_u(0).collect(),
        along_v(m - 1).collect(),
        along_u(n - 1).rev().collect(),
        along_v(0).rev().collect(),
    ]
}

fn is_collapsed(edge: &[u32]) -> bool {
    edge.iter().all(|&point| point == edge[0])
}

/// An edge from the end that comes first, and whether that turned it round.
fn canonical(edge: &[u32]) -> (Vec<u32>, bool) {
    let reversed: Vec<u32> = edge.iter().rev().copied().collect();
    if reversed.as_slice() < edge { (reversed, true) } else { (edge.to_vec(), false) }
}

impl Patches {
    /// The mesh of `level` segments along every edge of every patch.
    ///
    /// Samples on edges that name the same control points are one vertex, so are all samples of a collapsed edge, and cells that
    /// lose corners so become triangles or nothing. Patches are wound as the first of those that hang together by edges.
    ///
    /// # Errors
    /// [`Error::Mesh`] for another level than 1 to 1024, and for patches that cannot be wound alike (a Möbius band).
    pub fn tessellate(&self, level: usize) -> Result<Tessellation> {
        if !(1..=FINEST).contains(&level) {
            return Err(Error::Mesh(format!("level: found {level}, expected 1 to {FINEST} segments")));
        }
        let turned = self.turned()?;
        let mut weaver = Weaver::new(self, level);
        (0..self.len()).for_each(|patch| weaver.add(patch, turned[patch]));
        Ok(weaver.finish())
    }

    /// Which patches must be wound the other way to fit the first of their piece.
    fn turned(&self) -> Result<Vec<bool>> {
        let neighbours = self.neighbours();
        let mut turned: Vec<Option<bool>> = vec![None; self.len()];
        for first in 0..self.len() {
            let mut waiting = Vec::new();
            if turned[first].is_none() {
                turned[first] = Some(false);
                waiting.push(first);
            }
            while let Some(patch) = waiting.pop() {
                for &(other, alike) in &neighbours[patch] {
                    let wanted = (turned[patch] == Some(true)) != alike;
                    match turned[other] {
                        None => {
                            turned[other] = Some(wanted);
                            waiting.push(other);
                        }
                        Some(found) if found != wanted => return Err(one_sided(patch, other)),
                        Some(_) => {}
                    }
                }
            }
        }
        Ok(turned.into_iter().map(|turned| turned == Some(true)).collect())
    }

    /// The patches that share an edge with each, and whether both run along it in the same direction. Edges of more than two patches
    /// join none.
    fn neighbours(&self) -> Vec<Vec<(usize, bool)>> {
        let mut users: BTreeMap<Vec<u32>, Vec<(usize, bool)>> = BTreeMap::new();
        for patch in 0..self.len() {
            for edge in edges(self, patch).iter().filter(|edge| !is_collapsed(edge)) {
                let (edge, reversed) = canonical(edge);
                users.entry(edge).or_default().push((patch, reversed));
            }
        }
        let mut neighbours = vec![Vec::new(); self.len()];
        for users in users.values() {
            if let [(a, along_a), (b, along_b)] = users.as_slice()
                && a != b
            {
                neighbours[*a].push((*b, along_a == along_b));
                neighbours[*b].push((*a, along_a == along_b));
            }
        }
        neighbours
    }
}

fn one_sided(patch: usize, other: usize) -> Error {
    Error::Mesh(format!(
        "patches: patches {patch} and {other} share an edge but cannot be wound alike with the patches around them, expected a surface with two sides; take one of them out"
    ))
}

/// Adds patch after patch to a mesh.
struct Weaver<'a> {
    patches: &'a Patches,
    level: usize,
    /// Values of the basis functions at all samples, along u and v.
    weights: [Vec<Vec<f64>>; 2],
    known: HashMap<Sample, u32>,
    rows: Vec<Vec<(u32, f64)>>,
    mesh: Tessellation,
}

impl<'a> Weaver<'a> {
    fn new(patches: &'a Patches, level: usize) -> Self {
        let weights = patches.bases().each_ref().map(|basis| {
            let span = basis.span(0);
            let at = |k: usize| {
                let mut values = vec![0.0; basis.count()];
                span.evaluate(k as f64 / level as f64, &mut values);
                values
            };
            (0..=level).map(at).collect()
        });
        let mesh = Tessellation {
            surface: Surface::of_rows(patches.points().len(), Vec::<Vec<(u32, f64)>>::new()),
            triangles: Vec::new(),
            quads: Vec::new(),
            patch_of_quad: Vec::new(),
            patch_of_vertex: Vec::new(),
            parameters: Vec::new(),
        };
        Self { patches, level, weights, known: HashMap::new(), rows: Vec::new(), mesh }
    }

    fn add(&mut self, patch: usize, turned: bool) {
        let level = self.level;
        let sides = edges(self.patches, patch);
        let mut grid = Vec::with_capacity((level + 1) * (level + 1));
        for i in 0..=level {
            for j in 0..=level {
                let sample = self.sample(patch, &sides, i, j);
                grid.push(self.vertex(patch, sample, i, j));
            }
        }
        let at = |i: usize, j: usize| grid[i * (level + 1) + j];
        for i in 0..level {
            for j in 0..level {
                let mut corners = vec![at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                if turned {
                    corners.reverse();
                }
                self.cell(patch, corners);
            }
        }
    }

    /// What sample `[i, j]` of a patch is, by the patch's sides.
    fn sample(&self, patch: usize, sides: &[Vec<u32>; 4], i: usize, j: usize) -> Sample {
        let level = self.level;
        // The side, and how far along it.
        let (side, k) = match (i, j) {
            (_, 0) => (0, i),
            _ if i == level => (1, j),
            _ if j == level => (2, level - i),
            (0, _) => (3, level - j),
            _ => return Sample::Within(patch as u32, i, j),
        };
        let edge = &sides[side];
        match k {
            0 => Sample::Point(edge[0]),
            _ if k == level => Sample::Point(edge[edge.len() - 1]),
            _ if is_collapsed(edge) => Sample::Point(edge[0]),
            _ => {
                let (edge, reversed) = canonical(edge);
                Sample::Edge(edge, if reversed { level - k } else { k })
            }
        }
    }

    /// The vertex of a sample, new where no patch before had it.
    fn vertex(&mut self, patch: usize, sample: Sample, i: usize, j: usize) -> u32 {
        if let Some(&vertex) = self.known.get(&sample) {
            return vertex;
        }
        let vertex = self.rows.len() as u32;
        self.rows.push(self.row(patch, &sample));
        self.mesh.patch_of_vertex.push(patch as u32);
        self.mesh.parameters.push([i, j].map(|k| k as f64 / self.level as f64));
        self.known.insert(sample, vertex);
        vertex
    }

    /// The control points of a sample with their weights. On an edge they depend on nothing but the edge.
    fn row(&self, patch: usize, sample: &Sample) -> Vec<(u32, f64)> {
        let mut sums: BTreeMap<u32, f64> = BTreeMap::new();
        let [u, v] = &self.weights;
        match sample {
            Sample::Point(point) => drop(sums.insert(*point, 1.0)),
            Sample::Edge(edge, k) => {
                let weights = if edge.len() == u[*k].len() { &u[*k] } else { &v[*k] };
                edge.iter().zip(weights).for_each(|(&point, w)| *sums.entry(point).or_default() += w);
            }
            Sample::Within(_, i, j) => {
                let weights = u[*i].iter().flat_map(|wu| v[*j].iter().map(move |wv| wu * wv));
                let points = self.patches.patch(patch).iter();
                points.zip(weights).for_each(|(&point, w)| *sums.entry(point).or_default() += w);
            }
        }
        sums.into_iter().filter(|(_, weight)| *weight != 0.0).collect()
    }

    /// Adds a cell by its corners, of which some may be one vertex.
    fn cell(&mut self, patch: usize, mut corners: Vec<u32>) {
        corners.dedup();
        if corners.len() > 1 && corners.first() == corners.last() {
            corners.pop();
        }
        let mesh = &mut self.mesh;
        match *corners.as_slice() {
            // A cell folded in two encloses nothing, and its edges cancel each other.
            [a, b, c, d] if a != c && b != d => {
                mesh.quads.push([a, b, c, d]);
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
            [a, b, c] => {
                mesh.quads.push([a, b, c, NO_CORNER]);
                mesh.triangles.push([a, b, c]);
            }
            _ => return,
        }
        mesh.patch_of_quad.push(patch as u32);
    }

    fn finish(self) -> Tessellation {
        Tessellation { surface: Surface::of_rows(self.patches.points().len(), self.rows), ..self.mesh }
    }
}
