# Everything a person or CI does, from a clean clone: each target sets up what it needs.
# It takes Python 3.11 or later and pip, nothing else; another Python by `make PYTHON=python3.12 ...`.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
LOWEST := .venv-lowest
NEWEST := .venv-newest
OUT := out

PIP := -m pip install --quiet --disable-pip-version-check
PYTEST := -m pytest -q -n 2 --dist loadfile
FAST := $(PYTEST) -m 'not slow'
export OPENBLAS_NUM_THREADS := 1
export HYPOTHESIS_PROFILE ?= ci

.DEFAULT_GOAL := help
.PHONY: help demo test test-fast test-full test-lowest test-newest coverage lint types format \
	docs playground vsix bench pins clean

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-12s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

$(STAMP): pyproject.toml constraints.txt
	@$(call venv,$(VENV))
	$(BIN)/python $(PIP) -c constraints.txt -e '.[all,test]'
	@touch $@

$(LOWEST)/.installed: pyproject.toml constraints-lowest.txt
	@$(call venv,$(LOWEST))
	$(LOWEST)/bin/python $(PIP) -c constraints-lowest.txt -e '.[all,test]'
	@touch $@

# An environment in the folder $(1), by a Python that is recent enough.
define venv
$(PYTHON) -c 'import sys; sys.version_info >= (3, 11) or sys.exit("stlc needs Python 3.11 or later, \
	and $(PYTHON) is " + sys.version.split()[0] + "; try: make PYTHON=python3.12 ...")' \
	&& echo "$(PYTHON) -m venv $(1)" && $(PYTHON) -m venv $(1)
endef

demo: $(STAMP) ## solve the paper's case and the flat; plans and pictures go to out/
	$(BIN)/python examples/demo.py --out $(OUT)

test: $(STAMP) ## run all tests (reduced hypothesis profile)
	$(BIN)/python $(PYTEST)

test-fast: $(STAMP) ## run the tests that take no more than a moment each
	$(BIN)/python $(FAST)

test-full: $(STAMP) ## run all tests with the full hypothesis profile
	HYPOTHESIS_PROFILE=full $(BIN)/python $(PYTEST)

test-lowest: $(LOWEST)/.installed ## run the fast tests with the lowest versions that we declare
	$(LOWEST)/bin/python $(FAST)

test-newest: ## run the fast tests with today's newest versions of everything
	@$(call venv,$(NEWEST))
	$(NEWEST)/bin/python $(PIP) --upgrade --upgrade-strategy eager -e '.[all,test]'
	$(NEWEST)/bin/python $(FAST)

coverage: $(STAMP) ## run the fast tests, print how much of the code they reach
	$(BIN)/python $(FAST) --cov --cov-report=term:skip-covered

lint: $(STAMP) ## ruff: style and formatting
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(STAMP) ## mypy --strict
	$(BIN)/mypy

format: $(STAMP) ## let ruff mend style and formatting
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

docs: $(STAMP) ## the site of docs/, warnings being errors, in out/docs
	$(BIN)/python $(PIP) -c constraints.txt -e '.[docs]'
	$(BIN)/python -m sphinx -q -W -b html docs $(OUT)/docs
	@echo "look at $(OUT)/docs/index.html"

PYODIDE := 314.0.7
WHEELS ?=

playground: $(STAMP) ## a page that checks, formats and shows missions in a browser, from disk (needs npm)
	@$(call npm,Pyodide)
	npm install --silent --no-save --no-package-lock --prefix $(OUT)/npm pyodide@$(PYODIDE)
	rm -rf $(OUT)/packages && $(BIN)/python -m pip wheel --quiet --no-deps -w $(OUT)/packages .
	$(BIN)/python -m stlc.playground.packages $(OUT)/packages \
		--pyodide $(OUT)/npm/node_modules/pyodide $(if $(WHEELS),--wheels '$(WHEELS)')
	$(BIN)/python examples/gallery.py $(OUT)/gallery
	$(BIN)/python -m stlc.playground.build $(OUT)/playground --packages $(OUT)/packages \
		--pyodide $(OUT)/npm/node_modules/pyodide --examples examples --reports $(OUT)/gallery
	@echo "look at $(OUT)/playground/index.html"

vsix: ## the extension for Visual Studio Code, out/stlc-missions.vsix (needs npm)
	@$(call npm,the client of the language server and the packager)
	rm -rf $(OUT)/vscode && mkdir -p $(OUT) && cp -R grammar/vscode $(OUT)/vscode
	cp LICENSE $(OUT)/vscode/LICENSE
	cd $(OUT)/vscode && npm install --silent --no-package-lock \
		&& npx --yes @vscode/vsce@3 package --allow-missing-repository --out ../stlc-missions.vsix

# Says what is missing where there is no npm, which fetches $(1).
define npm
command -v npm > /dev/null || { echo "make $@ needs npm, which fetches $(1) (Debian: \
	apt-get install npm)"; exit 1; }
endef

bench: $(STAMP) ## the benchmark suites that take minutes, with their report
	$(BIN)/stlc bench --quick --store $(OUT)/bench.sqlite
	$(BIN)/stlc bench report --store $(OUT)/bench.sqlite -o $(OUT)/bench.html --csv $(OUT)/bench.csv

RESOLVE := pip compile --quiet --upgrade --no-header --no-annotate --python-version 3.11 \
	--extra all --extra docs --extra test pyproject.toml

pins: $(STAMP) ## resolve both constraints files anew: today's newest, and our lowest
	$(BIN)/python $(PIP) uv
	$(BIN)/uv $(RESOLVE) -o constraints.txt
	$(BIN)/uv $(RESOLVE) --resolution lowest-direct -o constraints-lowest.txt

clean: ## remove what make made
	rm -rf $(VENV) $(LOWEST) $(NEWEST) $(OUT)
