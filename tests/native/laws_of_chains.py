# SPDX-License-Identifier: GPL-3.0-or-later
"""Several lattices one after another: the composition of their maps, and the volume of what leaves the last."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import isochor
import lattices
import meshes
import numpy as np
import oracle as textbook
from corrections import Correction, Solid
from laws_deforming import EVERY, Run, law
from oracle import Array, Embedded, Spec

LOCAL = Spec((4, 4, 4), origin=(0.1, 0.2, 0.5), edges=((0.8, 0.1, 0), (-0.1, 0.7, 0), (0, 0.1, 0.6)))


@dataclass(frozen=True)
class Links:
    """Lattices in order, each with the options of its `bind`."""

    specs: tuple[Spec, ...]
    options: tuple[dict[str, Any], ...] = field(default=(), hash=False)

    def pairs(self) -> list[tuple[isochor.Lattice, dict[str, Any]]]:
        options = self.options or ({},) * len(self.specs)
        return [(spec.build(), chosen) for spec, chosen in zip(self.specs, options)]

    def controls(self, amount: float = 0.15) -> list[Array]:
        return [
            spec.build().rest + lattices.noisy(spec, amount, 3 + number) - spec.rest
            for number, spec in enumerate(self.specs)
        ]

    def composed(self, run: Run, vertices, controls) -> Array:
        """One binding after another, the mesh carried from each to the next."""
        for (lattice, options), control in zip(self.pairs(), controls):
            vertices = lattice.bind(vertices, device=run.device, **options).deform(control)
        return vertices


def quarter(x: float, y: float) -> Spec:
    """One of Ferrier's four blocks around a car, as seen from above."""
    return Spec((3, 3, 3), origin=(x, y, 0), edges=((0.5, 0, 0), (0, 0.5, 0), (0, 0, 1)))


EXTEND = {"outside": "extend"}
CHAINS = {
    "two": Links((Spec((3, 4, 3)), EVERY["uniform"]), (EXTEND, EXTEND)),
    "local": Links((EVERY["uniform"], LOCAL), (EXTEND, {"outside": "keep"})),
    "three": Links((EVERY["rational-bernstein"], EVERY["blender-mixed"], EVERY["clamped"]), (EXTEND, EXTEND, EXTEND)),
    "rational-last": Links((EVERY["bernstein"], EVERY["rational-uniform"]), (EXTEND, EXTEND)),
    "blender-last": Links((EVERY["bernstein"], EVERY["blender-bspline"]), (EXTEND, EXTEND)),
    "one": Links((EVERY["uniform"],), (EXTEND,)),
    "four-blocks": Links(tuple(quarter(x, y) for x in (0, 0.5) for y in (0, 0.5))),
}


def ball(run: Run, roughness: float = 0.15):
    vertices, triangles = meshes.bumpy_ball(3, roughness)
    return vertices.astype(run.dtype), triangles


def room(run: Run, links: Links, *controls: Array) -> float:
    """Each lattice magnifies what the ones before have rounded."""
    return 8 * sum(run.room(spec, *controls) for spec in links.specs)


@law(CHAINS)
def a_chain_composes_in_order(run: Run, links: Links) -> None:
    """What leaves one lattice enters the next; the other order is another shape."""
    vertices, triangles = ball(run)
    controls = links.controls()
    chain = isochor.Chain(links.pairs(), vertices, triangles, device=run.device)
    found = chain.deform(controls)
    assert found.dtype == run.dtype
    np.testing.assert_allclose(found, links.composed(run, vertices, controls), rtol=0, atol=room(run, links, *controls))
    if len(links.specs) == 2:
        turned = isochor.Chain(links.pairs()[::-1], vertices, triangles, device=run.device)
        assert np.abs(turned.deform(controls[::-1]) - found).max() > 1e-3


@law(CHAINS)
def a_chain_at_rest_is_the_identity(run: Run, links: Links) -> None:
    vertices, triangles = ball(run)
    chain = isochor.Chain(links.pairs(), vertices, triangles, device=run.device)
    np.testing.assert_array_equal(chain.deform([spec.build().rest for spec in links.specs]), vertices)


@law({name: links for name, links in CHAINS.items() if name != "four-blocks"})
def the_last_keeps_the_volume_of_the_whole(run: Run, links: Links) -> None:
    """The volume is that of the mesh that enters the first; only the last lattice's control points are corrected."""
    vertices, triangles = ball(run)
    controls = links.controls()
    controls[0] = (controls[0] - links.specs[0].centre) * [0.8, 1.0, 0.7] + links.specs[0].centre
    chain = isochor.Chain(links.pairs(), vertices, triangles, device=run.device)
    target = textbook.volume(vertices, triangles, links.specs[-1].centre)
    plain = textbook.volume(chain.deform(controls), triangles, links.specs[-1].centre)
    assert abs(plain / target - 1) > 0.01
    for method in ("balanced", "sweep", "gradient", "nearest"):
        given = [control.copy() for control in controls]
        result = chain.preserve(given, method=method)
        for control, kept in zip(given, controls):
            np.testing.assert_array_equal(control, kept)
        assert result.control.shape == controls[-1].shape
        found = textbook.volume(result.vertices, triangles, links.specs[-1].centre)
        allowed = textbook.tolerance(result.vertices, triangles, links.specs[-1].centre, target)
        assert abs(found - target) <= allowed * abs(target), method
        again = chain.deform([*controls[:-1], result.control])
        np.testing.assert_allclose(result.vertices, again, rtol=0, atol=room(run, links, *controls))


@law({name: CHAINS[name] for name in ("two", "three", "rational-last", "blender-last", "local")})
def the_last_correction_is_the_papers(run: Run, links: Links) -> None:
    """The closed form, with the rows of the last lattice where the others have carried the mesh."""
    if run.dtype != np.float64:
        return
    vertices, triangles = ball(run)
    controls = links.controls()
    carried = Links(links.specs[:-1], links.options[:-1]).composed(run, vertices, controls[:-1])
    embedded = Embedded.of(links.specs[-1], carried, triangles, **links.options[-1])
    wanted = np.array([textbook.volume(vertices, triangles, links.specs[-1].centre)])
    weights = None
    if links.options[-1]["outside"] == "keep":
        return  # which layers stand still at crossed faces is another law's
    asked = Correction(Solid.of(embedded), controls[-1], wanted=wanted, weights=weights)
    result = isochor.Chain(links.pairs(), vertices, triangles, device=run.device).preserve(controls, method="sweep")
    expected = asked.sweep() - controls[-1]
    off = np.linalg.norm(result.control - controls[-1] - expected) / np.linalg.norm(expected)
    assert off <= (1e-8 if run.device == "cpu" else 1e-4)


@law({"two": CHAINS["two"]})
def a_target_of_its_own(run: Run, links: Links) -> None:
    vertices, triangles = ball(run)
    chain = isochor.Chain(links.pairs(), vertices, triangles, device=run.device)
    result = chain.preserve(links.controls(), target=0.3, axes=(1, 1, 0))
    allowed = textbook.tolerance(result.vertices, triangles, links.specs[-1].centre, 0.3)
    assert abs(textbook.volume(result.vertices, triangles, links.specs[-1].centre) / 0.3 - 1) <= allowed
