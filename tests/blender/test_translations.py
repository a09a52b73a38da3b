# SPDX-License-Identifier: GPL-3.0-or-later
"""The languages are complete, fit their texts, and are what a Blender with languages shows."""

import re
import sys
from collections.abc import Iterator
from pathlib import Path

import bpy
import pytest
import scenes
from installed_extension import MODULE

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "addon" / "tools"))

import list_untranslated

HAS_LANGUAGES = "de_DE" in bpy.app.translations.locales
needs_languages = pytest.mark.skipif(not HAS_LANGUAGES, reason="this Blender was built without languages")


@pytest.fixture
def german() -> Iterator[None]:
    view = bpy.context.preferences.view
    view.language = "de_DE"
    view.use_translate_interface = view.use_translate_tooltips = view.use_translate_reports = True
    yield
    view.language = "en_US"


@pytest.mark.parametrize("language", list_untranslated.languages())
def test_every_text_is_translated_and_none_is_left_over(language):
    missing, needless = list_untranslated.compare(language)
    assert missing == []
    assert needless == []


@pytest.mark.parametrize("language", list_untranslated.languages())
def test_places_for_names_are_the_same_in_the_translation(language):
    for english, text in list_untranslated.catalogue(language).items():
        assert text.strip()
        assert set(re.findall(r"{\w*}", english)) == set(re.findall(r"{\w*}", text)), english


def test_the_search_finds_texts_wherever_they_may_stand(tmp_path):
    place = tmp_path / "part.py"
    place.write_text(
        """
KIND = (("ONE", "First item", "What it does", 1), (device.TWO, "Second item", "What that does"))
NAMES = ("Global", "Object", "Lattice")

class ISOCHOR_OT_x(bpy.types.Operator):
    '''A tooltip over
    two lines'''
    bl_label = "A label"
    bl_idname = "isochor.x"
    size: bpy.props.FloatProperty(name="Size", description="How " "large", default=1.0)

    def execute(self, context):
        self.report({"ERROR"}, "An error" if bad else "Another")
        self.report({"ERROR"}, words.reported(Sentence("With {name}", name=name)))
        layout.label(text="On a panel", icon="X")
        row.prop(self, "size", text="Renamed")
        words.shown("Shown")
        self.report({"INFO"}, f"{size} times")
        layout.label(text=f"{obj.name}: {modifier.name}")
        raise Problem("Nothing there")
""",
        encoding="utf-8",
    )
    assert set(list_untranslated.texts_of(place)) == {
        *("First item", "What it does", "Second item", "What that does", "A tooltip over two lines", "A label", "Size"),
        *("How large", "An error", "Another", "With {name}", "On a panel", "Renamed", "Shown"),
        "Nothing there",
    }


def test_the_search_tells_what_no_language_can_have(tmp_path, monkeypatch):
    monkeypatch.setattr(list_untranslated, "SOURCE", tmp_path)
    place = tmp_path / "part.py"
    place.write_text(
        """
self.report({"INFO"}, f"{size} times")
layout.label(text=f"{obj.name}: {modifier.name}")
raise Problem(Sentence("With {name}", name=f"{one} and {other}"))
""",
        encoding="utf-8",
    )
    assert list(list_untranslated.untranslatable(place)) == ["part.py:2 f'{size} times'"]


def test_a_sentence_is_english_text_until_it_is_translated():
    sentence = scenes.part("core.words").Sentence("“{name}” has {count}", name="A {b}", count=3)
    assert sentence == "“A {b}” has 3"
    assert isinstance(sentence, str)
    assert sentence.translated({"“{name}” has {count}": "{count} × „{name}“"}.get) == "3 × „A {b}“"
    problem = scenes.part("core.problem").Problem(sentence)
    assert problem.sentence is sentence
    assert str(problem) == sentence


def test_problems_keep_what_they_need_to_be_translated():
    ball = scenes.sphere()
    modifier = scenes.volume_lattice(ball, scenes.lattice_object(4), Vertex_Group="Nowhere")
    (text,) = scenes.report(ball, modifier).problems
    assert text.translated(scenes.part("languages.german").TEXTS.get).startswith("Es gibt keine Vertexgruppe „Nowhere“")
    assert text.startswith("There is no vertex group “Nowhere”")


def test_tooltips_over_several_lines_are_found_as_blender_asks_for_them():
    made = scenes.part("languages").catalogues()["de_DE"]
    for operator in (bpy.types.Operator.__subclasses__(), bpy.types.Menu.__subclasses__()):
        for found in operator:
            if found.__module__.startswith(MODULE):
                assert ("*", found.__doc__) in made, found


@needs_languages
def test_labels_tooltips_and_items_come_out_in_german(german):
    translate = bpy.app.translations
    operator = bpy.ops.isochor.add.get_rna_type()
    assert translate.pgettext_iface(operator.name, operator.translation_context) == "Volumengitter hinzufügen"
    assert translate.pgettext_tip(operator.description).startswith("Passt den ausgewählten Netzen ein Gitter an")
    margin = operator.properties["margin"]
    assert translate.pgettext_iface(margin.name, margin.translation_context) in ("Rand", "Randabstand")
    fit = operator.properties["fit"]
    assert [translate.pgettext_tip(item.description) for item in fit.enum_items][1].startswith("Der kleinste Quader")
    assert translate.pgettext_iface("Volume Lattice") == "Volumengitter"
    # What poll says is looked up as a tooltip, where the button is drawn.
    assert translate.pgettext_tip("Select a mesh object first") == "Zuerst ein Netzobjekt auswählen"


@needs_languages
def test_text_made_at_run_time_comes_out_in_german_and_back(german):
    ball = scenes.sphere()
    modifier = scenes.volume_lattice(ball, scenes.lattice_object(4), Vertex_Group="Nowhere")
    sidebar, words = scenes.part("ui.sidebar"), scenes.part("tool.words")
    assert "Zielvolumen" in dict(sidebar.rows(scenes.report(ball, modifier)))
    (text,) = scenes.report(ball, modifier).problems
    assert words.shown(text).startswith("Es gibt keine Vertexgruppe „Nowhere“")
    assert "Bilder im Speicher" in scenes.part("ui.preferences").memory_used()
    flat = scenes.lattice_object((4, 1, 4), name="Flach")
    scenes.choose(flat)
    with pytest.raises(RuntimeError, match="„Flach“ hat entlang Y nur eine Schicht"):
        bpy.ops.isochor.mirror_lattice(axis="Y")
    bpy.context.preferences.view.language = "en_US"
    assert words.shown(text).startswith("There is no vertex group “Nowhere”")


@needs_languages
def test_disabling_takes_the_language_away(german):
    bpy.ops.preferences.addon_disable(module=MODULE)
    try:
        assert bpy.app.translations.pgettext_iface("Fit Lattice Again") == "Fit Lattice Again"
    finally:
        bpy.ops.preferences.addon_enable(module=MODULE)
    assert bpy.app.translations.pgettext_iface("Fit Lattice Again") == "Gitter neu anpassen"
