# SPDX-License-Identifier: GPL-3.0-or-later
"""A monkey at the keyboard: random operators, edits, frame changes, undo and redo, and a look at the volume after each.

Use, as run_in_blender.py is used: monkey.py --zip dist/isochor-….zip --seed 1 --steps 3000. Ends with status 1 and the
last steps where Blender's console shows an exception or a volume is off; a crash ends it by itself. The same seed takes
the same steps.
"""

import argparse
import io
import sys
import tempfile
import traceback
from collections import Counter, deque
from pathlib import Path
from random import Random

sys.path.insert(0, str(Path(__file__).resolve().parent))

import installed_extension

installed_extension.isolate()

SHOWN = 25
"""Steps printed where something goes wrong."""


class Console(io.TextIOBase):
    """Python's standard error, where Blender prints what a handler, a draw or an operator raised."""

    def __init__(self) -> None:
        self._text = ""

    def write(self, text: str) -> int:
        """Keeps the text until it is looked at."""
        self._text += text
        return len(text)

    def complaint(self) -> str:
        """What was printed since the last call, if it holds a traceback; other lines pass."""
        text, self._text = self._text, ""
        return text if "Traceback" in text else ""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--zip", type=Path, required=True, help="the extension that make extension built")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--steps", type=int, default=3000)
    chosen = parser.parse_args(installed_extension.own_arguments())
    installed_extension.install(chosen.zip)
    console, original = Console(), sys.stderr
    taken: deque[str] = deque(maxlen=SHOWN)
    sys.stderr = console
    ended = False
    try:
        play(Random(chosen.seed), chosen.steps, console, taken)
        ended = True
    finally:
        sys.stderr = original
        if not ended:
            print(*taken, sep="\n")
            traceback.print_exc()
            installed_extension.leave(1)
    return 0


def play(random: Random, steps: int, console: Console, taken: "deque[str]") -> None:
    """Takes the steps; raises RuntimeError at the first that goes wrong. ``taken`` holds the last ones."""
    import bpy
    import monkey_actions
    import monkey_operators
    import monkey_pins
    import monkey_things
    from monkey_scene import Scene

    scene, counts = Scene(random), Counter()
    folder = Path(tempfile.mkdtemp(prefix="isochor-monkey-"))
    parts = (monkey_actions, monkey_operators, monkey_pins, monkey_things)
    functions, weights = zip(*(item for part in parts for item in part.ACTIONS.items()), strict=True)
    unchanging = (monkey_actions.undo, monkey_actions.redo, monkey_actions.choose)
    bpy.ops.ed.undo_push(message="start")
    for number in range(steps):
        act = random.choices(functions, weights)[0]
        taken.append(f"{number}: in {act.__name__}")
        taken[-1] = f"{number}: {act(scene, folder)}"
        counts[act.__name__] += not taken[-1].endswith(("nothing", "refused"))
        if act not in unchanging:
            bpy.ops.ed.undo_push(message=taken[-1])
        bpy.context.view_layer.update()
        complaint = console.complaint() or scene.wrong_volume() or monkey_pins.wrong_pin(scene)
        complaint = complaint or monkey_things.wrong_points(scene)
        if complaint:
            raise RuntimeError(complaint)
    print("steps by action:", ", ".join(f"{name} {count}" for name, count in sorted(counts.items())))
    print(f"{steps} steps, {scene.measured} volumes measured, largest error {scene.largest_error:.1e}")


if __name__ == "__main__":
    installed_extension.leave(main())
