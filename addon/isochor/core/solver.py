# SPDX-License-Identifier: GPL-3.0-or-later
"""From what enters a modifier in one frame to the vertices that leave it, keeping what frames have in common."""

from dataclasses import dataclass, field
from functools import partial
from time import perf_counter
from typing import Any, Literal
from weakref import ref

import numpy as np
from numpy.typing import NDArray

import isochor

from . import pin_problem, problem
from . import pins as pinning
from .arrays import same_array
from .bound import Embedding
from .frames import Frames
from .grid import Grid, build_lattice
from .pins import Pins
from .report import Report
from .settings import Settings
from .volume import is_flat

Vertices = NDArray[np.floating[Any]]
METHODS: dict[str, Literal["balanced", "sweep"]] = {"Balanced": "balanced", "Sweep": "sweep"}
OUTSIDES: dict[str, Literal["keep", "extend"]] = {"Keep": "keep", "Extend": "extend"}
FLAT_PERHAPS = 1e-3
"""Fraction of the rest volume below which what enters is looked at closely: that costs time, so not in every frame."""


@dataclass(frozen=True)
class Request:
    """One frame of one modifier, in the deformed object's own space.

    ``positions`` (V, 3) float32; ``influence`` (V,) float32 in [0, 1] or None for 1 everywhere; ``triangles``
    (F, 3) int32, the very same array as in the frame before where the faces have not changed, or None with the reason
    in ``no_triangles``; ``control`` (nu, nv, nw, 3) float64; ``frame`` (3, 3) rows or None; ``rest_volume`` is the
    volume that entered when the modifier was added or bound, or None where that is not known. ``device`` is what
    should compute: "auto", "gpu", "cpu" or the name of an adapter; ``double`` whether in float64 up to the last
    rounding. ``bound``: the lattice when its rest was set, from which ``control`` then moves the vertices; None where
    ``grid``, the lattice as it stands, embeds them. ``pins``: points that must land on targets, or None.
    """

    positions: Vertices = field(repr=False)
    influence: NDArray[np.float32] | None = field(repr=False)
    triangles: NDArray[np.int32] | None = field(repr=False)
    no_triangles: str
    grid: Grid
    control: NDArray[np.float64] = field(repr=False)
    frame: NDArray[np.float64] | None
    rest_volume: float | None
    settings: Settings
    device: str = "auto"
    double: bool = False
    bound: Embedding | None = None
    pins: Pins | None = None

    @property
    def embedding_grid(self) -> Grid:
        """The undeformed lattice that the vertices are embedded in."""
        return self.grid if self.bound is None else self.bound.grid

    @property
    def rest_control(self) -> NDArray[np.float64] | None:
        """Control points that move nothing; None for those of the undeformed lattice."""
        return None if self.bound is None else self.bound.control

    def same_as(self, other: "Request | None") -> bool:
        """Whether the two ask for the same thing, so that the answer is known."""
        return (
            other is not None
            and self.triangles is other.triangles
            and (self.no_triangles, self.rest_volume, self.settings, self.device, self.double)
            == (other.no_triangles, other.rest_volume, other.settings, other.device, other.double)
            and self.grid.same_as(other.grid)
            and self.embeds_as(other)
            and np.array_equal(self.control, other.control)
            and same_array(self.frame, other.frame)
            and same_array(self.influence, other.influence)
            and same_array(self.positions, other.positions)
            and pinning.same(self.pins, other.pins)
        )

    def embeds_as(self, other: "Request") -> bool:
        """Whether the two embed a vertex alike."""
        return (self.bound is not None and self.bound is other.bound) or (
            self.embedding_grid.same_as(other.embedding_grid) and same_array(self.rest_control, other.rest_control)
        )


@dataclass(frozen=True)
class Outcome:
    """``vertices`` (V, 3) float32 in object space, or None: leave the mesh undeformed. ``report`` says why."""

    vertices: Vertices | None = field(repr=False)
    report: Report


