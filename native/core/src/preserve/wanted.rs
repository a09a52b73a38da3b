// SPDX-License-Identifier: GPL-3.0-or-later
//! The volume that each body is to have.

use crate::binding::Binding;
use crate::error::{Error, Result};
use crate::preserve::Preserve;
use crate::surface::Measure;
use crate::vertices::Scalar;
use crate::words::number;

/// Bodies wound both ways whose volumes sum to less than this fraction of their sizes cancel out: the sum says nothing of any.
const CANCELLED: f64 = 1e-9;

impl<T: Scalar> Binding<T> {
    /// The volumes wanted, and the bodies as bound. Pins alone need no volume: with `amount` 0 there may be none.
    pub(super) fn wanted_volumes(&self, options: &Preserve) -> Result<(Vec<f64>, Vec<Measure>)> {
        if !options.amount.is_finite() {
            return Err(Error::Volume(format!(
                "amount: found {}, expected a finite number; 1 preserves",
                number(options.amount)
            )));
        }
        let pins_alone = options.amount == 0.0 && !options.pins.points.is_empty();
        if pins_alone && self.surface().is_err() {
            return Ok((Vec::new(), Vec::new()));
        }
        let bound = self.references()?;
        let wanted = match &options.target {
            Some(target) => shared(target, bound)?,
            None if pins_alone => own(bound),
            None => refuse_flat(bound, T::EPSILON).map(|()| own(bound))?,
        };
        Ok((wanted, bound.to_vec()))
    }
}

fn own(bound: &[Measure]) -> Vec<f64> {
    bound.iter().map(|body| body.volume).collect()
}

/// One volume for each body: as given, or one for all in proportion to their own.
fn shared(target: &[f64], bound: &[Measure]) -> Result<Vec<f64>> {
    if let Some(found) = target.iter().find(|target| !target.is_finite()) {
        return Err(Error::Volume(format!("target: found {}, expected a finite volume", number(*found))));
    }
    match *target {
        _ if target.len() == bound.len() => Ok(target.to_vec()),
        [sum] => in_proportion(sum, bound),
        _ => Err(Error::Volume(format!(
            "target: found {} volumes, expected one number for all bodies together or {}, one for each body",
            target.len(),
            bound.len()
        ))),
    }
}

fn in_proportion(sum: f64, bound: &[Measure]) -> Result<Vec<f64>> {
    let own: f64 = bound.iter().map(|body| body.volume).sum();
    let sizes: f64 = bound.iter().map(|body| body.volume.abs()).sum();
    if own.abs() <= CANCELLED * sizes {
        return Err(Error::Volume(format!(
            "target: found one number, but the volumes of the {} bodies cancel out, so it cannot be shared in proportion to them; give one for each body, or recalculate the normals",
            bound.len()
        )));
    }
    Ok(bound.iter().map(|body| sum * (body.volume / own)).collect())
}

/// Refuses bodies whose own volume is nothing but rounding.
fn refuse_flat(bound: &[Measure], epsilon: f64) -> Result<()> {
    let Some(body) = bound.iter().position(|body| body.is_flat(epsilon)) else { return Ok(()) };
    let (what, advice) = match bound.len() {
        1 => ("the mesh".into(), "or give a target"),
        _ => (format!("body {body}"), "leave it out of the bodies, or give targets"),
    };
    Err(Error::Volume(format!(
        "{what} as bound encloses no volume: found {} with an area of {}; give it thickness, {advice}",
        number(bound[body].volume),
        number(bound[body].area)
    )))
}
