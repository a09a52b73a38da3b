// SPDX-License-Identifier: GPL-3.0-or-later
//! Vertices that are fixed linear combinations of points: what a patch model, a subdivision surface or a refined mesh is.

use glam::DVec3;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::words::number;

/// How far the weights of a row may be from summing to 1 before it does not follow its points as one body: what float32 weights
/// leave of it.
const SUM_TOLERANCE: f64 = 1e-5;

/// Rows that one thread works out at a time at least.
const RUN: usize = 1024;

/// Vertices as linear combinations of points, `vertex = sum weight point`: a sparse matrix by rows.
///
/// The weights of a row need not sum to 1. Where they do the vertex follows every affine motion of the points.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    point_count: usize,
    /// Start of each row; one more entry than rows.
    offsets: Vec<usize>,
    columns: Vec<u32>,
    weights: Vec<f64>,
}

impl Surface {
    /// Rows over `point_count` points: row `i` has the entries `offsets[i] .. offsets[i + 1]` of `columns` (points) and `weights`.
    ///
    /// # Errors
    /// [`Error::Mesh`] for offsets that do not rise from 0 to the number of entries, rows without entries, columns out of range, and
    /// weights that are not finite.
    pub fn new(
        point_count: usize,
        offsets: Vec<usize>,
        columns: Vec<u32>,
        weights: Vec<f64>,
    ) -> Result<Self> {
        check_offsets(&offsets, &columns, &weights)?;
        let row = |entry: usize| offsets.partition_point(|&start| start <= entry).saturating_sub(1);
        if let Some(entry) = columns.iter().position(|&point| point as usize >= point_count) {
            return Err(Error::Mesh(format!(
                "surface: found point {} in row {}, expected 0 to {} for {point_count} points",
                columns[entry],
                row(entry),
                point_count as i64 - 1
            )));
        }
        if let Some(entry) = weights.iter().position(|weight| !weight.is_finite()) {
            return Err(Error::Mesh(format!(
                "surface: found the weight {} in row {}, expected finite numbers",
                number(weights[entry]),
                row(entry)
            )));
        }
        Ok(Self { point_count, offsets, columns, weights })
    }

    /// Rows given one by one as pairs of points in range and finite weights.
    pub(crate) fn of_rows<R: AsRef<[(u32, f64)]>>(
        point_count: usize,
        rows: impl IntoIterator<Item = R>,
    ) -> Self {
        let mut all = Self { point_count, offsets: vec![0], columns: Vec::new(), weights: Vec::new() };
        for row in rows {
            for &(point, weight) in row.as_ref() {
                all.columns.push(point);
                all.weights.push(weight);
            }
            all.offsets.push(all.columns.len());
        }
        all
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Whether there are no vertices.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of points that the vertices are combined of.
    pub fn point_count(&self) -> usize {
        self.point_count
    }

    /// Start of each row in [`Surface::columns`]; one more entry than vertices.
    pub fn offsets(&self) -> &[usize] {
        &self.offsets
    }

    /// Points of all rows, row after row.
    pub fn columns(&self) -> &[u32] {
        &self.columns
    }

    /// Their weights.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Points of one vertex with their weights.
    pub fn row(&self, vertex: usize) -> impl Iterator<Item = (u32, f64)> + Clone {
        let entries = self.offsets[vertex]..self.offsets[vertex + 1];
        self.columns[entries.clone()].iter().copied().zip(self.weights[entries].iter().copied())
    }

    /// The rows whose weights do not sum to 1: their number, the first, and its sum.
    pub fn unbalanced(&self) -> Option<(usize, usize, f64)> {
        let sum = |vertex: usize| self.row(vertex).map(|(_, weight)| weight).sum::<f64>();
        let is_off = |vertex: &usize| (sum(*vertex) - 1.0).abs() > SUM_TOLERANCE;
        let first = (0..self.len()).find(is_off)?;
        Some(((first..self.len()).filter(is_off).count(), first, sum(first)))
    }

    /// The vertices (T) of points in float64.
    ///
    /// # Errors
    /// [`Error::Mesh`] for another number of points.
    pub fn apply(&self, points: &[DVec3]) -> Result<Vec<DVec3>> {
        self.check_count(points.len())?;
        Ok(self.at(|point| points[point]))
    }

    /// The same for any number of values a point, `width` of them side by side: colours, texture coordinates, weights.
    ///
    /// # Errors
    /// [`Error::Mesh`] for another number of points.
    pub fn carry(&self, values: &[f64], width: usize) -> Result<Vec<f64>> {
        self.check_count(values.len().checked_div(width).unwrap_or(self.point_count))?;
        let mut carried = vec![0.0; self.len() * width];
        for (vertex, into) in carried.chunks_exact_mut(width.max(1)).enumerate() {
            for (point, weight) in self.row(vertex) {
                let from = &values[point as usize * width..][..width];
                into.iter_mut().zip(from).for_each(|(sum, value)| *sum += weight * value);
            }
        }
        Ok(carried)
    }

    /// The vertices by the place of each point.
    pub(crate) fn at(&self, point: impl Fn(usize) -> DVec3 + Sync) -> Vec<DVec3> {
        let vertex = |v: usize| self.row(v).map(|(p, weight)| point(p as usize) * weight).sum();
        (0..self.len()).into_par_iter().with_min_len(RUN).map(vertex).collect()
    }

    pub(crate) fn check_count(&self, found: usize) -> Result<()> {
        if found == self.point_count {
            return Ok(());
        }
        Err(Error::Mesh(format!(
            "surface: found {found} points, expected {}, those that its rows combine",
            self.point_count
        )))
    }
}

fn check_offsets(offsets: &[usize], columns: &[u32], weights: &[f64]) -> Result<()> {
    if columns.len() != weights.len() {
        return Err(Error::Mesh(format!(
            "surface: found {} columns and {} weights, expected one weight for each",
            columns.len(),
            weights.len()
        )));
    }
    let (first, last) = (offsets.first().copied(), offsets.last().copied());
    if first != Some(0) || last != Some(columns.len()) {
        return Err(Error::Mesh(format!(
            "surface: offsets run from {first:?} to {last:?}, expected one more than rows, from 0 to the {} entries",
            columns.len()
        )));
    }
    match offsets.windows(2).position(|pair| pair[0] >= pair[1]) {
        None => Ok(()),
        Some(row) => Err(Error::Mesh(format!(
            "surface: row {row} runs from entry {} to {}, expected at least one entry in every row",
            offsets[row],
            offsets[row + 1]
        ))),
    }
}
