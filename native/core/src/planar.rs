// SPDX-License-Identifier: GPL-3.0-or-later
//! Free-form deformation of the plane (Sederberg 14.1-14.3): a lattice with one layer, and flat meshes whose area is kept.
//!
//! A flat mesh is bound as the prism over it. Both of its faces hang on the same control points by the same weights, and nothing
//! moves across the plane, so that the volume of the deformed prism is the deformed area times its height: all that keeps
//! volumes keeps areas, as exactly.

use glam::{DMat2, DMat3, DVec2, DVec3};

use crate::basis::AxisBasis;
use crate::binding::{Bind, Binding};
use crate::broken::refuse_degenerate;
use crate::error::{Error, Result};
use crate::lattice::Lattice;
use crate::sum::CompensatedSum;
use crate::vertices::{Outside, Scalar, check_influence, check_triangles};
use crate::words::bracketed;

/// Edges lie on one line where they enclose less than this fraction of the product of their lengths.
const FLAT_FRAME: f64 = 1e-12;

impl Lattice {
    /// A lattice of the plane over the parallelogram with corner `origin` and edge vectors `edges` (columns): one layer of control
    /// points, all with z = 0. Its thickness is a power of two near the parallelogram's size, so that rounding is alike
    /// in all directions, and areas are volumes divided without error.
    ///
    /// # Errors
    /// [`Error::Lattice`] where the frame is not finite, has an edge of length 0, or edges on one line.
    pub fn planar(axes: [AxisBasis; 2], origin: DVec2, edges: DMat2) -> Result<Self> {
        let lengths = DVec2::new(edges.x_axis.length(), edges.y_axis.length());
        let area = edges.determinant().abs();
        let independent = area > FLAT_FRAME * lengths.element_product();
        if !(origin.is_finite() && area.is_finite() && independent) {
            return Err(Error::Lattice(format!(
                "lattice frame: found the corner {} and the edges {} and {}, expected finite numbers, and edges of some length that do not lie on one line",
                bracketed(origin.to_array()),
                bracketed(edges.x_axis.to_array()),
                bracketed(edges.y_axis.to_array())
            )));
        }
        let height = area.sqrt().log2().round().exp2();
        let [s, t] = axes;
        let frame = DMat3::from_cols(
            edges.x_axis.extend(0.0),
            edges.y_axis.extend(0.0),
            DVec3::new(0.0, 0.0, height),
        );
        Self::new([s, t, AxisBasis::bernstein(1)?], origin.extend(-0.5 * height), frame)
    }
}

/// A flat mesh bound to a lattice of the plane.
pub struct Planar<T> {
    binding: Binding<T>,
    triangles: Vec<[u32; 3]>,
    count: usize,
    height: f64,
}

impl<T: Scalar> Planar<T> {
    /// Embeds points of the plane, and the triangles of a flat mesh if areas are wanted (none: points only). `lattice`: one that
    /// [`Lattice::planar`] made.
    ///
    /// # Errors
    /// [`Error::Mesh`] for points that are not finite, indices out of range, triangles that repeat a vertex, edges that triangles use
    /// more than once in one direction, and a wrong influence.
    pub fn new(
        lattice: Lattice,
        vertices: &[[T; 2]],
        triangles: Vec<[u32; 3]>,
        influence: Option<Vec<f64>>,
        outside: Outside,
    ) -> Result<Self> {
        let height = lattice.edges().z_axis.z;
        check_triangles(&triangles, vertices.len())?;
        refuse_degenerate(&triangles)?;
        if let Some(influence) = &influence {
            check_influence(influence, vertices.len())?;
        }
        let border = border(&triangles)?;
        let levels: &[f64] = if triangles.is_empty() { &[0.0] } else { &[-0.5 * height, 0.5 * height] };
        let at = |[x, y]: [T; 2], z: f64| [x, y, T::from_f64(z)];
        let mut rows: Vec<[T; 3]> =
            levels.iter().flat_map(|&z| vertices.iter().map(move |&v| at(v, z))).collect();
        rows.extend(border.corners.iter().map(|&v| at(vertices[v as usize], 0.0)));
        let influence = influence.map(|all| {
            let of_border = border.corners.iter().map(|&v| all[v as usize]);
            levels.iter().flat_map(|_| all.iter().copied()).chain(of_border).collect()
        });
        let faces = prism(&triangles, vertices.len() as u32, &border);
        let options = Bind { influence, outside, ..Bind::default() };
        let binding = Binding::with(lattice, rows, faces, options)?;
        Ok(Self { binding, triangles, count: vertices.len(), height })
    }

