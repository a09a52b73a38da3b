# SPDX-License-Identifier: GPL-3.0-or-later
"""The models of the volume paper's figures, our own: closed, triangulated surfaces made of numbers alone."""
