// SPDX-License-Identifier: GPL-3.0-or-later
//! The faces of a lattice's domain, by name.

use glam::DVec3;

use crate::lattice::Lattice;

/// Faces of a lattice by name: where the first, second or third parameter is 0 or 1.
pub const FACES: [&str; 6] = ["s0", "s1", "t0", "t1", "u0", "u1"];

/// A face of a lattice: the axis across it, and whether it is where that parameter is 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Face {
    /// 0, 1, 2 for s, t, u.
    pub axis: usize,
    /// Where the parameter is 1.
    pub upper: bool,
}

impl Face {
    /// All faces, by [`FACES`].
    pub fn named(name: &str) -> Option<Self> {
        let index = FACES.iter().position(|face| *face == name)?;
        Some(Self { axis: index / 2, upper: index % 2 == 1 })
    }

    /// The name.
    pub fn name(self) -> &'static str {
        FACES[2 * self.axis + usize::from(self.upper)]
    }

    /// The axes along the face.
    pub(crate) fn along(self) -> [usize; 2] {
        [[1, 2], [0, 2], [0, 1]][self.axis]
    }

    /// The parameters of a place on the face.
    pub(crate) fn parameter(self, along: [f64; 2]) -> DVec3 {
        let mut parameter = DVec3::ZERO;
        parameter[self.axis] = f64::from(u8::from(self.upper));
        self.along().into_iter().zip(along).for_each(|(axis, t)| parameter[axis] = t);
        parameter
    }

    /// The edge across the face, out of the lattice.
    pub(crate) fn outward(self, lattice: &Lattice) -> DVec3 {
        let edge = lattice.edges().col(self.axis);
        if self.upper { edge } else { -edge }
    }
}
