// SPDX-License-Identifier: GPL-3.0-or-later
//! The search for the directions of a small box.
//!
//! About an axis that is given, the smallest box has a side along an edge of the points' outline as seen along that axis: that
//! is found exactly. The search does so about each of the three axes in turn until the box gets no smaller, from several starts.

use std::cmp::Ordering;
use std::f64::consts::PI;

use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;

use crate::lattice::bounds;
use crate::oriented::outline::{edges, outline, rectangle};

/// Directions whose outermost points, on both sides, stand for all.
const EXTREMES: usize = 512;
/// Directions that a search may start from, and how many of those are followed to the end.
const STARTS: usize = 48;
const FOLLOWED: usize = 6;
/// Turns of a search at most; it ends after five to ten.
const TURNS: usize = 40;
/// A turn must make the box smaller by this fraction: less is rounding.
const GAIN: f64 = 1e-12;
/// Least thickness that counts, as a fraction of the largest size: of boxes around a flat thing the one with the smallest face wins.
const THINNEST: f64 = 1e-14;
/// Rounds of Jacobi's method, which converges quadratically: five are enough for 3 x 3.
const SWEEPS: usize = 8;

/// Orthonormal columns along the smallest box found around points. `like`: orthonormal columns to start from too; they come back as
/// they are where no box is smaller.
pub(super) fn smallest(points: &[DVec3], like: DMat3) -> DMat3 {
    let outer = outermost(points);
    let size = |axes: &DMat3| volume(&outer, *axes);
    let by_size = |a: &(f64, DMat3), b: &(f64, DMat3)| a.0.total_cmp(&b.0);
    let sized = |axes: DMat3| (size(&axes), axes);
    let mut spread: Vec<(f64, DMat3)> = directions(STARTS)
        .collect::<Vec<DVec3>>()
        .into_par_iter()
        .map(|direction| sized(turned(&outer, frame_about(direction), 2).1))
        .collect();
    spread.sort_by(by_size);
    spread.truncate(FOLLOWED);
    spread.extend([like, principal(&outer)].map(sized));
    let found = spread.into_par_iter().map(|(_, start)| sized(followed(&outer, start))).collect::<Vec<_>>();
    let best = found.into_iter().min_by(by_size);
    match best {
        Some((volume, axes)) if volume < (1.0 - 1e-9) * size(&like) => axes,
        _ => like,
    }
}

/// Sizes as a volume, flat things at their least thickness.
fn product(size: DVec3) -> f64 {
    size.max(DVec3::splat(THINNEST * size.max_element())).element_product()
}

fn volume(points: &[DVec3], axes: DMat3) -> f64 {
    let along: Vec<DVec3> = points.iter().map(|p| axes.transpose() * *p).collect();
    let (low, high) = bounds(&along);
    product(high - low)
}

/// Axes turned about one of them at a time, until no such turn makes the box smaller.
fn followed(points: &[DVec3], mut axes: DMat3) -> DMat3 {
    let mut volume = volume(points, axes);
    for _ in 0..TURNS {
        let turns = (0..3).map(|axis| turned(points, axes, axis));
        let Some((smaller, best)) = turns.min_by(|a, b| a.0.total_cmp(&b.0)) else { break };
        if smaller >= (1.0 - GAIN) * volume {
            break;
        }
        (volume, axes) = (smaller, best);
    }
    axes
}

/// Axes turned about one of them so that the box is smallest, and its volume.
fn turned(points: &[DVec3], axes: DMat3, axis: usize) -> (f64, DMat3) {
    let (one, other) = (axes.col((axis + 1) % 3), axes.col((axis + 2) % 3));
    let corners = outline(points.iter().map(|p| DVec2::new(one.dot(*p), other.dot(*p))).collect());
    let depths = points.iter().map(|p| axes.col(axis).dot(*p));
    let (low, high) =
        depths.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), d| (low.min(d), high.max(d)));
    let sized = |direction: DVec2| (product(rectangle(&corners, direction).extend(high - low)), direction);
    let best = edges(&corners).map(sized).min_by(|a, b| a.0.total_cmp(&b.0));
    let (volume, direction) = best.unwrap_or_else(|| sized(DVec2::X));
    let mut turned = axes;
    *turned.col_mut((axis + 1) % 3) = one * direction.x + other * direction.y;
    *turned.col_mut((axis + 2) % 3) = other * direction.x - one * direction.y;
    (volume, turned)
}

