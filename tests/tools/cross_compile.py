"""Compiles the core for the platforms that this machine is not: cross_compile.py FOLDER [TARGET...]

What it proves: no code but the SIMD kernels and a few named attributes needs more than C17, every header that is
included exists on the platform, and each library function links. The compiler is Clang, as the Python package `ziglang`
brings it with the headers and libraries of every platform. Warnings are errors.
"""

import argparse
import subprocess
import sys
from pathlib import Path

NATIVE = Path(__file__).resolve().parents[2] / "native"
FOLDERS = ("base", "spacetime", "table", "geometry", "scene", "light", "render")  # all but python
# Target: its instruction sets, and the flags of each.
V2, V3, V4 = ("-march=x86_64_v2",), ("-march=x86_64_v3",), ("-march=x86_64_v4", "-mprefer-vector-width=512")
X86_64 = {"v2": V2, "v3": V3, "v4": V4}
TARGETS = {
    "x86_64-windows-gnu": X86_64,
    "aarch64-windows-gnu": {"neon": ()},
    "x86_64-macos": X86_64,
    "aarch64-macos": {"neon": ()},
    "aarch64-linux-gnu.2.34": {"neon": ()},
}
# As in native/CMakeLists.txt, which also takes the C library's extensions (M_PI). Clang alone warns of fields that are
# left zero at the end of an initializer.
WARNINGS = ("-Wall", "-Wextra", "-Werror", "-Wno-missing-field-initializers")
FLAGS = ("-std=gnu17", "-O1", *WARNINGS, "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=fast")


def compiler(target: str, *flags: str) -> list[str]:
    """The command line of the compiler for `target`."""
    includes = [f"-I{NATIVE / 'include'}", f"-I{NATIVE / 'src'}"]
    return [sys.executable, "-m", "ziglang", "cc", "-target", target, *FLAGS, *flags, *includes]


def build(target: str, folder: Path) -> Path:
    """The program of tests/native/smoke.c with all of the core in it, for `target`."""
    folder.mkdir(parents=True, exist_ok=True)
    files = [path for name in FOLDERS for path in sorted((NATIVE / "src" / name).glob("*.c"))]
    kernels = [path for path in files if path.name.endswith(".kernel.c")]
    others = [path for path in files if path not in kernels] + [NATIVE.parent / "tests" / "native" / "smoke.c"]
    isas, objects = TARGETS[target], []
    for isa, flags in isas.items():
        for kernel in kernels:
            objects.append(folder / f"{kernel.stem}.{isa}.{'obj' if 'windows' in target else 'o'}")
            chosen = (f"-DBENT_ISA={isa}", f"-DBENT_ISA_{isa}=1", *flags)
            subprocess.run([*compiler(target, *chosen), "-c", "-o", objects[-1], kernel], check=True)
    program = folder / ("smoke.exe" if "windows" in target else "smoke")
    command = [*compiler(target, "-pedantic", *next(iter(isas.values()))), "-o", program, *others, *objects]
    subprocess.run([*command, *(() if "windows" in target else ("-lm",))], check=True)
    return program


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="where objects and programs go")
    parser.add_argument("target", nargs="*", help=f"of {', '.join(TARGETS)}; default: all of them")
    arguments = parser.parse_args()
    for target in arguments.target or TARGETS:
        print(build(target, arguments.folder.resolve() / target))


if __name__ == "__main__":
    main()
