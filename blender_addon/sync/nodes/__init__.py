"""Blender node trees as programs of the core: `compiler` walks a tree, each other file knows one family of nodes."""
