// SPDX-License-Identifier: GPL-3.0-or-later
//! The search for folds, cell by cell and piece by piece.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::determinant::Signs;
use crate::folds::MOST_DEPTH;
use crate::jacobian::{Cell, Cells, Derivatives, Tensor};
use crate::lattice::Lattice;
use crate::pieces::indices;

/// Places looked at along each axis of the domain at least, for showing a fold: enough to see its outline.
const PLACES: usize = 16;

/// Coefficients that pieces may have altogether in a turn: a tenth of a second. Each cell that needs halving gets an equal
/// part, but some pieces at least. Only shapes that are flat in places come near it.
const MOST_COEFFICIENTS: usize = 1 << 20;
const LEAST_PIECES: usize = 16;

/// Places along each axis of a cell in which a flat one has no sign: enough that none is taken for flat by its symmetry.
const FLAT_PLACES: usize = 4;

/// Halvings of the way from a piece's corner to its middle, on which the wrong sign at the corner is met again.
const INWARD_STEPS: i32 = 30;

/// The sign that the determinant should have.
pub(crate) enum Wanted {
    /// That of the frame's.
    Frame(f64),
    /// In each cell that of the rest shape, where it has one.
    Cells(Vec<Option<f64>>),
    /// The same in some cells only; the others may do as they like.
    Kept(Vec<Option<f64>>),
}

impl Wanted {
    pub(crate) fn of(&self, cell: usize) -> Option<f64> {
        match self {
            Self::Frame(sign) => Some(*sign),
            Self::Cells(signs) | Self::Kept(signs) => signs[cell],
        }
    }

    /// Whether a cell is not to be looked at.
    fn leaves_out(&self, cell: usize) -> bool {
        matches!(self, Self::Kept(signs) if signs[cell].is_none())
    }
}

/// A shape of a lattice, in which folds are looked for.
pub(crate) struct Search<'a> {
    cells: &'a Cells,
    wanted: &'a Wanted,
    derivatives: Derivatives,
    depth: u32,
}

/// What is found in one cell.
pub(crate) enum Found {
    /// The sign wanted throughout.
    Unfolded,
    /// Not the sign wanted at these parameters.
    Folded(Vec<DVec3>),
    /// Open at these parameters, the first of several perhaps.
    Open(DVec3),
}

/// Part of a cell, from `low` in the cell's own parameters.
struct Piece {
    tensor: Tensor,
    low: DVec3,
    size: DVec3,
    halvings: [u32; 3],
}

impl<'a> Search<'a> {
    /// `control`: checked to fit the lattice. `is_displaced`: the form in which bound vertices move, where weights are unequal.
    pub(crate) fn new(
        lattice: &Lattice,
        (cells, wanted): (&'a Cells, &'a Wanted),
        (control, is_displaced): (&[DVec3], bool),
        depth: u32,
    ) -> Self {
        let derivatives = Derivatives::new(lattice, control, is_displaced);
        Self { cells, wanted, derivatives, depth: depth.min(MOST_DEPTH) }
    }

    /// Every cell: most are decided as a whole; those that are not share the work of halving.
    pub(crate) fn everywhere(&self) -> Vec<Found> {
        let count = self.cells.count().into_iter().product();
        let mut found: Vec<Option<Found>> =
            (0..count).into_par_iter().map(|index| self.whole(index)).collect();
        let hard: Vec<usize> = (0..count).filter(|&index| found[index].is_none()).collect();
        for (index, result) in self.halved(hard, false).into_iter().flatten() {
            found[index] = Some(result);
        }
        found
            .into_par_iter()
            .enumerate()
            .flat_map_iter(|(index, found)| found.map(|f| self.shown(index, f)))
            .collect()
    }

    /// Stops at the first cell that folds.
    pub(crate) fn is_unfolded(&self) -> bool {
        let count: usize = self.cells.count().into_iter().product();
        let open = |index: usize| match self.whole(index) {
            _ if self.wanted.leaves_out(index) => Some(None),
            Some(Found::Unfolded) => Some(None),
            Some(_) => None,
            None => Some(Some(index)),
        };
        let open: Option<Vec<Option<usize>>> = (0..count).into_par_iter().map(open).collect();
        let halved = open.and_then(|open| self.halved(open.into_iter().flatten().collect(), true));
        halved.is_some_and(|found| found.iter().all(|(_, found)| matches!(found, Found::Unfolded)))
    }

