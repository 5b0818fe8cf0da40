"""Tables as OpenEXR images: accuracy of the float32 copies, what another library reads, and what is refused."""

import struct

import numpy as np
import OpenEXR
import pytest
from bentlight_native import (
    Cancelled,
    DeflectionTable,
    ExrError,
    KerrMap,
    Progress,
    SampledTable,
    Spacetime,
    trace_rays,
)
from bentlight_native.exr import read_exr, write_exr
from bentlight_native.table import map_values
from rays import angle_between
from tables import SPACETIMES


@pytest.fixture(scope="module")
def kerr_map():
    return KerrMap(Spacetime.kerr(1.0, 0.998), 20.0)


def chart_radius(spacetime, x):
    if spacetime.kind == "ellis":
        return spacetime.core_radius / map_values("ratio_ellis", x)
    if spacetime.chart == "areal":
        return 0.5 * spacetime.core_radius / x
    return spacetime.core_radius / map_values("ratio_schwarzschild", x)


def test_copies_keep_1e5(table, tmp_path):
    """Total, outward, and so inward angles, read back from the files, within 1e-5 rad of the table."""
    paths = tmp_path / "total.exr", tmp_path / "outward.exr"
    SampledTable.from_table(table).write(*paths)
    images = SampledTable.read(table.spacetime, *paths)
    random = np.random.default_rng(1)
    delta = 10 ** random.uniform(-6, 6, 20000)
    if table.spacetime.kind == "ellis":
        delta = np.concatenate([delta, -(10 ** random.uniform(-6, -1e-9, 20000))])
    total_error = np.abs(images.total(delta) - table.total(delta)).max()
    low, high = (0.2426, 0.99999) if table.spacetime.kind == "ellis" else (1e-5, 0.24999)
    x, cosine = random.uniform(low, high, 40000), random.uniform(0, 1, 40000)
    sine = np.sqrt(1 - cosine**2)
    _, swept = table.sweep(chart_radius(table.spacetime, x), cosine, sine)
    outward_error = np.abs(images.outward(x, cosine, sine) - swept).max()
    assert total_error + outward_error <= 1e-5
    known = images.measured
    assert known.total_max + known.sweep_max <= 1e-5
    assert total_error <= 2 * known.total_max and outward_error <= 2 * known.sweep_max
    assert 0 < known.total_rms < known.total_max and 0 < known.sweep_rms < known.sweep_max
    assert sorted(path.name for path in tmp_path.iterdir()) == ["outward.exr", "total.exr"]


def test_lens_sphere_copy(table, tmp_path):
    """One number in: across a sphere the swept angle is total - 2 outward, within 1e-5 rad."""
    sphere = 30 * table.spacetime.core_radius
    paths = tmp_path / "total.exr", tmp_path / "sphere.exr"
    SampledTable.from_table(table, sphere).write(*paths)
    images = SampledTable.read(table.spacetime, *paths, sphere)
    angle = np.linspace(1e-6, np.pi / 2 - 1e-6, 5001)
    cosine, sine = np.cos(angle), np.sin(angle)
    _, outward = table.sweep(np.full(len(angle), sphere), cosine, sine)
    x = map_values("x_ellis" if table.spacetime.kind == "ellis" else "x_schwarzschild", 1 / 30)
    if table.spacetime.chart == "areal":
        x = 1 / 60
    delta = map_values("delta_ellis" if table.spacetime.kind == "ellis" else "delta_schwarzschild", x, sine)
    exact = table.total(delta) - 2 * outward
    copy = images.total(delta) - 2 * images.outward(None, cosine, sine)
    defined = np.isfinite(exact) & (np.abs(delta) > 1e-6)
    assert defined.sum() > 3000
    assert np.abs(exact - copy)[defined].max() <= min(1e-5, 2 * (images.measured.total_max + images.measured.sweep_max))
    with pytest.raises(ExrError, match="Radius"):
        SampledTable.read(table.spacetime, *paths, 2 * sphere)


