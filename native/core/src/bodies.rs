// SPDX-License-Identifier: GPL-3.0-or-later
//! Which triangles enclose a volume of their own, and the vertices that several such bodies share.

use std::collections::HashMap;

use glam::DVec3;

use crate::broken;
use crate::error::{Error, Result};
use crate::surface::{ClosedSurface, Measure, Rings};

/// Which triangles enclose a volume that is kept of its own.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Bodies {
    /// All triangles enclose one volume.
    #[default]
    Whole,
    /// Every piece that is connected by shared vertices, if it encloses a volume; others deform along.
    Islands,
    /// The body of each triangle, from 0 on without a gap; -1 for those of no body. Borders between bodies are closed by caps.
    Labels(Vec<i32>),
}

/// Marks what belongs to no body.
pub(crate) const NO_BODY: u32 = u32::MAX;

/// The bodies of a mesh.
///
/// A vertex that several bodies share becomes one *node* for each of them, so that every node belongs to one body at most. The
/// vertices' own nodes come first, in their order.
#[derive(Debug, Clone, Default)]
pub(crate) struct Partition {
    count: usize,
    /// Body of each triangle, or -1; `None` where all triangles are one body.
    of_triangle: Option<Vec<i32>>,
    /// Body of each node, or `NO_BODY`; empty where all triangles are one body.
    of_node: Vec<u32>,
    /// Vertices of the nodes beyond the vertices' own.
    further: Vec<u32>,
    /// Triangles of the bodies, by nodes, body after body.
    triangles: Vec<[u32; 3]>,
    /// Start of each body's triangles; one more entry than bodies.
    starts: Vec<usize>,
}

impl Partition {
    /// All triangles are one body.
    pub(crate) fn whole() -> Self {
        Self { count: 1, ..Self::default() }
    }

    /// Bodies by the label of each triangle.
    pub(crate) fn labelled(vertex_count: usize, triangles: &[[u32; 3]], labels: Vec<i32>) -> Self {
        let count = labels.iter().max().map_or(0, |&largest| (largest + 1) as usize);
        let mut partition = Self { count, of_node: vec![NO_BODY; vertex_count], ..Self::default() };
        let mut known: HashMap<(u32, u32), u32> = HashMap::new();
        let mut by_node = triangles.to_vec();
        for (corners, &label) in by_node.iter_mut().zip(&labels).filter(|(_, label)| **label >= 0) {
            for corner in corners {
                *corner = partition.node(*corner, label as u32, &mut known);
            }
        }
        partition.starts = vec![0; count + 1];
        labels.iter().filter(|label| **label >= 0).for_each(|&l| partition.starts[l as usize + 1] += 1);
        (0..count).for_each(|body| partition.starts[body + 1] += partition.starts[body]);
        let mut next = partition.starts.clone();
        partition.triangles = vec![[0; 3]; partition.starts[count]];
        for (corners, &label) in by_node.iter().zip(&labels).filter(|(_, label)| **label >= 0) {
            partition.triangles[next[label as usize]] = *corners;
            next[label as usize] += 1;
        }
        partition.of_triangle = Some(labels);
        partition
    }

    /// The node of a vertex in a body, new where the vertex's own node belongs to another.
    fn node(&mut self, vertex: u32, body: u32, known: &mut HashMap<(u32, u32), u32>) -> u32 {
        let owner = &mut self.of_node[vertex as usize];
        if *owner == NO_BODY || *owner == body {
            *owner = body;
            return vertex;
        }
        *known.entry((vertex, body)).or_insert_with(|| {
            self.further.push(vertex);
            self.of_node.push(body);
            self.of_node.len() as u32 - 1
        })
    }

    /// Number of bodies.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// Number of nodes of a mesh with so many vertices.
    pub(crate) fn nodes(&self, vertex_count: usize) -> usize {
        vertex_count + self.further.len()
    }

    /// Vertex of a node.
    pub(crate) fn vertex(&self, node: usize, vertex_count: usize) -> usize {
        if node < vertex_count { node } else { self.further[node - vertex_count] as usize }
    }

    /// Vertices of the nodes beyond the vertices' own.
    pub(crate) fn further(&self) -> &[u32] {
        &self.further
    }

    /// Body of a node, or `NO_BODY`.
    pub(crate) fn of_node(&self, node: usize) -> u32 {
        if self.of_node.is_empty() { 0 } else { self.of_node[node] }
    }

    /// Body of each triangle, or -1; `None` where all are one body.
    pub(crate) fn of_triangle(&self) -> Option<&[i32]> {
        self.of_triangle.as_deref()
    }

