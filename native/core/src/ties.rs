// SPDX-License-Identifier: GPL-3.0-or-later
//! Adjacent lattices that stay joined: the control points of one follow those of the other across a common face.
//!
//! With displacements `d` of the control points, along the normal of a face both lattices' maps are the same affine one and `sum B d`. So the
//! joint is C^k where, for each pair of control point lines across the face, the derivatives up to order `k` of both sums are equal in
//! space. The basis functions along the face are the same, so nothing else is needed.

use glam::{DMat3, DVec3};

use crate::basis::AxisBasis;
use crate::ends::end_derivatives;
use crate::error::{Error, Result};
use crate::faces::Face;
use crate::lattice::Lattice;
use crate::preserve::{Basis, Taken};
use crate::words::number;

/// How far apart corners of coinciding faces may be, as a fraction of the face's size: what float32 leaves of an object's transform.
const APART: f64 = 1e-5;

/// How far from parallel the edges across the face may be, as the sine of their angle; and knots from each other.
const UNEQUAL: f64 = 1e-6;

/// One of the two lattices of a tie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The first.
    A,
    /// The second.
    B,
}

/// Two lattices joined across a face.
#[derive(Debug, Clone)]
pub struct Tie {
    lattices: [Lattice; 2],
    rest: [Vec<DVec3>; 2],
    /// Derivatives at the face of the functions along the axis across it, per length along the same direction.
    rows: [Vec<Vec<f64>>; 2],
    /// Shortest changes of a line of control points that change one of these derivatives by 1 and no other.
    answers: [Vec<Vec<f64>>; 2],
    /// From a control point to the next across the face.
    strides: [usize; 2],
    /// First control points of the lines across the face that belong to each other.
    lines: Vec<[usize; 2]>,
}

/// How the axes along one face lie on those along the other.
#[derive(Debug, Clone, Copy)]
struct Fit {
    swapped: bool,
    /// Of each axis along the second face, whether it runs against the first one's.
    flipped: [bool; 2],
}

impl Fit {
    fn all() -> impl Iterator<Item = Self> {
        (0..8u8).map(|n| Self { swapped: n & 4 != 0, flipped: [n & 1 != 0, n & 2 != 0] })
    }

    /// Numbers along the first face's axes as numbers along the second's; `turned` runs one of them backwards along an axis.
    fn over<V: Copy>(self, along: [V; 2], turned: impl Fn(usize, V) -> V) -> [V; 2] {
        let [p, q] = if self.swapped { [along[1], along[0]] } else { along };
        let run = |axis: usize, value: V| if self.flipped[axis] { turned(axis, value) } else { value };
        [run(0, p), run(1, q)]
    }
}

impl Tie {
    /// Ties two lattices, at rest, across faces that coincide, so that the joint can be C^`continuity`.
    ///
    /// # Errors
    /// [`Error::Lattice`] for faces that do not coincide (with how far apart they are) or lie on the same side, for other bases along
    /// them, for rational lattices, for edges across them that are not parallel where derivatives are to agree, and for more continuity than the degrees
    /// across have.
    pub fn new(a: &Lattice, face_a: Face, b: &Lattice, face_b: Face, continuity: usize) -> Result<Self> {
        if [a, b].iter().any(|lattice| lattice.map().weights().is_some()) {
            return Err(Error::Lattice(
                "weights: found a rational lattice, expected polynomial ones (equal weights): where weights differ the joint is not linear in the control points".into(),
            ));
        }
        let fit = fit(a, face_a, b, face_b)?;
        check_bases(a, face_a, b, face_b, fit)?;
        check_across(a, face_a, b, face_b, continuity)?;
        // Per length of the first lattice's edge, out of it.
        let rows_of = |lattice: &Lattice, face: Face, forwards: bool| -> Vec<Vec<f64>> {
            let lengths = [(a, face_a), (lattice, face)].map(|(l, face)| l.edges().col(face.axis).length());
            let rate = if forwards { lengths[0] / lengths[1] } else { -lengths[0] / lengths[1] };
            let mut rows = end_derivatives(&lattice.axes()[face.axis], face.upper, continuity);
            for (order, row) in rows.iter_mut().enumerate() {
                row.iter_mut().for_each(|value| *value *= rate.powi(order as i32));
            }
            rows
        };
        let rows = [rows_of(a, face_a, face_a.upper), rows_of(b, face_b, !face_b.upper)];
        let answers = [answers(&rows[0], "a", face_a)?, answers(&rows[1], "b", face_b)?];
        Ok(Self {
            lines: lines(a, face_a, b, face_b, fit),
            strides: [strides(a.shape())[face_a.axis], strides(b.shape())[face_b.axis]],
            rest: [a.rest(), b.rest()],
            lattices: [a.clone(), b.clone()],
            rows,
            answers,
        })
    }

