# SPDX-License-Identifier: GPL-3.0-or-later
"""The plot of volume against frame, plain lattice and Isochor (matplotlib)."""

from pathlib import Path

from bounce_table import BounceRow
from matplotlib.axes import Axes
from matplotlib.figure import Figure

RED = "#be2a18"
TEAL = "#08687c"
GREY = "#8a8f9c"


def draw_volume_plot(rows: list[BounceRow], output: Path) -> None:
    """Draws the volume of `rows` (BounceRows), as a share of the volume at rest, to the PNG `output`."""
    frames = [row.frame for row in rows]
    figure = Figure(figsize=(9.0, 4.6), dpi=110, layout="constrained")
    axes = figure.add_subplot()
    axes.plot(frames, [100 * (1 + row.plain_change) for row in rows], color=RED, linewidth=2.4)
    axes.plot(frames, [100 * (1 + row.isochor_error) for row in rows], color=TEAL, linewidth=3.2)
    _mark_losses(axes, rows)
    _label_lines(axes, rows)
    axes.set(xlabel="frame", ylabel="volume, % of the ball at rest", xlim=(frames[0], frames[-1]), ylim=(0, 130))
    axes.set_title("Volume of the bouncing ball, measured on the rendered mesh", loc="left", fontsize=12)
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(axis="y", color="#e3e3e0", linewidth=0.8)
    axes.set_axisbelow(True)
    figure.savefig(output)


def _mark_losses(axes: Axes, rows: list[BounceRow]) -> None:
    for row in (row for row in rows if row.marked_loss is not None):
        volume = 100 * (1 + row.plain_change)
        axes.vlines(row.frame, volume, 100, color=GREY, linewidth=1, linestyle=":")
        axes.plot([row.frame], [volume], "o", color=RED, markersize=7)
        text = f"{100 * row.plain_change:+.0f} %".replace("-", "\N{MINUS SIGN}")
        axes.annotate(text, (row.frame, volume), (-9, -12), textcoords="offset points", color=RED, ha="right")


def _label_lines(axes: Axes, rows: list[BounceRow]) -> None:
    worst = max(abs(row.isochor_error) for row in rows)
    deepest = min(rows, key=lambda row: row.plain_change)
    axes.annotate(
        f"Isochor: constant to {worst:.0e}".replace("e-0", "e-"),
        (deepest.frame, 100),
        (0, 9),
        textcoords="offset points",
        color=TEAL,
        ha="center",
        fontweight="bold",
    )
    axes.annotate(
        "Blender\N{RIGHT SINGLE QUOTATION MARK}s Lattice modifier",
        (deepest.frame, 100 * (1 + deepest.plain_change)),
        (0, -30),
        textcoords="offset points",
        color=RED,
        ha="center",
        fontweight="bold",
    )
