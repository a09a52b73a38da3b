# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts a real Blender 5.2 into .build/blender-root: a Debian sid tree made by debootstrap, entered by chroot.

Use: python blender_root.py; prints the command that runs Blender in there. About 100 s and 1 GB, once.
"""

import os
import shutil
from pathlib import Path

import system_packages
from workspace import BUILD, Command, Unavailable, alone, as_program, fingerprint, is_fresh, logged_status, run, say

PLACE = BUILD / "blender-root"
LOG = BUILD / "blender-root.log"
LAUNCHER = Path(__file__).with_name("blender_in_root.sh")
KEYRING = Path("/usr/share/keyrings/debian-archive-keyring.gpg")
SUITE = "sid"
# Blender with what its own Python code imports and Debian only recommends, what a window needs, the test runner, and
# the picture tools.
PACKAGES = (
    "blender python3-numpy python3-requests python3-zstandard python3-cattr"
    " libegl1 libegl-mesa0 libgl1 libgl1-mesa-dri libglx-mesa0"
    " python3-pytest python3-hypothesis python3-scipy python3-pil python3-matplotlib"
).split()
# An archive snapshot has release files past their date.
DATES = 'Acquire::Check-Valid-Until "false";\nAcquire::Check-Date "false";\n'


@alone("blender-root")
def launcher() -> Path:
    """The command that runs Blender in the tree, which is made first if need be."""
    stamp = PLACE / "contents.stamp"
    digest = fingerprint([], SUITE, *PACKAGES)
    if not is_fresh(stamp, digest):
        _check_architecture()
        system_packages.install(system_packages.GROUPS["blender-root"])
        _bootstrap()
        _install()
        _write(stamp, digest)
    return LAUNCHER


def _check_architecture() -> None:
    if shutil.which("apt-get") is None:
        raise Unavailable("a real Blender can be fetched on Debian and Ubuntu only: name one in BLENDER instead")


def _bootstrap() -> None:
    """The bare tree; one that an interrupted run left half-made is begun again."""
    done = PLACE / "bootstrap.stamp"
    if done.is_file():
        return
    root = system_packages.privilege()
    if PLACE.exists():
        run([*root, "rm", "-rf", "--one-file-system", PLACE])
    PLACE.parent.mkdir(exist_ok=True)
    say(f"unpacking Debian {SUITE} into {PLACE} (for a real Blender 5.2; nothing outside that folder is touched)")
    # A mount namespace of its own: whatever debootstrap mounts is gone when it ends.
    private: Command = [*root, "unshare", "--mount", "--propagation", "private"]
    bootstrap: Command = ["debootstrap", "--variant=minbase", f"--keyring={KEYRING}", SUITE, PLACE]
    if logged_status([*private, *bootstrap], LOG) != 0:
        raise Unavailable(f"debootstrap failed (it needs root and the right to mount): see {LOG}")
    _write(PLACE / "etc/apt/apt.conf.d/99dates", DATES)
    _write(done, SUITE)


def _install() -> None:
    say(f"installing {' '.join(PACKAGES)} in {PLACE}")
    root = system_packages.privilege()
    enter: Command = [*root, "env", "DEBIAN_FRONTEND=noninteractive", "ISOCHOR_PROGRAM=sh", LAUNCHER]
    apt = "apt-get -q -o APT::Sandbox::User=root"
    install = f"{apt} update && {apt} install -y --no-install-recommends {' '.join(PACKAGES)}"
    script = f"ln -sf /proc/self/mounts /etc/mtab && {install}"
    if logged_status([*enter, "-c", script], LOG) != 0:
        raise Unavailable(f"Blender could not be installed in {PLACE}: see {LOG}")


def _write(path: Path, text: str) -> None:
    """Writes a file in the tree, which belongs to root."""
    if os.access(path.parent, os.W_OK):
        path.write_text(text)
    else:
        run([*system_packages.privilege(), "sh", "-c", 'printf %s "$1" >"$0"', path, text])


if __name__ == "__main__":
    as_program(lambda: print(launcher()))
