// SPDX-License-Identifier: GPL-3.0-or-later
//! Bézier patches that share control points (Ferrier): a lattice moves the control points, the surface follows.

use glam::DVec3;

use crate::basis::{AxisBasis, MAX_POINTS};
use crate::error::{Error, Result};
use crate::words::bracketed;

/// A cross product of the two tangents below this fraction of their lengths' product, or of the patch's size, is none: the patch is
/// collapsed there.
const COLLAPSED: f64 = 1e-9;

/// How far from a collapsed point, in parameters, the normal is looked for at last: its error is of the same size.
const NEARBY: f64 = 1e-4;

/// Tensor-product Bézier patches of `m x n` control points each, degree `m - 1` along u and `n - 1` along v, over common points.
///
/// Patches that name the same points along an edge, in either direction, are joined there; an edge that names one point all along is
/// collapsed to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Patches {
    points: Vec<DVec3>,
    shape: [usize; 2],
    /// Control points of all patches, `n` fastest.
    indices: Vec<u32>,
    bases: [AxisBasis; 2],
}

/// A place on a patch with what surrounds it.
struct Jet {
    value: DVec3,
    /// Derivatives along u and v.
    first: [DVec3; 2],
    /// Derivatives along u twice, u and v, v twice.
    second: [DVec3; 3],
}

impl Patches {
    /// Patches of `shape` control points (2 to 64 along u and v), by indices of `points`, the patch slowest and v fastest.
    ///
    /// # Errors
    /// [`Error::Mesh`] for points that are not finite, indices out of range or too few of them, and other shapes.
    pub fn new(points: Vec<DVec3>, shape: [usize; 2], indices: Vec<u32>) -> Result<Self> {
        let bases = [basis(shape[0], shape)?, basis(shape[1], shape)?];
        if indices.is_empty() || !indices.len().is_multiple_of(shape[0] * shape[1]) {
            return Err(Error::Mesh(format!(
                "patches: found {} indices, expected a multiple of {} for patches of shape {shape:?}, at least one patch",
                indices.len(),
                shape[0] * shape[1]
            )));
        }
        if let Some(i) = points.iter().position(|p| !p.is_finite()) {
            return Err(Error::Mesh(format!(
                "points: found NaN or infinity at index {i}, expected finite numbers"
            )));
        }
        if let Some(i) = indices.iter().position(|&index| index as usize >= points.len()) {
            return Err(Error::Mesh(format!(
                "patches: found point {} in patch {}, expected 0 to {}",
                indices[i],
                i / (shape[0] * shape[1]),
                points.len() as i64 - 1
            )));
        }
        Ok(Self { points, shape, indices, bases })
    }

    /// Number of patches.
    pub fn len(&self) -> usize {
        self.indices.len() / (self.shape[0] * self.shape[1])
    }

    /// Never: there is at least one patch.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// Control points along u and v of every patch.
    pub fn shape(&self) -> [usize; 2] {
        self.shape
    }

    /// The control points.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// Control points of all patches, patch by patch, v fastest.
    pub fn indices(&self) -> &[u32] {
        &self.indices
    }

    /// Control points of one patch, v fastest.
    pub fn patch(&self, patch: usize) -> &[u32] {
        let size = self.shape[0] * self.shape[1];
        &self.indices[patch * size..(patch + 1) * size]
    }

    /// The bases along u and v.
    pub(crate) fn bases(&self) -> &[AxisBasis; 2] {
        &self.bases
    }

    /// Positions at parameters `[u, v]` in `[0, 1]` of patches: Bernstein polynomials by sums of non-negative products, which is stable
    /// at every degree as de Casteljau's scheme is.
    ///
    /// # Errors
    /// [`Error::Mesh`] for patches out of range and parameters not in `[0, 1]`.
    pub fn evaluate(&self, places: &[(u32, [f64; 2])]) -> Result<Vec<DVec3>> {
        self.jets(places, |jet| jet.value)
    }

    /// Derivatives along u and v there.
    ///
    /// # Errors
    /// As [`Patches::evaluate`].
    pub fn derivatives(&self, places: &[(u32, [f64; 2])]) -> Result<Vec<[DVec3; 2]>> {
        self.jets(places, |jet| jet.first)
    }

    /// Unit normals there, on the side from which u and v turn counter-clockwise. At a collapsed edge it is the limit from within the
    /// patch; zero where there is none nearby either.
    ///
    /// # Errors
    /// As [`Patches::evaluate`].
    pub fn normals(&self, places: &[(u32, [f64; 2])]) -> Result<Vec<DVec3>> {
        self.check(places)?;
        Ok(places.iter().map(|&(patch, uv)| self.normal(patch as usize, uv)).collect())
    }

