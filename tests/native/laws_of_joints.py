# SPDX-License-Identifier: GPL-3.0-or-later
"""How smoothly the moved part joins what stays: frozen layers and knots, measured by one-sided derivatives."""

from __future__ import annotations

from dataclasses import dataclass

import lattices
import laws_smoothness as smooth
import meshes
import numpy as np
import oracle as textbook
from laws_deforming import EVERY, Run, law, native
from oracle import Array, Spec

FACES = ("s0", "s1", "t0", "t1", "u0", "u1")
KINDS = {
    "bernstein": (Spec((5, 4, 6)), (0, 1, 2)),
    "uniform": (Spec((9, 8, 7), "bspline", 3, "uniform"), (0, 1, 2)),
    "uniform-mixed": (Spec((9, 8, 7), "bspline", (2, 1, 4), "uniform"), (0, 0, 3)),
    "clamped": (Spec((9, 8, 7), "bspline", (3, 2, 3), "clamped"), (0, 1)),
    "knots": (Spec((7, 7, 7), "bspline", 3, lattices.KNOTS), (0, 1)),
    "blender-bspline": (native((7, 6, 7), "bspline"), (0, 1, 2)),
    "blender-cardinal": (native((7, 6, 7), "cardinal"), (0, 1)),
    "blender-catmull-rom": (native((7, 6, 7), "catmull-rom"), (0, 1)),
    "blender-linear": (native((7, 6, 7), "linear"), (0,)),
}
KINDS |= {
    f"rational-{name}": (lattices.weighted(KINDS[name][0]), KINDS[name][1])
    for name in ("bernstein", "uniform", "clamped")
}


@dataclass(frozen=True)
class Joint:
    """A lattice, a face of it, and the continuity there."""

    spec: Spec
    axis: int
    side: int
    order: int

    @property
    def face(self) -> str:
        return FACES[2 * self.axis + self.side]

    @property
    def first_piece(self) -> float:
        """Length of the polynomial piece at the face."""
        breaks = smooth.breaks(self.spec, self.axis)
        return float(breaks[1] - breaks[0] if self.side == 0 else breaks[-1] - breaks[-2])

    @property
    def degree(self) -> int:
        return smooth.piece_degree(self.spec, self.axis)

    def unit(self, depth: Array, across: Array) -> Array:
        """(m, 3) parameters at depths inside the face (negative: outside), elsewhere at `across` (3,)."""
        places = np.tile(across, (len(depth), 1))
        places[:, self.axis] = depth if self.side == 0 else 1 - depth
        return places

    def frozen(self) -> Array:
        return self.spec.build().frozen(continuity=self.order, faces=(self.face,))

    def innermost(self) -> Array:
        """(nu, nv, nw) of bool: the frozen layer farthest from the face."""
        frozen = np.moveaxis(self.frozen(), self.axis, 0)
        layers = np.flatnonzero(frozen.all(axis=(1, 2)))
        chosen = np.zeros_like(frozen)
        chosen[layers[-1] if self.side == 0 else layers[0]] = True
        return np.moveaxis(chosen, 0, self.axis)


def joints(kinds=KINDS) -> dict[str, Joint]:
    """Each kind at two of its faces, all orders."""
    found = {}
    for number, (name, (spec, orders)) in enumerate(kinds.items()):
        for order in sorted(set(orders)):
            for axis, side in ((number % 3, 0), ((number + 1) % 3, 1)):
                most = smooth.piece_degree(spec, axis) - 1
                if order <= most or spec.basis == "blender":
                    found[f"{name}-{FACES[2 * axis + side]}-C{order}"] = Joint(spec, axis, side, order)
    return found


