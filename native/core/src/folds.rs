// SPDX-License-Identifier: GPL-3.0-or-later
//! Whether a shaped lattice folds over: proof that it does not, or places where it does.
//!
//! The map folds where the determinant of its derivative has the wrong sign. In each cell its Bernstein coefficients
//! decide; where they leave it open, the cell is halved, again and again. Every sign is guarded by a bound on
//! rounding: what it leaves open is undecided, never claimed. All of this is local: a lattice bent round by more than 360
//! degrees overlaps itself without folding anywhere.

use glam::DVec3;

use crate::error::Result;
use crate::fold_search::{Found, Search, Wanted};
use crate::jacobian::Cells;
use crate::lattice::Lattice;
use crate::net::Net;

/// Halvings of a cell along each axis, where the caller has no wish. What decides is local, so most cells need none, and few
/// pieces are ever as small as this; a random shape that all but folded needed more than six.
pub const DEPTH: u32 = 12;

/// More halvings than these would leave pieces of the size of rounding.
pub const MOST_DEPTH: u32 = 24;

/// What is known of a shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Proved to fold nowhere locally.
    Unfolded,
    /// It folds: there are places where the determinant has the wrong sign.
    Folded,
    /// No such place found, and no proof: the determinant comes too near to zero somewhere.
    Undecided,
}

/// Where a shaped lattice folds.
#[derive(Debug, Clone, PartialEq)]
pub struct Folds {
    /// What is known.
    pub verdict: Verdict,
    /// Parameters (s, t, u) with a determinant of the wrong sign: in each cell that folds those of a grid, or one.
    pub parameters: Vec<DVec3>,
    /// Where the lattice takes them.
    pub points: Vec<DVec3>,
    /// For each cell that is undecided, where the lattice takes the middle of the first piece left open.
    pub undecided: Vec<DVec3>,
}

impl Lattice {
    /// Whether the map `point(p) + sum B(p) (control - rest)` folds anywhere in the domain, where its derivative's determinant
    /// has not the sign of the lattice's frame. With `rest` given, the map is measured from the lattice as shaped by that: the
    /// sign wanted in each cell is the one proved there for `rest` (which is undecided where `rest` itself folds).
    ///
    /// With unequal weights the map is what moves the vertices of a mesh: bound to the lattice at rest, `point(p) + sum w B (control - rest)
    /// / sum w B`; with `rest` given, the rational map itself, which [`Lattice::evaluate`] is.
    ///
    /// `depth`: how often a cell is halved along each axis at most; [`DEPTH`] if in doubt, [`MOST_DEPTH`] at most.
    ///
    /// # Errors
    /// [`crate::Error::Lattice`] for a control array of another length or with a non-finite entry.
    pub fn folds(&self, control: &[DVec3], rest: Option<&[DVec3]>, depth: u32) -> Result<Folds> {
        FoldTest::new(self, rest)?.folds(control, depth)
    }

    /// Whether the map of [`Lattice::folds`] is proved to fold nowhere. Stops at the first place where it is not.
    ///
    /// # Errors
    /// As for [`Lattice::folds`].
    pub fn is_unfolded(&self, control: &[DVec3], rest: Option<&[DVec3]>) -> Result<bool> {
        FoldTest::new(self, rest)?.is_unfolded(control)
    }
}

/// A lattice made ready to be tested in many shapes.
pub struct FoldTest<'a> {
    lattice: &'a Lattice,
    cells: Cells,
    wanted: Wanted,
    /// With unequal weights, whether the map is that of vertices bound to the lattice at rest.
    is_displaced: bool,
}

impl<'a> FoldTest<'a> {
    /// For shapes measured from `rest`, or from the lattice at rest.
    ///
    /// # Errors
    /// [`crate::Error::Lattice`] for a rest array of another length or with a non-finite entry.
    pub fn new(lattice: &'a Lattice, rest: Option<&[DVec3]>) -> Result<Self> {
        let frame = Wanted::Frame(lattice.edges().determinant().signum());
        let is_displaced = rest.is_none() || !lattice.is_rational_map();
        let mut test = Self { lattice, cells: Cells::new(lattice), wanted: frame, is_displaced };
        if let Some(rest) = rest {
            lattice.check_control("rest", rest)?;
            test.wanted = Wanted::Cells(test.search(rest, DEPTH).signs());
        }
        Ok(test)
    }

    /// For shapes that must not fold where `control` is proved unfolded; what it leaves open or folds is not looked at.
    ///
    /// # Errors
    /// As for [`FoldTest::new`], and for `control` alike.
    pub(crate) fn keeping(lattice: &'a Lattice, rest: Option<&[DVec3]>, control: &[DVec3]) -> Result<Self> {
        let mut test = Self::new(lattice, rest)?;
        lattice.check_control("control", control)?;
        let signs = test.search(control, DEPTH).signs();
        let kept =
            signs.into_iter().enumerate().map(|(cell, sign)| sign.filter(|_| sign == test.wanted.of(cell)));
        test.wanted = Wanted::Kept(kept.collect());
        Ok(test)
    }

    /// What [`Lattice::folds`] gives.
    ///
    /// # Errors
    /// As there.
    pub fn folds(&self, control: &[DVec3], depth: u32) -> Result<Folds> {
        self.lattice.check_control("control", control)?;
        let (mut parameters, mut open) = (Vec::new(), Vec::new());
        for found in self.search(control, depth).everywhere() {
            match found {
                Found::Unfolded => {}
                Found::Folded(mut places) => parameters.append(&mut places),
                Found::Open(place) => open.push(place),
            }
        }
        let verdict = match (parameters.is_empty(), open.is_empty()) {
            (false, _) => Verdict::Folded,
            (true, false) => Verdict::Undecided,
            (true, true) => Verdict::Unfolded,
        };
        let net = match self.is_displaced {
            true => Net::displaced(self.lattice, &self.lattice.displacement(control)?),
            false => Net::of(self.lattice, control)?,
        };
        let [points, undecided] =
            [&parameters, &open].map(|places| places.iter().map(|&place| net.at(place)).collect());
        Ok(Folds { verdict, parameters, points, undecided })
    }

    /// What [`Lattice::is_unfolded`] gives.
    ///
    /// # Errors
    /// As there.
    pub fn is_unfolded(&self, control: &[DVec3]) -> Result<bool> {
        self.lattice.check_control("control", control)?;
        Ok(self.search(control, DEPTH).is_unfolded())
    }

    fn search(&'a self, control: &[DVec3], depth: u32) -> Search<'a> {
        Search::new(self.lattice, (&self.cells, &self.wanted), (control, self.is_displaced), depth)
    }
}
