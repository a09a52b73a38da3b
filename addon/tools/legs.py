# SPDX-License-Identifier: GPL-3.0-or-later
"""The legs of `make test`: each one function from nothing to a Report, raising Unavailable where it cannot run."""

import platform
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import blenders
import build_extension
import build_stubs
import build_wheel
import environments
import reports
import system_packages
import toolchain
from reports import Report
from workspace import BUILD, ROOT, Command, status

TESTS = ROOT / "tests"
# The Python that is ours to check; the extension is typed under a name of its own, the wheel has the same.
PYTHON_CODE = [ROOT / "addon", ROOT / "blend_fixtures", ROOT / "native", ROOT / "tests"]
TYPED_ADDON = BUILD / "types" / "isochor_addon"
# A hung Blender must not eat the whole run; the slowest leg takes a few minutes.
LIMIT_S = 1500.0
# Of a command line.
Words = Sequence[str]


@dataclass(frozen=True)
class Leg:
    """One part of the tests, under the name that --only takes."""

    name: str
    title: str
    run: Callable[[], Report]


def rust_format() -> Report:
    return reports.from_status(status([toolchain.cargo(), "fmt", "--all", "--check"]), "cargo fmt")


def clippy() -> Report:
    lints = ["--workspace", "--all-targets", "--locked", "--", "-D", "warnings"]
    return reports.from_status(status([toolchain.cargo(), "clippy", *lints], _clippy_environment()), "cargo clippy")


def rust_tests() -> Report:
    command = [toolchain.cargo(), "test", "--locked", "--no-fail-fast"]
    return reports.from_cargo(*reports.echoed(command, {}, LIMIT_S))


def gpu_rust_tests() -> Report:
    command = [toolchain.cargo(), "test", "--locked", "--no-fail-fast", "--package", "isochor-gpu"]
    return reports.from_cargo(*reports.echoed(command, _gpu_environment(), LIMIT_S))


def gpu_tests(tests: Words) -> Report:
    python = environments.install_wheel("native", build_wheel.wheel())
    return _pytest([str(python), "-m", "pytest", *(tests or [str(TESTS / "gpu")])], "gpu", _gpu_environment())


def stubs() -> Report:
    changes = build_stubs.difference(build_stubs.generated())
    print(changes or f"{build_stubs.COMMITTED.relative_to(ROOT)} is what the binding gives", flush=True)
    return Report(0, 1, note="differ: run `make stubs`") if changes else Report(1, 0, note="up to date")


def python_format() -> Report:
    ruff = environments.python("tools").with_name("ruff")
    check = reports.from_status(status([ruff, "check", *PYTHON_CODE]), "ruff check")
    return _noted(check + reports.from_status(status([ruff, "format", "--check", *PYTHON_CODE]), ""), "ruff")


def python_types() -> Report:
    mypy: Command = [environments.python("tools"), "-m", "mypy"]
    TYPED_ADDON.parent.mkdir(parents=True, exist_ok=True)
    TYPED_ADDON.unlink(missing_ok=True)
    TYPED_ADDON.symlink_to(build_extension.SOURCE, target_is_directory=True)
    library = status([*mypy, ROOT / "native/python/python/isochor"])
    tools = status([*mypy, ROOT / "addon/tools"])
    search = {"MYPYPATH": f"{ROOT / 'native/python/python'}:{TYPED_ADDON.parent}"}
    addon = status([*mypy, TYPED_ADDON / "core"], search)
    return _noted(sum((reports.from_status(found, "") for found in (library, tools, addon)), Report()), "mypy")


def tool_tests(tests: Words) -> Report:
    python = environments.python("native")
    return _pytest([str(python), "-m", "pytest", *(tests or [str(TESTS / "tools")])], "tools", {})


def native_tests(tests: Words) -> Report:
    python = environments.install_wheel("native", build_wheel.wheel())
    return _pytest([str(python), "-m", "pytest", *(tests or [str(TESTS / "native")])], "native", {})


def blender_tests(blender: blenders.Blender, env: dict[str, str], tests: Words) -> Report:
    """The tests inside a Blender in which the built zip is installed."""
    script = TESTS / "blender" / "run_in_blender.py"
    command = blender.command(script, "--zip", build_extension.extension(), *tests)
    report = _pytest(command, blender.name.replace(" ", "-"), blender.isolation("test") | env)
    return _noted(report, blender.name) if not report.note else report


def farm_tests(tests: Words) -> Report:
    """The farm's job templates: compiled and checked by their own tools, and their tasks run in a real Blender."""
    python, blender = environments.python("farm"), blenders.in_root()
    options = ["--blender", str(blender.program), "--extension", str(build_extension.extension())]
    command = [str(python), "-m", "pytest", *(tests or [str(TESTS / "farm")]), *options]
    return _pytest(command, "farm", blender.isolation("farm"))


def all_legs(tests: Words = ()) -> list[Leg]:
    """Every leg in the order in which they are run: quick checks first. ``tests``: what those that use pytest give it,
    files first, in the place of all their tests."""
    legs = [
        Leg("rustfmt", "Rust is formatted", rust_format),
        Leg("ruff", "Python is formatted and linted", python_format),
        Leg("types", "Python types", python_types),
        Leg("tools", "The build and test tools", partial(tool_tests, tests)),
        Leg("clippy", "Rust lints, warnings as errors", clippy),
        Leg("rust", "Rust tests", rust_tests),
        Leg("stubs", "The binding's stubs are the generated ones", stubs),
        Leg("native", "The installed wheel, without Blender", partial(native_tests, tests)),
        Leg("gpu-rust", "Rust tests of the kernels, on a software rasteriser where there is no GPU", gpu_rust_tests),
        Leg("gpu", "The installed wheel on the same", partial(gpu_tests, tests)),
    ]
    for version in blenders.WHEELS:
        title = f"The installed extension in the bpy wheel for Python {version}"
        legs.append(Leg(f"bpy-{version}", title, partial(_bpy_wheel, version, tests)))
    legs.append(Leg("blender", "The installed extension in a real Blender", partial(_real_blender, tests)))
    title = "The farm's job templates, run in a real Blender without a server"
    legs.append(Leg("farm", title, partial(farm_tests, tests)))
    return legs


def _bpy_wheel(version: str, tests: Words) -> Report:
    return blender_tests(blenders.wheel(version), _gpu_environment(), tests)


def _real_blender(tests: Words) -> Report:
    return blender_tests(blenders.in_root(), {}, tests)


def _pytest(command: list[str], name: str, env: dict[str, str]) -> Report:
    place = BUILD / "reports" / f"{name}.xml"
    place.unlink(missing_ok=True)
    found, _ = reports.echoed([*command, f"--junitxml={place}", "-p", "no:cacheprovider"], env, LIMIT_S)
    return reports.from_junit(found, place)


def _noted(report: Report, note: str) -> Report:
    return Report(report.passed, report.failed, report.skipped, note)


def _gpu_environment() -> dict[str, str]:
    """Makes sure of a Vulkan driver; tests may then expect one, and Mesa is not to write about a missing desktop."""
    if platform.system() == "Linux":
        system_packages.install(system_packages.GROUPS["vulkan"])
    return {"ISOCHOR_GPU_EXPECTED": "1", "NODEVICE_SELECT": "1"}


def _clippy_environment() -> dict[str, str]:
    """The Python that PyO3's build asks for its version, and a target folder apart from maturin's: PyO3 is built
    anew whenever it is asked about another Python.
    """
    return {"PYO3_PYTHON": str(environments.python("tools")), "CARGO_TARGET_DIR": str(ROOT / "target" / "lint")}
