#!/bin/bash
# make_tree.sh FOLDER: a Debian unstable system with the real Blender application in FOLDER (1.2 GB; needs root and the
# network, takes a minute). Does nothing where it is ready. Blender's version there is Debian's newest.
set -eu
tree=$1 here=$(dirname "$(readlink -f "$0")")
if [ "$(id -u)" != 0 ]; then
    echo "The real Blender runs in a system tree of its own, which only root can make and enter: sudo make test-blender" >&2
    exit 1
fi
[ ! -e "$tree/.ready" ] || [ ! -x "$tree/usr/bin/xdotool" ] || exit 0
command -v debootstrap >/dev/null || { apt-get -qq update; apt-get -qq install --no-install-recommends debootstrap; }
mirror=$(sed -n 's/^URIs: *\([^ ]*\).*/\1/p; s/^deb \(\[[^]]*\] \)\?\([^ ]*\) .*/\2/p' \
    /etc/apt/sources.list.d/debian.sources /etc/apt/sources.list 2>/dev/null | head -1)
mkdir -p "$tree"
[ -e "$tree/.ready" ] || debootstrap --variant=minbase --include=ca-certificates sid "$tree" "$mirror"
# Services must not start in a tree, and nobody reads its manuals.
printf '#!/bin/sh\nexit 101\n' >"$tree/usr/sbin/policy-rc.d"
chmod +x "$tree/usr/sbin/policy-rc.d"
printf 'path-exclude=/usr/share/%s/*\n' doc man locale >"$tree/etc/dpkg/dpkg.cfg.d/small"
# Debian's blender does not name numpy and cattr, yet its extension system imports them.
"$here/in_tree.sh" "$tree" "$tree/root" apt-get -o Dpkg::Options::=--force-unsafe-io install -y --no-install-recommends \
    blender python3-numpy python3-cattr python3-requests xvfb libgl1-mesa-dri libegl1 scrot xdotool
"$here/in_tree.sh" "$tree" "$tree/root" apt-get clean
touch "$tree/.ready"
