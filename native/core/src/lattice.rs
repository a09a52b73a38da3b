// SPDX-License-Identifier: GPL-3.0-or-later
//! The lattice: an affine frame of space with a tensor-product spline basis over it.

use std::ops::{Add, Mul};
use std::sync::Arc;

use glam::{DMat3, DVec3};

use crate::basis::AxisBasis;
use crate::control_map::ControlMap;
use crate::error::{Error, Result};
use crate::inversion::{Inversion, Preimage};
use crate::net::Net;
use crate::words::{bracketed, number};

/// Parameters this close to a face of the domain count as on it, for float64 points: rounding puts a fitted box's own
/// extreme vertices outside in most cases.
pub const FACE_TOLERANCE: f64 = 1e-9;

/// The same for float32 points, whose coordinates carry rounding errors of 6e-8 of the domain's size where the domain lies near
/// the origin.
pub const FACE_TOLERANCE_F32: f64 = 1e-6;

/// Shortest and longest edge of a domain: squares and cubes of what lies between are numbers still.
const SMALLEST_EDGE: f64 = 1e-100;
const LARGEST_EDGE: f64 = 1e100;

/// A frame is refused where its volume is smaller than this fraction of the product of its edge lengths: its inverse
/// would lose more than twelve of float64's sixteen digits.
const FLAT_FRAME: f64 = 1e-12;

/// The heaviest control point of a rational lattice may weigh so many times the lightest: float32 keeps seven digits, and the
/// functions are all but steps by then.
const LARGEST_RATIO: f64 = 1e6;

/// A free-form deformation lattice (Sederberg & Parry; Hoff): a domain, the image of `[0, 1]^3` under an affine map, and one
/// basis per axis. Control points are `[i, j, k]` along `s, t, u`, stored with `k` fastest.
#[derive(Debug, Clone, PartialEq)]
pub struct Lattice {
    axes: [AxisBasis; 3],
    origin: DVec3,
    edges: DMat3,
    inverse: DMat3,
    /// Of a rational lattice, as given.
    weights: Option<Arc<[f64]>>,
    map: Arc<ControlMap>,
}

impl Lattice {
    /// A lattice over the box with corner `origin` and edge vectors `edges` (columns; any affine frame, either
    /// handedness), in the space of the points to deform.
    ///
    /// # Errors
    /// [`Error::Lattice`] where the frame is not finite or encloses no space.
    pub fn new(axes: [AxisBasis; 3], origin: DVec3, edges: DMat3) -> Result<Self> {
        if !origin.is_finite() || !edges.is_finite() {
            return Err(Error::Lattice(
                "lattice frame: found NaN or infinity, expected finite numbers".into(),
            ));
        }
        let unit = unit_columns(edges);
        if let Some(axis) = (0..3).find(|&axis| unit.col(axis) == DVec3::ZERO) {
            return Err(Error::Lattice(format!(
                "lattice frame: edge {} has length 0, expected a box with three extents; scale the lattice up on that axis",
                ["s", "t", "u"][axis]
            )));
        }
        if unit.determinant().abs() <= FLAT_FRAME {
            return Err(Error::Lattice(format!(
                "lattice frame: the edges {} lie in one plane, expected three independent directions",
                written(edges)
            )));
        }
        let lengths = [edges.x_axis, edges.y_axis, edges.z_axis].map(|edge| edge.abs().max_element());
        if lengths.iter().any(|length| !(SMALLEST_EDGE..LARGEST_EDGE).contains(length)) {
            return Err(Error::Lattice(format!(
                "lattice frame: edges between {} and {} long were expected, found {}; scale the lattice",
                number(SMALLEST_EDGE),
                number(LARGEST_EDGE),
                written(edges)
            )));
        }
        let lengths = DMat3::from_diagonal(DVec3::new(
            edges.x_axis.length().recip(),
            edges.y_axis.length().recip(),
            edges.z_axis.length().recip(),
        ));
        let map = Arc::new(ControlMap::new(&axes, None));
        Ok(Self { axes, origin, edges, inverse: lengths * unit.inverse(), weights: None, map })
    }

    /// The same lattice with a weight for each control point, `k` fastest: the map is rational (Sederberg 14.1), with functions
    /// `w B / sum w B`. Only ratios count; equal weights change nothing, to the bit.
    ///
    /// # Errors
    /// [`Error::Lattice`] for another number of weights, for weights that are not positive and finite or more than a million times
    /// apart, and for unequal ones where basis functions are negative, as Blender's cardinal ones: their sum might vanish.
    pub fn with_weights(mut self, weights: Vec<f64>) -> Result<Self> {
        self.check_weights(&weights)?;
        self.map = Arc::new(ControlMap::new(&self.axes, Some(&weights)));
        self.weights = Some(weights.into());
        Ok(self)
    }

