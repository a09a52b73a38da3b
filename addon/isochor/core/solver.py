# SPDX-License-Identifier: GPL-3.0-or-later
"""From what enters a modifier in one frame to the vertices that leave it, keeping what frames have in common."""

from dataclasses import dataclass, field, replace
from functools import partial
from time import perf_counter
from typing import Any, Literal
from weakref import ref

import numpy as np
from numpy.typing import NDArray

import isochor

from . import pin_problem, problem, weights
from .arrays import same_array
from .frames import Frames
from .grid import build_lattice
from .report import Report
from .request import Request, Vertices
from .targets import rest_of_bodies, wanted_volume
from .volume import is_flat

METHODS: dict[str, Literal["balanced", "sweep", "gradient", "nearest"]] = {
    "Balanced": "balanced",
    "Sweep": "sweep",
    "Gradient": "gradient",
    "Nearest": "nearest",
}
COSTS: dict[str, Literal["points", "surface", "bending"]] = {
    "Points": "points",
    "Surface": "surface",
    "Bending": "bending",
}
OUTSIDES: dict[str, Literal["keep", "extend"]] = {"Keep": "keep", "Extend": "extend"}


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

    def whole_volume(self, request: Request) -> float | None:
        """Signed volume of the whole mesh that enters, or None where it encloses none, as one that is open or flat."""
        if request.triangles is None:
            return None
        solver = self if request.bodies is None else Solver()
        try:
            volume = solver._bind(replace(request, bodies=None)).reference_volume
            return None if is_flat(request.positions, request.triangles) else volume
        except isochor.Error:
            solver._forget()
            return None

    def incoming_parts(self, request: Request) -> tuple[float, ...] | None:
        """Signed volume at rest of each body that enters, or None where they enclose none: what enters, made to fit the
        rest volume of the whole."""
        if request.triangles is None:
            return None
        try:
            own = self._bind(request).reference_volumes
            return tuple(map(float, rest_of_bodies(own, replace(request, rest_parts=None))))
        except isochor.Error:
            self._forget()
            return None

    def _fresh(self, request: Request) -> Outcome:
        try:
            binding = self._bind(request)
        except isochor.Error as error:
            self._forget()
            return Outcome(None, Report(problems=(problem.sentence(error, request.positions),)))
        problems = (self._no_device,) if self._no_device else ()
        report = Report(
            binding=binding,
            grid=request.grid,
            bound=request.bound,
            asked=request.control,
            held=None if request.continuity is None else np.asarray(binding.held(request.control)),
            problems=problems,
            pins=request.pins,
            has_surface=request.has_surface,
        )
        report.method = request.settings.method
        report.embed = partial(_embedded_again, ref(self), request)
        report.result = self._corrected(binding, request, report)
        if report.result is None:
            return Outcome(single(binding.deform(request.control)), report)
        vertices = single(report.result.vertices)
        if request.double and request.triangles is not None:
            report.rounded = vertices, request.triangles, request.bodies
        return Outcome(vertices, report)

    def _corrected(self, binding: isochor.Binding, request: Request, report: Report) -> isochor.Preserved | None:
        """The lattice with its pins on their targets and its volume kept. Where the volume cannot be kept, with the
        pins alone; where these cannot be either, None. What is wrong goes into the report."""
        preserve = request.settings.preserve
        for amount in (*([preserve] if preserve > 0.0 else []), *([0.0] if request.pins is not None else [])):
            try:
                result = self._preserve(binding, request, amount)
            except isochor.PinError as error:
                names = () if request.pins is None else request.pins.names
                report.problems += (pin_problem.trouble(error, names),)
                return None
            except isochor.Error as error:
                reason = (amount > 0.0 and request.no_triangles) or problem.sentence(error, request.positions)
                report.problems = tuple(dict.fromkeys((*report.problems, reason)))
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
                cost=COSTS[settings.cost],
                limit="unfolded" if settings.unfolded else None,
            )
        except isochor.VolumeError as error:
            if request.triangles is not None and is_flat(request.positions, request.triangles):
                raise isochor.VolumeError(problem.FLAT) from error
            raise

    def _weights(self, request: Request) -> NDArray[np.float64] | None:
        """(nu, nv, nw) how much each control point resists the correction; None where all do alike."""
        share, lattice = request.settings.where_lost, self._lattice
        found = [] if request.stiffness is None else [weights.of_stiffness(request.stiffness)]
        if share > 0.0 and lattice is not None:
            found.append(weights.of_loss(lattice, request.control, request.rest_control, share))
        if request.pins is not None and request.settings.falloff > 0.0 and lattice is not None:
            distance, rest = request.settings.falloff, request.rest_control
            found.append(request.pins.fading_weights(lattice, request.positions, rest, distance))
        return weights.product(found)

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
                bodies=labels,
                caps=bodies is not None and bodies.close_holes,
                **joint,
            )

        joint: dict[str, Any] = {} if request.continuity is None else {"continuity": request.continuity}
        bodies = request.bodies
        labels = None if bodies is None else bodies.labels(request.positions, request.triangles)
        self._no_device = ""
        try:
            return bind("cpu" if request.double else request.device)
        except isochor.UnknownDeviceError:
            self._no_device = problem.no_device(request.device)
            return bind("cpu")

    def _same_mesh(self, request: Request, before: Request) -> bool:
        return (
            request.triangles is before.triangles
            and request.divides_as(before)
            and len(request.positions) == len(before.positions)
            and request.settings.outside == before.settings.outside
            and request.continuity == before.continuity
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


def entering(request: Request) -> Vertices:
    """The positions in the precision to compute in, which the native library takes from them."""
    return request.positions.astype(np.float64) if request.double else request.positions


def single(vertices: Vertices) -> Vertices:
    """In the float32 that Blender keeps."""
    return vertices.astype(np.float32, copy=False)
