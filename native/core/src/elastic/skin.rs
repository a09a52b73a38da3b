// SPDX-License-Identifier: GPL-3.0-or-later
//! The surface that the lattice carries: its vertices as weighted sums of control points, and the volume inside.

use std::collections::HashMap;

use glam::DVec3;

use crate::basis::AxisBasis;
use crate::embedding::{Located, Spot};
use crate::error::{Error, Result};
use crate::lattice::Lattice;
use crate::sum::CompensatedSum;
use crate::surface::Measure;
use crate::vertices::{Outside, check_influence, check_triangles, check_vertices};
use crate::words::number;

/// Weights in all at most: vertices times the control points that act on each.
const MOST_WEIGHTS: usize = 1 << 25;

/// Vertices of the surface, each `offset + sum of weight · control point`, and its triangles, if it is closed.
#[derive(Debug, Clone, Default)]
pub(super) struct Skin {
    offsets: Vec<DVec3>,
    /// Control points that act on one vertex; as many for each.
    taps: usize,
    points: Vec<u32>,
    weights: Vec<f64>,
    triangles: Vec<[u32; 3]>,
}

impl Skin {
    /// Embeds vertices as [`crate::Binding`] does.
    pub(super) fn new(
        lattice: &Lattice,
        vertices: &[[f64; 3]],
        triangles: Vec<[u32; 3]>,
        influence: Option<&[f64]>,
        outside: Outside,
    ) -> Result<Self> {
        check_vertices(vertices)?;
        check_triangles(&triangles, vertices.len())?;
        check_closed(&triangles)?;
        if let Some(influence) = influence {
            check_influence(influence, vertices.len())?;
        }
        let taps = lattice.axes().iter().map(AxisBasis::window).product::<usize>();
        if vertices.len().saturating_mul(taps) > MOST_WEIGHTS {
            return Err(Error::Mesh(format!(
                "vertices: found {} with {taps} control points acting on each, expected at most {}; take some of them",
                vertices.len(),
                MOST_WEIGHTS / taps
            )));
        }
        let mut skin = Self { taps, triangles, ..Self::default() };
        let rest = lattice.rest();
        for (v, vertex) in vertices.iter().enumerate() {
            let point = DVec3::from_array(*vertex);
            let spot = Spot::Projected(lattice.parameter(point));
            let place = Located::new::<f64>(lattice, spot, influence.map_or(1.0, |all| all[v]), outside);
            skin.push(lattice, &rest, point, &place);
        }
        Ok(skin)
    }

    fn push(&mut self, lattice: &Lattice, rest: &[DVec3], point: DVec3, place: &Located) {
        let mut offset = point;
        for (index, share) in lattice.taps(DVec3::from_array(place.parameter)) {
            let weight = place.influence * share;
            self.points.push(index as u32);
            self.weights.push(weight);
            offset -= rest[index] * weight;
        }
        self.offsets.push(offset);
    }

    pub(super) fn len(&self) -> usize {
        self.offsets.len()
    }

    pub(super) fn encloses(&self) -> bool {
        !self.triangles.is_empty()
    }

    /// (control point, weight) pairs of a vertex.
    #[inline]
    pub(super) fn row(&self, vertex: usize) -> impl Iterator<Item = (usize, f64)> {
        let range = vertex * self.taps..(vertex + 1) * self.taps;
        self.points[range.clone()]
            .iter()
            .map(|&point| point as usize)
            .zip(self.weights[range].iter().copied())
    }

    pub(super) fn position(&self, vertex: usize, control: &[DVec3]) -> DVec3 {
        self.row(vertex).fold(self.offsets[vertex], |sum, (point, weight)| sum + control[point] * weight)
    }

    /// Where a vertex stands along `direction`, of control points along the same.
    pub(super) fn height(&self, vertex: usize, heights: &[f64], direction: DVec3) -> f64 {
        let start = self.offsets[vertex].dot(direction);
        self.row(vertex).fold(start, |sum, (point, weight)| sum + heights[point] * weight)
    }