    fn check_weights(&self, weights: &[f64]) -> Result<()> {
        if weights.len() != self.len() {
            return Err(Error::Lattice(format!(
                "weights: found {} values, expected {} for a lattice of shape {:?}",
                weights.len(),
                self.len(),
                self.shape()
            )));
        }
        let is_bad = |w: &f64| !(w.is_finite() && *w > 0.0);
        if let Some(i) = weights.iter().position(is_bad) {
            let [_, nv, nw] = self.shape();
            return Err(Error::Lattice(format!(
                "weights: found {} at [{}, {}, {}], the first of {} that are not positive, finite numbers",
                number(weights[i]),
                i / (nv * nw),
                i / nw % nv,
                i % nw,
                weights.iter().copied().filter(is_bad).count()
            )));
        }
        let (low, high) =
            weights.iter().fold((f64::INFINITY, 0.0f64), |(low, high), &w| (low.min(w), high.max(w)));
        if high / low > LARGEST_RATIO {
            return Err(Error::Lattice(format!(
                "weights: found {} and {}, expected the heaviest to weigh at most {} times the lightest",
                number(low),
                number(high),
                number(LARGEST_RATIO)
            )));
        }
        if high > low && self.axes.iter().any(AxisBasis::has_negative_functions) {
            return Err(Error::Lattice(
                "weights: cardinal and Catmull-Rom axes have negative functions, whose weighted sum may vanish; use interpolation \"bspline\" or \"linear\", or equal weights".into(),
            ));
        }
        Ok(())
    }

    /// Weights of the control points as given, `k` fastest; `None` for a lattice that is not rational.
    pub fn weights(&self) -> Option<&[f64]> {
        self.weights.as_deref()
    }

    /// From the lattice's control points to the inner ones that the passes over a mesh know.
    pub fn map(&self) -> &ControlMap {
        &self.map
    }

    pub(crate) fn shared_map(&self) -> &Arc<ControlMap> {
        &self.map
    }

    /// Whether the lattice's map is a quotient of two splines: weights are unequal. Where functions are Blender's, the lattice at rest
    /// is no identity but in the displaced form, which is theirs with weights too.
    pub(crate) fn is_rational_map(&self) -> bool {
        self.map.weights().is_some() && self.axes.iter().all(|axis| axis.rows().is_none())
    }

    /// A lattice over the axis-aligned box of `points`, widened by `margin` times its size on every side. An axis along
    /// which the points are flat gets the largest extent (1 for a single point), centred on them.
    ///
    /// # Errors
    /// [`Error::Lattice`] without points, with non-finite points, or with a margin that leaves no box.
    pub fn around(axes: [AxisBasis; 3], points: &[DVec3], margin: f64) -> Result<Self> {
        check_around(points, margin)?;
        let (low, high) = bounds(points);
        let (origin, size) = widened(low, high, margin);
        Self::new(axes, origin, DMat3::from_diagonal(size))
    }

    /// The bases along s, t and u.
    pub fn axes(&self) -> &[AxisBasis; 3] {
        &self.axes
    }

    /// Corner of the domain at parameters (0, 0, 0).
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// Edge vectors of the domain, as columns.
    pub fn edges(&self) -> DMat3 {
        self.edges
    }

    /// Middle of the domain.
    pub fn centre(&self) -> DVec3 {
        self.origin + self.edges * DVec3::splat(0.5)
    }

    /// Number of control points along s, t, u.
    pub fn shape(&self) -> [usize; 3] {
        [self.axes[0].count(), self.axes[1].count(), self.axes[2].count()]
    }

    /// Number of control points.
    pub fn len(&self) -> usize {
        self.shape().iter().product()
    }

    /// Never: a lattice has at least one control point.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// Control points at rest, `k` fastest: at the Greville abscissae, where the lattice is the identity map (linear
    /// precision).
    pub fn rest(&self) -> Vec<DVec3> {
        let [s, t, u] =
            self.axes.each_ref().map(|axis| (0..axis.count()).map(|i| axis.greville(i)).collect::<Vec<_>>());
        let mut points = Vec::with_capacity(self.len());
        for &si in &s {
            for &tj in &t {
                points.extend(u.iter().map(|&uk| self.point(DVec3::new(si, tj, uk))));
            }
        }
        points
    }

