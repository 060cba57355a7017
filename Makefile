# Everything a person or CI does, from a clean clone: each target sets up what it needs.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
OUT := out

.DEFAULT_GOAL := help
.PHONY: help demo test test-full lint types format bench clean

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-10s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

$(STAMP): pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[all,test]'
	@touch $@

demo: $(STAMP) ## solve the paper's case and the flat; plans and pictures go to out/
	OPENBLAS_NUM_THREADS=1 $(BIN)/python examples/demo.py --out $(OUT)

test: $(STAMP) ## run all tests (reduced hypothesis profile)
	OPENBLAS_NUM_THREADS=1 HYPOTHESIS_PROFILE=ci $(BIN)/python -m pytest -q -n 2 --dist loadfile

test-full: $(STAMP) ## run all tests with the full hypothesis profile
	OPENBLAS_NUM_THREADS=1 HYPOTHESIS_PROFILE=full $(BIN)/python -m pytest -q -n 2 --dist loadfile

lint: $(STAMP) ## ruff: style and formatting
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(STAMP) ## mypy --strict
	$(BIN)/mypy

format: $(STAMP) ## let ruff mend style and formatting
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

bench: $(STAMP) ## the benchmark suites that take minutes, with their report
	$(BIN)/stlc bench --quick --store $(OUT)/bench.sqlite
	$(BIN)/stlc bench report --store $(OUT)/bench.sqlite -o $(OUT)/bench.html --csv $(OUT)/bench.csv

clean: ## remove what make made
	rm -rf $(VENV) $(OUT)