class Solver:
    """The cache of one modifier in one mode (viewport or render). Not thread-safe: the caller serialises.

    ``frames``: where frames seen before are kept, shared with other solvers; by default none is.
    """

    def __init__(self, frames: Frames | None = None) -> None:
        self._frames = Frames() if frames is None else frames
        self._binding: isochor.Binding | None = None
        self._lattice: isochor.Lattice | None = None
        self._bound: Request | None = None
        self._no_device = ""
        self._answered: Request | None = None
        self._outcome: Outcome | None = None

    @property
    def bound_transform(self) -> NDArray[np.float64] | None:
        """The lattice's transform in the frame before; None where that could not be embedded."""
        return self._answered.grid.to_object if self._answered is not None and self._binding is not None else None

    @property
    def entered(self) -> Vertices | None:
        """(V, 3) positions that the frame before was computed from."""
        return None if self._answered is None else self._answered.positions

    def solve(self, request: Request) -> Outcome:
        """The outcome of ``request``; the very same object as before where nothing has changed. Never raises
        ``isochor.Error``: it becomes a problem in the report, and the frame the uncorrected deformation."""
        if self._outcome is None or not request.same_as(self._answered):
            started = perf_counter()
            known = self._frames.find(self, request) if self._binding is not None else None
            self._outcome, self._answered = self._fresh(request) if known is None else known, request
            self._outcome.report.milliseconds = (perf_counter() - started) * 1e3
            if known is None and self._binding is not None:
                self._frames.keep(self, request, self._outcome)
        return self._outcome

    def incoming_volume(self, request: Request) -> float | None:
        """Signed volume of the mesh that enters, or None where it encloses none, as one that is open or flat."""
        if request.triangles is None:
            return None
        try:
            volume = self._bind(request).reference_volume
            return None if is_flat(request.positions, request.triangles) else volume
        except isochor.Error:
            self._forget()
            return None

    def bound_volume(self) -> float | None:
        """Signed volume of the mesh that entered last, or None where it encloses none."""
        return None if self._answered is None else self.incoming_volume(self._answered)

    def _fresh(self, request: Request) -> Outcome:
        try:
            binding = self._bind(request)
        except isochor.Error as error:
            self._forget()
            return Outcome(None, Report(problems=(problem.sentence(error),)))
        problems = (self._no_device,) if self._no_device else ()
        report = Report(
            binding=binding,
            grid=request.grid,
            bound=request.bound,
            asked=request.control,
            problems=problems,
            pins=request.pins,
        )
        report.embed = partial(_embedded_again, ref(self), request)
        report.result = self._corrected(binding, request, report)
        if report.result is None:
            return Outcome(single(binding.deform(request.control)), report)
        vertices = single(report.result.vertices)
        if request.double and request.triangles is not None:
            report.rounded = vertices, request.triangles
        return Outcome(vertices, report)

    def _corrected(self, binding: isochor.Binding, request: Request, report: Report) -> isochor.Preserved | None:
        """The lattice with its pins on their targets and its volume kept. Where the volume cannot be kept, with the
        pins alone; where these cannot be either, None. What is wrong goes into the report."""
        amounts = [request.settings.preserve] if request.settings.preserve > 0.0 else []
        for amount in (*amounts, *([0.0] if request.pins is not None else [])):
            try:
                result = self._preserve(binding, request, amount)
            except isochor.PinError as error:
                names = () if request.pins is None else request.pins.names
                report.problems += (pin_problem.trouble(error, names),)
                return None
            except isochor.Error as error:
                reason = request.no_triangles if amount > 0.0 else ""
                report.problems += (reason or problem.sentence(error),)
            else:
                report.keeps_volume = amount > 0.0
                return result
        return None

    def _preserve(self, binding: isochor.Binding, request: Request, amount: float) -> isochor.Preserved:
        settings, pins = request.settings, request.pins
        try:
            return binding.preserve(
                request.control,
                axes=settings.axes,
                frame=request.frame,
                method=METHODS[settings.method],
                weights=self._weights(request),
                pins=None if pins is None else pins.for_native(),
                target=wanted_volume(binding, request) if amount > 0.0 else None,
                amount=amount,
            )
        except isochor.VolumeError as error:
            if request.triangles is not None and is_flat(request.positions, request.triangles):
                raise isochor.VolumeError(problem.FLAT) from error
            raise

    def _weights(self, request: Request) -> NDArray[np.float64] | None:
        """(nu, nv, nw) how much each control point resists the correction; None where all do alike."""
        distance = request.settings.falloff
        if request.pins is None or distance <= 0.0 or self._lattice is None:
            return None
        return pinning.fading_weights(self._lattice, request.pins, request.positions, request.rest_control, distance)

    def _bind(self, request: Request) -> isochor.Binding:
        before = self._bound
        if self._binding is None or before is None or not self._same_mesh(request, before):
            self._frames.forget(self)
            self._lattice = build_lattice(request.embedding_grid)
            self._binding = self._bind_anew(self._lattice, request)
        else:
            self._update(self._binding, request, before)
        self._bound = request
        return self._binding

    def _bind_anew(self, lattice: isochor.Lattice, request: Request) -> isochor.Binding:
        """Binds to the device asked for, or where this machine does not have it to the CPU; float64 is the CPU's."""

        def bind(device: str) -> isochor.Binding:
            return lattice.bind(
                entering(request),
                request.triangles,
                device=device,
                outside=OUTSIDES[request.settings.outside],
                influence=request.influence,
                rest=request.rest_control,
            )

        self._no_device = ""
        try:
            return bind("cpu" if request.double else request.device)
        except isochor.UnknownDeviceError:
            self._no_device = problem.no_device(request.device)
            return bind("cpu")

    def _same_mesh(self, request: Request, before: Request) -> bool:
        return (
            request.triangles is before.triangles
            and len(request.positions) == len(before.positions)
            and request.settings.outside == before.settings.outside
            and (request.device, request.double) == (before.device, before.double)
            and (request.influence is None) == (before.influence is None)
            and (request.bound is None) == (before.bound is None)
        )

    def _update(self, binding: isochor.Binding, request: Request, before: Request) -> None:
        """Hands the binding what differs from the frame before."""
        same_lattice = request.embeds_as(before)
        same_positions = same_array(request.positions, before.positions)
        same_influence = same_array(request.influence, before.influence)
        if same_lattice and same_positions and same_influence:
            return
        if not same_lattice:
            self._lattice = build_lattice(request.embedding_grid)
        binding.update(
            vertices=None if same_positions else entering(request),
            lattice=None if same_lattice else self._lattice,
            influence=None if same_influence else request.influence,
            rest=None if same_lattice else request.rest_control,
        )

    def _forget(self) -> None:
        self._binding = self._lattice = self._bound = None