    /// The undeformed point at parameters `(s, t, u)`.
    pub fn point(&self, parameter: DVec3) -> DVec3 {
        self.origin + self.edges * parameter
    }

    /// Parameters `(s, t, u)` of a point, by projection on the frame; inside the domain they lie in `[0, 1]`.
    pub fn parameter(&self, point: DVec3) -> DVec3 {
        self.inverse * (point - self.origin)
    }

    /// The lattice's map at parameters, in float64: `point(p) + sum B(p) (control - rest)`. Inside the domain this is the paper's
    /// equation (1); beyond it, points follow the nearest point of the domain. The same displacement form keeps an axis with a
    /// single control point at its full thickness.
    ///
    /// With unequal weights it is the rational map itself, `sum w B control / sum w B` (Sederberg 14.1), which does not leave the
    /// lattice at rest in its place, but where control points lie on a conic gives it exactly. An axis with a single control point keeps its
    /// thickness: what the control points give is its middle. A mesh bound to the lattice at rest moves by the differences
    /// `sum w B (control - rest) / sum w B` (the displaced form), and so do evaluated points of Blender's bases, with weights too.
    ///
    /// # Errors
    /// [`Error::Lattice`] for a control array of another length or with a non-finite entry, or non-finite parameters.
    pub fn evaluate(&self, parameters: &[DVec3], control: &[DVec3]) -> Result<Vec<DVec3>> {
        use rayon::prelude::*;
        let net = Net::of(self, control)?;
        if let Some(i) = parameters.iter().position(|p| !p.is_finite()) {
            return Err(Error::Lattice(format!(
                "parameters: found NaN or infinity at index {i}, expected finite numbers"
            )));
        }
        Ok(parameters.par_iter().map(|&p| net.at(p)).collect())
    }

    /// The way back of [`Lattice::evaluate`]: parameters at which the lattice shaped by `control` takes these points.
    ///
    /// A point inside the shaped lattice gets parameters in the domain (to within [`FACE_TOLERANCE`]) that `evaluate` takes to it
    /// to rounding, a thousand of float64's `epsilon` times the lattice's size at most (more where its edges all but lie in one
    /// plane). Where the lattice folds over itself and has several, it gets one of them, the same in every call; or, one point
    /// in some hundreds, none is found, and it counts as outside. Any other gets the nearest parameters found, and is not
    /// [`Preimage::inside`].
    ///
    /// # Errors
    /// [`Error::Lattice`] for a control array of another length or with a non-finite entry, [`Error::Mesh`] for points that are
    /// not finite.
    pub fn invert(&self, points: &[DVec3], control: &[DVec3]) -> Result<Vec<Preimage>> {
        use rayon::prelude::*;
        self.check_control("control", control)?;
        if let Some(i) = points.iter().position(|p| !p.is_finite()) {
            return Err(Error::Mesh(format!(
                "points: found NaN or infinity at index {i}, expected finite numbers"
            )));
        }
        let inversion = Inversion::new(self, control);
        Ok(points.par_iter().map(|&p| inversion.find(p, FACE_TOLERANCE, true)).collect())
    }

    /// `control - rest`, after checking `control`.
    pub(crate) fn displacement(&self, control: &[DVec3]) -> Result<Vec<DVec3>> {
        self.check_control("control", control)?;
        Ok(control.iter().zip(self.rest()).map(|(p, rest)| p - rest).collect())
    }

    /// Checks that control points, called `name`, fit the lattice and are finite.
    pub(crate) fn check_control(&self, name: &str, control: &[DVec3]) -> Result<()> {
        if control.len() != self.len() {
            return Err(Error::Lattice(format!(
                "{name}: found {} points, expected {} for a lattice of shape {:?}",
                control.len(),
                self.len(),
                self.shape()
            )));
        }
        if let Some(i) = control.iter().position(|p| !p.is_finite()) {
            let [_, nv, nw] = self.shape();
            return Err(Error::Lattice(format!(
                "{name}: found NaN or infinity at [{}, {}, {}], expected finite numbers",
                i / (nv * nw),
                i / nw % nv,
                i % nw
            )));
        }
        Ok(())
    }