    /// The largest continuity that the tie holds.
    pub fn continuity(&self) -> usize {
        self.rows[0].len() - 1
    }

    /// The control points of the follower with the least change, `sqrt(sum |change|^2)`, such that the joint with the leader is
    /// C^`continuity`. `control`: of both lattices, the first before the second.
    ///
    /// # Errors
    /// [`Error::Lattice`] for control points that do not fit their lattice.
    pub fn apply(&self, control: [&[DVec3]; 2], leader: Side) -> Result<Vec<DVec3>> {
        self.check(control)?;
        let follower = if leader == Side::A { 1 } else { 0 };
        let mut followed = control[follower].to_vec();
        // Twice: what rounding leaves of the first change.
        for _ in 0..2 {
            let now = if follower == 1 { [control[0], &followed] } else { [&followed, control[1]] };
            let changes: Vec<(usize, DVec3)> =
                self.lines.iter().flat_map(|line| self.change(now, *line, follower)).collect();
            changes.into_iter().for_each(|(point, change)| followed[point] += change);
        }
        Ok(followed)
    }

    /// How far the joint is from C^0, C^1, and so on: the largest difference of the derivatives of that order, in lengths per power of
    /// the first lattice's edge across the face, over the control points of the face.
    ///
    /// # Errors
    /// As [`Tie::apply`].
    pub fn gaps(&self, control: [&[DVec3]; 2]) -> Result<Vec<f64>> {
        self.check(control)?;
        let gap = |order: usize| {
            self.lines.iter().map(|line| self.missing(control, *line, order).length()).fold(0.0, f64::max)
        };
        Ok((0..self.rows[0].len()).map(gap).collect())
    }

    fn check(&self, control: [&[DVec3]; 2]) -> Result<()> {
        self.lattices[0].check_control("control of a", control[0])?;
        self.lattices[1].check_control("control of b", control[1])
    }

    /// By how much the first lattice's derivative on a line exceeds the second's.
    fn missing(&self, control: [&[DVec3]; 2], line: [usize; 2], order: usize) -> DVec3 {
        let [a, b] = [0, 1].map(|side| {
            let at = |i: usize| line[side] + i * self.strides[side];
            let way = |i: usize| control[side][at(i)] - self.rest[side][at(i)];
            self.rows[side][order].iter().enumerate().map(|(i, w)| way(i) * *w).sum::<DVec3>()
        });
        a - b
    }

    /// What closes a line's gaps by moving the follower's points.
    fn change(&self, control: [&[DVec3]; 2], line: [usize; 2], follower: usize) -> Vec<(usize, DVec3)> {
        let sign = if follower == 1 { 1.0 } else { -1.0 };
        let mut changes = vec![DVec3::ZERO; self.rows[follower][0].len()];
        for (order, answer) in self.answers[follower].iter().enumerate() {
            let missing = self.missing(control, line, order) * sign;
            changes.iter_mut().zip(answer).for_each(|(change, share)| *change += missing * *share);
        }
        let at = |i: usize| line[follower] + i * self.strides[follower];
        changes.into_iter().enumerate().map(|(i, change)| (at(i), change)).collect()
    }
}

/// From a control point to the next along each axis.
fn strides([_, nv, nw]: [usize; 3]) -> [usize; 3] {
    [nv * nw, nw, 1]
}

/// The fit of two faces whose corners are nearest to each other.
fn fit(a: &Lattice, face_a: Face, b: &Lattice, face_b: Face) -> Result<Fit> {
    let corners = [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]];
    let apart = |fit: Fit| {
        let of = |along: [f64; 2]| {
            let other = fit.over(along, |_, t| 1.0 - t);
            (a.point(face_a.parameter(along)) - b.point(face_b.parameter(other))).length()
        };
        corners.map(of).into_iter().fold(0.0, f64::max)
    };
    let fits: Vec<(Fit, f64)> = Fit::all().map(|fit| (fit, apart(fit))).collect();
    let best = fits.iter().fold(fits[0], |best, fit| if fit.1 < best.1 { *fit } else { best });
    let edges: DMat3 = a.edges();
    let size = face_a.along().map(|axis| edges.col(axis).length()).into_iter().fold(0.0, f64::max);
    if best.1 <= APART * size {
        return Ok(best.0);
    }
    Err(Error::Lattice(format!(
        "faces {} and {}: their corners are up to {} apart, expected the same face (within {}); move or scale a lattice until they meet",
        face_a.name(),
        face_b.name(),
        number(best.1),
        number(APART * size)
    )))
}

