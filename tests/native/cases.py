# SPDX-License-Identifier: GPL-3.0-or-later
"""Random tasks for `preserve`, every second with a planted difficulty, and what must be true of whatever comes back."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from typing import Any

import isochor
import lattices
import meshes
import numpy as np
import oracle
from corrections import Correction, Solid, independence
from numpy.typing import NDArray
from oracle import Array, Embedded, Spec

METHODS = ("sweep", "balanced", "gradient", "nearest")
SPECS = (
    Spec((2, 2, 2)),
    Spec((3, 3, 3)),
    Spec((4, 4, 4)),
    Spec((3, 5, 4)),
    Spec((4, 4, 4), "bspline", 3, "uniform"),
    Spec((6, 5, 6), "bspline", 3, "uniform"),
    Spec((5, 5, 5), "bspline", 2, "clamped"),
    Spec((6, 6, 6), "bspline", 3, "clamped"),
    lattices.FRAMES["oblique"],
    Spec((4, 4, 1)),  # thin ones move points by displacements; only along their long axes can they change a volume
    Spec((5, 1, 1), "bspline", 2, "clamped"),
)
RATIONAL = tuple(lattices.weighted(spec) for spec in SPECS)
BLENDER = (
    Spec((2, 2, 2), "blender"),
    Spec((4, 4, 4), "blender"),
    Spec((3, 5, 4), "blender", interpolation="linear"),
    Spec((4, 4, 4), "blender", interpolation="catmull-rom"),
    Spec((5, 3, 6), "blender", interpolation=("cardinal", "bspline", "linear")),
    replace(lattices.FRAMES["oblique"], basis="blender", interpolation="cardinal"),
    Spec((4, 4, 1), "blender", interpolation="catmull-rom"),
    lattices.weighted(Spec((4, 3, 5), "blender")),  # and both at once
    lattices.weighted(Spec((5, 4, 4), "blender", interpolation=("linear", "bspline", "linear")), 30.0),
)
SURFACES = (
    meshes.bumpy_ball(1, 0.2),
    meshes.bumpy_ball(2, 0.3),
    meshes.box(2),
    meshes.torus(9, 6),
    meshes.inside_out(meshes.bumpy_ball(1, 0.2)),
    meshes.joined(meshes.icosphere(1, 0.2, (0.25, 0.3, 0.3)), meshes.box(2, (0.55, 0.5, 0.45), (0.95, 0.9, 0.95))),
)
TRAPS = ("none", "flat", "dependent", "far", "tiny", "frozen", "outside", "masked", "wild", "small")


@dataclass
class Case:
    """A mesh in a lattice, the animator's lattice, and the options of `preserve`."""

    trap: str
    spec: Spec
    vertices: NDArray
    triangles: NDArray
    control: Array
    options: dict[str, Any] = field(default_factory=dict)
    bound: dict[str, Any] = field(default_factory=dict)
    pins: tuple[NDArray, NDArray, NDArray | None] | None = None  # indices, moves, barycentric or None for vertices

    @property
    def embedded(self) -> Embedded:
        return Embedded.of(self.spec, self.vertices, self.triangles, **{"outside": "extend"} | self.bound)

    @property
    def pin_rows(self) -> tuple[Array, Array]:
        """(m, N) rows and (m, 3) present places of the pins."""
        embedded, (indices, _, barycentric) = self.embedded, self.pins
        if barycentric is None:
            return embedded.rows[indices], embedded.deform(self.control)[indices]
        corners = self.triangles[indices]
        return (
            np.einsum("pk,pkn->pn", barycentric, embedded.rows[corners]),
            np.einsum("pk,pkx->px", barycentric, embedded.deform(self.control)[corners]),
        )

    @property
    def arguments(self) -> dict[str, Any]:
        """Of `preserve`, after the control points."""
        if self.pins is None:
            return self.options
        indices, _, barycentric = self.pins
        plain = barycentric is None
        return self.options | {
            "pins": (indices, self.places) if plain else isochor.Pins(indices, self.places, barycentric)
        }

    @property
    def places(self) -> Array:
        """(m, 3) targets of the pins."""
        return self.pin_rows[1] + self.pins[1]

    @property
    def correction(self) -> Correction:
        """The same for the oracle."""
        known = {key: value for key, value in self.options.items() if key in ("axes", "weights", "amount")}
        if self.options.get("frame") is not None:
            known["frame"] = np.asarray(self.options["frame"], dtype=float)
        if self.options.get("target") is not None:
            known["wanted"] = np.array([self.options["target"]])
        else:
            known["wanted"] = np.array([oracle.volume(self.vertices, self.triangles, self.spec.centre)])
        if self.pins is not None:
            known |= {"pin_rows": self.pin_rows[0], "pin_moves": self.pins[1]}
        return Correction(Solid.of(self.embedded), self.control, **known)

    def bind(self, device: str = "cpu") -> isochor.Binding:
        options = {"outside": "extend", "device": device} | self.bound
        return self.spec.build().bind(self.vertices, self.triangles, **options)

    def in_dtype(self, dtype: type) -> Case:
        return replace(self, vertices=self.vertices.astype(dtype))