    /// Triangles of one body by nodes; `None` where all triangles are one body.
    pub(crate) fn triangles(&self, body: usize) -> Option<&[[u32; 3]]> {
        self.of_triangle.as_ref().map(|_| &self.triangles[self.starts[body]..self.starts[body + 1]])
    }

    /// The surface of all bodies, by nodes.
    ///
    /// # Errors
    /// [`Error::Mesh`] for edges not used once in each direction, but for open ones that caps may close: `caps` allows it for holes;
    /// borders with other triangles are always closed.
    pub(crate) fn surface(&self, triangles: &[[u32; 3]], caps: bool) -> Result<ClosedSurface> {
        broken::refuse_degenerate(triangles)?;
        let rings = Rings::new(self.of_node.len(), &self.triangles);
        if let Some(node) = rings.0.iter().position(Option::is_none) {
            let body = self.of_node[node];
            let labels = self.of_triangle.iter().flatten();
            let faces = triangles.iter().enumerate().zip(labels);
            let own = faces.filter(|(_, label)| **label == body as i32).map(|(face, _)| face);
            return Err(Error::Mesh(format!("body {body} {}", broken::edges(own, false))));
        }
        let surface = ClosedSurface::of_rings(rings, |_| true);
        match self.holes(&surface, triangles).split_first() {
            Some(((body, first), rest)) if !caps => {
                let own = rest.iter().filter(|(other, _)| other == body).map(|(_, hole)| hole.clone());
                let holes: Vec<Vec<u32>> = std::iter::once(first.clone()).chain(own).collect();
                Err(Error::Mesh(format!("body {body} {}", broken::holes(&holes))))
            }
            _ => Ok(surface),
        }
    }

    /// Loops with an edge at which the mesh itself ends, each with its body and by vertices.
    fn holes(&self, surface: &ClosedSurface, triangles: &[[u32; 3]]) -> Vec<(u32, Vec<u32>)> {
        let count = self.of_node.len() - self.further.len();
        let vertex = |node: u32| self.vertex(node as usize, count) as u32;
        let by_vertex = |each: &Vec<u32>| each.iter().map(|&node| vertex(node)).collect::<Vec<u32>>();
        let loops: Vec<(u32, Vec<u32>)> =
            surface.loops().iter().map(|each| (self.of_node[each[0] as usize], by_vertex(each))).collect();
        let mut borders: HashMap<[u32; 2], bool> =
            loops.iter().flat_map(|(_, each)| edges_of(each)).map(|edge| (edge, false)).collect();
        for &[a, b, c] in triangles {
            for edge in [[a, b], [b, c], [c, a]] {
                borders.entry(edge).and_modify(|is_border| *is_border = true);
            }
        }
        let is_hole = |(_, each): &(u32, Vec<u32>)| edges_of(each).any(|edge| !borders[&edge]);
        loops.into_iter().filter(is_hole).collect()
    }
}

/// The half-edges of a loop.
pub(crate) fn edges_of(each: &[u32]) -> impl Iterator<Item = [u32; 2]> {
    each.iter().zip(each.iter().cycle().skip(1)).map(|(&from, &to)| [from, to])
}

/// Checks labels of triangles.
///
/// # Errors
/// [`Error::Mesh`] for another number of labels than triangles, labels below -1, none from 0 on, and numbers left out.
pub(crate) fn check_labels(labels: &[i32], triangle_count: usize) -> Result<()> {
    if labels.len() != triangle_count {
        return Err(Error::Mesh(format!(
            "bodies: found {} labels, expected {triangle_count}, one for each triangle",
            labels.len()
        )));
    }
    if let Some(first) = labels.iter().position(|&label| label < -1) {
        return Err(Error::Mesh(format!(
            "bodies: found the label {} at triangle {first}, expected numbers of bodies from 0 on, or -1 for no body",
            labels[first]
        )));
    }
    let mut sorted = labels.to_vec();
    sorted.sort_unstable();
    sorted.dedup();
    let bodies = sorted.iter().filter(|label| **label >= 0);
    if bodies.clone().count() == 0 {
        return Err(Error::Mesh(
            "bodies: found no triangle with a label of 0 or more, expected at least one body".into(),
        ));
    }
    match bodies.zip(0..).find(|(label, expected)| **label != *expected) {
        None => Ok(()),
        Some((found, left_out)) => Err(Error::Mesh(format!(
            "bodies: found the label {found} but no triangle labelled {left_out}, expected numbers without a gap from 0 on"
        ))),
    }
}

