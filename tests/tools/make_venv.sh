#!/bin/sh
# make_venv.sh FOLDER REQUIREMENTS: a virtual environment of Python 3.11 in which everything here builds and runs.
#
# Debian packages that are missing are installed where the user is root, and named otherwise.
set -eu
folder=$1 requirements=$2

# need PACKAGE...: installs these Debian packages, or says that somebody has to.
need() {
    if [ "$(id -u)" != 0 ] || ! command -v apt-get >/dev/null; then
        echo "This machine lacks what these Debian packages hold. As root: apt-get install $*" >&2
        echo "Then run the same command again." >&2
        exit 1
    fi
    echo "Installing the missing Debian packages: $*"
    apt-get -qq update
    DEBIAN_FRONTEND=noninteractive apt-get -qq install --no-install-recommends "$@" >/dev/null
}

# The first Python 3.11 there is. bpy's wheels are for this version alone.
find_python() {
    for candidate in python3.11 python3; do
        if "$candidate" -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' 2>/dev/null; then
            command -v "$candidate"
            return
        fi
    done
}

python=$(find_python)
[ -n "$python" ] || { need python3.11; python=python3.11; }
packages=
"$python" -c 'import ensurepip' 2>/dev/null || packages="$packages python3.11-venv"
[ -e "$("$python" -c 'import sysconfig; print(sysconfig.get_path("include"))')/Python.h" ] ||
    packages="$packages python3.11-dev"
command -v cc >/dev/null || packages="$packages gcc libc6-dev"
# shellcheck disable=SC2086  # a list of words
[ -z "$packages" ] || need $packages

[ -x "$folder/bin/python" ] || "$python" -m venv "$folder"
"$folder/bin/python" -m pip install --quiet --disable-pip-version-check --requirement "$requirements"

# The shared libraries that bpy wants from the system. Debian names a library's package after it: libX11.so.6 is in
# libx11-6, libXi.so.6 in libxi6.
module=$("$folder/bin/python" -c 'import importlib.util; print(importlib.util.find_spec("bpy").origin)')
missing=$(ldd "$module" | sed -n 's/^[[:space:]]*\([^ ]*\) => not found.*/\1/p' | sort -u |
    tr '[:upper:]' '[:lower:]' | sed -e 's/\([0-9]\)\.so\./\1-/' -e 's/\.so\.//')
# shellcheck disable=SC2086  # a list of words
[ -z "$missing" ] || need $missing
"$folder/bin/python" -c 'import bpy' >/dev/null