    /// `sum B values` at parameters, over inner control points.
    pub(crate) fn interpolated<V>(&self, values: &[V], parameter: DVec3) -> V
    where
        V: Copy + Default + Add<Output = V> + Mul<f64, Output = V>,
    {
        let [_, nv, nw] = self.map.inner_shape();
        let [(i0, wu), (j0, wv), (k0, ww)] = self.inner_axis_taps(parameter);
        let mut sum = V::default();
        for (i, &a) in wu.iter().enumerate() {
            for (j, &b) in wv.iter().enumerate() {
                let row = ((i0 + i) * nv + j0 + j) * nw + k0;
                let inner = values[row..].iter().zip(&ww).fold(V::default(), |acc, (&p, &c)| acc + p * c);
                sum = sum + inner * (a * b);
            }
        }
        sum
    }

    /// The control points that act at parameters, clamped to what the basis reaches, each with its function's value, `w B / sum w B`
    /// where weights are unequal. Where the first point is the same, all are.
    pub(crate) fn taps(&self, parameter: DVec3) -> impl Iterator<Item = (usize, f64)> {
        let [_, nv, nw] = self.shape();
        let [(i0, wu), (j0, wv), (k0, ww)]: [(usize, Vec<f64>); 3] =
            std::array::from_fn(|axis| self.axes[axis].taps(parameter[axis]));
        let mut taps = Vec::with_capacity(wu.len() * wv.len() * ww.len());
        for (i, a) in wu.iter().enumerate() {
            for (j, b) in wv.iter().enumerate() {
                let row = ((i0 + i) * nv + j0 + j) * nw + k0;
                taps.extend(ww.iter().enumerate().map(|(k, c)| (row + k, a * b * c)));
            }
        }
        if let Some(weights) = self.map.weights() {
            taps.iter_mut().for_each(|(point, share)| *share *= weights[*point]);
            let sum: f64 = taps.iter().map(|(_, share)| share).sum();
            taps.iter_mut().for_each(|(_, share)| *share /= sum);
        }
        taps.into_iter()
    }

    /// Of every axis the first inner control point that acts at clamped parameters, and the spline's values from there on.
    pub(crate) fn inner_axis_taps(&self, parameter: DVec3) -> [(usize, Vec<f64>); 3] {
        std::array::from_fn(|axis| self.axes[axis].inner_taps(parameter[axis]))
    }

    /// The denominator of a rational lattice's functions, `sum w B`; 1 where weights are equal.
    pub(crate) fn denominator(&self, parameter: DVec3) -> f64 {
        self.map.inner_weights().map_or(1.0, |weights| self.interpolated(weights, parameter))
    }
}

/// The columns at length one; a column of length zero stays zero. Scaled first, so that no square over- or underflows.
pub(crate) fn unit_columns(matrix: DMat3) -> DMat3 {
    let unit = |column: DVec3| (column / column.abs().max_element()).normalize_or_zero();
    let column = |c: DVec3| if c == DVec3::ZERO { c } else { unit(c) };
    DMat3::from_cols(column(matrix.x_axis), column(matrix.y_axis), column(matrix.z_axis))
}

/// Checks that a box can be put around points, and widened by a margin.
pub(crate) fn check_around(points: &[DVec3], margin: f64) -> Result<()> {
    if points.is_empty() {
        return Err(Error::Lattice(
            "points: found none, expected at least one to put a lattice around".into(),
        ));
    }
    if let Some(i) = points.iter().position(|p| !p.is_finite()) {
        return Err(Error::Lattice(format!(
            "points: found NaN or infinity at index {i}, expected finite numbers"
        )));
    }
    if !(margin.is_finite() && margin > -0.5) {
        return Err(Error::Lattice(format!(
            "margin: found {}, expected a finite fraction of the box's size above -0.5",
            number(margin)
        )));
    }
    Ok(())
}

/// Corner and size of a domain around a box, with a margin as a fraction of its size on every side. Flat sides get the largest
/// extent first (1 for a single point).
pub(crate) fn widened(low: DVec3, high: DVec3, margin: f64) -> (DVec3, DVec3) {
    let size = high - low;
    let largest = if size.max_element() > 0.0 { size.max_element() } else { 1.0 };
    let flat = size.cmple(DVec3::splat(largest * FLAT_FRAME));
    let size = DVec3::select(flat, DVec3::splat(largest), size);
    let corner = DVec3::select(flat, (low + high - size) * 0.5, low) - size * margin;
    (corner, size * (1.0 + 2.0 * margin))
}

/// Corners of the axis-aligned box of `points`; an inverted box without points.
pub(crate) fn bounds(points: &[DVec3]) -> (DVec3, DVec3) {
    points.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)))
}

/// The edges in a message.
fn written(edges: DMat3) -> String {
    [edges.x_axis, edges.y_axis, edges.z_axis].map(|edge| bracketed(edge.to_array())).join(", ")
}