def random_case(seed: int, pinned: bool | None = None, specs: tuple[Spec, ...] = SPECS) -> Case:
    """Case of that number; `pinned` makes it one with or without pins, else every third has none."""
    random, trap = np.random.default_rng(seed), TRAPS[seed % len(TRAPS)]
    spec = specs[random.integers(len(specs))]
    vertices, triangles = _surface(trap, random)
    case = Case(trap, spec, lattices.fitted(spec, vertices), triangles, _control(spec, trap, random))
    case.options = _options(spec, trap, random)
    if trap == "far":
        extent = np.abs(spec.edges).sum(axis=0) * [64, -32, 128]
        moved = spec.moved(offset=extent)
        case = replace(case, spec=moved, vertices=case.vertices + extent, control=case.control + extent)
    elif trap == "small":
        tiny = spec.moved(np.eye(3) * 1e-5)
        case = replace(case, spec=tiny, vertices=case.vertices * 1e-5, control=case.control * 1e-5)
    elif trap == "masked":
        case.bound["influence"] = 0.2 + 0.8 * random.random(len(vertices))
    if random.random() < 2 / 3 if pinned is None else pinned:
        case.pins = _pins(case, random)
    return case


def _surface(trap: str, random: np.random.Generator):
    if trap == "tiny":
        small = meshes.icosphere(0, 10.0 ** random.uniform(-3, -1.5), (0.92, 0.9, 0.9))
        return meshes.joined(meshes.icosphere(1, 0.4, (0.45, 0.5, 0.5)), small)
    vertices, triangles = SURFACES[random.integers(len(SURFACES))]
    return (vertices + [0.0, 0.0, 0.3] if trap == "outside" else vertices), triangles


def _control(spec: Spec, trap: str, random: np.random.Generator) -> Array:
    linear = lattices.rotation(random.normal(size=3), random.uniform(0, 3)) * random.uniform(0.4, 1.6, 3)
    if trap == "flat":
        linear = linear @ np.diag([1, 1, 10.0 ** random.uniform(-5, -2)])
    if min(spec.shape) == 1:
        linear = np.diag(random.uniform(0.6, 1.4, 3))
    noise = 0.6 if trap == "wild" else 0.1
    return spec.centre + (lattices.noisy(spec, noise, int(random.integers(1 << 30))) - spec.centre) @ linear.T


def _options(spec: Spec, trap: str, random: np.random.Generator) -> dict[str, Any]:
    shares = random.integers(0, 4, 3) * (np.array(spec.shape) > 1)
    shares = shares if shares.any() else (np.array(spec.shape) > 1).astype(int)
    options: dict[str, Any] = {"axes": tuple(map(float, shares))}
    if trap == "frozen" or random.random() < 0.4:
        options["weights"] = np.exp(random.uniform(0, 6, spec.shape))
    if trap == "frozen":
        options["weights"][random.random(spec.shape) < 0.3] = np.inf
    if random.random() < 0.3 and min(spec.shape) > 1:
        options["frame"] = lattices.rotation(random.normal(size=3), random.uniform(0, 3))
    if random.random() < 0.3:
        options["amount"] = float(random.choice([0.0, 0.4, 1.2]))
    return options


