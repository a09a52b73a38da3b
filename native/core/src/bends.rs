// SPDX-License-Identifier: GPL-3.0-or-later
//! How far a deformed mesh is from the deformed space: straight edges and flat faces against what they should follow.

use glam::DVec3;
use rayon::prelude::*;

use crate::binding::{Bind, Binding};
use crate::error::{Error, Result};
use crate::lattice::Lattice;
use crate::vertices::{Outside, Scalar, check_influence, check_vertices};
use crate::words::number;

/// Where an edge is looked at, as fractions of it.
const SAMPLES: [f64; 3] = [0.25, 0.5, 0.75];

/// Edges or faces whose samples are embedded at a time: what bounds the memory.
const BATCH: usize = 1 << 18;

/// A face with less area than this fraction of its longest edge's square has no plane.
const NO_PLANE: f64 = 1e-12;

/// How space is deformed: by a lattice with control points, `k` fastest, as a binding with these options does it.
#[derive(Debug, Clone)]
pub struct Deformation<'a> {
    /// The lattice.
    pub lattice: &'a Lattice,
    /// Its control points.
    pub control: &'a [DVec3],
    /// What happens to points beyond the lattice's domain.
    pub outside: Outside,
    /// Control points that leave every point where it is; `None` for the lattice's own.
    pub rest: Option<&'a [DVec3]>,
}

/// Points with how much of the deformation each takes.
pub(crate) struct Points<T> {
    pub(crate) places: Vec<[T; 3]>,
    pub(crate) influence: Option<Vec<f64>>,
}

impl<T: Scalar> Points<T> {
    pub(crate) fn checked(places: &[[T; 3]], influence: Option<&[f64]>) -> Result<Self> {
        check_vertices(places)?;
        influence.iter().try_for_each(|all| check_influence(all, places.len()))?;
        Ok(Self { places: places.to_vec(), influence: influence.map(<[f64]>::to_vec) })
    }

    pub(crate) fn place(&self, point: u32) -> DVec3 {
        DVec3::from_array(self.places[point as usize].map(T::to_f64))
    }

    /// The same combinations of these points, `count` shares each.
    fn combined(&self, rows: impl IndexedParallelIterator<Item = [(u32, f64); 3]> + Clone) -> Self {
        let place = |row: [(u32, f64); 3]| {
            let sum: DVec3 = row.iter().map(|&(point, share)| self.place(point) * share).sum();
            sum.to_array().map(T::from_f64)
        };
        let influence = self.influence.as_ref().map(|all| {
            let of = |row: [(u32, f64); 3]| {
                row.iter().map(|&(point, share)| all[point as usize] * share).sum::<f64>().clamp(0.0, 1.0)
            };
            rows.clone().map(of).collect()
        });
        Self { places: rows.map(place).collect(), influence }
    }
}