def slopes(run: Run, joint: Joint, control: Array, continuity: int | None) -> Array:
    """(lines, orders + 1, 3) derivatives inside the face of what points move, times the denominator."""
    lines = np.random.default_rng(11).uniform(0.2, 0.8, (3, 3))
    beyond = lattices.fitted(joint.spec, joint.unit(np.array([-0.1, -0.5]), lines[0]))

    def moved(depth: Array, across: Array) -> Array:
        unit = joint.unit(depth, across)
        points = np.concatenate([lattices.fitted(joint.spec, unit), beyond]).astype(run.dtype)
        out = run.deform(joint.spec, points, control, outside="keep", continuity=continuity)
        np.testing.assert_array_equal(out[-2:], points[-2:])
        unit = np.clip(joint.spec.parameters(points[:-2]), 0, 1)
        return (out - points)[:-2] * smooth.denominator(joint.spec, unit)

    return np.array(
        [
            smooth.derivatives(lambda x, a=across: moved(x, a), 0.0, joint.first_piece, joint.degree, joint.order)
            for across in lines
        ]
    )


def rounding(run: Run, joint: Joint, size: float) -> Array:
    """(orders + 1, 1) of what rounding leaves of those derivatives."""
    heavy = 1.0 if joint.spec.weights is None else float(np.max(joint.spec.weights))
    return np.array(
        [
            [smooth.rounding(run.epsilon, 4 * size * heavy, joint.degree, joint.first_piece, order)]
            for order in range(joint.order + 1)
        ]
    )


def shaken(spec: Spec, seed: int = 5) -> Array:
    rest = spec.build().rest
    return rest + np.random.default_rng(seed).uniform(-0.5, 0.5, rest.shape)


@law(joints())
def frozen_layers_join_smoothly(run: Run, joint: Joint) -> None:
    """What moves joins what stays with `continuity` derivatives, whatever the animator did to the frozen layers."""
    control = shaken(joint.spec)
    found = slopes(run, joint, control, joint.order)
    assert np.all(np.abs(found) <= rounding(run, joint, 2.0)), np.abs(found).max(axis=(0, 2))


@law(joints())
def not_one_layer_less_would_do(run: Run, joint: Joint) -> None:
    """Moving the innermost frozen layer alone breaks the joint, by much more than the test above can miss."""
    control = joint.spec.build().rest.copy()
    control[joint.innermost()] += [3.0, -5.0, 4.0]
    found = np.abs(slopes(run, joint, control, None)).max(axis=(0, 2))
    assert np.any(found > 20 * rounding(run, joint, 2.0)[:, 0]), found


@law(joints())
def frozen_is_what_continuity_holds(run: Run, joint: Joint) -> None:
    """Bound with a continuity, a lattice acts as if `frozen` stood at rest; what is not frozen acts in full."""
    control = shaken(joint.spec)
    frozen = joint.frozen()
    assert (frozen.dtype, frozen.shape) == (np.bool_, joint.spec.shape)
    held = np.where(frozen[..., None], joint.spec.build().rest, control)
    points = np.concatenate(
        [run.points(joint.spec), lattices.fitted(joint.spec, joint.unit(np.array([-0.2]), np.full(3, 0.5)))]
    )
    found = run.deform(joint.spec, points, control, outside="keep", continuity=joint.order)
    expected = run.deform(joint.spec, points, held, outside="keep")
    np.testing.assert_allclose(found, expected, rtol=0, atol=run.room(joint.spec, control))
    inside = run.points(joint.spec)[:-8]
    nothing_beyond = run.deform(joint.spec, inside, control, outside="keep", continuity=joint.order)
    plain = run.deform(joint.spec, inside, control, outside="keep")
    np.testing.assert_array_equal(nothing_beyond, plain)


CORRECTED = {
    name: joint
    for name, joint in joints().items()
    if joint.order == max(KINDS[name.rsplit("-", 2)[0]][1]) and joint.side == 0
}


