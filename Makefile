# On a fresh machine with Python 3.11, `make report` and `make test` do all the set-up themselves.
# Measurements go to runs/ and $(LOCAL), which git ignores; only `make publication` writes what is tracked in reports/.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
UV := $(shell command -v uv 2>/dev/null)
SOURCES := $(shell find reference cases harness src -type f -not -path '*/__pycache__/*')
# The suite to report on
SUITE ?= standard
# The optional libraries to compare with: make report EXTRAS=all,dev,peers
EXTRAS ?= all,dev
LOCAL := reports/local
INSTALLED := $(VENV)/installed-$(EXTRAS)

.PHONY: report engines outside certificates solutions libraries publication test test-changed test-all mutants stability verification lint types unit bench catalogue docs clean

# A first page within a minute of the installation, from the suite `quick`; the whole run then continues in the same file,
# and writes its page again every two minutes, at its end and after Ctrl-C. Each suite prints its predicted time before it
# starts. The last line is the time of all.
report: $(INSTALLED)
	@date +%s > runs/.began
	$(BIN)/gnomon run --suite quick --out runs/$(SUITE).sqlite --report $(LOCAL)
	$(BIN)/gnomon certify --out runs/certificates.json --independent $(LOCAL)/checks.json
	$(BIN)/gnomon run --suite $(SUITE) --out runs/$(SUITE).sqlite --report $(LOCAL)
	@seconds=$$(($$(date +%s) - $$(cat runs/.began))); echo "the report took $$((seconds / 60)) min $$((seconds % 60)) s from the end of the installation"

# All variants: less than 15 minutes on 2 cores. The next `make report` shows the certificates.
certificates: $(INSTALLED)
	$(BIN)/gnomon certify --all --out $(LOCAL)/certificates.json

# The exact states that come with gnomon, after a change of cases/ or reference/: some minutes. Commit them once a release.
solutions: $(INSTALLED)
	$(BIN)/python -m gnomon.harness.running.kept_solutions harness/measuring/reference_solutions.zip

# The copies of harness/adapters/libraries.toml and absent.toml, after a change of them: docs/libraries.md, lines of README.md
# and pyproject.toml.
libraries: $(INSTALLED)
	$(BIN)/python -m gnomon.harness.adapters.library_copies

# Everything under reports/ from one revision, with all libraries: six hours in parts, each within 75 minutes of 2 cores.
# The same command goes on. PUBLICATION="--minutes 75" stops in time, --list shows the parts, --part NAME measures one alone,
# --with-older assembles at once.
PUBLICATION ?=
publication:
	$(MAKE) $(VENV)/installed-all,dev,peers,league EXTRAS=all,dev,peers,league
	$(BIN)/python -m gnomon.harness.reporting.publication --out reports $(PUBLICATION)

# Types beside the tests: mypy has one process, and the tests do not always have two. If one fails, the others end first.
test: $(INSTALLED)
	$(MAKE) -j lint types unit

lint: $(INSTALLED)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .

# mypy finds the package under its import name only in an ordinary install, so the venv has one.
types: $(INSTALLED)
	$(BIN)/mypy -p gnomon

unit: $(INSTALLED)
	$(BIN)/pytest -n auto --dist loadfile -m "not slow" --benchmark-disable

