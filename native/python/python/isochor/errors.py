# SPDX-License-Identifier: GPL-3.0-or-later
"""Every exception that isochor raises.

Each is an :class:`Error`, and a ``ValueError`` where the caller's data is wrong or a ``RuntimeError`` where the machine
is.
"""


class Error(Exception):
    """Anything that isochor reports."""


class LatticeError(Error, ValueError):
    """The lattice, its frame, or an array with one entry per control point is wrong."""


class MeshError(Error, ValueError):
    """The mesh, or an array with one entry per vertex, is wrong: not finite, out of range, or, where a volume is asked
    for, open, non-manifold or inconsistently wound."""


class VolumeError(Error, ValueError):
    """The volume cannot be reached, or what the correction was given (axes, frame, target, amount, method) is wrong."""


class PinError(Error, ValueError):
    """Pins are wrong, repeated or contradict each other."""


class ElasticError(Error, ValueError):
    """What an elastic body is made of, its ground, or the time to move on by is wrong."""


class DeviceError(Error, RuntimeError):
    """The device asked for is not there or failed."""


class UnknownDeviceError(DeviceError, ValueError):
    """No device has the name that was given."""
