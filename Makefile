# Everything runs in one virtual environment; it is made on first use and renewed when constraints.txt or pyproject.toml change.
VENV ?= .venv
ifndef PYTHON
PYTHON := $(shell for python in python3.11 python3 python3.12 python3.13; do \
	$$python -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo $$python && break; done)
endif
BIN := $(VENV)/bin
DEMO := results/elbow

.PHONY: help setup demo test slow test-all check manual format benchmark lock clean
.DEFAULT_GOAL := help

help:  ## list the targets
	@sed -n 's/^\([a-z-]*\):.*## /  make \1\t/p' $(MAKEFILE_LIST)

setup:  ## make or renew the virtual environment
	@test -n "$(PYTHON)" || { echo "Python 3.11 or newer is needed (Debian: apt-get install python3.11)" >&2; exit 1; }
	@$(PYTHON) .ci/environment.py $(VENV)

demo: setup  ## press an elbow into the fabric: reliability report, result file and failure maps
	$(BIN)/etextile run elbow --output $(DEMO) --force
	@echo "report, result file and maps: $(CURDIR)/$(DEMO)"

test: setup  ## run the tests (under three minutes)
	$(BIN)/python -m pytest -n auto

slow: setup  ## run the tests marked slow
	$(BIN)/python -m pytest -m slow -n auto --dist worksteal

test-all: setup  ## run all tests
	$(BIN)/python -m pytest -m ""

check: setup  ## lint, formatting and types
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

manual: setup  ## build the pages of the manual (minutes: its commands and its gallery are run)
	$(BIN)/etextile manual --build etextile/manual/html --keep build/manual

format: setup  ## format the code and sort its imports
	$(BIN)/ruff check --select I --fix .
	$(BIN)/ruff format .

benchmark: setup  ## run the micro-benchmarks of the kernels
	$(BIN)/python -m pytest -m "" --benchmark-only tests/benchmarks

lock:  ## renew constraints.txt (needs uv)
	uv pip compile pyproject.toml --extra page --extra frames --extra life --extra manual --extra test --extra dev --output-file constraints.txt \
		--universal --python-version 3.11 --fork-strategy fewest --no-build --generate-hashes \
		--no-annotate --no-header --no-emit-index-url --no-emit-find-links --quiet

clean:  ## remove the virtual environment, caches and demo results
	rm -rf $(VENV) results build etextile/manual/html .pytest_cache .mypy_cache .ruff_cache .benchmarks dist
	find etextile wires loadcases viz tests -name __pycache__ -type d -prune -exec rm -rf {} +
