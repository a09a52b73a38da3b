# SPDX-License-Identifier: GPL-3.0-or-later
"""What Isochor does inside Blender: node group, result meshes, evaluated data, handlers."""
