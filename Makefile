PYTHON ?= python3
BIN := .venv/bin

.PHONY: setup build demo test lint slow foreign-hosts docs clean

setup: .venv/ready

.venv/ready: pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/pip install --quiet --upgrade pip
	$(BIN)/pip install --quiet --editable '.[all]'
	touch $@

build: setup
	$(BIN)/ahv build

# The README's first command: set up, build the FMUs, fly Case 1, then an uncertain vehicle with two laws; see results/.
demo: build
	$(BIN)/ahv run case1
	$(BIN)/ahv compare docs/scenarios/uncertain.yaml --controller neural --controller resilient || test $$? -eq 1 # one is lost

test: build
	$(BIN)/pytest -n 2 --dist loadfile -m 'not slow'

lint: setup
	$(BIN)/ruff check .
	$(BIN)/mypy

# What is too long for the everyday suite.
slow: build
	$(BIN)/pytest -m slow

# The native controller in hosts for Windows (Debian's wine64) and Arm (qemu-user), and the long valgrind runs.
foreign-hosts: build
	$(BIN)/pytest -m slow tests/conformance/test_native_hosts.py

# The documentation as a site, in site/; open site/index.html.
docs: setup
	$(BIN)/pip install --quiet --editable '.[docs]'
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --quiet --strict

clean:
	rm -rf .venv results fmus/dist site
