# SPDX-License-Identifier: GPL-3.0-or-later
"""Free-form deformation that keeps the volume, exactly.

Bind a mesh to a :class:`Lattice`, move the control points, and get the deformed vertices with the volume of the mesh as
it was (:meth:`Binding.preserve`). The method is that of Hahmann, Bonneau, Barbier, Elber and Hagen, *Volume-preserving
FFD for programmable graphics hardware* (2012).
"""

from ._native import (
    Binding,
    Device,
    Elastic,
    Folds,
    Lattice,
    Patches,
    Pins,
    Preserved,
    Refined,
    Surface,
    Tessellation,
    __version__,
    bent_edges,
    devices,
    prepare_in_background,
    tessellate,
)
from .errors import DeviceError, ElasticError, Error, LatticeError, MeshError, PinError, UnknownDeviceError, VolumeError

__all__ = [
    "Binding",
    "Device",
    "DeviceError",
    "Elastic",
    "ElasticError",
    "Error",
    "Folds",
    "Lattice",
    "LatticeError",
    "MeshError",
    "Patches",
    "PinError",
    "Pins",
    "Preserved",
    "Refined",
    "Surface",
    "Tessellation",
    "UnknownDeviceError",
    "VolumeError",
    "__version__",
    "bent_edges",
    "devices",
    "prepare_in_background",
    "tessellate",
]