/// Checks that functions along the faces are the same.
fn check_bases(a: &Lattice, face_a: Face, b: &Lattice, face_b: Face, fit: Fit) -> Result<()> {
    let axes = fit.over(face_a.along(), |_, axis| axis);
    for ((axis_a, axis_b), flipped) in axes.into_iter().zip(face_b.along()).zip(fit.flipped) {
        let [one, other] = [&a.axes()[axis_a], &b.axes()[axis_b]];
        if !is_alike(one, other, flipped) {
            return Err(Error::Lattice(format!(
                "faces {} and {}: along them one lattice has {} and the other {}, expected the same points, degree and knots; refine one lattice, or make them alike",
                face_a.name(),
                face_b.name(),
                described(one),
                described(other)
            )));
        }
    }
    Ok(())
}

fn is_alike(one: &AxisBasis, other: &AxisBasis, flipped: bool) -> bool {
    let near = |(a, b): (f64, f64)| (a - b).abs() <= UNEQUAL;
    let (knots, others) = (one.knots().iter().copied(), other.knots().iter().copied());
    (one.count(), one.degree()) == (other.count(), other.degree())
        && one.rows() == other.rows()
        && match flipped {
            false => knots.zip(others).all(near),
            true => knots.zip(others.rev().map(|knot| 1.0 - knot)).all(near),
        }
}

fn described(basis: &AxisBasis) -> String {
    format!("{} points of degree {}", basis.count(), basis.degree())
}

/// Checks what lies across the faces.
fn check_across(a: &Lattice, face_a: Face, b: &Lattice, face_b: Face, continuity: usize) -> Result<()> {
    let (out, into) = (face_a.outward(a).normalize(), -face_b.outward(b).normalize());
    if out.dot(into) <= 0.0 {
        return Err(Error::Lattice(format!(
            "faces {} and {}: both lattices lie on the same side, expected one on each",
            face_a.name(),
            face_b.name()
        )));
    }
    let sine = out.cross(into).length();
    if continuity > 0 && sine > UNEQUAL {
        return Err(Error::Lattice(format!(
            "faces {} and {}: the edges across them are {} degrees apart, expected parallel ones for continuity {continuity}; straighten a lattice, or use 0",
            face_a.name(),
            face_b.name(),
            number(sine.asin().to_degrees())
        )));
    }
    let degrees = [(a, face_a), (b, face_b)].map(|(lattice, face)| lattice.axes()[face.axis].degree());
    let most = degrees[0].min(degrees[1]);
    if continuity > most {
        return Err(Error::Lattice(format!(
            "continuity: found {continuity}, expected at most {most} for degrees {degrees:?} across the faces"
        )));
    }
    Ok(())
}

/// First control points of the lines across two faces that belong to each other.
fn lines(a: &Lattice, face_a: Face, b: &Lattice, face_b: Face, fit: Fit) -> Vec<[usize; 2]> {
    let (along_a, along_b) = (face_a.along(), face_b.along());
    let (strides_a, strides_b) = (strides(a.shape()), strides(b.shape()));
    let [np, nq] = along_a.map(|axis| a.shape()[axis]);
    let counts = along_b.map(|axis| b.shape()[axis]);
    let line = |p: usize, q: usize| {
        let [r, s] = fit.over([p, q], |axis, i| counts[axis] - 1 - i);
        let first = p * strides_a[along_a[0]] + q * strides_a[along_a[1]];
        [first, r * strides_b[along_b[0]] + s * strides_b[along_b[1]]]
    };
    (0..np).flat_map(|p| (0..nq).map(move |q| line(p, q))).collect()
}

/// For each row the shortest vector whose product with it is 1 and with the others 0.
fn answers(rows: &[Vec<f64>], name: &str, face: Face) -> Result<Vec<Vec<f64>>> {
    let mut basis = Basis::default();
    for (order, row) in rows.iter().enumerate() {
        if !matches!(basis.take(row.clone(), 0.0), Taken::Independent(_)) {
            return Err(Error::Lattice(format!(
                "continuity: lattice {name} has too few control points across face {} for derivatives of order {order}; refine it, or use {}",
                face.name(),
                order.saturating_sub(1)
            )));
        }
    }
    let unit = |order: usize| (0..rows.len()).map(|i| f64::from(u8::from(i == order))).collect::<Vec<f64>>();
    Ok((0..rows.len()).map(|order| basis.shortest(&unit(order))).collect())
}
