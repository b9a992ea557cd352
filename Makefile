# The commands of the README, and the developers' check. Everything happens in .venv, made here.
#
# uv installs where it is on PATH, otherwise venv and pip do. Stamp files in .venv make a second call quick.

.PHONY: demo test docs check check-all format lint types layers clean

# The first interpreter that will do, or nothing. A name on PATH may be a shim that fails, so it is asked.
PYTHON := $(shell for name in python3.11 python3.12 python3.13 python3; do \
	if "$$name" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info < (3, 14))' 2>/dev/null; \
	then command -v "$$name"; break; fi; done)
UV := $(shell command -v uv)
WRONG_PYTHON = frameout needs Python 3.11, 3.12 or 3.13: install one of them (or uv, which brings it)

# What uv takes if it may choose an interpreter itself.
INTERPRETER = $(or $(PYTHON),3.11)
INSTALL = $(if $(UV),uv pip install --python .venv/bin/python,.venv/bin/python -m pip install) --quiet -c constraints.txt

demo: .venv/installed
	.venv/bin/frameout bench frame-out --seeds 0:5 --trackers mosaic_graph_pf colour_pf hold hold_ground oracle_map --out results/demo
	.venv/bin/frameout render road-town --seed 3 --frames 90 --tracker mosaic_graph_pf --out results/demo/frame_out.mp4

test: .venv/installed-dev
	.venv/bin/pytest -n 2 --dist loadfile

# Pages and pictures that are there already are kept, in build/docs.
docs: .venv/installed-docs
	.venv/bin/sphinx-build --quiet --fail-on-warning --keep-going -c docs -d build/docs/pages . build/site
	@echo "the site is in build/site"

check: format lint types layers test

check-all: format lint types layers .venv/installed-dev
	.venv/bin/pytest -n 2 --dist loadfile -m "heavy or not heavy"

format: .venv/installed-dev
	.venv/bin/ruff format --check .

lint: .venv/installed-dev
	.venv/bin/ruff check .

types: .venv/installed-dev
	.venv/bin/mypy

layers: .venv/installed-dev
	.venv/bin/lint-imports

clean:
	rm -rf .venv results build dist *.egg-info

.venv/made:
	$(if $(PYTHON)$(UV),,$(error $(WRONG_PYTHON)))
	@echo "making .venv with $(if $(PYTHON),$(PYTHON),uv)"
	@$(if $(UV),uv venv --quiet --allow-existing --python $(INTERPRETER) .venv,$(PYTHON) -m venv .venv)
	@touch $@

# setuptools builds the package itself; installed beforehand it is the pinned one.
.venv/installed: .venv/made constraints.txt pyproject.toml
	@echo "installing the pinned packages of constraints.txt"
	@$(INSTALL) setuptools
	@$(INSTALL) --no-build-isolation -e .
	@touch $@

.venv/installed-docs: .venv/installed
	@echo "installing what the site needs"
	@$(INSTALL) --no-build-isolation -e '.[docs]'
	@touch $@

.venv/installed-dev: .venv/installed
	@echo "installing what tests, tuning, training, play, data sets and the site need"
	@$(INSTALL) --no-build-isolation -e '.[dev,docs,tune,train,play,data,s3,dask,rerun]'
	@# It asks for the OpenCV with windows, which would take the place of the headless one.
	@$(INSTALL) --no-deps trackeval
	@touch $@