@law(CORRECTED)
def corrections_keep_the_joint(run: Run, joint: Joint) -> None:
    """A ball that leaves the lattice over that face: volume exact, joint as smooth, outside untouched to the bit."""
    centre = np.full(3, 0.5)
    centre[joint.axis] = 0.2
    ball, triangles = meshes.bumpy_ball(3, 0.1, centre=centre)
    ball = lattices.fitted(joint.spec, 0.5 + (ball - 0.5) * 0.95).astype(run.dtype)
    binding = joint.spec.build().bind(ball, triangles, outside="keep", continuity=joint.order, device=run.device)
    rest = joint.spec.build().rest
    control = rest + 0.3 * (shaken(joint.spec) - rest)
    result = binding.preserve(control)
    assert result.device == run.device
    target = textbook.volume(ball, triangles, joint.spec.centre)
    room = textbook.tolerance(result.vertices, triangles, joint.spec.centre, target)
    found = textbook.volume(result.vertices, triangles, joint.spec.centre)
    assert abs(found - target) <= room * abs(target)
    outside = np.any((joint.spec.parameters(ball) < -1e-6) | (joint.spec.parameters(ball) > 1 + 1e-6), axis=1)
    assert outside.any()
    np.testing.assert_array_equal(result.vertices[outside], ball[outside])
    np.testing.assert_allclose(
        binding.deform(result.control), result.vertices, rtol=0, atol=run.room(joint.spec, result.control)
    )
    size = float(np.abs(result.control).max())
    left = slopes(run, joint, result.control, joint.order)
    assert np.all(np.abs(left) <= rounding(run, joint, size)), np.abs(left).max(axis=(0, 2))
    assert np.abs(result.control - control).max() > 1e-4


SEAMS = {
    name: spec
    for name, spec in EVERY.items()
    if any(len(smooth.breaks(spec, axis)) > 2 for axis in range(3) if spec.shape[axis] > 1)
}


@law(SEAMS)
def pieces_join_as_smoothly_as_the_knots_say(run: Run, spec: Spec) -> None:
    """Across every knot inside, along every axis: degree − multiplicity derivatives agree, and no more (in float64)."""
    lattice, random = spec.build(), np.random.default_rng(12)
    control = lattice.rest + random.uniform(-0.5, 0.5, lattice.rest.shape)
    for axis in (a for a in range(3) if spec.shape[a] > 1):
        across, breaks = random.uniform(0.1, 0.9, 3), smooth.breaks(spec, axis)
        for before, at, after in zip(breaks, breaks[1:], breaks[2:]):
            order = smooth.continuity(spec, axis, at)
            left, right = (
                smooth.derivatives(
                    lambda t, a=axis, x=across: along(run, spec, control, a, x, t),
                    at, end, smooth.piece_degree(spec, axis), order + 1,
                )
                for end in (before, after)
            )  # fmt: skip
            check_seam(run, spec, axis, np.abs(left - right).max(axis=1), min(at - before, after - at))


def along(run: Run, spec: Spec, control: Array, axis: int, across: Array, t: Array) -> Array:
    """What points on a line along an axis move, times the denominator."""
    unit = np.tile(across, (len(t), 1))
    unit[:, axis] = t
    points = lattices.fitted(spec, unit).astype(run.dtype)
    moved = run.deform(spec, points, control, outside="extend") - points
    return moved * smooth.denominator(spec, unit)


def check_seam(run: Run, spec: Spec, axis: int, jumps: Array, length: float) -> None:
    """`jumps` of the derivatives: nothing but rounding up to the last but one, much more in the last."""
    size = 4.0 if spec.weights is None else 4 * float(np.max(spec.weights))
    size *= max(1.0, float(np.abs(spec.edges).max()))
    room = [smooth.rounding(run.epsilon, size, smooth.piece_degree(spec, axis), length, k) for k in range(len(jumps))]
    assert np.all(jumps[:-1] <= room[:-1]), (axis, jumps, room)
    if run.dtype == np.float64:
        assert jumps[-1] > 20 * room[-1], (axis, jumps, room)
