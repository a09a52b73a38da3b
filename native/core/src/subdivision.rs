// SPDX-License-Identifier: GPL-3.0-or-later
//! Adaptive tessellation: edges that deformed space bends are split until the mesh is as close to it as wanted, without cracks.
//!
//! What is decided is decided per edge, whatever faces meet in it. In every face with a split edge the longest is split too, so that
//! corners do not become ever sharper (Rivara's rule), and the face is cut by which of its edges are.

use glam::DVec3;
use rayon::prelude::*;

use crate::bends::{Deformation, Points, check_tolerance};
use crate::broken;
use crate::combination::Surface;
use crate::error::{Error, Result};
use crate::vertices::{Scalar, check_triangles};

/// Levels at most: each makes four triangles of one at most.
const MOST_LEVELS: usize = 12;

/// Triangles at which the splitting ends, whatever the deviation: what memory holds.
const MOST_TRIANGLES: usize = 1 << 26;

/// A mesh that is split where deformed space bends, in rest space.
#[derive(Debug, Clone, PartialEq)]
pub struct Refined<T> {
    /// Vertices before the deformation: the given ones, then new ones on the way between them.
    pub vertices: Vec<[T; 3]>,
    /// Triangles, wound as the given ones.
    pub triangles: Vec<[u32; 3]>,
    /// The given triangle that each is a part of.
    pub parent_triangle: Vec<u32>,
    /// The vertices as combinations of the given ones: three at most, weights that sum to 1. Carries whatever vertices have.
    pub parents: Surface,
    /// Largest distance of a deformed edge (at its quarters) from the straight one and of a deformed face's centre from its plane, as
    /// given.
    pub before: f64,
    /// The same of what came out; above the tolerance where the levels did not suffice.
    pub after: f64,
    /// Levels that it took.
    pub levels: usize,
}

/// A vertex as a combination of given ones, those of one triangle.
#[derive(Debug, Clone, Copy)]
struct Row {
    points: [u32; 3],
    weights: [f64; 3],
    count: usize,
}

impl Row {
    fn own(point: u32) -> Self {
        Self { points: [point; 3], weights: [1.0, 0.0, 0.0], count: 1 }
    }

    fn between(a: &Self, b: &Self) -> Self {
        let mut row = Self { points: [0; 3], weights: [0.0; 3], count: 0 };
        for (point, weight) in a.entries().chain(b.entries()) {
            let known = row.points[..row.count].iter().position(|&p| p == point);
            let at = known.unwrap_or(row.count);
            row.count = row.count.max(at + 1);
            row.points[at] = point;
            row.weights[at] += 0.5 * weight;
        }
        row
    }

    fn entries(&self) -> impl Iterator<Item = (u32, f64)> {
        self.points.into_iter().zip(self.weights).take(self.count)
    }
}

/// A mesh on its way, and what is known of its edges and faces.
struct Splitting<'a, T> {
    deformation: &'a Deformation<'a>,
    given: Points<T>,
    points: Points<T>,
    rows: Vec<Row>,
    /// Where the points go.
    moved: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    parents: Vec<u32>,
    /// Deviation of each face's centre, NaN where it is not known yet.
    centres: Vec<f64>,
    /// All edges, ascending, with their deviations.
    edges: Vec<(u64, f64)>,
}

impl Deformation<'_> {
    /// Splits the edges of triangles where the deformed space bends, until every deformed edge and face's centre is within
    /// `tolerance` of the straight one, `levels` times at most.
    ///
    /// New vertices stand in the middle of edges before the deformation, with an influence in the middle of those at the ends. Which
    /// edges are split depends on nothing but the edge and its faces, so neighbours always agree, and the same input gives the same
    /// mesh on any number of threads.
    ///
    /// # Errors
    /// [`Error::Mesh`] for vertices that are not finite, a wrong influence, triangles with indices out of range or repeated corners, a
    /// tolerance that is not positive, and more than 12 levels; [`Error::Lattice`] for control points that do not fit the lattice.
    pub fn tessellate<T: Scalar>(
        &self,
        vertices: &[[T; 3]],
        triangles: &[[u32; 3]],
        influence: Option<&[f64]>,
        tolerance: f64,
        levels: usize,
    ) -> Result<Refined<T>> {
        check_tolerance(tolerance)?;
        if levels > MOST_LEVELS {
            return Err(Error::Mesh(format!("levels: found {levels}, expected at most {MOST_LEVELS}")));
        }
        check_triangles(triangles, vertices.len())?;
        broken::refuse_degenerate(triangles)?;
        let mut splitting = Splitting::new(self, vertices, influence, triangles)?;
        splitting.measure()?;
        let before = splitting.worst();
        let mut taken = 0;
        while taken < levels && splitting.worst() > tolerance && splitting.triangles.len() < MOST_TRIANGLES {
            splitting.split(tolerance)?;
            splitting.measure()?;
            taken += 1;
        }
        Ok(splitting.refined(before, taken))
    }
}

