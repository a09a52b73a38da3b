# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture of a volume curve shows the numbers that it was given, and is a PNG that Blender reads."""

import bpy
import numpy as np
import pytest
import scenes

FRAMES = np.arange(1, 61)
PLAIN = 100.0 - 64.0 * np.sin(FRAMES / 9.0) ** 2
CORRECTED = np.full(60, 100.0)


def heights_of(picture: np.ndarray, colour: tuple[int, int, int], above: int) -> dict[int, float]:
    """Column to mean row of a colour's pixels below the row ``above``, which holds the legend."""
    close = np.abs(picture[above:, :, :3].astype(int) - colour).sum(axis=2) < 60
    return {column: float(np.flatnonzero(close[:, column]).mean()) + above for column in np.flatnonzero(close.any(0))}


@pytest.mark.parametrize("size", [(400, 200), (1600, 800), (300, 240)])
@pytest.mark.parametrize("look", ["LIGHT", "DARK"])
def test_the_lines_stand_where_the_numbers_say(size, look):
    curve_image = scenes.part("core.curve_image")
    colours = getattr(curve_image, look)
    picture = curve_image.draw_volume_curve(FRAMES, PLAIN, CORRECTED, size, colours)
    assert picture.shape == (size[1], size[0], 4)
    assert (picture[..., 3] == 255).all()
    legend = int(30 * max(1, round(min(size[0] / 440, size[1] / 220)))) - 2
    plain, kept = heights_of(picture, colours.plain, legend), heights_of(picture, colours.corrected, legend)
    assert np.ptp(list(kept.values())) <= 1.0
    first, last = min(kept), max(kept)
    columns = np.array([column for column in plain if first + 3 < column < last - 3])
    frames = 1.0 + (columns - first) / (last - first) * 59.0
    percents = np.interp(frames, FRAMES, PLAIN)
    rows = np.array([plain[column] for column in columns])
    clear = percents < 94.0
    slope, start = np.polyfit(percents[clear], rows[clear], 1)
    assert clear.sum() > 0.6 * (last - first)
    assert slope < 0.0
    assert np.abs(np.polyval((slope, start), percents[clear]) - rows[clear]).max() < 0.02 * size[1]
    assert np.polyval((slope, start), 100.0) == pytest.approx(np.mean(list(kept.values())), abs=0.02 * size[1])


def test_gaps_stay_empty_and_a_lonely_frame_is_a_dot():
    curve_image = scenes.part("core.curve_image")
    plain = np.array([90.0, 80.0, np.nan, np.nan, np.nan, 60.0, np.nan, np.nan, 80.0, 90.0])
    nothing = np.full(10, np.nan)
    picture = curve_image.draw_volume_curve(np.arange(10), plain, nothing, (600, 300), curve_image.LIGHT)
    found = np.array(sorted(heights_of(picture, curve_image.LIGHT.plain, 32)))
    pieces = np.split(found, np.flatnonzero(np.diff(found) > 1) + 1)
    assert [len(piece) > 20 for piece in pieces] == [True, False, True]


@pytest.mark.parametrize(
    "plain",
    [[100.0], [100.0] * 3, [np.nan] * 2, [-40.0, 20.0], [1e-9, 1e9], [99.9999, 100.0001], [1e300, -1.7e308]],
)
def test_any_numbers_make_a_picture(plain):
    curve_image = scenes.part("core.curve_image")
    frames = np.arange(len(plain)) - 7
    picture = curve_image.draw_volume_curve(frames, plain, np.full(len(plain), 100.0), (240, 160))
    assert len(heights_of(picture, curve_image.LIGHT.corrected, 30)) > 0


def test_what_cannot_be_drawn_is_refused():
    draw = scenes.part("core.curve_image").draw_volume_curve
    for given in (([], [], []), ([1, 2], [100.0], [100.0]), ([[1.0]], [[1.0]], [[1.0]])):
        with pytest.raises(ValueError, match="one length"):
            draw(*given)
    for unknown in (np.nan, np.inf):
        with pytest.raises(ValueError, match="finite"):
            draw([1, unknown], [100.0, 100.0], [100.0, 100.0])
    with pytest.raises(ValueError, match="160 x 120"):
        draw([1], [100.0], [100.0], (100, 100))


def test_percent_of_an_unknown_or_zero_target_is_unknown():
    percent_of = scenes.part("core.curve_image").percent_of
    assert percent_of([2.0, -3.0], [4.0, -3.0]).tolist() == [50.0, 100.0]
    assert np.isnan(percent_of([1.0, np.nan, 1.0], [0.0, 1.0, np.nan])).all()


def test_blender_reads_the_png(tmp_path):
    curve_image = scenes.part("core.curve_image")
    picture = curve_image.draw_volume_curve(FRAMES, PLAIN, CORRECTED, (400, 200), curve_image.DARK, "Ball (1)_/?")
    place = tmp_path / "curve.png"
    place.write_bytes(curve_image.png_bytes(picture))
    image = bpy.data.images.load(str(place))
    assert tuple(image.size) == (400, 200)
    assert image.colorspace_settings.name == "sRGB"
    found = np.empty(400 * 200 * 4, np.float32)
    image.pixels.foreach_get(found)
    assert np.array_equal(np.rint(found.reshape(200, 400, 4)[::-1] * 255).astype(np.uint8), picture)


def test_labels_name_the_frames_and_percents():
    """The same text drawn alone is found in the picture."""
    curve_image, tiny_font = scenes.part("core.curve_image"), scenes.part("core.tiny_font")
    picture = curve_image.draw_volume_curve(FRAMES, PLAIN, CORRECTED, (400, 200), curve_image.DARK)
    ink = np.abs(picture[..., :3].astype(int) - curve_image.DARK.ink).sum(axis=2) == 0
    for text in ("100", "60", "% of target volume"):
        letters = tiny_font.text_mask(text) > 0.5
        windows = np.lib.stride_tricks.sliding_window_view(ink, letters.shape)
        assert (windows == letters).all(axis=(2, 3)).any(), text
