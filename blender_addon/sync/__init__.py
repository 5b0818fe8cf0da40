"""Blender's evaluated scene as plain numpy data; one file for each kind of datablock."""