impl<'a, T: Scalar> Splitting<'a, T> {
    fn new(
        deformation: &'a Deformation<'a>,
        vertices: &[[T; 3]],
        influence: Option<&[f64]>,
        triangles: &[[u32; 3]],
    ) -> Result<Self> {
        let points = || Points::checked(vertices, influence);
        Ok(Self {
            deformation,
            given: points()?,
            points: points()?,
            rows: (0..vertices.len() as u32).map(Row::own).collect(),
            moved: deformation.moved(points()?)?,
            triangles: triangles.to_vec(),
            parents: (0..triangles.len() as u32).collect(),
            centres: vec![f64::NAN; triangles.len()],
            edges: Vec::new(),
        })
    }

    /// Finds the edges of the triangles as they are, and measures what is not known yet.
    fn measure(&mut self) -> Result<()> {
        let mut keys: Vec<u64> =
            self.triangles.par_iter().flat_map_iter(|face| sides(face).map(key)).collect();
        keys.par_sort_unstable();
        keys.dedup();
        let known = |&key: &u64| self.edges.binary_search_by_key(&key, |edge| edge.0).ok();
        let (old, new): (Vec<u64>, Vec<u64>) = keys.into_iter().partition(|key| known(key).is_some());
        let ends: Vec<[u32; 2]> = new.iter().map(|&key| ends(key)).collect();
        let moved = |edge: usize| ends[edge].map(|v| self.moved[v as usize]);
        let deviations = self.deformation.of_edges(&self.points, &ends, moved)?;
        let old = old.iter().filter_map(|key| known(key).map(|at| self.edges[at]));
        let mut edges: Vec<(u64, f64)> = old.chain(new.iter().copied().zip(deviations)).collect();
        edges.par_sort_unstable_by_key(|edge| edge.0);
        self.edges = edges;
        let unknown: Vec<usize> =
            (0..self.centres.len()).filter(|&face| self.centres[face].is_nan()).collect();
        let faces: Vec<[u32; 3]> = unknown.iter().map(|&face| self.triangles[face]).collect();
        let corner = |v: u32| self.moved[v as usize];
        let centres = self.deformation.of_faces(&self.points, &faces, corner)?;
        unknown.into_iter().zip(centres).for_each(|(face, centre)| self.centres[face] = centre);
        Ok(())
    }

    fn worst(&self) -> f64 {
        let edges = self.edges.iter().map(|edge| edge.1);
        edges.chain(self.centres.iter().copied()).fold(0.0, f64::max)
    }

    /// Number of an edge among all.
    fn edge(&self, side: [u32; 2]) -> usize {
        self.edges.partition_point(|edge| edge.0 < key(side))
    }

