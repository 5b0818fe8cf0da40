"""Runs every bench_*.py beside it on one core, one after the other, and gathers their Markdown in output/bench.md."""

import os
import platform
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent
OUTPUT = HERE.parents[1] / "output" / "bench.md"


def processor() -> str:
    """The processor's name as Linux knows it."""
    lines = Path("/proc/cpuinfo").read_text().splitlines()
    return next((line.split(":")[1].strip() for line in lines if line.startswith("model name")), platform.machine())


def main() -> None:
    """Writes the file as the parts come, and shows them."""
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    OUTPUT.parent.mkdir(exist_ok=True)
    OUTPUT.write_text(f"# Bentlight's speed and errors\n\nOne core of {processor()}.\n")
    for script in sorted(HERE.glob("bench_*.py")):
        done = subprocess.run([sys.executable, script], stdout=subprocess.PIPE, text=True, check=True)
        print(done.stdout, flush=True)
        with OUTPUT.open("a") as file:
            file.write(f"\n## {script.stem.removeprefix('bench_').capitalize()}\n\n{done.stdout}")
    print(OUTPUT)


if __name__ == "__main__":
    main()