/// The islands of a mesh that enclose a volume, in the order of their first triangles, and their surface. `at`: place of a vertex.
pub(crate) fn islands(
    vertex_count: usize,
    triangles: &[[u32; 3]],
    at: impl Fn(usize) -> DVec3 + Sync,
    epsilon: f64,
    caps: bool,
) -> (Partition, Result<ClosedSurface>) {
    if triangles.is_empty() {
        return (Partition::labelled(vertex_count, &[], Vec::new()), ClosedSurface::new(vertex_count, &[]));
    }
    let rings = Rings::new(vertex_count, triangles);
    let pieces = pieces(vertex_count, triangles);
    let count = pieces.iter().max().map_or(0, |&last| last as usize + 1);
    let mut found = Census { open: vec![false; count], broken: vec![false; count], flat: vec![false; count] };
    for (corners, &piece) in triangles.iter().zip(&pieces) {
        for &v in corners {
            match &rings.0[v as usize] {
                None => found.broken[piece as usize] = true,
                Some(ring) => found.open[piece as usize] |= ring.is_open() && !caps,
            }
        }
    }
    let first = Partition::labelled(vertex_count, triangles, found.labels(&pieces));
    let surface = ClosedSurface::of_rings(rings, |v| first.of_node[v] != NO_BODY);
    let sound: Vec<usize> = (0..count).filter(|&piece| !found.open[piece] && !found.broken[piece]).collect();
    for (body, measure) in Measure::of_bodies(&first, &surface, at, vertex_count).iter().enumerate() {
        found.flat[sound[body]] = measure.is_flat(epsilon) || measure.is_rounding(epsilon);
    }
    if !found.flat.contains(&true) {
        let surface = if first.count == 0 { Err(found.none_left(triangles)) } else { Ok(surface) };
        return (first, surface);
    }
    let partition = Partition::labelled(vertex_count, triangles, found.labels(&pieces));
    let surface = match partition.count {
        0 => Err(found.none_left(triangles)),
        _ => partition.surface(&partition.triangles, true),
    };
    (partition, surface)
}

/// What became of the pieces of a mesh.
struct Census {
    open: Vec<bool>,
    broken: Vec<bool>,
    flat: Vec<bool>,
}

impl Census {
    /// Labels of the triangles: pieces without a fault are bodies.
    fn labels(&self, pieces: &[u32]) -> Vec<i32> {
        let mut next = 0;
        let label = |piece: usize| {
            let is_body = !self.open[piece] && !self.broken[piece] && !self.flat[piece];
            next += i32::from(is_body);
            if is_body { next - 1 } else { -1 }
        };
        let labels: Vec<i32> = (0..self.open.len()).map(label).collect();
        pieces.iter().map(|&piece| labels[piece as usize]).collect()
    }

    fn none_left(&self, triangles: &[[u32; 3]]) -> Error {
        let count = |faults: &[bool]| faults.iter().filter(|fault| **fault).count();
        let (open, broken, flat) = (count(&self.open), count(&self.broken), count(&self.flat));
        let mut text = format!(
            "bodies: none of {} islands encloses a volume, expected at least one closed island that is not flat: {open} have holes, {broken} have edges that are non-manifold or inconsistently wound, {flat} are flat",
            self.open.len()
        );
        if open + broken > 0 {
            text += &format!("; the mesh {}", broken::edges(triangles.iter().enumerate(), true));
        }
        Error::Mesh(text)
    }
}

/// The number of each triangle's piece, where pieces share no vertex, in the order of their first triangles.
fn pieces(vertex_count: usize, triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut parent: Vec<u32> = (0..vertex_count as u32).collect();
    for &[a, b, c] in triangles {
        let root = root_of(&mut parent, a);
        for corner in [b, c] {
            let other = root_of(&mut parent, corner);
            parent[other as usize] = root;
        }
    }
    let mut numbers = vec![u32::MAX; vertex_count];
    let mut next = 0;
    let number = |corners: &[u32; 3]| {
        let number = &mut numbers[root_of(&mut parent, corners[0]) as usize];
        if *number == u32::MAX {
            (*number, next) = (next, next + 1);
        }
        *number
    };
    triangles.iter().map(number).collect()
}

/// The root of a vertex's tree; halves the way there.
fn root_of(parent: &mut [u32], vertex: u32) -> u32 {
    let mut at = vertex;
    while parent[at as usize] != at {
        parent[at as usize] = parent[parent[at as usize] as usize];
        at = parent[at as usize];
    }
    at
}
