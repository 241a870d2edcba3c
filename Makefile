PYTHON ?= python3
BIN := .venv/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check
UV := $(BIN)/python -m uv pip

# Importers of others whose versions do not fit beside ours: an environment for each list.
PEERS := $(patsubst requirements/peers/%.txt,.venv-peers/%/installed,$(wildcard requirements/peers/*.txt))

.PHONY: setup build dist demo test lint slow mutants foreign-hosts peers docs lock oldest clean

# Everything: to build the native FMUs, to test and to develop.
setup: .venv/everything

$(BIN)/python:
	$(PYTHON) -m venv .venv

# What it takes to build the Python FMUs and to fly. --no-deps: the list is complete.
.venv/flying: requirements/flying.txt pyproject.toml | $(BIN)/python
	@echo "Installing what flying needs into .venv: about 670 MB on disk, 210 MB to download."
	$(PIP) install --no-deps --no-compile --requirement requirements/flying.txt
	$(PIP) install --no-deps --editable .
	@touch $@
	@echo "Installed: $$(du -sh .venv | cut -f1)."

.venv/everything: requirements/all.txt pyproject.toml | $(BIN)/python
	@echo "Installing everything into .venv: about 2.2 GB on disk, 600 MB to download."
	$(PIP) install --no-deps --requirement requirements/all.txt
	$(PIP) install --no-deps --editable .
	@touch .venv/flying $@
	@echo "Installed: $$(du -sh .venv | cut -f1)."

build: setup
	@echo "Building all FMUs in both flavours; the first time takes the compiler a few minutes."
	$(BIN)/ahv build

# A release: a wheel that carries the native FMUs, the FMUs of both FMI versions, checksums, a bill of materials.
dist: build
	rm -rf dist/release
	$(BIN)/python -m cosim.master.compile_loop
	$(BIN)/python -m hatchling build -t wheel -d dist/release
	$(BIN)/python -m fmus.release dist/release

# The README's first command: set up, build the FMUs, fly Case 1, then an uncertain vehicle with two laws; see results/.
demo: .venv/flying
	@echo "Building the FMUs of the Python flavour."
	$(BIN)/ahv build --flavour python
	@echo "Flying Case 1."
	$(BIN)/ahv run case1 --flavour python
	@echo "Flying an uncertain vehicle with two laws. One of them loses it."
	$(BIN)/ahv compare docs/scenarios/uncertain.yaml --controller neural --controller resilient --flavour python || test $$? -eq 1
	@echo "The figures are in results/run/case1/figures and results/compare/uncertain. 'make build' adds the native FMUs, which need no Python."

# A file at a time, in their order: the small ones of tests/unit come last, so that both workers end together.
test: build
	$(BIN)/python -m pytest -n 2 --dist loadfile --no-loadscope-reorder -m 'not slow and not peers'

lint: setup
	$(BIN)/ruff check .
	$(BIN)/mypy

# What is too long for the everyday suite.
slow: build
	$(BIN)/python -m pytest -m slow

# Do the tests notice mistakes? Hours; it goes on where it was stopped. Writes docs/mutants.md.
mutants: build
	$(BIN)/python tests/mutants
	$(BIN)/python tests/mutants --table

# The native controller in hosts for Windows (Debian's wine64) and Arm (qemu-user), on a board (qemu-system-arm and
# picolibc-arm-none-eabi) and as WebAssembly (nodejs), and the long valgrind runs.
foreign-hosts: build
	$(BIN)/python -m pytest -m slow $(patsubst %,tests/conformance/test_%.py,native_hosts board wasm component)

# Our FMUs in the importers of others (1.7 GB more on disk, in .venv-peers). Writes docs/importers.md.
peers: build $(PEERS)
	$(BIN)/python benchmarks/importers.py
	$(BIN)/python -m pytest --no-skips -m peers tests/system/test_importers.py tests/system/test_ecosystems.py

.venv-peers/%/installed: requirements/peers/%.txt | .venv/everything
	@echo "Installing $* into .venv-peers/$*."
	$(PYTHON) -m venv --clear .venv-peers/$*
	$(UV) install --quiet --python .venv-peers/$*/bin/python --requirement $<
	@touch $@

# Renew the lists of pinned versions. Flying needs no CMake, which fmpy names for compiling FMUs.
lock: setup
	$(UV) compile --quiet --upgrade --universal --no-header --no-annotate --all-extras pyproject.toml -o requirements/all.txt
	$(UV) compile --quiet --universal --no-header --no-annotate --constraint requirements/all.txt \
		--no-emit-package cmake pyproject.toml -o requirements/flying.txt

# Does everything work with the oldest versions that pyproject.toml allows?
oldest: setup
	rm -rf .venv-oldest
	$(PYTHON) -m venv .venv-oldest
	$(UV) install --quiet --python .venv-oldest/bin/python --resolution lowest-direct --editable '.[all]'
	.venv-oldest/bin/ahv build
	.venv-oldest/bin/python -m pytest -q -m 'not slow and not peers' tests/unit tests/conformance tests/system/test_cases.py

# The documentation as a site, in site/, with the playground; open site/index.html.
docs: build
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --quiet --strict

clean:
	rm -rf .venv .venv-oldest .venv-peers results dist fmus/dist cosim/master/built site
