# Every command of the project; `make` alone lists them.

PYTHON ?= python3
JOBS ?= auto
# More words for the tool, as in: make test ARGS="-k euler", make lock ARGS=--upgrade
ARGS ?=

# the environment that make sets up, and clears when the lock changes
VENV ?= .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --quiet --disable-pip-version-check
# pip compiles on one core, and the packages' own tests too: half of the time of a set-up; what does not
# compile is left, as pip leaves it
INSTALL := $(PIP) install --require-hashes --no-compile
PYTEST := $(BIN)/pytest
SMOKE := $(CURDIR)/build/smoke
# Long evidence: one test may take two hours, which a loaded machine does not reach. By default a
# test that takes five minutes hangs, and its worker is ended (pyproject.toml).
slow golden fuzz peers clients proofs: PYTEST += -o faulthandler_timeout=7200
# The stamps' order: the locked packages, the project itself, every optional extra, the site's.
LOCKED := $(VENV)/.stamp-locked
DEV := $(VENV)/.stamp-dev
ALL := $(VENV)/.stamp-all
DOCS := $(VENV)/.stamp-docs

# Python's own variable against bytecode files: the tests start a hundred processes, which would all
# compile the package anew
unexport PYTHONDONTWRITEBYTECODE
# what heyoka compiles for the site and for the commands that tests start, which share it
docs: export HEYOKA_CACHE_DIR = $(CURDIR)/build/compiled

.DEFAULT_GOAL := help
.PHONY: help venv report measured test evidence slow golden peers clients browser proofs fuzz costs mutants \
        lint format types check schemas docs smoke lock build clean

help:     ## list the targets
	@awk -F ': *## ' '/^[a-z]+:.*## /{sub(/:.*/, "", $$1); printf "  make %-8s %s\n", $$1, $$2}' \
		$(MAKEFILE_LIST)

venv:     ## set .venv up with all that the default checks need
venv: $(DEV)

# --clear, so that a package which left the lock leaves .venv as well.
$(LOCKED): requirements/dev.txt
	@test ! -e $(VENV) -o -e $(VENV)/.made || { echo "$(VENV): not made by make, so not cleared; \
	expected none there, or another name: make $(MAKECMDGOALS) VENV=build/venv" >&2; exit 2; }
	$(PYTHON) -m venv --clear $(VENV)
	touch $(VENV)/.made
	$(INSTALL) -r requirements/dev.txt
	-$(BIN)/python -m compileall -q -j 0 -x /tests/ $(VENV)/lib
	touch $@

$(DEV): pyproject.toml $(LOCKED)
	$(PIP) install --no-deps --no-build-isolation -e .
	touch $@

$(ALL): requirements/all.txt $(LOCKED) | $(DEV)
	$(INSTALL) -r requirements/all.txt
	touch $@

$(DOCS): requirements/docs.txt $(LOCKED) | $(DEV)
	$(INSTALL) -r requirements/docs.txt
	touch $@

report:   ## write the precision report into reports/
report: $(DEV)
	$(BIN)/tt-precise report $(ARGS)

measured: ## run the extreme cases again, whose outcomes the report shows (half a minute)
measured: $(DEV)
	$(BIN)/python -m benchmarks.extremes $(ARGS)

test:     ## the default tests: none of the marked ones
test: $(DEV)
	$(PYTEST) -n $(JOBS) --dist worksteal $(ARGS)

evidence: ## tests marked evidence: more cases of what the default tests show
evidence: $(DEV)
	$(PYTEST) -n $(JOBS) --dist worksteal -m "$@ and not (slow or fuzz)" $(ARGS)

slow:     ## tests marked slow: long evidence
golden:   ## tests marked golden: rebuild the golden data
fuzz:     ## tests marked fuzz: long fuzzing
proofs:   ## tests marked proofs: long rigorous proofs
slow golden fuzz proofs: $(DEV)
	$(PYTEST) -n $(JOBS) -m $@ $(ARGS)

peers:    ## tests marked peers: other integrators (installs every extra)
clients:  ## tests marked clients: other people's engines (installs every extra)
peers clients: $(ALL)
	$(PYTEST) -n $(JOBS) -m $@ $(ARGS)

costs:    ## what calls and commands cost, beside their baselines
costs: $(DEV)
	$(PYTEST) -n 0 -o addopts=--import-mode=importlib benchmarks $(ARGS)

# In a worktree, because cosmic-ray changes the files; PYTHONPATH goes before the editable install, and
# bytecode of the same second and size would hide a change.
FILE ?= tt_precise/mechanics/newton.py
MUTANTS := $(CURDIR)/build/mutants
# cr-rate counts a mutant that the filter skipped as killed: forget those before any is tried
FORGET := import sqlite3; db = sqlite3.connect('session.sqlite'); [db.execute('delete from ' + table + \
	' where job_id in (select job_id from work_results)') for table in \
	('mutation_specs', 'work_items', 'work_results')]; db.commit()
IN_MUTANTS = cd $(MUTANTS) && PYTHONDONTWRITEBYTECODE=1 PYTHONPATH=$(MUTANTS) $(abspath $(BIN))

