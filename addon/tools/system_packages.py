# SPDX-License-Identifier: GPL-3.0-or-later
"""Installs the Debian/Ubuntu packages that are missing, as root or through sudo, and says which.

Use: python system_packages.py GROUP... with groups from GROUPS. Packages already there are left untouched.
"""

import os
import shutil
import sys

from workspace import BUILD, Command, Unavailable, as_program, fail, logged_status, output, say

# What the bpy wheel loads at start in a bare Debian 12; Workbench and EEVEE abort without libegl1.
BPY = "libgl1 libice6 libsm6 libx11-6 libxext6 libxfixes3 libxi6 libxrender1 libxkbcommon0 libegl1".split()
GROUPS: dict[str, list[str]] = {
    "bpy": BPY,
    # A software rasteriser, lavapipe, and the loader that finds it.
    "vulkan": ["mesa-vulkan-drivers", "libvulkan1"],
    "blender-root": ["debootstrap", "debian-archive-keyring", "util-linux", "mount"],
    # A display for a window that nobody sees.
    "window": ["xvfb"],
    "compiler": ["gcc", "libc6-dev"],
}


def privilege() -> list[str]:
    """The words before a command that needs root; raises Unavailable for a user without sudo."""
    if os.geteuid() == 0:
        return []
    sudo = shutil.which("sudo")
    if sudo is None:
        raise Unavailable("system packages are missing, but this user is not root and there is no sudo")
    return [sudo]


def missing(names: list[str]) -> list[str]:
    """Those of the packages that are not installed."""
    listing = output(["dpkg-query", "--show", "--showformat=${Package} ${db:Status-Abbrev}\n"])
    if listing is None:
        raise Unavailable(f"this is no Debian or Ubuntu: install by hand what corresponds to {' '.join(names)}")
    there = {line.split()[0] for line in listing.splitlines() if line.split()[1:2] == ["ii"]}
    # Ubuntu's 64-bit time_t transition renamed libraries to NAMEt64; those provide the old name.
    return [name for name in names if name not in there and f"{name}t64" not in there]


def install(names: list[str]) -> None:
    """Installs the missing ones of the packages; raises Unavailable where apt-get cannot."""
    wanted = missing(names)
    if not wanted:
        return
    say(f"installing system packages: {' '.join(wanted)}")
    BUILD.mkdir(exist_ok=True)
    log = BUILD / "system-packages.log"
    apt: Command = [*privilege(), "env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "-q", "-y"]
    logged_status([*apt, "update"], log)  # a partly unreachable list may still hold what is wanted
    if logged_status([*apt, "install", "--no-install-recommends", *wanted], log) != 0:
        raise Unavailable(f"apt-get could not install {' '.join(wanted)}: see {log}")


def candidate(name: str) -> bool:
    """True where apt knows a package of that name to install."""
    policy = output(["apt-cache", "policy", name])
    return policy is not None and "Candidate:" in policy and "Candidate: (none)" not in policy


def main(groups: list[str]) -> None:
    unknown = [group for group in groups if group not in GROUPS]
    if unknown or not groups:
        fail(f"system_packages.py: unknown group {' '.join(unknown) or '(none given)'}, expected {' '.join(GROUPS)}")
    for group in groups:
        install(GROUPS[group])


if __name__ == "__main__":
    as_program(lambda: main(sys.argv[1:]))
