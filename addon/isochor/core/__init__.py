# SPDX-License-Identifier: GPL-3.0-or-later
"""What a Volume Lattice computes, without Blender."""