mutants:  ## mutants of one file, FILE=..., of which the tests of its folder must kill 92 %
mutants: $(ALL)
	rm -rf $(MUTANTS) && git worktree prune && git worktree add --detach $(MUTANTS) HEAD
	sed 's|FILE|$(FILE)|; s|FOLDER|$(notdir $(patsubst %/,%,$(dir $(FILE))))|; s|PYTHON|$(abspath $(BIN))/python|' \
		benchmarks/mutants.toml > $(MUTANTS)/mutants.toml
	$(IN_MUTANTS)/cosmic-ray init mutants.toml session.sqlite
	$(IN_MUTANTS)/cr-filter-operators session.sqlite mutants.toml
	$(IN_MUTANTS)/python -c "$(FORGET)"
	$(IN_MUTANTS)/cosmic-ray baseline mutants.toml
	$(IN_MUTANTS)/cosmic-ray exec mutants.toml session.sqlite
	$(IN_MUTANTS)/cr-report --surviving-only --show-diff session.sqlite
	$(IN_MUTANTS)/cr-rate --fail-over 8 session.sqlite

browser:  ## tests marked browser: the report in chromium (installs it from Debian)
browser: $(DEV)
	{ command -v chromium && command -v chromedriver; } >/dev/null || \
		{ apt-get update && apt-get install --yes chromium chromium-driver; }
	$(PYTEST) -m $@ $(ARGS)

lint:     ## ruff: rules and formatting
lint: $(DEV)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

format:   ## let ruff repair what it can
format: $(DEV)
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

types:    ## mypy
types: $(DEV)
	$(BIN)/mypy

check:    ## what a commit has to pass: lint, types, test, evidence
check: lint types test evidence

schemas:  ## docs/schemas, written from the records
schemas: $(DEV)
	$(BIN)/python docs/_ext/schemas.py

# -W: a warning is an error; the tutorials are run, or taken from the cache of an unchanged package.
docs:     ## the documentation site, into build/docs/html; works offline
docs: $(DOCS)
	$(BIN)/sphinx-build -W --keep-going -q -b html -d build/docs/doctrees docs build/docs/html $(ARGS)
	@echo build/docs/html/index.html

build:    ## wheel and sdist, into dist/
build: $(DEV)
	$(BIN)/hatchling build --clean

# The wheel that is built from the sdist has to be the same, byte by byte. Installed elsewhere, it runs the
# examples of README and start.md without a network, and every command of README without extras. .venv lends
# its packages through a path file that does not lead back to the checkout.
OFFLINE = $(shell unshare -rn true 2> /dev/null && echo unshare -rn)
LARGEST_WHEEL := 10000000
PACKAGES := -c "import sysconfig; print(sysconfig.get_path('purelib'))"

smoke:    ## the wheel, also from the sdist, runs the examples of README and start.md elsewhere and offline
smoke: build
	test $$(stat -c %s dist/*.whl) -lt $(LARGEST_WHEEL)
	rm -rf build/again && $(PIP) wheel --no-deps --no-build-isolation --wheel-dir build/again dist/*.tar.gz
	cmp dist/*.whl build/again/*.whl
	$(PYTHON) -m venv --clear $(SMOKE)
	$(BIN)/python $(PACKAGES) > $$($(SMOKE)/bin/python $(PACKAGES))/lent.pth
	$(SMOKE)/bin/python -m pip --quiet --disable-pip-version-check install --no-deps --ignore-installed dist/*.whl
	cd / && $(SMOKE)/bin/python -c "import tt_precise as tt; \
		assert tt.__file__.startswith('$(SMOKE)'), tt.__file__"
	$(SMOKE)/bin/tt-precise --version
	$(OFFLINE) $(SMOKE)/bin/python -m pytest -q -n 0 -p no:cacheprovider \
		-c $(CURDIR)/pyproject.toml -o pythonpath= $(CURDIR)/tests/test_documentation.py -m "slow or not slow" \
		-k "without_extras or (examples_run and not True and (README or start))"

# all.txt first: the smaller sets are cut out of it, so that one .venv can hold them all.
UV_COMPILE = build/lock/bin/uv pip compile pyproject.toml --quiet --universal \
	--python-version 3.11 --fork-strategy fewest --generate-hashes --no-emit-index-url \
	--no-annotate --custom-compile-command "make lock"

lock:     ## pin and hash requirements/*.txt anew
	$(PYTHON) -m venv --clear build/lock
	build/lock/bin/python -m pip --quiet --disable-pip-version-check install uv
	$(UV_COMPILE) $(ARGS) --all-extras -o requirements/all.txt
	$(UV_COMPILE) -c requirements/all.txt --extra test --extra dev --extra parquet --extra hdf5 \
		-o requirements/dev.txt
	$(UV_COMPILE) -c requirements/all.txt --extra docs -o requirements/docs.txt
	$(UV_COMPILE) -c requirements/all.txt -o requirements/runtime.txt

clean:    ## remove .venv, builds and caches
	rm -rf .venv build dist .mypy_cache .pytest_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
