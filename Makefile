# make demo   demonstrations -> a learned assistant -> a driver in a course never seen; ends with a table and report.html
# make test   builds, then runs gtest and pytest
# Both install what is missing: system packages through apt where that is allowed, the rest into .venv.

VENV := .venv
BIN := $(VENV)/bin
# pinned: an open range takes several gigabytes of CUDA packages; users choose their own build
TORCH := torch==2.13.0
LINTED := python tests/py benchmarks examples tools
SOURCES := $(shell find cpp python CMakeLists.txt pyproject.toml -type f -not -name '*.so' -not -name '*.pyc')

.PHONY: demo test check format stubs benchmark clean

demo: $(VENV)/.installed-study
	$(BIN)/lfdcore demo --output demo

test: $(VENV)/.installed-test
	build/release/lfdcore_tests --gtest_brief=1
	$(BIN)/python -m pytest -n 2

check: $(VENV)/.installed-test
	$(BIN)/ruff check $(LINTED)
	$(BIN)/ruff format --check $(LINTED)
	$(BIN)/clang-format --dry-run --Werror $$(git ls-files '*.hpp' '*.cpp')
	$(BIN)/mypy
	$(BIN)/python tools/make_architecture.py --check

format: $(VENV)/.installed-test
	$(BIN)/ruff check --fix $(LINTED)
	$(BIN)/ruff format $(LINTED)
	$(BIN)/clang-format -i $$(git ls-files '*.hpp' '*.cpp')

stubs: $(VENV)/.installed-test
	$(BIN)/python tools/make_stubs.py

benchmark: $(VENV)/.installed-test
	$(BIN)/pip install --quiet '.[benchmark]'
	for file in benchmarks/bench_*.py; do echo "== $$file"; $(BIN)/python $$file || exit 1; done

$(BIN)/python:
	sh tools/system-packages.sh build
	python3 -m venv $(VENV)

$(VENV)/.installed-study: $(SOURCES) | $(BIN)/python
	$(BIN)/pip install --quiet $(TORCH) '.[study,train]' --config-settings=build-dir=build/release --config-settings=cmake.define.LFDCORE_BUILD_TESTS=OFF
	touch $@

$(VENV)/.installed-test: $(SOURCES) $(wildcard tests/cpp/*.cpp tests/cpp/*/*.cpp) | $(BIN)/python
	sh tools/system-packages.sh build test
	$(BIN)/pip install --quiet $(TORCH) '.[study,train,test]' --config-settings=build-dir=build/release --config-settings=cmake.define.LFDCORE_BUILD_TESTS=ON
	touch $@ $(VENV)/.installed-study

clean:
	rm -rf build $(VENV)