def _pins(case: Case, random: np.random.Generator):
    """Up to four pins, as many as leave the lattice room, moved by up to a tenth of the domain."""
    count = min(1 + int(random.integers(4)), max(1, int(np.prod(case.spec.shape)) // 6))
    moves = random.uniform(-0.1, 0.1, (count, 3)) @ np.asarray(case.spec.edges)
    if case.trap == "dependent":  # two points of one face, a hundred-thousandth of it apart, moved alike but for that
        indices = np.full(2, random.integers(len(case.triangles)))
        barycentric = np.array([[0.3, 0.3, 0.4], [0.3 + 1e-5, 0.3, 0.4 - 1e-5]])
        return indices, np.repeat(moves[:1], 2, axis=0) + [[0, 0, 0], [1e-6, 0, 0]], barycentric
    if random.random() < 0.5:
        return random.choice(len(case.vertices), count, replace=False), moves, None
    return random.choice(len(case.triangles), count, replace=False), moves, random.dirichlet([1, 1, 1], count)


def room(case: Case, vertices: NDArray, target: float) -> float:
    """Relative error of the volume to allow: 1e-12 or 1e-6, or what 4 ε A R / |V| makes of coordinates in the world."""
    reach = np.abs(vertices).max() / np.abs(vertices - case.spec.centre).max()
    return oracle.tolerance(vertices, case.triangles, case.spec.centre, target) * max(1.0, reach)


def check_exact(case: Case, result) -> None:
    """Volume and pins measured on the vertices; what may not move has not; every number is one."""
    asked, size = case.correction, np.ptp(result.vertices, axis=0).max()
    target = float(asked.targets()[0])
    allowed = room(case, result.vertices, target)
    assert np.all(np.isfinite(result.control)), "not a number in the lattice"
    # the volume with the pins alone is known as well as the pins are independent
    known = allowed + 64 * 2.3e-16 / independence(asked.moves()[0], asked.mobility) * (asked.amount != 1)
    assert abs(result.target - target) <= known * abs(target), f"target {result.target}, not {target}"
    found, target = oracle.volume(result.vertices, case.triangles, case.spec.centre), result.target
    assert abs(found - target) <= allowed * abs(target), f"volume {found}, not {target}; room {allowed:.1e}"
    if case.pins is not None:
        off = np.abs(pin_places(case, result.vertices) - case.places).max()
        assert off <= allowed * size, f"pins off by {off / size:.1e} of the size, room {allowed:.1e}"
    check_still(case, result)


def pin_places(case: Case, vertices: NDArray) -> Array:
    """(m, 3) where the pins are on a deformed mesh."""
    indices, _, barycentric = case.pins
    if barycentric is None:
        return vertices[indices].astype(float)
    return np.einsum("pk,pkx->px", barycentric, vertices[case.triangles[indices]].astype(float))


def check_still(case: Case, result) -> None:
    """Frozen points to the bit; axes without a share too, unless pins move them."""
    weights = case.options.get("weights")
    if weights is not None:
        np.testing.assert_array_equal(result.control[np.isinf(weights)], case.control[np.isinf(weights)])
    if case.pins is None and case.options.get("frame") is None:
        still = np.array(case.options["axes"]) == 0
        np.testing.assert_array_equal(result.control[..., still], case.control[..., still])


def solvable(case: Case) -> bool:
    """Whether the pins, and pins and volume together on some axis with a share, are independent beyond doubt."""
    asked = case.correction
    rows, _ = asked.moves()
    slopes = asked.solid.gradients(asked.pinned())[0] @ asked.directions[asked.shares > 0].T
    scale = oracle.area(case.embedded.deform(asked.pinned()), case.triangles)
    steep = [c for c in slopes.T if np.linalg.norm(c) > 1e-9 * scale]
    return independence(rows, asked.mobility) > 1e-9 and any(
        independence(np.concatenate([rows, c[None]]), asked.mobility) > 1e-9 for c in steep
    )


def numbers(message: str) -> list[float]:
    """Every number in a text."""
    return [float(found) for found in re.findall(r"[-−]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?", message.replace("−", "-"))]