    /// Signed volume inside.
    pub(super) fn volume(&self, control: &[DVec3]) -> f64 {
        let placed = self.placed(control);
        let at = |vertex: u32| placed[vertex as usize];
        let parts = self.triangles.iter().map(|&[a, b, c]| at(a).dot(at(b).cross(at(c))) / 6.0);
        parts.collect::<CompensatedSum>().value()
    }

    /// The same with the control points at rest; refused where triangles enclose none.
    pub(super) fn own_volume(&self, rest: &[DVec3]) -> Result<f64> {
        let measure = Measure::of(|vertex| self.position(vertex, rest), self.len(), &self.triangles);
        if self.encloses() && (!measure.volume.is_finite() || measure.is_flat(f64::EPSILON)) {
            return Err(Error::Mesh(format!(
                "triangles: found a volume of {} with an area of {}, expected a surface that encloses some, or no triangles",
                number(measure.volume),
                number(measure.area)
            )));
        }
        Ok(measure.volume)
    }

    /// Derivative of the volume by each control point.
    pub(super) fn gradient(&self, control: &[DVec3], gradient: &mut [DVec3]) {
        let placed = self.placed(control);
        let mut at_vertices = vec![DVec3::ZERO; placed.len()];
        for &triangle in &self.triangles {
            let [a, b, c] = triangle.map(|vertex| vertex as usize);
            at_vertices[a] += placed[b].cross(placed[c]) / 6.0;
            at_vertices[b] += placed[c].cross(placed[a]) / 6.0;
            at_vertices[c] += placed[a].cross(placed[b]) / 6.0;
        }
        gradient.fill(DVec3::ZERO);
        for (vertex, &value) in at_vertices.iter().enumerate() {
            self.row(vertex).for_each(|(point, weight)| gradient[point] += value * weight);
        }
    }

    /// Whether a point is inside the closed surface of these vertices: a ray from there leaves it more often than it enters.
    pub(super) fn is_inside(&self, vertices: &[[f64; 3]], point: DVec3) -> bool {
        let at = |vertex: u32| DVec3::from_array(vertices[vertex as usize]) - point;
        let crossings = self.triangles.iter().map(|&[a, b, c]| crossing(at(a), at(b), at(c)));
        crossings.sum::<i32>() != 0
    }

    /// All vertices, about the middle of the control points.
    fn placed(&self, control: &[DVec3]) -> Vec<DVec3> {
        let middle = control.iter().sum::<DVec3>() / control.len() as f64;
        (0..self.len()).map(|vertex| self.position(vertex, control) - middle).collect()
    }
}

/// How a ray from the origin passes a triangle: 1 outwards, -1 inwards, 0 beside it. The ray is along no axis and no diagonal, so
/// that it meets no edge of what was modelled with care.
fn crossing(a: DVec3, b: DVec3, c: DVec3) -> i32 {
    let ray = DVec3::new(0.8163, 0.5312, 0.2267);
    let sides = [a.cross(b), b.cross(c), c.cross(a)].map(|across| across.dot(ray));
    let ahead = a.dot((b - a).cross(c - a));
    if sides.iter().all(|side| *side > 0.0) && ahead > 0.0 {
        1
    } else if sides.iter().all(|side| *side < 0.0) && ahead < 0.0 {
        -1
    } else {
        0
    }
}

/// A volume needs every edge walked as often one way as the other. More than two triangles may share it.
fn check_closed(triangles: &[[u32; 3]]) -> Result<()> {
    let mut walked: HashMap<(u32, u32), i64> = HashMap::new();
    for &[a, b, c] in triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let way = if from < to { 1 } else { -1 };
            *walked.entry((from.min(to), from.max(to))).or_default() += way;
        }
    }
    let open = walked.iter().filter(|(_, ways)| **ways != 0).map(|(edge, _)| *edge);
    match open.clone().min() {
        Some((from, to)) => Err(Error::Mesh(format!(
            "triangles: {} edges are not closed, the first between vertices {from} and {to}; expected a closed, consistently wound surface, or none",
            open.count()
        ))),
        None => Ok(()),
    }
}