def _embedded_again(solver: "ref[Solver]", request: Request) -> isochor.Binding:
    """The binding with the mesh of this request in it. A report must not keep its solver, which keeps the report: only
    Python's search for cycles would let go of both, and of the native library's memory, much later."""
    alive = solver()
    return (Solver() if alive is None else alive)._bind(request)


def wanted_volume(binding: isochor.Binding, request: Request) -> float | None:
    """The volume to reach: that of the reference, times the factor of the Target input. None is that of the mesh as
    bound, which the native library refuses where the mesh is flat; any other volume is refused for it here."""
    settings, own = request.settings, binding.reference_volume
    rest = request.rest_volume if settings.reference == "Rest" else None
    if settings.target == 1.0 and rest in (None, own):
        return None
    perhaps_flat = rest is None or abs(own) <= FLAT_PERHAPS * abs(rest)
    if perhaps_flat and request.triangles is not None and is_flat(request.positions, request.triangles):
        raise isochor.VolumeError(problem.FLAT)
    return (own if rest is None else rest) * settings.target


def target_volume(binding: isochor.Binding, request: Request) -> float | None:
    """Signed volume that the mesh of this request, which is in the binding, should have; None where it encloses
    none."""
    if request.triangles is None:
        return None
    try:
        wanted = wanted_volume(binding, request)
        return binding.reference_volume if wanted is None else wanted
    except isochor.Error:
        return None


def entering(request: Request) -> Vertices:
    """The positions in the precision to compute in, which the native library takes from them."""
    return request.positions.astype(np.float64) if request.double else request.positions


def single(vertices: Vertices) -> Vertices:
    """In the float32 that Blender keeps."""
    return vertices.astype(np.float32, copy=False)
