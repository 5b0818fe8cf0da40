# Every command of a checkout. Each target does its own set-up: the virtual environments, the native wheel.
#
#   make render         examples/room_schwarzschild.py: the picture of a room around a black hole
#   make test           all tests: two versions of Blender, and the C core under sanitizers
#   make lint           style of Python, and warnings of C as errors
#   make bench          measures speed and errors (output/bench/bench.md)
#   make package        the installable Blender extension (dist)
#   make packages       that for every platform, by cross compilation, and looks into each (docs/packages.md)
#   make test-blender   installs that in the real Blender application and renders (needs root; not part of `test`)
#   make blends         examples/*.blend: scenes with thumbnails
#   make clean          removes what all this built, the virtual environments excepted

SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DELETE_ON_ERROR:
.NOTPARALLEL:
.PHONY: render test test-python test-python-4.5 test-sanitized lint bench package packages test-blender blends clean
.DEFAULT_GOAL := render

python := .venv/bin/python
python_4.5 := .venv-4.5/bin/python
pip_build := -m pip --disable-pip-version-check --quiet
pytest := -m pytest -n 2 --dist loadfile --durations 15

render: build/native.stamp
	$(python) examples/room_schwarzschild.py

test: test-python test-python-4.5 test-sanitized

test-python: build/native.stamp
	$(python) $(pytest) tests

# The oldest Blender with the oldest instruction set; the sanitized core has the one between alone, test-python the best.
test-python-4.5: build/native-4.5.stamp
	BENTLIGHT_ISA=v2 $(python_4.5) $(pytest) tests

# Python itself leaks at exit, so leaks are looked for in the C program alone, which has no Python in it.
test-sanitized: build/sanitized.stamp
	build/sanitized/cmake/bentlight_smoke .venv/lib/python3.11/site-packages/bpy/lib/libembree4.so.4
	LD_PRELOAD="$$(cc -print-file-name=libasan.so)" ASAN_OPTIONS=detect_leaks=0 PYTHONMALLOC=malloc BENTLIGHT_SANITIZED=1 \
	  PYTHONPATH=build/sanitized/site $(python) $(pytest) tests/native -m "not unsanitized"

lint: .venv/ready
	$(python) -m ruff check .
	$(python) -m ruff format --check .
	.venv/bin/cmake -S native -B build/lint -G Ninja -DSKBUILD=ON -DCMAKE_COMPILE_WARNING_AS_ERROR=ON \
	  -DPython_EXECUTABLE="$(CURDIR)/$(python)" -DCMAKE_MAKE_PROGRAM="$(CURDIR)/.venv/bin/ninja" --log-level=WARNING
	.venv/bin/cmake --build build/lint -- --quiet

bench: build/native.stamp
	$(python) tests/bench/run.py

package: build/native.stamp
	rm -rf dist
	$(python) tests/tools/build_extension.py --wheel build/wheelhouse/*.whl --output dist

packages: build/native.stamp build/cross/ready
	PYTHONPATH=build/cross/site $(python) tests/tools/cross_compile.py build/cross
	rm -rf dist
	$(python) tests/tools/build_extension.py --wheel build/wheelhouse/*.whl build/cross/*/wheelhouse/*.whl --output dist
	BENTLIGHT_PACKAGES=dist $(python) -m pytest -n 0 tests/package/check_packages.py

test-blender: export BENTLIGHT_BLENDER_DIR ?= $(HOME)/.cache/bentlight-blender
test-blender: package
	tests/blender/make_tree.sh "$$BENTLIGHT_BLENDER_DIR"
	BENTLIGHT_ZIP=$$(echo dist/bentlight-*.zip) $(python) -m pytest tests/blender/check_application.py

# By the oldest Blender that is supported: newer ones open what it writes.
blends: build/native-4.5.stamp
	$(python_4.5) examples/save_blends.py

clean:
	rm -rf build dist output

# Set-up -----------------------------------------------------------------------------------------------------------

requirements := tests/requirements/common.txt tests/tools/make_venv.sh
# Folders too: their times tell of files that were added or removed.
native := $(shell find native -not -name __pycache__ -not -name '*.pyc')

.venv/ready: tests/requirements/bpy-5.0.txt $(requirements)
	tests/tools/make_venv.sh .venv $<
	touch $@

.venv-4.5/ready: tests/requirements/bpy-4.5.txt $(requirements)
	tests/tools/make_venv.sh .venv-4.5 $<
	touch $@

build/cross/ready: tests/requirements/cross.txt .venv/ready
	$(python) $(pip_build) install --upgrade --target build/cross/site --requirement $<
	touch $@

build/wheel.stamp: $(native) | .venv/ready
	rm -rf build/wheelhouse
	$(python) $(pip_build) wheel --no-build-isolation --no-deps --wheel-dir build/wheelhouse ./native
	touch $@

build/native.stamp: build/wheel.stamp .venv/ready
	$(python) $(pip_build) install --force-reinstall --no-deps build/wheelhouse/*.whl
	touch $@

build/native-4.5.stamp: build/wheel.stamp .venv-4.5/ready
	$(python_4.5) $(pip_build) install --force-reinstall --no-deps build/wheelhouse/*.whl
	touch $@

build/sanitized.stamp: $(native) tests/native/smoke.c | .venv/ready
	rm -rf build/sanitized/site
	$(python) $(pip_build) install --no-build-isolation --no-deps --target build/sanitized/site \
	  -Cbuild-dir=../build/sanitized/cmake -Ccmake.build-type=Debug -Ccmake.define.BENT_SANITIZE=ON ./native
	touch $@