impl Deformation<'_> {
    /// Where points go, in float64.
    pub(crate) fn moved<T: Scalar>(&self, points: Points<T>) -> Result<Vec<DVec3>> {
        let mut out = points.places.clone();
        let options = Bind {
            influence: points.influence,
            outside: self.outside,
            rest: self.rest.map(<[DVec3]>::to_vec),
            ..Bind::default()
        };
        let binding = Binding::with(self.lattice.clone(), points.places, Vec::new(), options)?;
        binding.deform(self.control, &mut out)?;
        Ok(out.into_iter().map(|p| DVec3::from_array(p.map(T::to_f64))).collect())
    }

    /// How far each deformed edge, at a quarter, a half and three quarters of its way, is from the straight one between its ends.
    ///
    /// `influence`: of each vertex, `None` for 1; between the ends of an edge it runs from one to the other.
    ///
    /// # Errors
    /// [`Error::Mesh`] for vertices that are not finite, a wrong influence and indices out of range; [`Error::Lattice`] for control
    /// points that do not fit the lattice.
    pub fn edge_deviations<T: Scalar>(
        &self,
        vertices: &[[T; 3]],
        influence: Option<&[f64]>,
        edges: &[[u32; 2]],
    ) -> Result<Vec<f64>> {
        let points = Points::checked(vertices, influence)?;
        if let Some(i) = edges.iter().position(|edge| edge.iter().any(|&v| v as usize >= vertices.len())) {
            return Err(Error::Mesh(format!(
                "edges: found {:?} at index {i}, expected 0 to {} for {} vertices",
                edges[i],
                vertices.len() as i64 - 1,
                vertices.len()
            )));
        }
        let ends: Vec<u32> = edges.as_flattened().to_vec();
        let own = points.combined(ends.par_iter().map(|&end| [(end, 1.0), (end, 0.0), (end, 0.0)]));
        let ends = self.moved(own)?;
        let pairs: Vec<[DVec3; 2]> = ends.as_chunks().0.to_vec();
        self.of_edges(&points, edges, |edge| pairs[edge])
    }

    /// Whether these are above a tolerance.
    ///
    /// # Errors
    /// As [`Deformation::edge_deviations`]; [`Error::Mesh`] for a tolerance that is not positive.
    pub fn bent_edges<T: Scalar>(
        &self,
        vertices: &[[T; 3]],
        influence: Option<&[f64]>,
        edges: &[[u32; 2]],
        tolerance: f64,
    ) -> Result<Vec<bool>> {
        check_tolerance(tolerance)?;
        let deviations = self.edge_deviations(vertices, influence, edges)?;
        Ok(deviations.into_iter().map(|deviation| deviation > tolerance).collect())
    }

    /// The same for checked edges of points, by where each edge's ends go.
    pub(crate) fn of_edges<T: Scalar>(
        &self,
        points: &Points<T>,
        edges: &[[u32; 2]],
        ends: impl Fn(usize) -> [DVec3; 2] + Sync,
    ) -> Result<Vec<f64>> {
        let mut found = Vec::with_capacity(edges.len());
        for batch in edges.chunks(BATCH) {
            let first = found.len();
            let row = |sample: usize| {
                let ([a, b], t) = (batch[sample / SAMPLES.len()], SAMPLES[sample % SAMPLES.len()]);
                [(a, 1.0 - t), (b, t), (b, 0.0)]
            };
            let samples = (0..batch.len() * SAMPLES.len()).into_par_iter().map(row);
            let moved = self.moved(points.combined(samples))?;
            let of = |(edge, samples): (usize, &[DVec3])| {
                let [a, b] = ends(first + edge);
                samples.iter().map(|&p| from_segment(p, a, b)).fold(0.0, f64::max)
            };
            found.par_extend(moved.par_chunks(SAMPLES.len()).enumerate().map(of));
        }
        Ok(found)
    }

    /// How far the deformed centre of each face is from the plane of its deformed corners.
    pub(crate) fn of_faces<T: Scalar>(
        &self,
        points: &Points<T>,
        faces: &[[u32; 3]],
        corner: impl Fn(u32) -> DVec3 + Sync,
    ) -> Result<Vec<f64>> {
        let mut found = Vec::with_capacity(faces.len());
        for batch in faces.chunks(BATCH) {
            let centres = batch.par_iter().map(|face| face.map(|v| (v, 1.0 / 3.0)));
            let moved = self.moved(points.combined(centres))?;
            let of = |(face, centre): (&[u32; 3], &DVec3)| from_plane(*centre, face.map(&corner));
            found.par_extend(batch.par_iter().zip(&moved).map(of));
        }
        Ok(found)
    }
}

/// Checks a distance that deformed edges may be from straight ones.
pub(crate) fn check_tolerance(tolerance: f64) -> Result<()> {
    if tolerance.is_finite() && tolerance > 0.0 {
        return Ok(());
    }
    Err(Error::Mesh(format!("tolerance: found {}, expected a positive distance", number(tolerance))))
}

/// Distance from a point to the straight edge between two.
fn from_segment(point: DVec3, a: DVec3, b: DVec3) -> f64 {
    let (way, along) = (point - a, b - a);
    let squared = along.length_squared();
    let t = if squared > 0.0 { (way.dot(along) / squared).clamp(0.0, 1.0) } else { 0.0 };
    (way - along * t).length()
}

/// Distance from a point to the plane of three, or to their mean where they have none.
fn from_plane(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let longest = (b - a).length_squared().max((c - a).length_squared()).max((c - b).length_squared());
    if normal.length() > NO_PLANE * longest {
        return (point - a).dot(normal.normalize()).abs();
    }
    (point - (a + b + c) / 3.0).length()
}