    /// Cells that have to be halved, each with what is found in it; `None` if one folds, where that is all that is asked.
    ///
    /// In turns: all get an equal part of the work, then those still open, as long as most are decided in each turn.
    fn halved(&self, mut hard: Vec<usize>, stop_at_fold: bool) -> Option<Vec<(usize, Found)>> {
        let mut decided = Vec::new();
        loop {
            let search = |&index: &usize| match self.search_cell(index, hard.len()) {
                Found::Folded(_) if stop_at_fold => None,
                found => Some((index, found)),
            };
            let found: Vec<(usize, Found)> = hard.par_iter().map(search).collect::<Option<_>>()?;
            let is_open = |(_, found): &(usize, Found)| matches!(found, Found::Open(_));
            let (open, closed): (Vec<_>, Vec<_>) = found.into_iter().partition(is_open);
            decided.extend(closed);
            if 2 * open.len() > hard.len() || open.is_empty() {
                decided.extend(open);
                return Some(decided);
            }
            hard = open.into_iter().map(|(index, _)| index).collect();
        }
    }

    /// The sign in each cell, of those that have one.
    pub(crate) fn signs(&self) -> Vec<Option<f64>> {
        let count: usize = self.cells.count().into_iter().product();
        let sign = |index: usize| {
            let (cell, signs) = self.cell(index);
            let sign = signs.of(&cell.tensor.middle())?;
            let found = self.search_pieces(&cell, &signs, sign, self.pieces(&cell, count));
            matches!(found, Found::Unfolded).then_some(sign)
        };
        (0..count).into_par_iter().map(sign).collect()
    }

    fn cell(&self, index: usize) -> (Cell, Signs) {
        let [_, nt, nu] = self.cells.count();
        let index = [index / (nt * nu), index / nu % nt, index % nu];
        let cell = self.cells.cell(&self.derivatives, index, self.depth);
        let signs = Signs::new(&cell);
        (cell, signs)
    }

    /// How many pieces a cell may have, one of several that need halving.
    fn pieces(&self, cell: &Cell, cells: usize) -> usize {
        (MOST_COEFFICIENTS / cell.tensor.coefficients.len() / cells).max(LEAST_PIECES)
    }

    /// A cell in one piece; `None` where it has to be halved.
    fn whole(&self, index: usize) -> Option<Found> {
        let (cell, signs) = self.cell(index);
        let centre = DVec3::splat(0.5);
        let Some(wanted) = self.wanted.of(index) else { return Some(Found::Open(cell.at(centre).0)) };
        let middle = cell.tensor.middle();
        let Some(sign) = signs.of(&middle) else {
            return is_flat(&cell, &signs).then(|| Found::Open(cell.at(centre).0));
        };
        if sign != wanted {
            let place = wrong_place(&cell, &signs, wanted, centre)?;
            return Some(Found::Folded(vec![place]));
        }
        signs.is_one(&cell.tensor, &middle).then_some(Found::Unfolded)
    }

    /// A cell that has to be halved, one of so many.
    fn search_cell(&self, index: usize, of: usize) -> Found {
        let (cell, signs) = self.cell(index);
        match self.wanted.of(index) {
            Some(wanted) => self.search_pieces(&cell, &signs, wanted, self.pieces(&cell, of)),
            None => Found::Open(cell.at(DVec3::splat(0.5)).0),
        }
    }

    /// With all the places that show a fold, where one is or may be.
    fn shown(&self, index: usize, found: Found) -> Found {
        let known = match &found {
            Found::Unfolded => return found,
            Found::Folded(places) => places.first().copied(),
            Found::Open(_) => None,
        };
        let Some(wanted) = self.wanted.of(index) else { return found };
        let (cell, signs) = self.cell(index);
        let places = self.wrong_places(&cell, &signs, wanted, known);
        if places.is_empty() { found } else { Found::Folded(places) }
    }

