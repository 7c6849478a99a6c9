# Two commands do all the set-up on a fresh machine with Python 3.11: `make report` and `make test`.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
UV := $(shell command -v uv 2>/dev/null)
SOURCES := $(shell find reference cases harness src -type f -not -path '*/__pycache__/*')
RUN := runs/standard.sqlite
# The optional libraries to compare with: make report EXTRAS=dev,peers
EXTRAS ?= dev

.PHONY: report certificates test test-all lint types unit bench clean

report: $(VENV)/installed
	$(BIN)/gnomon certify --to runs/certificates.json --opponents reports/checks.json
	$(BIN)/gnomon run --suite standard --out $(RUN)
	$(BIN)/gnomon report $(RUN) --to reports

# Every variant too, published: about 6 minutes on 2 cores. The page of the next `make report` shows it.
certificates: $(VENV)/installed
	$(BIN)/gnomon certify --all --to reports/certificates.json

test: lint types unit

lint: $(VENV)/installed
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .

# mypy sees the package under its import name only in an ordinary install, so that is what the venv holds.
types: $(VENV)/installed
	$(BIN)/mypy -p gnomon

unit: $(VENV)/installed
	$(BIN)/pytest -n auto --dist loadfile -m "not slow" --benchmark-disable

test-all: lint types
	$(BIN)/pytest -n auto --dist loadfile --benchmark-disable

bench: $(VENV)/installed
	$(BIN)/pytest tests/benchmarks --benchmark-only --benchmark-json=runs/benchmarks.json

# A stale build/ would put files into the package that are no longer in the tree.
$(VENV)/installed: pyproject.toml $(SOURCES) | $(BIN)/python
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
	rm -rf $(VENV) build runs
