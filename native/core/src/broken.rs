// SPDX-License-Identifier: GPL-3.0-or-later
//! Why a surface encloses no volume, in words: holes, edges used wrongly, faces that are none.

use std::fmt::Write as _;

use rayon::prelude::*;

use crate::error::{Error, Result};

/// Holes that a message lists one by one; more are only counted.
const LISTED: usize = 4;

/// Refuses triangles that repeat a vertex.
pub(crate) fn refuse_degenerate(triangles: &[[u32; 3]]) -> Result<()> {
    let repeats = |[a, b, c]: &[u32; 3]| a == b || b == c || c == a;
    let Some(first) = triangles.iter().position(repeats) else { return Ok(()) };
    let count = triangles.iter().filter(|corners| repeats(corners)).count();
    Err(Error::Mesh(format!(
        "triangles: {count} repeat a vertex, the first is triangle {first} {:?}; expected three different vertices; remove degenerate faces",
        triangles[first]
    )))
}

/// Counts the edges that are not used once in each direction, by kind, and names the first of each kind. `faces`: triangles with
/// their numbers. Open edges are left out where caps may close them.
pub(crate) fn edges<'a>(faces: impl Iterator<Item = (usize, &'a [u32; 3])>, with_open: bool) -> String {
    let mut edges: Vec<(u32, u32, bool, usize)> = Vec::new();
    for (f, &[a, b, c]) in faces {
        edges.extend([(a, b), (b, c), (c, a)].map(|(m, n)| (m.min(n), m.max(n), m < n, f)));
    }
    edges.par_sort_unstable();
    let mut kinds: [Option<(usize, u32, u32, usize)>; 3] = [None; 3];
    for group in edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
        let forward = group.iter().filter(|edge| edge.2).count();
        let kind = match (group.len(), forward) {
            (2, 1) => continue,
            (1, _) if !with_open => continue,
            (1, _) => 0,
            (2, _) => 2,
            _ => 1,
        };
        let face = group.iter().map(|edge| edge.3).min().unwrap_or_default();
        let (count, ..) = *kinds[kind].get_or_insert((0, group[0].0, group[0].1, face));
        kinds[kind] = kinds[kind].map(|(_, a, b, first)| (count + 1, a, b, first));
    }
    let names = [
        "open (used by one triangle only; close the holes)",
        "non-manifold (used by more than two triangles; remove inner faces)",
        "inconsistently wound (used twice in one direction; recalculate the normals)",
    ];
    let mut text =
        String::from("does not enclose a volume, expected every edge to be used once in each direction:");
    for (name, found) in names.iter().zip(kinds) {
        if let Some((count, a, b, face)) = found {
            let _ = write!(text, " {count} edges are {name}, the first is edge {a}-{b} of triangle {face};");
        }
    }
    text.pop();
    text
}

/// Says how many holes there are, where, and with how many edges.
pub(crate) fn holes(loops: &[Vec<u32>]) -> String {
    let edges: usize = loops.iter().map(Vec::len).sum();
    let around = if loops.len() == 1 { "one hole".into() } else { format!("{} holes", loops.len()) };
    let mut listed: Vec<String> = loops
        .iter()
        .take(LISTED)
        .map(|each| format!("{} edges from vertex {} on", each.len(), each[0]))
        .collect();
    if loops.len() > LISTED {
        listed.push("…".into());
    }
    format!(
        "does not enclose a volume, expected every edge to be used once in each direction: {edges} edges are open (used by one triangle only) around {around}: {}; close the holes, or let caps close them",
        listed.join(", ")
    )
}
