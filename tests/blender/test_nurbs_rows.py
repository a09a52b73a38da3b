# SPDX-License-Identifier: GPL-3.0-or-later
"""The rows of core.nurbs against the mesh that Blender makes of its NURBS surfaces."""

from itertools import product

import bpy
import numpy as np
import pytest
import scenes
import things


@pytest.fixture
def torus():
    """A torus with shaken points and weights, of whose flags every mixture can be set."""
    scenes.empty_file()
    bpy.ops.surface.primitive_nurbs_surface_torus_add()
    obj = bpy.context.object
    random = np.random.default_rng(1)
    for point in obj.data.splines[0].points:
        point.co = (*(np.array(point.co[:3]) + random.uniform(-0.2, 0.2, 3)), random.uniform(0.5, 2.0))
    return obj


def compared(obj):
    """Largest distance between Blender's samples and ours, or None where neither draws anything; quads must agree."""
    nurbs, control_points = scenes.part("core.nurbs"), scenes.part("tool.control_points")
    (patch,) = control_points.patches(obj.data)
    shown = things.shown(obj).get("mesh")
    assert (shown is not None) == (patch.u.is_valid and patch.v.is_valid)
    if shown is None:
        return None
    rows = nurbs.surface(patch.u, patch.v, patch.weights)
    points = control_points.read(obj.data)
    found = np.add.reduceat(rows.weights[:, None] * points[rows.columns], rows.offsets[:-1], axis=0)
    holder = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).evaluated_geometry()
    quads = np.array([tuple(face.vertices) for face in holder.mesh.polygons])
    assert sorted(map(sorted, quads.tolist())) == sorted(map(sorted, rows.quads.tolist()))
    return np.abs(found - shown).max()


@pytest.mark.parametrize("kind", ["sphere", "torus", "cylinder", "surface"])
def test_the_surfaces_that_blender_offers(kind):
    getattr(bpy.ops.surface, f"primitive_nurbs_surface_{kind}_add")()
    assert compared(bpy.context.object) < 1e-5


@pytest.mark.parametrize("order", [2, 3, 4, 5, 6])
def test_every_mixture_of_flags_and_orders(torus, order):
    spline = torus.data.splines[0]
    spline.resolution_u, spline.resolution_v = 3, 2
    drawn = 0
    for cyclic, endpoint, bezier in product((False, True), repeat=3):
        spline.use_cyclic_u, spline.use_endpoint_u, spline.use_bezier_u = cyclic, endpoint, bezier
        spline.order_u = order
        for across in ((False, False, False, 3), (True, True, True, 3), (False, True, False, 4)):
            spline.use_cyclic_v, spline.use_endpoint_v, spline.use_bezier_v, spline.order_v = across
            error = compared(torus)
            drawn += error is not None
            assert error is None or error < 1e-5
    assert drawn > 10
