// SPDX-License-Identifier: GPL-3.0-or-later
//! The directions and shares of a correction.

use glam::{DMat3, DVec3};

use crate::error::{Error, Result};
use crate::lattice::unit_columns;

/// A frame whose unit directions enclose less than this volume has lost twelve of float64's sixteen digits.
const FLAT_FRAME: f64 = 1e-12;

/// Coordinates along the directions that "axes" means.
#[derive(Debug, Clone)]
pub(crate) struct Frame {
    /// Unit directions as columns, and the inverse; `None` for x, y, z.
    pub(crate) directions: Option<(DMat3, DMat3)>,
    pub(crate) determinant: f64,
}

impl Frame {
    pub(crate) fn new(rows: Option<[DVec3; 3]>) -> Result<Self> {
        let Some(rows) = rows else { return Ok(Self { directions: None, determinant: 1.0 }) };
        if rows.iter().any(|row| !row.is_finite()) {
            return Err(Error::Volume(format!("frame: found {rows:?}, expected finite numbers")));
        }
        let columns = unit_columns(DMat3::from_cols(rows[0], rows[1], rows[2]));
        if columns == DMat3::IDENTITY {
            return Ok(Self { directions: None, determinant: 1.0 });
        }
        let determinant = columns.determinant();
        if determinant.abs() <= FLAT_FRAME {
            return Err(Error::Volume(format!(
                "frame: the rows {rows:?} span no space, expected three independent directions"
            )));
        }
        Ok(Self { directions: Some((columns, columns.inverse())), determinant })
    }

    pub(crate) fn is_identity(&self) -> bool {
        self.directions.is_none()
    }

    pub(crate) fn to_frame(&self) -> Option<DMat3> {
        self.directions.map(|(_, inverse)| inverse)
    }

    pub(crate) fn coordinates(&self, point: DVec3) -> DVec3 {
        self.directions.map_or(point, |(_, inverse)| inverse * point)
    }

    pub(crate) fn move_along(&self, axis: usize, distance: f64, point: &mut DVec3) {
        match self.directions {
            Some((columns, _)) => *point += columns.col(axis) * distance,
            None => point[axis] += distance,
        }
    }
}

/// Shares of the axes, made to sum to 1.
///
/// # Errors
/// [`Error::Volume`] for shares that are negative, not finite, or all zero.
pub(crate) fn normalised_shares(axes: [f64; 3]) -> Result<[f64; 3]> {
    if axes.iter().any(|share| !share.is_finite() || *share < 0.0) {
        return Err(Error::Volume(format!(
            "axes: found {axes:?}, expected three finite shares, none negative"
        )));
    }
    let largest = axes.iter().copied().fold(0.0, f64::max);
    if largest == 0.0 {
        return Err(Error::Volume(format!(
            "axes: found {axes:?}, expected at least one positive share; no displacement is allowed"
        )));
    }
    let total: f64 = axes.iter().map(|share| share / largest).sum();
    Ok(axes.map(|share| share / largest / total))
}
