# Each target sets up everything it needs: Python >= 3.11 and make are enough.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# Each worker takes half of the tests in their order, so that the fixtures of a file are made once.
XDIST ?= -n auto --dist worksteal

.PHONY: demo test test-slow attack coverage lint docs bench bench-views pictures validation clean

demo: $(VENV)/installed
	mkdir -p runs
	$(BIN)/blockstruct demo --output runs/demo.h5

test: $(VENV)/installed-dev
	$(BIN)/python -m pytest $(XDIST)

test-slow: $(VENV)/installed-dev
	$(BIN)/python -m pytest $(XDIST) -m slow
	$(BIN)/python -m pytest $(XDIST) -m "hypothesis and not slow" --hypothesis-profile=wide

attack: $(VENV)/installed-dev
	$(BIN)/python -m pytest $(XDIST) tests/attack -m "slow or not slow"

coverage: $(VENV)/installed-dev
	$(BIN)/python -m pytest $(XDIST) --cov=blockstruct --cov-report=term:skip-covered

lint: $(VENV)/installed-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

docs: $(VENV)/installed-docs
	$(BIN)/python -m sphinx -W --keep-going -b html docs docs/_build/html

bench: $(VENV)/installed
	$(BIN)/python benchmarks/surroundings.py
	$(BIN)/python benchmarks/wall_40x60.py
	$(BIN)/python benchmarks/loading_path.py
	$(BIN)/python benchmarks/crushing.py
	$(BIN)/python benchmarks/detection.py
	$(BIN)/python benchmarks/storage.py
	$(BIN)/python benchmarks/pushover.py

bench-views: $(VENV)/installed-dev
	$(BIN)/python benchmarks/views.py

pictures: $(VENV)/installed-dev
	$(BIN)/python docs/gallery.py

validation: $(VENV)/installed-dev
	$(BIN)/python docs/validation.py --workers 2

clean:
	rm -rf $(VENV)

$(VENV)/bin/python:
	$(PYTHON) -m venv $(VENV)

$(VENV)/installed: pyproject.toml | $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet --editable .
	touch $@

$(VENV)/installed-dev: pyproject.toml | $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet --editable ".[dev]"
	touch $@

$(VENV)/installed-docs: pyproject.toml | $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet --editable ".[docs]"
	touch $@
