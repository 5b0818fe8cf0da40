"""C beside the tests, compiled once a test run: references that share nothing with the core."""

import ctypes
import shutil
import subprocess
from pathlib import Path


def load(source, folder, *libraries):
    """Compiles a C file of this folder into a shared library in `folder`, and loads it."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    path = Path(__file__).with_name(source)
    library = Path(folder) / path.with_suffix(".so").name
    options = ["-O2", "-std=gnu17", "-shared", "-fPIC"]
    subprocess.run([compiler, *options, str(path), "-o", str(library), *libraries, "-lm"], check=True)
    return ctypes.CDLL(str(library))


def pointer(array):
    """The address of an array's data, as an argument."""
    return array.ctypes.data_as(ctypes.c_void_p)
