// SPDX-License-Identifier: GPL-3.0-or-later
//! What comes in with a mesh: coordinates of either precision, triangles, influence, and their checks.

use crate::error::{Error, Result};
use crate::lattice::{FACE_TOLERANCE, FACE_TOLERANCE_F32};

/// A coordinate of a vertex: float32 or float64. The mathematics is float64 for both.
pub trait Scalar: bytemuck::Pod + Send + Sync {
    /// Relative rounding error of one value.
    const EPSILON: f64;
    /// Largest control point coordinate that deforms such vertices: sums of a few still fit the type.
    const LARGEST: f64;
    /// Distance from a face of the domain, in parameters, within which a point counts as on it.
    const FACE_TOLERANCE: f64;
    /// Exact conversion.
    fn to_f64(self) -> f64;
    /// Nearest value.
    fn from_f64(value: f64) -> Self;
}

impl Scalar for f32 {
    const EPSILON: f64 = f32::EPSILON as f64;
    const LARGEST: f64 = f32::MAX as f64 / 16.0;
    const FACE_TOLERANCE: f64 = FACE_TOLERANCE_F32;
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self as f64
    }
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        value as f32
    }
}

impl Scalar for f64 {
    const EPSILON: f64 = f64::EPSILON;
    const LARGEST: f64 = f64::MAX / 16.0;
    const FACE_TOLERANCE: f64 = FACE_TOLERANCE;
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        value
    }
}

/// What happens to vertices beyond the lattice's domain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Outside {
    /// They stay where they are (Sederberg), and the correction holds the layers of control points still that act on a
    /// face with vertices beyond it.
    #[default]
    Keep,
    /// They move by the displacement of the nearest parameters of the domain.
    Extend,
}

/// Checks coordinates: all finite, and few enough to number with 32 bits.
pub(crate) fn check_vertices<T: Scalar>(vertices: &[[T; 3]]) -> Result<()> {
    let bad = |p: &[T; 3]| p.iter().any(|c| !c.to_f64().is_finite());
    if let Some(first) = vertices.iter().position(bad) {
        let count = vertices.iter().filter(|p| bad(p)).count();
        return Err(Error::Mesh(format!(
            "vertices: {count} hold NaN or infinity, the first is vertex {first}; expected finite coordinates"
        )));
    }
    // Each cell may leave some lanes empty, and the gradient's walks count three entries a triangle.
    if vertices.len() > (u32::MAX / 16) as usize {
        return Err(Error::Mesh(format!(
            "vertices: found {}, expected at most {}",
            vertices.len(),
            u32::MAX / 16
        )));
    }
    Ok(())
}

/// Checks that every index names a vertex.
pub(crate) fn check_triangles(triangles: &[[u32; 3]], vertex_count: usize) -> Result<()> {
    // Walks have three entries a triangle and some to spare, and are counted with 32 bits.
    if triangles.len() > (u32::MAX / 8) as usize {
        return Err(Error::Mesh(format!(
            "triangles: found {}, expected at most {}",
            triangles.len(),
            u32::MAX / 8
        )));
    }
    let bad = |f: &[u32; 3]| f.iter().any(|&v| v as usize >= vertex_count);
    if let Some(first) = triangles.iter().position(bad) {
        let count = triangles.iter().filter(|f| bad(f)).count();
        return Err(Error::Mesh(format!(
            "triangles: {count} have an index out of range, the first is triangle {first} {:?}; expected 0 to {} for {vertex_count} vertices",
            triangles[first],
            vertex_count as i64 - 1
        )));
    }
    Ok(())
}

/// Checks one influence in [0, 1] for each vertex.
pub(crate) fn check_influence(influence: &[f64], vertex_count: usize) -> Result<()> {
    if influence.len() != vertex_count {
        return Err(Error::Mesh(format!(
            "influence: found {} values, expected {vertex_count}, one for each vertex",
            influence.len()
        )));
    }
    let bad = |s: &f64| !(0.0..=1.0).contains(s);
    if let Some(first) = influence.iter().position(bad) {
        let count = influence.iter().filter(|s| bad(s)).count();
        return Err(Error::Mesh(format!(
            "influence: {count} values are not in [0, 1], the first is {:?} at vertex {first}",
            influence[first]
        )));
    }
    Ok(())
}
