"""Finding Embree: the copy of the process, a missing one, and one that is too old. Each in a process of its own."""

import shutil
import subprocess
import sys

import pytest

OLD = """
void *rtcNewDevice(const char *config) { static int device; return &device; }
void rtcReleaseDevice(void *device) {}
long rtcGetDeviceProperty(void *device, int property) { return property == 1 ? 3 : property == 2 ? 13 : 5; }
"""


def run(code):
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return result.stdout.strip()


def refusal(path):
    return run(
        "import bentlight_native as b\n"
        f"try: b.load_embree([{str(path)!r}])\n"
        "except OSError as error: print(error)\n"
        "b.load_embree(); print(b.embree_version()[0])"
    ).splitlines()


def test_a_missing_embree_is_named():
    message, version = refusal("/nowhere/libembree4.so.4")
    assert "Embree 4 is needed" in message and "/nowhere/libembree4.so.4" in message
    assert version.startswith("4.")  # a refusal is not for ever


@pytest.mark.parametrize(
    "source, reason", [(OLD, "is Embree 3.13.5, but version 4 is needed"), ("int x;", "lacks rtc")]
)
def test_another_library_is_refused(tmp_path, source, reason):
    library = tmp_path / "libembree.so"
    (tmp_path / "old.c").write_text(source)
    subprocess.run([shutil.which("cc"), "-shared", "-fPIC", str(tmp_path / "old.c"), "-o", str(library)], check=True)
    message, version = refusal(library)
    assert reason in message and version.startswith("4.")


@pytest.mark.unsanitized
def test_the_process_has_one_embree():
    """After `import bpy` its copy is used, and no second one is loaded."""
    code = (
        "import bpy, bentlight_native as b\n"
        "b.load_embree(); print(b.embree_version()[1])\n"
        "print(len({l.split()[-1] for l in open('/proc/self/maps') if 'embree4' in l}))"
    )
    origin, count = run(code).splitlines()[-2:]
    assert origin.startswith("already loaded") and count == "1"