    /// The side of a face that is longest before the deformation; of equals the one whose ends come last.
    fn longest(&self, face: &[u32; 3]) -> usize {
        let length = |[a, b]: [u32; 2]| (self.points.place(a) - self.points.place(b)).length_squared();
        let all = sides(face).map(|side| (length(side), key(side)));
        let is_longer = |a: &(f64, u64), b: &(f64, u64)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).is_gt();
        (0..3).fold(0, |best, side| if is_longer(&all[side], &all[best]) { side } else { best })
    }

    /// Which edges are to be split, and for each face the numbers of its edges and its longest side.
    fn marks(&self, tolerance: f64) -> (Vec<bool>, Vec<([usize; 3], usize)>) {
        let mut marked: Vec<bool> = self.edges.iter().map(|edge| edge.1 > tolerance).collect();
        let of = |face: &[u32; 3]| (sides(face).map(|side| self.edge(side)), self.longest(face));
        let faces: Vec<([usize; 3], usize)> = self.triangles.par_iter().map(of).collect();
        let bulging = faces.iter().zip(&self.centres).filter(|(_, centre)| **centre > tolerance);
        bulging.for_each(|((edges, _), _)| edges.iter().for_each(|&edge| marked[edge] = true));
        let mut changed = true;
        while changed {
            changed = false;
            for (edges, longest) in &faces {
                if !marked[edges[*longest]] && edges.iter().any(|&edge| marked[edge]) {
                    marked[edges[*longest]] = true;
                    changed = true;
                }
            }
        }
        (marked, faces)
    }

    /// Splits what is too far from straight, once.
    fn split(&mut self, tolerance: f64) -> Result<()> {
        let (marked, faces) = self.marks(tolerance);
        let mut next = self.points.places.len() as u32;
        let middles: Vec<Option<u32>> = marked
            .iter()
            .map(|&marked| {
                next += u32::from(marked);
                marked.then(|| next - 1)
            })
            .collect();
        let split = self.edges.iter().zip(&marked).filter(|(_, marked)| **marked);
        self.add(split.map(|((key, _), _)| ends(*key)).collect())?;
        let (mut triangles, mut parents, mut centres) = (Vec::new(), Vec::new(), Vec::new());
        for (face, (edges, longest)) in faces.iter().enumerate() {
            let turned = |side: usize| (side + longest) % 3;
            let corners = [0, 1, 2].map(|corner| self.triangles[face][turned(corner)]);
            let middles = [0, 1, 2].map(|side| middles[edges[turned(side)]]);
            let centre = match middles[0] {
                Some(longest) => {
                    cut(corners, longest, [middles[1], middles[2]], &mut triangles);
                    f64::NAN
                }
                None => {
                    triangles.push(self.triangles[face]);
                    self.centres[face]
                }
            };
            parents.resize(triangles.len(), self.parents[face]);
            centres.resize(triangles.len(), centre);
        }
        (self.triangles, self.parents, self.centres) = (triangles, parents, centres);
        Ok(())
    }

    /// Adds the middles of edges.
    fn add(&mut self, edges: Vec<[u32; 2]>) -> Result<()> {
        let row = |[a, b]: &[u32; 2]| Row::between(&self.rows[*a as usize], &self.rows[*b as usize]);
        let rows: Vec<Row> = edges.iter().map(row).collect();
        let place = |row: &Row| {
            let sum: DVec3 = row.entries().map(|(point, weight)| self.given.place(point) * weight).sum();
            sum.to_array().map(T::from_f64)
        };
        let influence = self.given.influence.as_ref().map(|all| {
            let of = |row: &Row| row.entries().map(|(point, weight)| all[point as usize] * weight).sum();
            rows.iter().map(of).collect::<Vec<f64>>()
        });
        let new = Points { places: rows.iter().map(place).collect(), influence };
        self.points.places.extend(&new.places);
        if let (Some(all), Some(new)) = (&mut self.points.influence, &new.influence) {
            all.extend(new);
        }
        self.rows.extend(rows);
        self.moved.extend(self.deformation.moved(new)?);
        Ok(())
    }

    fn refined(self, before: f64, levels: usize) -> Refined<T> {
        let after = self.worst();
        let rows = self.rows.iter().map(|row| row.entries().collect::<Vec<_>>());
        Refined {
            parents: Surface::of_rows(self.given.places.len(), rows),
            vertices: self.points.places,
            triangles: self.triangles,
            parent_triangle: self.parents,
            before,
            after,
            levels,
        }
    }
}

/// Cuts a triangle whose longest side is from its first corner to its second, by the middle `m` of that and those of the other two.
fn cut([a, b, c]: [u32; 3], m: u32, others: [Option<u32>; 2], into: &mut Vec<[u32; 3]>) {
    match others {
        [None, None] => into.extend([[a, m, c], [m, b, c]]),
        [Some(n), None] => into.extend([[a, m, c], [m, b, n], [m, n, c]]),
        [None, Some(o)] => into.extend([[a, m, o], [m, b, c], [o, m, c]]),
        [Some(n), Some(o)] => into.extend([[a, m, o], [m, b, n], [o, n, c], [m, n, o]]),
    }
}

fn sides(&[a, b, c]: &[u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// An edge as a number, whichever way it runs.
fn key([a, b]: [u32; 2]) -> u64 {
    u64::from(a.min(b)) << 32 | u64::from(a.max(b))
}

fn ends(key: u64) -> [u32; 2] {
    [(key >> 32) as u32, key as u32]
}
