// SPDX-License-Identifier: GPL-3.0-or-later
//! The convex outline of points in a plane, and directions along its edges.

use glam::DVec2;

/// Corners of the convex outline of the points, counter-clockwise, without those on its edges (Andrew's monotone chain). Fewer
/// than three where all points lie on a line.
pub(super) fn outline(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    if points.len() < 3 {
        return points;
    }
    let mut corners = half(points.iter());
    corners.pop();
    let mut upper = half(points.iter().rev());
    upper.pop();
    corners.append(&mut upper);
    corners
}

/// The side of the outline that keeps turning left on the way from the first point to the last.
fn half<'a>(points: impl Iterator<Item = &'a DVec2>) -> Vec<DVec2> {
    let mut chain: Vec<DVec2> = Vec::new();
    for &point in points {
        while let [.., a, b] = chain[..] {
            if (b - a).perp_dot(point - a) > 0.0 {
                break;
            }
            chain.pop();
        }
        chain.push(point);
    }
    chain
}

/// Unit directions of the outline's edges.
pub(super) fn edges(outline: &[DVec2]) -> impl Iterator<Item = DVec2> {
    let next = outline.iter().cycle().skip(1);
    outline.iter().zip(next).filter_map(|(&from, &to)| (to - from).try_normalize())
}

/// Size of the rectangle around the outline that has a side along `direction`: along it, and across.
pub(super) fn rectangle(outline: &[DVec2], direction: DVec2) -> DVec2 {
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for corner in outline {
        let place = DVec2::new(direction.dot(*corner), direction.perp_dot(*corner));
        (low, high) = (low.min(place), high.max(place));
    }
    high - low
}
