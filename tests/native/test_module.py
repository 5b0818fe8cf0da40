"""The native module's face: every name of the C module is documented and typed, every wrapper too."""

import ast
import gc
import inspect
from pathlib import Path

import bentlight_native
import numpy as np
import pytest
from bentlight_native import _core
from heap import allocated_bytes

STUB = Path(_core.__file__).with_name("_core.pyi")


def core_members():
    """Yields (dotted name, object) of every public function, class and member of a class in the C module."""
    for name, value in vars(_core).items():
        if name.startswith("_"):
            continue
        yield name, value
        if inspect.isclass(value):
            yield from ((f"{name}.{key}", item) for key, item in vars(value).items() if not key.startswith("_"))


def stub_names():
    """The dotted names that the C module's stub declares."""
    names = set()
    for node in ast.parse(STUB.read_text()).body:
        if isinstance(node, ast.ClassDef | ast.FunctionDef):
            names.add(node.name)
        if isinstance(node, ast.ClassDef):
            methods = (item.name for item in node.body if isinstance(item, ast.FunctionDef))
            names |= {f"{node.name}.{name}" for name in methods if not name.startswith("_")}
            names |= {f"{node.name}.{item.target.id}" for item in node.body if isinstance(item, ast.AnnAssign)}
    return names


def test_every_name_of_the_c_module_has_a_docstring():
    undocumented = [name for name, value in core_members() if not (value.__doc__ or "").strip()]
    assert not undocumented


def test_the_stub_declares_the_c_module_no_more_no_less():
    assert stub_names() == {name for name, _ in core_members()}


def test_every_wrapper_has_a_docstring_and_type_hints():
    for name in bentlight_native.__all__:
        value = getattr(bentlight_native, name)
        assert (value.__doc__ or "").strip(), name
        if inspect.isfunction(value):
            hints = inspect.signature(value)
            assert hints.return_annotation is not inspect.Signature.empty, name
            assert all(p.annotation is not inspect.Parameter.empty for p in hints.parameters.values()), name


def committed_scene():
    """A scene with a mesh, an instance and a hole, ready to be traced."""
    scene = bentlight_native.Scene()
    vertices = np.eye(3, dtype=np.float32)
    scene.add_instance(scene.add_mesh(vertices, np.array([[0, 1, 2]], np.uint32)), np.eye(4))
    scene.set_spacetime(bentlight_native.Spacetime.schwarzschild(0.1), np.eye(4))
    scene.commit()
    return scene


# How to make one, and how many in a round.
HANDLES = {
    "Progress": (bentlight_native.Progress, 1000),
    "Spacetime": (lambda: bentlight_native.Spacetime.kerr(1.0, 0.5), 1000),
    "Scene": (bentlight_native.Scene, 1000),
    "committed Scene": (committed_scene, 100),  # 8 ms each
}


@pytest.mark.unsanitized
@pytest.mark.parametrize("name", HANDLES)
def test_handles_do_not_leak(name):
    make, count = HANDLES[name]

    def growth():
        gc.collect()
        before = allocated_bytes()
        for _ in range(count):
            make()
        gc.collect()
        return allocated_bytes() - before

    growth()  # fills free lists and caches
    # 10 bytes a handle at most, and malloc's smallest piece has 32; threads of others grow now and then.
    assert min(growth() for _ in range(3)) < 1000
