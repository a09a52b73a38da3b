// SPDX-License-Identifier: GPL-3.0-or-later
//! Lattices one after the other: each takes what leaves the one before, and the last corrects the volume of them all.

use std::sync::OnceLock;

use glam::DVec3;

use crate::binding::{Bind, Binding};
use crate::error::{Error, Result};
use crate::lattice::Lattice;
use crate::preserve::{Preserve, Preserved};
use crate::vertices::Scalar;

/// Several lattices on one mesh, in the order in which they act (Ferrier's local and hierarchical deformations).
///
/// Vertices are embedded in each lattice where the one before leaves them. So the rows of the last depend on the control points of all
/// before it, and the volume is corrected by the last alone, exactly.
pub struct Chain<T> {
    before: Before<T>,
    last: Binding<T>,
}

/// All lattices of a chain but the last, and what left them.
pub struct Before<T> {
    links: Vec<Binding<T>>,
    /// The control points that each has deformed with; what comes after is embedded accordingly.
    fed: Vec<Option<Vec<DVec3>>>,
    /// The vertices that enter the chain.
    given: Vec<[T; 3]>,
    volumes: OnceLock<Vec<f64>>,
}

impl<T: Scalar> Chain<T> {
    /// Binds vertices to lattices, each with its own options; triangles, bodies and caps are the last one's, where volumes are
    /// measured.
    ///
    /// # Errors
    /// [`Error::Lattice`] without a lattice, and as [`Binding::with`].
    pub fn new(links: Vec<(Lattice, Bind)>, vertices: Vec<[T; 3]>, triangles: Vec<[u32; 3]>) -> Result<Self> {
        let mut bound = Vec::with_capacity(links.len());
        let count = links.len();
        for (i, (lattice, options)) in links.into_iter().enumerate() {
            let own = if i + 1 == count { triangles.clone() } else { Vec::new() };
            bound.push(Binding::with(lattice, vertices.clone(), own, options)?);
        }
        let Some(last) = bound.pop() else {
            return Err(Error::Lattice("lattices: found none, expected at least one".into()));
        };
        let fed = vec![None; bound.len()];
        Ok(Self { before: Before { links: bound, fed, given: vertices, volumes: OnceLock::new() }, last })
    }

    /// All lattices but the last, and the last.
    pub fn into_parts(self) -> (Before<T>, Binding<T>) {
        (self.before, self.last)
    }

    /// The last lattice's binding, as it was fed last.
    pub fn last(&self) -> &Binding<T> {
        &self.last
    }

    /// Number of lattices.
    pub fn len(&self) -> usize {
        self.before.len() + 1
    }

    /// Never: there is a last lattice.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// Deforms by control points of each lattice, in order: the same as binding to each in turn.
    ///
    /// # Errors
    /// [`Error::Lattice`] for another number of control point sets, and as [`Binding::deform`].
    pub fn deform(&mut self, controls: &[Vec<DVec3>], out: &mut [[T; 3]]) -> Result<()> {
        let control = self.before.feed(controls, &mut self.last)?.control;
        self.last.deform(control, out)
    }

    /// Volume of the result.
    ///
    /// # Errors
    /// As [`Chain::deform`] and [`Binding::volume`].
    pub fn volume(&mut self, controls: &[Vec<DVec3>]) -> Result<f64> {
        let control = self.before.feed(controls, &mut self.last)?.control;
        self.last.volume(control)
    }

    /// Deforms and corrects the last lattice's control points so that the volume of what leaves the chain is the one wanted: without a
    /// target that of the vertices that enter it.
    ///
    /// # Errors
    /// As [`Chain::deform`] and [`Binding::preserve`].
    pub fn preserve(
        &mut self,
        controls: &[Vec<DVec3>],
        options: &Preserve,
        out: &mut [[T; 3]],
    ) -> Result<Preserved> {
        let control = self.before.feed(controls, &mut self.last)?.control;
        let pins_alone = options.amount == 0.0 && !options.pins.points.is_empty();
        if options.target.is_some() || pins_alone {
            return self.last.preserve(control, options, out);
        }
        let target = Some(self.before.volumes(&self.last)?.to_vec());
        self.last.preserve(control, &Preserve { target, ..options.clone() }, out)
    }

    /// New positions of the vertices that enter the chain.
    ///
    /// # Errors
    /// As [`Binding::update`].
    pub fn update(&mut self, vertices: Vec<[T; 3]>) -> Result<()> {
        self.before.update(vertices, &mut self.last)
    }
}

/// What feeding a chain came to.
#[derive(Debug)]
pub struct Fed<'a> {
    /// The last lattice's control points.
    pub control: &'a [DVec3],
    /// Whether the last lattice's vertices are new.
    pub is_new: bool,
}

impl<T: Scalar> Before<T> {
    /// Number of lattices before the last.
    pub fn len(&self) -> usize {
        self.links.len()
    }

    /// Whether the last is the only one.
    pub fn is_empty(&self) -> bool {
        self.links.is_empty()
    }

    /// Control points of each lattice but the last.
    pub fn shapes(&self) -> impl Iterator<Item = [usize; 3]> {
        self.links.iter().map(|link| link.lattice().shape())
    }

    /// Brings what leaves these lattices to the last. Lattices up to the first whose control points are other than in the last call
    /// have nothing to do.
    ///
    /// # Errors
    /// [`Error::Lattice`] for another number of control point sets than lattices, the last included, and as [`Binding::deform`].
    pub fn feed<'a>(&mut self, controls: &'a [Vec<DVec3>], last: &mut Binding<T>) -> Result<Fed<'a>> {
        let Some((control, before)) =
            controls.split_last().filter(|(_, before)| before.len() == self.links.len())
        else {
            return Err(Error::Lattice(format!(
                "controls: found {} sets of control points, expected {}, one for each lattice",
                controls.len(),
                self.links.len() + 1
            )));
        };
        let known = self.fed.iter().zip(before).take_while(|(fed, control)| fed.as_ref() == Some(*control));
        let first = known.count();
        self.fed[first..].fill(None);
        for (i, control) in before.iter().enumerate().skip(first) {
            let mut leaving = self.links[i].vertices().to_vec();
            self.links[i].deform(control, &mut leaving)?;
            self.links.get_mut(i + 1).unwrap_or(last).update(Some(leaving), None, None, None)?;
            self.fed[i] = Some(control.clone());
        }
        Ok(Fed { control, is_new: first < before.len() })
    }

    /// Volume of each body of the vertices that enter the chain: what a correction without a target is to reach.
    ///
    /// # Errors
    /// [`Error::Mesh`] where the triangles enclose no volume.
    pub fn volumes(&self, last: &Binding<T>) -> Result<&[f64]> {
        if let Some(volumes) = self.volumes.get() {
            return Ok(volumes);
        }
        let bodies = last.measures(&self.given)?;
        Ok(self.volumes.get_or_init(|| bodies.iter().map(|body| body.volume).collect()))
    }

    /// New positions of the vertices that enter the chain. On an error nothing changes.
    ///
    /// # Errors
    /// As [`Binding::update`].
    pub fn update(&mut self, vertices: Vec<[T; 3]>, last: &mut Binding<T>) -> Result<()> {
        self.links.first_mut().unwrap_or(last).update(Some(vertices.clone()), None, None, None)?;
        self.given = vertices;
        self.volumes = OnceLock::new();
        self.fed.fill(None);
        Ok(())
    }
}
