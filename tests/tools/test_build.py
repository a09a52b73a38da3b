# SPDX-License-Identifier: GPL-3.0-or-later
"""What the build writes: the manifest of the zip, the difference of the stubs, the digests that spare a rebuild."""

import re
import tomllib

import build_extension
import build_stubs
import pytest
import toolchain
import workspace
from workspace import Unavailable

WHEEL = "isochor-1.2.3-cp311-abi3-manylinux_2_28_x86_64.whl"
SOURCE = 'id = "isochor"\n\n[permissions]\nfiles = "Write baked caches"\n'


def test_the_manifest_gets_version_platform_and_wheel_as_keys_of_its_own():
    written = tomllib.loads(build_extension.manifest(SOURCE, "1.2.3", WHEEL))
    assert written["version"] == "1.2.3"
    assert written["platforms"] == [build_extension.platform_name()]
    assert written["wheels"] == [f"./wheels/{WHEEL}"]
    assert written["permissions"] == {"files": "Write baked caches"}


@pytest.mark.parametrize("key", build_extension.WRITTEN)
def test_a_manifest_that_already_says_what_the_build_writes_is_refused(key):
    with pytest.raises(Unavailable, match=key):
        build_extension.manifest(f'{key} = "0.0.0"\n{SOURCE}', "1.2.3", WHEEL)


def test_the_committed_manifest_is_one_that_the_build_completes():
    source = (build_extension.SOURCE / build_extension.MANIFEST).read_text(encoding="utf-8")
    version = toolchain.workspace_package()["version"]
    written = tomllib.loads(build_extension.manifest(source, version, WHEEL))
    assert written["id"] == "isochor"
    assert written["license"] == [f"SPDX:{toolchain.workspace_package()['license']}"]


def test_a_changed_stub_differs_and_an_equal_one_does_not(tmp_path):
    committed = tmp_path / "_native.pyi"
    committed.write_text("def volume() -> float: ...\n")
    assert build_stubs.difference(committed.read_text(), committed) == ""
    assert "+def volume() -> int: ..." in build_stubs.difference("def volume() -> int: ...\n", committed)


def test_a_missing_stub_differs(tmp_path):
    assert build_stubs.difference("x: int\n", tmp_path / "_native.pyi")


def test_the_fingerprint_follows_names_contents_and_words(tmp_path, monkeypatch):
    monkeypatch.setattr(workspace, "ROOT", tmp_path)
    first, second = tmp_path / "first", tmp_path / "second"
    first.write_text("a")
    seen = [workspace.fingerprint([tmp_path]), workspace.fingerprint([tmp_path], "word")]
    first.write_text("b")
    seen.append(workspace.fingerprint([tmp_path]))
    first.rename(second)
    seen.append(workspace.fingerprint([tmp_path]))
    assert len(set(seen)) == 4
    assert workspace.fingerprint([tmp_path]) == seen[-1]


def test_the_release_builds_every_platform_that_the_build_can_name():
    workflow = (workspace.ROOT / ".github/workflows/release.yml").read_text(encoding="utf-8")
    named = set(re.findall(r"platform: (\S+),", workflow))
    assert named == {"linux-x64", "linux-arm64", "windows-x64", "macos-x64", "macos-arm64"}
    systems, machines = build_extension.SYSTEMS.values(), build_extension.MACHINES.values()
    assert named <= {f"{system}-{machine}" for system in systems for machine in machines}
