# tendond: set-up, checks and shortcuts. `make` alone lists the targets.

PYTHON ?= python3
BIN := .venv/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check --no-input -qq

.DEFAULT_GOAL := help
.PHONY: help venv venv-dev demo rig-demo paper robustness identify figures test check format bench golden clean

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-10s %s\n", $$1, $$2 }' Makefile

venv: .venv/.runtime ## set up .venv to run tendond

venv-dev: .venv/.dev ## set up .venv with the test tools as well

demo: .venv/.runtime ## run the demo, results in out/demo
	@$(BIN)/tendond demo --out out/demo

robustness: .venv/.runtime ## run the closed loop on plants unlike the model, results in out/robustness
	@$(BIN)/tendond robustness --out out/robustness

identify: .venv/.runtime ## prove the identification on simulated rigs, results in out/identify
	@$(BIN)/tendond identify demo --out out/identify

rig-demo: .venv/.runtime ## run the robot behind its real drivers, results in out/rig-demo
	@$(BIN)/tendond rig-demo --out out/rig-demo

figures: demo ## run the demo and renew the README's pictures from it
	@mkdir -p docs/images && cp out/demo/shapes.png out/demo/overview.png docs/images/

paper: .venv/.runtime ## reproduce the paper's tables and figures in out/paper
	@$(BIN)/tendond paper --out out/paper

test: .venv/.dev ## run all checks, then the tests
	@$(MAKE) --no-print-directory check
	$(BIN)/python -m pytest

check: .venv/.dev ## lint, formatting, types, layers
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/lint-imports --no-logo

format: .venv/.dev ## format the code and fix what ruff can fix
	$(BIN)/ruff format
	$(BIN)/ruff check --fix

bench: .venv/.dev ## time the rod model, the plain reference beside it
	@$(BIN)/tendond bench rod

golden: .venv/.dev ## make the recorded logs of the tests anew, where the cycle has changed
	@$(BIN)/python -m tests.golden.renew

clean: ## remove out, caches and build leftovers, not .venv
	rm -rf out build dist *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache
	find . -path ./.venv -prune -o -type d -name __pycache__ -prune -exec rm -rf {} +

# A set-up that was interrupted leaves .unfinished, or no .runtime at all: either way the next one starts from nothing.
define install
@if [ ! -e .venv/.runtime ] || [ -e .venv/.unfinished ]; then \
	command -v $(PYTHON) >/dev/null || \
		{ echo "tendond: no '$(PYTHON)' found: install Python 3.11 or newer, or name one: make PYTHON=..." >&2; exit 1; }; \
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "tendond: '$(PYTHON)' is older than Python 3.11: name a newer one: make PYTHON=python3.11" >&2; exit 1; }; \
	$(PYTHON) -c 'import venv, ensurepip' 2>/dev/null || \
		{ echo "tendond: '$(PYTHON)' cannot make a virtual environment: apt install python3-venv" >&2; exit 1; }; \
	$(PYTHON) -m venv --clear .venv || exit 1; \
fi
@touch .venv/.unfinished
@$(PIP) install -r $(1)
@$(PIP) install --no-deps --no-build-isolation -e .
@$(BIN)/python -m tendond.model.warm
@rm .venv/.unfinished
@touch .venv/.runtime
endef

.venv/.runtime: requirements.txt
	@echo "Setting up .venv from requirements.txt (once, takes about a minute)"
	$(call install,requirements.txt)

.venv/.dev: requirements-dev.txt .venv/.runtime
	@echo "Adding the test tools to .venv from requirements-dev.txt (once, takes about a minute)"
	$(call install,requirements-dev.txt)
	@touch $@