@pytest.mark.parametrize("kind", [np.float32, np.float16])
def test_another_library_reads_the_file(kind, tmp_path):
    """The reference OpenEXR library sees the same pixels and strings."""
    image = {"B": np.arange(12, dtype=kind).reshape(3, 4), "A": np.full((3, 4), np.pi, kind)}
    write_exr(tmp_path / "image.exr", image, {"note": "text"})
    with OpenEXR.File(str(tmp_path / "image.exr"), separate_channels=True) as file:
        assert file.header()["note"] == "text"
        for name, pixels in image.items():
            assert file.channels()[name].pixels.dtype == kind
            assert np.array_equal(file.channels()[name].pixels, pixels)
    channels, strings = read_exr(tmp_path / "image.exr")
    assert strings["note"] == "text"
    assert all(np.array_equal(channels[name], pixels) for name, pixels in image.items())


def test_every_truncation_and_damage_is_refused(tmp_path):
    path = tmp_path / "image.exr"
    write_exr(path, {"R": np.ones((2, 3), np.float32)}, {"note": "text"})
    whole = path.read_bytes()
    for length in range(len(whole)):
        path.write_bytes(whole[:length])
        with pytest.raises(ExrError, match=str(path)):
            read_exr(path)
    for at in range(len(whole) - 24, len(whole)):  # the last pixels
        path.write_bytes(whole[:at] + bytes([whole[at] ^ 0x40]) + whole[at + 1 :])
        if at >= len(whole) - 12:
            with pytest.raises(ExrError, match="damaged"):
                read_exr(path)
    path.write_bytes(b"not an image")
    with pytest.raises(ExrError, match="not an OpenEXR"):
        read_exr(path)
    with pytest.raises(OSError):
        read_exr(tmp_path / "missing.exr")


def test_files_of_others_are_refused(tmp_path):
    table = DeflectionTable(SPACETIMES["isotropic"])
    paths = tmp_path / "total.exr", tmp_path / "outward.exr"
    SampledTable.from_table(table).write(*paths)
    with pytest.raises(ExrError, match="Spacetime"):
        SampledTable.read(Spacetime.schwarzschild(1.5), *paths)
    with pytest.raises(ExrError, match="Kind"):
        SampledTable.read(table.spacetime, paths[1], paths[0])
    channels, strings = read_exr(paths[0])
    kept = {name: value for name, value in strings.items() if name.startswith("bentlight")}
    write_exr(paths[0], channels, kept | {"bentlightMapVersion": "999"})
    with pytest.raises(ExrError, match="MapVersion is 999"):
        SampledTable.read(table.spacetime, *paths)
    write_exr(paths[0], channels, kept | {"bentlightMeasured": "small"})
    with pytest.raises(ExrError, match="lacks bentlightMeasured"):
        SampledTable.read(table.spacetime, *paths)
    with OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION}, {"R": np.ones((2, 2), np.float32)}) as file:
        file.write(str(paths[0]))
    with pytest.raises(ExrError, match="not written by Bentlight"):
        SampledTable.read(table.spacetime, *paths)


def test_a_failed_write_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "image.exr"
    write_exr(path, {"R": np.ones((1, 1), np.float32)}, {})
    before = path.read_bytes()

    def refuse(*_):
        raise OSError("disk full")

    monkeypatch.setattr("os.replace", refuse)
    with pytest.raises(OSError, match="disk full"):
        write_exr(path, {"R": np.zeros((1, 1), np.float32)}, {})
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_size_that_makes_no_sense(tmp_path):
    path = tmp_path / "image.exr"
    write_exr(path, {"R": np.ones((2, 3), np.float32)}, {})
    data = path.read_bytes()
    window = struct.pack("<iiii", 0, 0, 2, 1)
    path.write_bytes(data.replace(window, struct.pack("<iiii", 0, 0, 2**30, 2**30)))
    with pytest.raises(ExrError, match="size"):
        read_exr(path)


