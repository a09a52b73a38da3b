# SPDX-License-Identifier: GPL-3.0-or-later
"""The gallery's pages: each a module with NAME and tiles(), which sets one picture after another up."""