    /// The prism over the mesh. Its first vertices are the mesh's, all at one height, `z` away from the plane.
    pub fn binding(&self) -> &Binding<T> {
        &self.binding
    }

    /// Number of points.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Height of the prism: its volume is the mesh's area times this, a power of two.
    pub fn height(&self) -> f64 {
        self.height
    }

    /// The point of the prism that stands for a point of the plane among the first vertices.
    pub fn lifted(&self, point: DVec2) -> DVec3 {
        point.extend(if self.triangles.is_empty() { 0.0 } else { -0.5 * self.height })
    }

    /// Signed area of the mesh with its points at `vertices`, summed in float64 with compensation about the middle of its
    /// box: positive where the triangles wind counter-clockwise.
    ///
    /// # Errors
    /// [`Error::Mesh`] where no triangles were given.
    pub fn area(&self, vertices: &[[T; 2]]) -> Result<f64> {
        if self.triangles.is_empty() {
            return Err(Error::Mesh(
                "triangles: found none, expected those of a flat mesh to have an area".into(),
            ));
        }
        let at = |v: usize| DVec2::new(vertices[v][0].to_f64(), vertices[v][1].to_f64());
        let (low, high) = (0..vertices.len())
            .map(at)
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        let middle = low * 0.5 + high * 0.5;
        let corner = |v: u32| at(v as usize) - middle;
        let terms = self.triangles.iter().flat_map(|&[a, b, c]| {
            let [a, b, c] = [a, b, c].map(corner);
            [a.perp_dot(b), b.perp_dot(c), c.perp_dot(a)]
        });
        Ok(terms.collect::<CompensatedSum>().value() / 2.0)
    }
}

/// The edges that one triangle uses, as it does.
struct Border {
    edges: Vec<[u32; 2]>,
    /// Vertices that the border passes, once for each time it does.
    corners: Vec<u32>,
    /// For each edge its two corners, as numbers in `corners`.
    of_edge: Vec<[u32; 2]>,
}

/// Finds the border of a flat mesh. Where it passes a vertex more than once, passages in and out are paired in any order.
fn border(triangles: &[[u32; 3]]) -> Result<Border> {
    let mut used: Vec<[u32; 2]> = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    used.sort_unstable();
    if let Some(pair) = used.windows(2).find(|pair| pair[0] == pair[1]) {
        let [a, b] = pair[0];
        return Err(Error::Mesh(format!(
            "triangles: edge {a}-{b} is used more than once in one direction, expected a flat mesh whose triangles wind one way and use each edge once in each direction at most; turn over those that wind the other way, and remove those that lie on others"
        )));
    }
    let is_open = |[a, b]: &[u32; 2]| used.binary_search(&[*b, *a]).is_err();
    let edges: Vec<[u32; 2]> = used.iter().copied().filter(is_open).collect();
    // Sorted by its first vertex, edge `i` leaves corner `i`. Ranked by their second vertex, edges enter the same corners in order.
    let corners: Vec<u32> = edges.iter().map(|edge| edge[0]).collect();
    let mut by_end: Vec<u32> = (0..edges.len() as u32).collect();
    by_end.sort_by_key(|&edge| edges[edge as usize][1]);
    let mut of_edge: Vec<[u32; 2]> = (0..edges.len() as u32).map(|edge| [edge, 0]).collect();
    for (corner, &edge) in (0..).zip(&by_end) {
        of_edge[edge as usize][1] = corner;
    }
    Ok(Border { edges, corners, of_edge })
}

/// Triangles of the prism: the mesh turned over, the mesh lifted, and walls on the border. A wall's sides have a corner half-way up,
/// of their own for each passage of the border, or walls that meet at one vertex would share an edge.
fn prism(triangles: &[[u32; 3]], count: u32, border: &Border) -> Vec<[u32; 3]> {
    let mut faces: Vec<[u32; 3]> = triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    faces.extend(triangles.iter().map(|corners| corners.map(|v| v + count)));
    for ([a, b], corners) in border.edges.iter().zip(&border.of_edge) {
        let [from, to] = corners.map(|corner| 2 * count + corner);
        let (over_a, over_b) = (a + count, b + count);
        faces.extend([[*a, *b, to], [*a, to, from], [from, to, over_b], [from, over_b, over_a]]);
    }
    faces
}
