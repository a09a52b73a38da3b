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
TYPES = ("MESH", "EMPTY", "CURVE")
FORMATS = (Format("THREE", "Third item", "What a third does", begin),)
BY_NAME = "Said by name"
UNSAID = "Said nowhere"

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
        words.shown("Shown" if bad else BY_NAME)
        layout.column(heading="Above a column")
        manager.invoke_confirm(self, event, title="Asked", message="Sure?", confirm_text="Yes")
        self.report({"INFO"}, f"{size} times")
        layout.label(text=f"{obj.name}: {modifier.name}")
        raise Problem("Nothing there")
""",
        encoding="utf-8",
    )
    assert set(list_untranslated.texts_of(place)) == {
        *("First item", "What it does", "Second item", "What that does", "A tooltip over two lines", "A label", "Size"),
        *("How large", "An error", "Another", "With {name}", "On a panel", "Renamed", "Shown"),
        *(
            "Nothing there",
            "Third item",
            "What a third does",
            "Said by name",
            "Above a column",
            "Asked",
            "Sure?",
            "Yes",
        ),
    }


def test_the_search_finds_all_prose_of_the_interface(tmp_path, monkeypatch):
    monkeypatch.setattr(list_untranslated, "INTERFACE", tmp_path / "ui")
    text = '''
class Work:
    """What the class does."""

    ended = "Ended before its time"
    name = "Volume Lattice"

    def step(self):
        """What the step does."""
        return 0.5, "Half of it is done", f"{self.name} or so - {self.name}"
'''
    found = {}
    for folder in ("ui", "tool"):
        (tmp_path / folder).mkdir()
        place = tmp_path / folder / "part.py"
        place.write_text(text, encoding="utf-8")
        found[folder] = set(list_untranslated.texts_of(place))
    assert found == {"ui": {"Ended before its time", "Half of it is done"}, "tool": set()}


def test_the_search_finds_the_tooltips_of_inputs():
    found = set(list_untranslated.texts_of(list_untranslated.TOOLTIPS))
    interface = scenes.part("tool.node_group").ensure().interface
    shown = {item.description for item in interface.items_tree if item.item_type == "SOCKET"} - {""}
    assert shown <= found
    assert len(shown) > 15


def test_the_search_tells_what_no_language_can_have(tmp_path, monkeypatch):
    monkeypatch.setattr(list_untranslated, "SOURCE", tmp_path)
    place = tmp_path / "part.py"
    place.write_text(
        """
