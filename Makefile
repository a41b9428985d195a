# Everything here needs Python 3.11 or newer with venv, and make; the rest is installed into .venv.
# Another interpreter: make test PYTHON=python3.13

PYTHON ?= python3
BIN := .venv/bin
ONE_THREAD := OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 MKL_NUM_THREADS=1

KERNEL := $(wildcard cca_core/kernel/c/*) cca_core/codegen/build.py

export MPLBACKEND ?= Agg

.DELETE_ON_ERROR:
.PHONY: help demo rig test kernel lint docs bench table1 validate trials package clean

help:
	@echo "make demo      drive the paper's scenarios; report, figures and summary.json in out/"
	@echo "make rig       the same scenarios through processes, CAN and radio; report and bus logs in out/rig/"
	@echo "make test      all that CI runs: lint, types, docs, tests, examples, notebooks"
	@echo "make kernel    translate the kernel to C and compile it beside its Python"
	@echo "make lint      ruff, mypy and the import contract alone"
	@echo "make docs      the documentation, in docs/_build/html"
	@echo "make bench     run times and budgets, into docs/performance.md (10 minutes)"
	@echo "make table1    the planning methods of the paper's Table 1 compared, into docs/table1.md (10 minutes)"
	@echo "make validate  the tests and studies in full, into docs/validation.md (hours, resumable)"
	@echo "make trials    measure the library in cases and traffic from outside (4 minutes)"
	@echo "make package   check that wheel and sdist build, install and pass the tests in clean environments;"
	@echo "               keeps neither (needs the network)"
	@echo "make clean     remove what was built; .venv stays"

demo: .venv/demo.stamp
	@echo "make demo: drives for about a minute, then writes out/report.html (9 MB)"
	@$(call editable,[plot,plant])
	$(BIN)/python examples/paper_scenarios.py --out out

rig: .venv/rig.stamp
	@echo "make rig: drives in real time, for about three minutes, then writes out/rig/report.html"
	@$(call editable,[rig])
	$(ONE_THREAD) $(BIN)/python -m cca_core.rig run --out out/rig

# the documentation runs the notebooks
test: .venv/kernel.stamp
	@echo "make test: about 8 minutes on two processors"
	@$(call editable,[all])
	$(MAKE) --no-print-directory --jobs 2 --output-sync=target lint docs
	$(ONE_THREAD) $(BIN)/python -m pytest --numprocesses auto --doctest-modules cca_core tests

# with the developer's Python, or another: make kernel PY=python
PY ?= $(BIN)/python
kernel: $(if $(filter $(BIN)/python,$(PY)),.venv/dev.stamp)
	CCA_KERNEL=python $(PY) -m cca_core.codegen
	$(PY) cca_core/codegen/build.py

lint: .venv/dev.stamp
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

docs: .venv/kernel.stamp
	$(BIN)/sphinx-build --quiet --fail-on-warning --keep-going --fresh-env --jobs auto docs docs/_build/html

bench: .venv/bench.stamp .venv/kernel.stamp
	@mkdir -p out
	@status=0; \
	$(ONE_THREAD) $(BIN)/python -m pytest --benchmark-sort=name --benchmark-columns=median,min,rounds \
	    --benchmark-json=out/bench.json --junitxml=out/bench.xml -o junit_family=xunit1 tests/bench || status=$$?; \
	$(BIN)/python -m tests.bench.speed_page out/bench.json out/bench.xml && exit $$status

table1: .venv/bench.stamp .venv/kernel.stamp
	$(ONE_THREAD) $(BIN)/python -m cca_core.baselines.table1

validate: .venv/kernel.stamp
	$(BIN)/python -m tests.validate

trials: .venv/kernel.stamp
	$(ONE_THREAD) $(BIN)/python -m tests.trials.faults
	$(ONE_THREAD) $(BIN)/python -m tests.trials.closed_loop --seeds 0:60

package:
	$(PYTHON) tests/build_packages.py

clean:
	rm -rf out build dist docs/_build docs/generated .benchmarks .hypothesis .import_linter_cache .mypy_cache \
	    .pytest_cache .ruff_cache
	find cca_core examples tests -name __pycache__ -type d -prune -exec rm -rf {} +

# Installs anew where .venv holds another cca_core than this checkout.
editable = $(BIN)/python -P -c 'import pathlib, sys, cca_core; \
    sys.exit(pathlib.Path(cca_core.__file__).resolve().parents[1] != pathlib.Path.cwd())' 2>/dev/null \
    || { echo "another cca_core is installed in .venv: installing this one"; \
    $(BIN)/python -m pip uninstall --quiet --yes cca-core cca-planner; \
    $(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".$(1)"; }

# The stamps make installation happen once, and again when pyproject.toml changes.
.venv/demo.stamp: pyproject.toml $(KERNEL)
	@echo "installing into .venv: about a minute, 500 MB"
	@test -x $(BIN)/python || $(PYTHON) -m venv .venv
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[plot,plant]"
	@touch $@

.venv/rig.stamp: pyproject.toml
	@echo "installing into .venv: about a minute"
	@test -x $(BIN)/python || $(PYTHON) -m venv .venv
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[rig]"
	@touch $@

# --group needs pip 25.1
.venv/dev.stamp: pyproject.toml
	@echo "installing into .venv, with all extras and the developer tools: 1 to 3 minutes, 2.5 GB"
	@test -x $(BIN)/python || $(PYTHON) -m venv .venv
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --upgrade "pip>=25.1"
	@$(BIN)/python -m pip install --quiet --editable ".[all]" --group dev
	@touch $@

# the installation compiles the kernel too; this does when it changes
.venv/kernel.stamp: .venv/dev.stamp $(KERNEL)
	@$(BIN)/python cca_core/codegen/build.py || echo "it runs in Python, slower"
	@touch $@

.venv/bench.stamp: .venv/dev.stamp
	@$(BIN)/python -m pip install --quiet --group bench
	@touch $@