/// The points that reach furthest in directions spread over the sphere; all, where they are few.
fn outermost(points: &[DVec3]) -> Vec<DVec3> {
    if points.len() <= 2 * EXTREMES {
        return points.to_vec();
    }
    let ends = |direction: DVec3| {
        let (mut low, mut high) = ((f64::INFINITY, 0), (f64::NEG_INFINITY, 0));
        for (i, point) in points.iter().enumerate() {
            let reach = direction.dot(*point);
            low = if reach < low.0 { (reach, i) } else { low };
            high = if reach > high.0 { (reach, i) } else { high };
        }
        [low.1, high.1]
    };
    // Of a spiral twice as long only the half above the equator: the ends of a direction are those of its opposite.
    let half: Vec<DVec3> = directions(2 * EXTREMES).take(EXTREMES).collect();
    let mut found: Vec<usize> = half.into_par_iter().flat_map_iter(ends).collect();
    found.sort_unstable();
    found.dedup();
    found.into_iter().map(|i| points[i]).collect()
}

/// Unit vectors spread evenly over the sphere, in a spiral from one pole to the other.
fn directions(count: usize) -> impl Iterator<Item = DVec3> {
    let golden = PI * (1.0 + 5.0_f64.sqrt());
    (0..count).map(move |i| {
        let place = i as f64 + 0.5;
        let height = 1.0 - 2.0 * place / count as f64;
        let radius = (1.0 - height * height).sqrt();
        DVec3::new(radius * (golden * place).cos(), radius * (golden * place).sin(), height)
    })
}

/// Orthonormal, right-handed columns, the last along the direction.
fn frame_about(direction: DVec3) -> DMat3 {
    let (one, other) = direction.any_orthonormal_pair();
    DMat3::from_cols(one, other, direction)
}

/// Directions in which the points spread most and least: eigenvectors of their covariance, by Jacobi's rotations.
fn principal(points: &[DVec3]) -> DMat3 {
    let mean = points.iter().sum::<DVec3>() / points.len() as f64;
    let mut matrix = points.iter().fold(DMat3::ZERO, |sum, p| {
        let offset = *p - mean;
        sum + DMat3::from_cols(offset * offset.x, offset * offset.y, offset * offset.z)
    });
    let mut axes = DMat3::IDENTITY;
    for (i, j) in [(0, 1), (0, 2), (1, 2)].repeat(SWEEPS) {
        let across = matrix.col(j)[i];
        if across == 0.0 {
            continue;
        }
        let ratio = (matrix.col(j)[j] - matrix.col(i)[i]) / (2.0 * across);
        let tangent = ratio.signum() / (ratio.abs() + ratio.hypot(1.0));
        let cosine = tangent.hypot(1.0).recip();
        let mut turn = DMat3::IDENTITY;
        (turn.col_mut(i)[i], turn.col_mut(j)[j]) = (cosine, cosine);
        (turn.col_mut(i)[j], turn.col_mut(j)[i]) = (-tangent * cosine, tangent * cosine);
        matrix = turn.transpose() * matrix * turn;
        axes *= turn;
    }
    axes
}

/// The same axes in the order, and turned the way, that is nearest to `like`; right-handed.
pub(super) fn nearest_order(axes: DMat3, like: DMat3) -> DMat3 {
    let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let near = |order: &[usize; 3]| (0..3).map(|i| axes.col(order[i]).dot(like.col(i)).abs()).sum::<f64>();
    // The first of the best.
    let better = |best: [usize; 3], order: [usize; 3]| match near(&order).partial_cmp(&near(&best)) {
        Some(Ordering::Greater) => order,
        _ => best,
    };
    let order = orders.into_iter().fold(orders[0], better);
    let column = |i: usize| {
        let axis = axes.col(order[i]);
        if axis.dot(like.col(i)) < 0.0 { -axis } else { axis }
    };
    let (one, other) = (column(0), column(1));
    let last = column(2);
    let handed = if one.cross(other).dot(last) < 0.0 { -last } else { last };
    DMat3::from_cols(one, other, handed)
}
