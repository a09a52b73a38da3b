#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# Runs the Blender of .build/blender-root with the arguments given, as the calling user, seeing the clone, the
# temporary folder and the working folder at their own places. All mounts live in a private namespace: none stays.
# ISOCHOR_PROGRAM names another program of the tree to run as root there (the tools install packages with it).
# ISOCHOR_DISPLAY names the X display on which Blender may open a window; without it Blender sees none.
set -eu

here=$(cd "$(dirname "$0")" && pwd)
clone=$(cd "$here/../.." && pwd)
tree="$clone/.build/blender-root"
home="$clone/.build/blender-home"
mkdir -p "$home"

if [ "${ISOCHOR_MOUNTED:-}" != yes ]; then
    as_root=
    # sudo drops the environment: what Blender and the tests are told through it is passed on by name.
    if [ "$(id -u)" -ne 0 ]; then
        as_root="sudo CI=${CI:-} BLENDER_USER_RESOURCES=${BLENDER_USER_RESOURCES:-} TMPDIR=${TMPDIR:-/tmp}"
        as_root="$as_root ISOCHOR_DISPLAY=${ISOCHOR_DISPLAY:-}"
    fi
    user="$(id -u):$(id -g)"
    if [ -n "${ISOCHOR_PROGRAM:-}" ]; then user=0:0; fi
    # shellcheck disable=SC2086
    exec $as_root env ISOCHOR_MOUNTED=yes ISOCHOR_USER="$user" unshare --mount --propagation private "$0" "$@"
fi

mount -t proc proc "$tree/proc"
mount --rbind /dev "$tree/dev"
for folder in "$clone" "${TMPDIR:-/tmp}" "$PWD"; do
    mkdir -p "$tree$folder"
    mountpoint -q "$tree$folder" || mount --bind "$folder" "$tree$folder"
done

window=
if [ -n "${ISOCHOR_DISPLAY:-}" ]; then window="DISPLAY=$ISOCHOR_DISPLAY"; fi

# shellcheck disable=SC2016,SC2086
exec chroot --userspec="$ISOCHOR_USER" "$tree" env -u DISPLAY -u WAYLAND_DISPLAY -u ISOCHOR_MOUNTED -u PYTHONHOME -u PYTHONPATH \
    $window HOME="$home" PATH=/usr/sbin:/usr/bin:/sbin:/bin sh -c 'cd "$0" && exec "$@"' "$PWD" "${ISOCHOR_PROGRAM:-blender}" "$@"