def test_kerr_map_keeps_1e3_at_the_95th_percentile(kerr_map):
    error = kerr_map.measure(10000)
    assert error.p95 <= 1e-3
    assert error.median < error.rms < error.maximum


def test_kerr_map_error_map_is_true(kerr_map):
    """What is published for a cell is what the other route finds between lookup and truth in the cell's middle."""
    random = np.random.default_rng(2)
    shape = np.array(kerr_map.error.shape)
    i, j, k = (random.integers(0, size, 4000) for size in shape)
    polar, chi = (i + 0.5) * (np.pi / 2 / shape[0]), (j + 0.5) * (2 * np.pi / shape[1])
    edge = 0.25 * sum(kerr_map.edge[a, b].astype(float) for a in (i, i + 1) for b in (j, (j + 1) % shape[1]))
    psi = map_values("psi_from_coordinate", (k + 0.5) / shape[2], edge, 1e-4)
    fate, direction = kerr_map.lookup(polar, psi, chi)
    traced = trace_rays(kerr_map.spacetime, *kerr_map.rays(polar, psi, chi), 1e-9, route="taylor")
    out = (fate == 1) & (traced["fate"] == 1)
    error, published = angle_between(direction[out], traced["direction"][out]), kerr_map.error[i, j, k][out]
    # psi agrees to float32 rounding of the edge; near the edge that alone turns the direction
    assert np.all(np.abs(error - published) <= 1e-6 + 1e-2 * published + 2 * traced["error"][out])
    assert np.all(kerr_map.error[i, j, k][~out] > 3)


def test_kerr_map_files(tmp_path):
    spacetime = Spacetime.kerr(1.0, 0.5)
    small = KerrMap(spacetime, 12.0, (5, 16, 12))
    paths = tmp_path / "kerr.exr", tmp_path / "kerr.error.exr"
    small.write(*paths)
    again = KerrMap.read(spacetime, 12.0, paths[0])
    assert np.array_equal(again.direction, small.direction) and np.array_equal(again.edge, small.edge)
    channels, _ = read_exr(paths[1])
    assert np.array_equal(channels["error"].reshape(small.error.shape), small.error)
    for wrong in ((Spacetime.kerr(1.0, 0.6), 12.0), (spacetime, 13.0)):
        with pytest.raises(ExrError, match="expected"):
            KerrMap.read(*wrong, paths[0])
    with pytest.raises(ValueError, match="kerr"):
        KerrMap(Spacetime.schwarzschild(1.0), 12.0)
    with pytest.raises(ValueError, match="radius"):
        KerrMap(spacetime, 3.0)


def test_kerr_map_progress_and_cancel():
    progress = Progress()
    KerrMap(Spacetime.kerr(1.0, 0.5), 12.0, (5, 8, 6), progress=progress)
    assert progress.done == 5
    progress.cancel()
    with pytest.raises(Cancelled):
        KerrMap(Spacetime.kerr(1.0, 0.5), 12.0, (5, 8, 6), progress=progress)


def test_kerr_map_mirrors_the_south():
    spacetime = Spacetime.kerr(1.0, 0.9)
    kerr_map = KerrMap(spacetime, 15.0, (17, 128, 96))
    random = np.random.default_rng(3)
    polar, chi = random.uniform(np.pi / 2, np.pi, 500), random.uniform(0, 2 * np.pi, 500)
    psi = random.uniform(1.0, 2.5, 500)
    fate, direction = kerr_map.lookup(polar, psi, chi)
    traced = trace_rays(spacetime, *kerr_map.rays(polar, psi, chi), 1e-9)
    assert np.array_equal(fate, traced["fate"])
    assert np.percentile(angle_between(direction, traced["direction"]), 99) < 3e-3