# The tests nearest to the code that changed since the last commit (SINCE=main: since that revision), on the sources as they
# are: nothing is installed. tests/helpers/plugins/changed_code.py says what it selects and what it cannot see.
SINCE ?= HEAD
TREE := runs/tree
test-changed:
	@[ -e $(INSTALLED) ] || $(MAKE) $(INSTALLED)
	@rm -rf $(TREE) && mkdir -p $(TREE)/gnomon
	@ln -s $(CURDIR)/src/gnomon/* $(CURDIR)/reference $(CURDIR)/cases $(CURDIR)/harness $(TREE)/gnomon/
	PYTHONPATH=$(CURDIR)/$(TREE):$(CURDIR)/tests/helpers/plugins \
	  $(BIN)/pytest -p changed_code --since $(SINCE) -n auto -m "not slow" --benchmark-disable

test-all: lint types
	HYPOTHESIS_PROFILE=wide $(BIN)/pytest -n auto --dist loadfile --benchmark-disable

# Verifies that each of some 150 changes of the code makes a test fail, and says what survived: 20 minutes of one core.
mutants: $(INSTALLED)
	$(BIN)/python tests/mutation/mutate.py

# All panels of all integrators, full grids: 1 h 16 min on 2 cores. The same command resumes; the next `make report` shows it.
stability: $(INSTALLED)
	$(BIN)/gnomon stability --depth high --out $(LOCAL)/stability.json

# The league of physics engines on exact scenes: within 5 minutes on 2 cores with the extra `engines`, within 20 with all
# (make engines EXTRAS=all,dev,league). The same command resumes; the next `make report` shows it.
engines: $(INSTALLED)
	$(BIN)/gnomon run --suite engines --out runs/engines.sqlite
	$(BIN)/python -m gnomon.harness.studies.league runs/engines.sqlite --out $(LOCAL)/engines.json

# The recommended methods on systems drawn at random, which are no cases: 20 minutes on 2 cores. The same command resumes. Then
# it judges the recommendations of the run of `make report`, whose next page shows it; docs/theory/outside.md says how.
outside: $(INSTALLED)
	$(BIN)/python -m gnomon.harness.own_systems.outside --out runs/outside.sqlite
	$(BIN)/python -m gnomon.harness.own_systems.outside --out runs/outside.sqlite --judge runs/$(SUITE).sqlite --to $(LOCAL)/outside.json

# What `gnomon verify` finds of all planted faults, and whether it fails what is right. Hours, in parts of minutes; the same
# command resumes. Right integrators on a loaded machine: python tests/detection/measure.py --load 8.
verification: $(INSTALLED)
	$(BIN)/python tests/detection/measure.py --out $(LOCAL)/verification.json

# Claims of speed in five launches, then measured orders and growth laws, then every other benchmark once; the next `make report` shows them.
LAUNCHES := 1 2 3 4 5
bench: $(INSTALLED)
	for launch in $(LAUNCHES); do \
	  $(BIN)/pytest tests/benchmarks/test_pairs.py -q --benchmark-only --benchmark-json=runs/launch_$$launch.json || exit 1; \
	done
	$(BIN)/python -m gnomon.harness.studies.benchmarks $(LAUNCHES:%=runs/launch_%.json) --out $(LOCAL)/benchmarks.json
	$(BIN)/python -m gnomon.harness.studies.orders --out $(LOCAL)/orders.json
	$(BIN)/python -m gnomon.harness.studies.growth --out $(LOCAL)/growth.json
	$(BIN)/pytest tests/benchmarks --ignore=tests/benchmarks/test_pairs.py -m "not slow" --benchmark-only \
	  --benchmark-max-time=0.25 --benchmark-min-rounds=3 --benchmark-json=runs/timings.json

# docs/cases.md: all cases and checks with their files.
catalogue: $(INSTALLED)
	$(BIN)/python -m gnomon.harness.reporting.publication.catalogue

# The documentation site, without a network: site/index.html.
docs:
	$(MAKE) $(VENV)/installed-docs EXTRAS=docs
	$(BIN)/mkdocs build --quiet

# An old build/ would put files into the package that are no longer in the tree.
$(INSTALLED): pyproject.toml $(SOURCES) | $(BIN)/python
	rm -rf build src/gnomon.egg-info
ifdef UV
	VIRTUAL_ENV=$(VENV) $(UV) pip install --quiet --reinstall-package gnomon '.[$(EXTRAS)]'
else
	$(BIN)/python -m pip install --quiet --disable-pip-version-check '.[$(EXTRAS)]'
endif
	rm -rf build src/gnomon.egg-info
	mkdir -p runs
	touch $@

$(BIN)/python:
ifdef UV
	$(UV) venv --python $(PYTHON) $(VENV)
else
	$(PYTHON) -m venv $(VENV)
endif

clean:
	rm -rf $(VENV) build runs site
