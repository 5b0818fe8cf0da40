"""The relay camera's files where they cannot be deleted, as on Windows while Cycles has them open."""

from pathlib import Path

from blender_addon.cycles import relay_maps


def test_a_map_that_is_open_elsewhere_keeps_no_other_from_going(tmp_path, monkeypatch):
    files = [tmp_path / f"{number}.exr" for number in range(3)]
    for file in files:
        file.touch()
    unlink = Path.unlink

    def refuse(path, missing_ok=False):
        if path == files[1]:
            raise PermissionError(13, "in use", str(path))
        unlink(path, missing_ok)

    monkeypatch.setattr(Path, "unlink", refuse)
    relay_maps.remove(files)
    assert [file.exists() for file in files] == [False, True, False]
