# SPDX-License-Identifier: GPL-3.0-or-later
"""What the overlay keeps on the graphics card: Blender's own shaders, and each drawing until it changes."""

from functools import cache
from typing import Any

import gpu
import numpy as np
from numpy.typing import NDArray

import isochor

from ..core.isolines import Drawing, colours, lengths
from .overlay_geometry import Key, Shown

FOLDED, UNDECIDED = (1.0, 0.1, 0.25, 0.9), (1.0, 0.6, 0.1, 0.9)
"""Colours of places where the lattice folds over, and of those where that cannot be told."""

_folds: dict[Key, tuple[isochor.Folds, gpu.types.GPUBatch | None]] = {}
_batches: dict[Key, tuple[Drawing, float, dict[str, gpu.types.GPUBatch]]] = {}


@cache
def shader(name: str) -> gpu.types.GPUShader:
    """One of those that every Blender from 4.5 on has; only where Blender draws, never in the background."""
    return gpu.shader.from_builtin(name)


def batch(kind: str, content: dict[str, NDArray[Any]]) -> gpu.types.GPUBatch:
    """Points to be drawn as ``kind`` (LINES, POINTS, TRI_STRIP); ``content``: an attribute's name to
    (N, width) float32, N the same for all and not 0."""
    layout = gpu.types.GPUVertFormat()
    for attribute, values in content.items():
        layout.attr_add(id=attribute, comp_type="F32", len=values.shape[1], fetch_mode="FLOAT")
    buffer = gpu.types.GPUVertBuf(layout, len(next(iter(content.values()))))
    for attribute, values in content.items():
        buffer.attr_fill(attribute, values)
    return gpu.types.GPUBatch(type=kind, buf=buffer)


def batches_of(one: Shown, scale: float) -> dict[str, gpu.types.GPUBatch]:
    """Lattice, isolines, paths and points, those of them that are not empty; sent anew only where the drawing or the
    displacement with the last colour (``scale``, world units) has changed."""
    before = _batches.get(one.key)
    if before is not None and before[0] is one.drawing and before[1] == scale:
        return before[2]
    sent = _send(one, scale)
    _batches[one.key] = (one.drawing, scale, sent)
    return sent


def folds_of(one: Shown) -> gpu.types.GPUBatch | None:
    """Points where the lattice folds over, or may; None where there are none. Sent anew only for another shape."""
    if one.folds is None:
        return None
    before = _folds.get(one.key)
    if before is None or before[0] is not one.folds:
        places, tints = marks(one.folds)
        sent = batch("POINTS", {"pos": places, "color": tints}) if len(places) else None
        before = _folds[one.key] = (one.folds, sent)
    return before[1]


def marks(folds: isochor.Folds) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """(K, 3) places to mark, and their (K, 4) colours."""
    tints = np.repeat(np.array([FOLDED, UNDECIDED], np.float32), (len(folds.points), len(folds.undecided)), axis=0)
    return np.concatenate([folds.points, folds.undecided]).astype(np.float32), tints


def forget_all_but(keys: set[Key]) -> None:
    """Lets go of what is no longer in the file."""
    for kept in (_batches, _folds):
        for key in kept.keys() - keys:
            del kept[key]


def _send(one: Shown, scale: float) -> dict[str, gpu.types.GPUBatch]:
    found = one.drawing
    moved = lengths(found.moved, np.array(one.to_world, np.float64))
    tints = colours(moved / scale if scale > 0.0 else np.zeros_like(moved))
    parts = {
        "lattice": ("LINES", {"pos": found.lattice}),
        "isolines": ("LINES", {"pos": found.isolines}),
        "paths": ("LINES", {"pos": found.paths, "color": np.repeat(tints, 2, axis=0)}),
        "points": ("POINTS", {"pos": found.points, "color": tints}),
    }
    return {name: batch(kind, content) for name, (kind, content) in parts.items() if len(content["pos"])}
