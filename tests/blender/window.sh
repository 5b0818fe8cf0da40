#!/bin/bash
# window.sh ARGUMENT...: inside the system tree, Blender's true window on a virtual screen, drawn by Mesa in software.
# Vulkan's software renderer corrupts overlays: OpenGL is asked for.
set -eu
export LIBGL_ALWAYS_SOFTWARE=1
pipe=$(mktemp -u)
mkfifo "$pipe"
Xvfb -displayfd 9 -screen 0 1280x800x24 -nolisten tcp 9>"$pipe" 2>/dev/null &
screen=$!
trap 'kill $screen; wait $screen 2>/dev/null || true; rm -f "$pipe"' EXIT
read -r display <"$pipe"
DISPLAY=:$display blender --gpu-backend opengl --window-geometry 0 0 1280 800 "$@"
