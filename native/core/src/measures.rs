// SPDX-License-Identifier: GPL-3.0-or-later
//! What a bound mesh encloses: its bodies, and their volumes in any shape.

use glam::DVec3;

use crate::binding::{Binding, too_large, with_engine};
use crate::engine::numbers;
use crate::error::{Error, Result};
use crate::surface::{ClosedSurface, Measure};
use crate::vertices::Scalar;

impl<T: Scalar> Binding<T> {
    /// Number of bodies that keep a volume each; 1 where all triangles enclose one, and where they should.
    pub fn body_count(&self) -> usize {
        self.partition().count()
    }

    /// Body of each triangle, or -1.
    pub fn body_of_triangle(&self) -> Vec<i32> {
        self.partition().of_triangle().map_or_else(|| vec![0; self.triangles().len()], <[i32]>::to_vec)
    }

    /// The closed surface that the triangles form.
    ///
    /// # Errors
    /// [`Error::Mesh`] where they form none.
    pub fn surface(&self) -> Result<&ClosedSurface> {
        let find = || match self.partition().of_triangle() {
            None => ClosedSurface::capped(self.corner_count(), self.triangles(), self.caps_wanted),
            Some(_) => self.partition().surface(self.triangles(), self.caps_wanted),
        };
        self.surface.get_or_init(find).as_ref().map_err(Clone::clone)
    }

    /// Volume, area and radius of every body as bound.
    ///
    /// # Errors
    /// [`Error::Mesh`] where the triangles enclose no volume.
    pub fn references(&self) -> Result<&[Measure]> {
        let surface = self.surface()?;
        Ok(self.reference.get_or_init(|| self.measured(surface, |v| self.place(self.vertices()[v]))))
    }

    /// Volume, area and radius of the mesh as bound, all bodies together.
    ///
    /// # Errors
    /// [`Error::Mesh`] where the triangles enclose no volume.
    pub fn reference(&self) -> Result<Measure> {
        self.references().map(Measure::sum)
    }

    /// Measures every body of deformed vertices (in the order bound) over the bound triangles and caps, in float64.
    ///
    /// # Errors
    /// [`Error::Mesh`] where the triangles enclose no volume, or for another number of vertices.
    pub fn measures(&self, vertices: &[[T; 3]]) -> Result<Vec<Measure>> {
        let surface = self.surface()?;
        self.check_count(vertices.len())?;
        Ok(self.measured(surface, |v| self.place(vertices[v])))
    }

    /// The same of all bodies together.
    ///
    /// # Errors
    /// As [`Binding::measures`].
    pub fn measure(&self, vertices: &[[T; 3]]) -> Result<Measure> {
        self.measures(vertices).map(|bodies| Measure::sum(&bodies))
    }

    /// Signed volume of every body of the mesh deformed by `control`, summed in float64.
    ///
    /// # Errors
    /// As [`Binding::deform`]; [`Error::Mesh`] where the triangles enclose no volume.
    pub fn volumes(&self, control: &[DVec3]) -> Result<Vec<f64>> {
        let surface = self.surface()?;
        let displacement = self.displacement(control)?;
        with_engine!(self, engine => {
            let inner = self.lattice().map().displacement(&displacement);
            let state = engine.deformed(&self.embedding().tasks, &inner, None);
            let columns = numbers(&state);
            let slots = self.embedding().slot_of_vertex();
            let at = |v: usize| DVec3::from_array(columns.map(|column| column[slots[v] as usize].to_f64()));
            let bodies = self.measured(surface, at);
            engine.recycle(state);
            match bodies.iter().find(|body| !body.volume.is_finite()) {
                None => Ok(bodies.iter().map(|body| body.volume).collect()),
                Some(body) => Err(too_large(body.volume)),
            }
        })
    }

    /// The sum of all bodies' volumes.
    ///
    /// # Errors
    /// As [`Binding::volumes`].
    pub fn volume(&self, control: &[DVec3]) -> Result<f64> {
        Ok(self.volumes(control)?.iter().sum())
    }

    /// Measures every body, by the place of each vertex bound.
    fn measured(&self, surface: &ClosedSurface, at: impl Fn(usize) -> DVec3 + Sync) -> Vec<Measure> {
        let over = self.over().map(|surface| surface.at(&at));
        let at = |corner: usize| over.as_ref().map_or_else(|| at(corner), |places| places[corner]);
        let (count, triangles) = (self.corner_count(), self.triangles());
        if self.partition().of_triangle().is_some() {
            return Measure::of_bodies(self.partition(), surface, at, count);
        }
        let loops: Vec<&[u32]> = surface.loops().iter().map(Vec::as_slice).collect();
        match loops.is_empty() {
            true => vec![Measure::of(at, count, triangles)],
            false => vec![Measure::of_part(at, triangles, &loops)],
        }
    }

    /// The surface's vertices over deformed ones, in float64; `None` where the surface is the vertices' own.
    ///
    /// # Errors
    /// [`Error::Mesh`] for another number of vertices.
    pub fn surface_over(&self, vertices: &[[T; 3]]) -> Result<Option<Vec<DVec3>>> {
        self.check_count(vertices.len())?;
        Ok(self.over().map(|surface| surface.at(|v| self.place(vertices[v]))))
    }

    pub(crate) fn check_count(&self, found: usize) -> Result<()> {
        if found == self.vertices().len() {
            return Ok(());
        }
        Err(Error::Mesh(format!(
            "vertices: found {found}, expected the {} that were bound",
            self.vertices().len()
        )))
    }

    fn place(&self, vertex: [T; 3]) -> DVec3 {
        DVec3::from_array(vertex.map(T::to_f64))
    }
}