self.report({"INFO"}, f"{size} times")
layout.label(text=f"{obj.name}: {modifier.name}")
raise Problem(Sentence("With {name}", name=f"{one} & {other}"))
raise ValueError(f"an angle of {angle} radians")
expression = f"lerp(1, {stretch}, min(1, speed / {full}))"
text = f"{name} comes from another file"
""",
        encoding="utf-8",
    )
    assert sorted(list_untranslated.untranslatable(place)) == [
        "part.py:2 f'{size} times'",
        "part.py:7 f'{name} comes from another file'",
    ]


def test_no_text_is_made_so_that_no_language_can_have_it():
    assert [line for place in list_untranslated.sources() for line in list_untranslated.untranslatable(place)] == []


def test_a_sentence_is_english_text_until_it_is_translated():
    sentence = scenes.part("core.words").Sentence("“{name}” has {count}", name="A {b}", count=3)
    assert sentence == "“A {b}” has 3"
    assert isinstance(sentence, str)
    assert sentence.translated({"“{name}” has {count}": "{count} × „{name}“"}.get) == "3 × „A {b}“"
    problem = scenes.part("core.problem").Problem(sentence)
    assert problem.sentence is sentence
    assert str(problem) == sentence


def test_sentences_within_sentences_are_translated_with_them():
    words = scenes.part("core.words")
    german = {"{a} of {b}": "{b}: {a}", "No {what}": "Kein {what}", "All is lost": "Alles ist hin"}
    inner = words.Sentence("No {what}", what="All is lost")
    outer = words.Sentence("{a} of {b}", a=words.together([inner, "All is lost"]), b="No {what}")
    assert outer == "No All is lost All is lost of No {what}"
    told = words.named("Ball", outer).translated(lambda text: german.get(text, text))
    assert told == "Ball: No {what}: Kein All is lost Alles ist hin"
    assert words.sentence("{braces} of the user").translated(str) == "{braces} of the user"


@pytest.mark.parametrize("kind", [item.identifier for item in bpy.types.Object.bl_rna.properties["type"].enum_items])
def test_kinds_of_objects_are_called_as_blender_calls_them(kind):
    word = scenes.part("core.kinds").Kind(kind)
    label = bpy.types.Object.bl_rna.properties["type"].enum_items[kind].name
    assert word == label.lower()
    assert word.translated(str) == label.lower()
    assert word.translated({label: "Ding"}.get) == "Ding"


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
    assert translate.pgettext_tip(operator.description).startswith("Passt den ausgewählten Objekten ein Gitter an")
    margin = operator.properties["margin"]
    assert translate.pgettext_iface(margin.name, margin.translation_context) in ("Rand", "Randabstand")
    fit = operator.properties["fit"]
    assert [translate.pgettext_tip(item.description) for item in fit.enum_items][1].startswith("Der kleinste Quader")
    assert translate.pgettext_iface("Volume Lattice") == "Volumengitter"
    # What poll says is looked up as a tooltip, where the button is drawn.
    assert translate.pgettext_tip("Select an object with a Volume Lattice, or its lattice").startswith("Ein Objekt")


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
def test_every_report_comes_out_in_german(german, tmp_path):
    ball = scenes.sphere()
    modifier = scenes.volume_lattice(ball, scenes.lattice_object(4, name="Gitter"))
    scenes.choose(ball)

    def refused(operator, **arguments):
        with pytest.raises(RuntimeError) as caught:
            operator(**arguments)
        return str(caught.value)

    assert "Das letzte Bild (1) kommt vor dem ersten (9)" in refused(
        bpy.ops.isochor.measure_volume, frame_start=9, frame_end=1
    )
    assert "Boden: ein anderes Objekt mit auswählen" in refused(bpy.ops.isochor.squash_from_ground)
    told = refused(bpy.ops.isochor.twist_from_bone, armature=ball.name)
    kind = bpy.app.translations.pgettext_rpt("Armature")
    assert kind != "Armature"
    assert told.rstrip().endswith(f"sie muss {kind} sein")
    assert "hat kein Bild, um sich zu bewegen" in refused(bpy.ops.isochor.simulate, frame_start=5, frame_end=5)
    scenes.set_input(modifier, "Lattice", None)
    bpy.context.view_layer.update()
    told = refused(bpy.ops.isochor.bake, format="LATTICE", frame_start=3, frame_end=4)
    assert f"Bild 3, „{ball.name}“: Kein Gitter: im Eingang" in told
    told = refused(bpy.ops.isochor.apply)
    assert f"Bei „{ball.name}“ gibt es nichts anzuwenden. Kein Gitter: im Eingang" in told
    told = refused(bpy.ops.isochor.set_rest)
    assert f"{ball.name}: Kein Gitter: im Eingang" in told


@needs_languages
def test_the_picture_of_the_curve_is_in_german_and_else_in_letters_that_it_has(german, monkeypatch):
    pictures, image = scenes.part("tool.curve_picture"), scenes.part("core.curve_image")
    assert pictures.in_words(image.LIGHT).words.plain == "Gitter allein"
    assert pictures.look_of_theme(bpy.context).words.y_title == "% des Zielvolumens"
    monkeypatch.setattr(pictures.words, "shown", lambda text: "Größe" if text == "frame" else text)
    assert pictures.in_words(image.LIGHT) == image.LIGHT


@needs_languages
def test_tooltips_of_inputs_come_out_in_german(german):
    group = scenes.part("tool.node_group").ensure()
    inputs = [item for item in group.interface.items_tree if item.item_type == "SOCKET" and item.in_out == "INPUT"]
    for item in inputs:
        assert not item.description or bpy.app.translations.pgettext_tip(item.description) != item.description


@needs_languages
def test_disabling_takes_the_language_away(german):
    bpy.ops.preferences.addon_disable(module=MODULE)
    try:
        assert bpy.app.translations.pgettext_iface("Fit Lattice Again") == "Fit Lattice Again"
    finally:
        bpy.ops.preferences.addon_enable(module=MODULE)
    assert bpy.app.translations.pgettext_iface("Fit Lattice Again") == "Gitter neu anpassen"