    /// Those parameters with the wrong sign among the middles of a grid in the cell; if there are none, the one that is known.
    fn wrong_places(&self, cell: &Cell, signs: &Signs, wanted: f64, known: Option<DVec3>) -> Vec<DVec3> {
        let (cells, varies) = (self.cells.count(), self.cells.varies());
        let count: [usize; 3] =
            std::array::from_fn(|axis| if varies[axis] { PLACES.div_ceil(cells[axis]) } else { 1 });
        let local = |index: [usize; 3]| {
            DVec3::from_array(std::array::from_fn(|axis| (index[axis] as f64 + 0.5) / count[axis] as f64))
        };
        let places: Vec<DVec3> =
            indices(count).filter_map(|index| wrong_place(cell, signs, wanted, local(index))).collect();
        if places.is_empty() { known.into_iter().collect() } else { places }
    }

    /// Halves what is open until all is decided, depth first: so that few pieces are kept at a time.
    fn search_pieces(&self, cell: &Cell, signs: &Signs, wanted: f64, most: usize) -> Found {
        let whole =
            Piece { tensor: cell.tensor.clone(), low: DVec3::ZERO, size: DVec3::ONE, halvings: [0; 3] };
        let (mut open, mut first_left, mut count) = (vec![whole], None, 1);
        while let Some(mut piece) = open.pop() {
            let middle = piece.tensor.middle();
            if signs.of(&middle) == Some(wanted) && signs.is_one(&piece.tensor, &middle) {
                continue;
            }
            if let Some(place) = piece.wrong_place(cell, signs, wanted, &middle) {
                return Found::Folded(vec![place]);
            }
            let axis = if count < most { self.axis_to_halve(&piece, cell) } else { None };
            if let Some(axis) = axis {
                open.push(piece.halve(axis));
                open.push(piece);
                count += 1;
            } else {
                first_left.get_or_insert(cell.at(piece.low + 0.5 * piece.size).0);
            }
        }
        first_left.map_or(Found::Unfolded, Found::Open)
    }

    /// The axis along which a piece changes most, of those along which it may be halved still.
    fn axis_to_halve(&self, piece: &Piece, cell: &Cell) -> Option<usize> {
        let axes = (0..3).filter(|&axis| piece.halvings[axis] < self.depth);
        let variations = axes.map(|axis| (axis, piece.tensor.variation(axis, &cell.largest)));
        let (axis, _) = variations.filter(|(_, size)| *size > 0.0).max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(axis)
    }
}

impl Piece {
    /// Parameters in the piece with the wrong sign, if its middle or a corner has it.
    fn wrong_place(&self, cell: &Cell, signs: &Signs, wanted: f64, middle: &DMat3) -> Option<DVec3> {
        let at = |inside: DVec3| wrong_place(cell, signs, wanted, self.low + inside * self.size);
        let centre = DVec3::splat(0.5);
        if signs.of(middle) == Some(-wanted) {
            return at(centre);
        }
        let corners = self.tensor.corners().filter(|(_, matrix)| signs.of(matrix) == Some(-wanted));
        // From the corner inwards: at the corner itself the next cell may have another derivative.
        let mut steps = corners.flat_map(|(corner, _)| {
            (1..=INWARD_STEPS).map(move |step| corner + (centre - corner) * 0.5f64.powi(step))
        });
        steps.find_map(at)
    }

    /// Becomes its upper half; the lower is returned.
    fn halve(&mut self, axis: usize) -> Self {
        self.size[axis] *= 0.5;
        self.halvings[axis] += 1;
        let lower =
            Self { tensor: self.tensor.halve(axis), low: self.low, size: self.size, halvings: self.halvings };
        self.low[axis] += self.size[axis];
        lower
    }
}

/// Whether no sign can be told at a cell's corners nor inside: halving it would come to nothing.
fn is_flat(cell: &Cell, signs: &Signs) -> bool {
    let inside = |index: [usize; 3]| DVec3::from_array(index.map(|i| (i as f64 + 0.5) / FLAT_PLACES as f64));
    cell.tensor.corners().all(|(_, matrix)| signs.of(&matrix).is_none())
        && indices([FLAT_PLACES; 3]).all(|index| signs.of(&cell.at(inside(index)).1).is_none())
}

/// The parameters at local ones in a cell, if the sign there, at the parameters as rounded, is the wrong one.
fn wrong_place(cell: &Cell, signs: &Signs, wanted: f64, local: DVec3) -> Option<DVec3> {
    let (parameter, matrix) = cell.at(local);
    (signs.of(&matrix) == Some(-wanted)).then_some(parameter)
}