    fn jets<R>(&self, places: &[(u32, [f64; 2])], pick: impl Fn(&Jet) -> R) -> Result<Vec<R>> {
        self.check(places)?;
        Ok(places.iter().map(|&(patch, uv)| pick(&self.jet(patch as usize, uv))).collect())
    }

    fn check(&self, places: &[(u32, [f64; 2])]) -> Result<()> {
        for (i, &(patch, uv)) in places.iter().enumerate() {
            if patch as usize >= self.len() {
                return Err(Error::Mesh(format!(
                    "patch: found {patch} at index {i}, expected 0 to {}",
                    self.len() - 1
                )));
            }
            if uv.iter().any(|t| !(0.0..=1.0).contains(t)) {
                return Err(Error::Mesh(format!(
                    "uv: found {} at index {i}, expected parameters in [0, 1]",
                    bracketed(uv)
                )));
            }
        }
        Ok(())
    }

    fn jet(&self, patch: usize, uv: [f64; 2]) -> Jet {
        let [u, v] = [0, 1].map(|axis| functions(&self.bases[axis], uv[axis]));
        let indices = self.patch(patch);
        // About one of its points: sums of weights that cancel leave no trace of where the patch stands.
        let origin = self.points[indices[0] as usize];
        let sum = |du: usize, dv: usize| -> DVec3 {
            let row = |i: usize| -> DVec3 {
                let row = &indices[i * self.shape[1]..(i + 1) * self.shape[1]];
                row.iter().zip(&v[dv]).map(|(&p, w)| (self.points[p as usize] - origin) * *w).sum()
            };
            u[du].iter().enumerate().map(|(i, w)| row(i) * *w).sum()
        };
        Jet {
            value: origin + sum(0, 0),
            first: [sum(1, 0), sum(0, 1)],
            second: [sum(2, 0), sum(1, 1), sum(0, 2)],
        }
    }

    fn normal(&self, patch: usize, uv: [f64; 2]) -> DVec3 {
        let size = self.size(patch);
        let is_sound = |n: DVec3, [a, b]: [DVec3; 2]| {
            n.length() > COLLAPSED * a.length() * b.length()
                && n.length() > COLLAPSED * size * a.length().max(b.length())
        };
        let jet = self.jet(patch, uv);
        let across = jet.first[0].cross(jet.first[1]);
        if is_sound(across, jet.first) {
            return across.normalize();
        }
        // The cross product's own derivative on the way into the patch.
        let [du, dv] = uv.map(|t| 0.5 - t);
        let [uu, mixed, vv] = jet.second;
        let change = (uu * du + mixed * dv).cross(jet.first[1]) + jet.first[0].cross(mixed * du + vv * dv);
        if change.length() > COLLAPSED * size * size {
            return change.normalize();
        }
        let jet = self.jet(patch, uv.map(|t| t + NEARBY * (0.5 - t)));
        jet.first[0].cross(jet.first[1]).normalize_or_zero()
    }

    /// Largest side of the box of a patch's control points.
    fn size(&self, patch: usize) -> f64 {
        let points: Vec<DVec3> = self.patch(patch).iter().map(|&p| self.points[p as usize]).collect();
        let (low, high) = crate::lattice::bounds(&points);
        (high - low).max_element()
    }
}

fn basis(count: usize, shape: [usize; 2]) -> Result<AxisBasis> {
    let basis = if count < 2 { None } else { AxisBasis::bernstein(count).ok() };
    basis.ok_or_else(|| {
        Error::Mesh(format!(
            "patches: found patches of shape {shape:?}, expected 2 to {MAX_POINTS} control points along u and v"
        ))
    })
}

/// Bernstein polynomials at `t`, their derivatives, and the derivatives of those.
fn functions(basis: &AxisBasis, t: f64) -> [Vec<f64>; 3] {
    let degree = basis.degree();
    let lower = |down: usize| -> Vec<f64> {
        let mut values = vec![1.0];
        for _ in 0..degree.saturating_sub(down) {
            let mut carried = 0.0;
            for value in &mut values {
                let part = *value;
                *value = carried + (1.0 - t) * part;
                carried = t * part;
            }
            values.push(carried);
        }
        values
    };
    let derived = |values: Vec<f64>, degree: usize| -> Vec<f64> {
        let at = |i: usize| values.get(i).copied().unwrap_or(0.0);
        let before = |i: usize| if i == 0 { 0.0 } else { at(i - 1) };
        (0..=degree).map(|i| degree as f64 * (before(i) - at(i))).collect()
    };
    let second =
        if degree < 2 { vec![0.0; degree + 1] } else { derived(derived(lower(2), degree - 1), degree) };
    [lower(0), derived(lower(1), degree), second]
}
