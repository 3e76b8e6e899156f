# tendond: set-up, checks and shortcuts. `make` alone lists the targets.

PYTHON ?= python3
BIN := .venv/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check --no-input -qq
LOCK = $(BIN)/uv pip compile -q $(if $(UPGRADE),--upgrade) --universal --python-version 3.11 --generate-hashes \
	--no-annotate --no-emit-index-url --custom-compile-command 'make lock'

.DEFAULT_GOAL := help
.PHONY: help venv venv-dev demo demo-wired demo-spatial paper robustness identify evidence figures notebooks gallery docs docs-version notes test checked check format bench example \
	dist pythons lock golden clean

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z0-9-]+:.*## / { printf "  make %-12s %s\n", $$1, $$2 }' Makefile

venv: .venv/.runtime ## set up .venv to run tendond

venv-dev: .venv/.dev ## set up .venv with the test tools as well
	@$(MAKE) --no-print-directory .venv/.runtime

demo: .venv/.packages ## run the demo, results in out/demo
	@$(BIN)/tendond demo --out out/demo

robustness: .venv/.runtime ## run the closed loop on plants unlike the model, results in out/robustness
	@$(BIN)/tendond study robustness --out out/robustness

demo-spatial: .venv/.packages ## run a circle of the tip in space, results in out/demo-spatial
	@$(BIN)/tendond demo --scenario spatial --out out/demo-spatial

identify: .venv/.runtime ## prove the identification on simulated rigs, results in out/identify
	@$(BIN)/tendond identify demo --out out/identify

demo-wired: .venv/.packages ## run the robot behind its real drivers, results in out/demo-wired
	@$(BIN)/tendond demo --scenario wired --out out/demo-wired

# Only runs in which no pose was lost and the tip settled are shown: otherwise this fails and copies nothing. The live
# view shows a run in real time, which a busy computer spoils; all others are of a run in lockstep.
figures: demo paper ## renew the pictures of the README and the documentation
	@$(BIN)/tendond demo --lockstep --out out/figures
	@$(BIN)/tendond animate out/figures/demo.mcap --to 1 --speed 0.25 --fps 12 --width 720 --force --out out/figures/demo.gif
	@$(BIN)/python -m tendond.cli.manual.checked out/figures/demo.mcap out/paper/results.json -- \
		out/figures/shapes.png docs/images/shapes.png out/figures/overview.png docs/images/overview.png \
		out/figures/demo.gif docs/images/demo.gif \
		out/paper/normal.png docs/images/paper_normal.png out/paper/normal_edge.png docs/images/paper_normal_edge.png
	@$(BIN)/python -m tendond.cli.manual.pictures out/demo/demo.mcap out/demo/watch.svg
	@$(BIN)/python -m tendond.cli.manual.pictures out/demo/demo.mcap out/demo/dashboard.png
	@$(BIN)/python -m tendond.cli.manual.checked out/demo/demo.mcap -- out/demo/watch.svg docs/images/watch.svg \
		out/demo/dashboard.png docs/images/dashboard.png

notebooks: .venv/.dev .venv/.runtime ## run the notebooks of the documentation, and renew their pages
	@$(BIN)/python -m tendond.cli.manual.notebooks docs/notebooks docs/notebooks docs/images

gallery: .venv/.dev .venv/.runtime ## run the examples, and renew the pictures of the gallery
	@for one in examples/*.py; do case $$one in */analyse_log.py) ;; *) \
		$(BIN)/python $$one docs/images/gallery-$$(basename $$one .py).png || exit 1;; esac; done

# A missed target is part of the evidence: the page says so. Missing data stop it.
evidence: .venv/.runtime ## validate the general rod on others' measured robots, and renew docs/evidence.md
	@rm -rf out/evidence
	@for one in armlab ftdcr_v4-tendon_pull ftdcr_v4-val; do \
		$(BIN)/tendond validate $$one --residual --out out/evidence || [ -e out/evidence/$$one.md ] || exit 1; \
	done
	@$(BIN)/tendond validate ftdcr_v4-val --every 4 --residual --out out/evidence || [ -e out/evidence/ftdcr_v4-val-every4.md ]
	@$(BIN)/python -m tendond.cli.manual.evidence out/evidence docs/evidence.md docs/images

docs: .venv/.dev ## build the documentation, strictly, in out/site
	@NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict
	@echo "documentation: out/site/index.html; with search: $(BIN)/python -m http.server -b 127.0.0.1 -d out/site"

docs-version: docs ## add the documentation of this version to the branch gh-pages, as ALIAS (latest), with a selector of versions
	@PATH="$(CURDIR)/$(BIN):$$PATH" NO_MKDOCS_2_WARNING=1 $(BIN)/mike deploy --update-aliases \
		"$$($(BIN)/python -m tendond.cli.manual.release --minor)" $(or $(ALIAS),latest)
	@$(BIN)/mike set-default latest
	@echo "documentation of all versions: branch gh-pages; $(BIN)/mike serve shows it; git push origin gh-pages publishes it"

notes: .venv/.dev ## print the release notes of VERSION (this one) in Markdown, from CHANGELOG.md
	@$(BIN)/python -m tendond.cli.manual.release $(VERSION)

paper: .venv/.packages ## reproduce the paper's tables and figures in out/paper
	@$(BIN)/tendond study paper --iterations --out out/paper

# The kernels are compiled beside the checks, which do not need them.
# A test of real time that fails beside the others is run once more, alone; whatever fails then fails the run.
test: .venv/.dev ## run all checks, then the tests
	@$(MAKE) --no-print-directory -j 2 .venv/.runtime checked
	$(BIN)/python -m pytest -n 4 --durations=40 || $(BIN)/python -m pytest --last-failed --last-failed-no-failures none

checked: check docs

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

example: .venv/.dev ## write deploy/rig.toml, the example with every key, anew from the schema
	@$(BIN)/python -m tendond.cli.manual.annotate > deploy/rig.toml

dist: .venv/.dev ## build source distribution and wheel into dist/; tests/deploy installs them
	@rm -rf dist && $(BIN)/uv build -q --no-build-isolation --python $(BIN)/python

pythons: .venv/.dev ## run TESTS (all unit tests) on the other Pythons that pyproject.toml declares
	@tests/pythons $(TESTS)

lock: .venv/.dev ## write requirements*.txt anew from pyproject.toml, with hashes; UPGRADE=1: the newest versions
	@printf 'setuptools\nwheel\n' | $(LOCK) pyproject.toml - --extra plot -o requirements.txt
	@printf 'setuptools\nwheel\n' | $(LOCK) pyproject.toml - --all-extras -c requirements.txt -o requirements-dev.txt

golden: .venv/.dev ## make the recorded logs of the tests anew, where the cycle has changed
	@$(BIN)/python -m tests.golden.renew

clean: ## remove out, caches (the compiled kernels too) and build leftovers, not .venv
	rm -rf .venv/.runtime out build dist *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache
	find . -path ./.venv -prune -o -type d -name __pycache__ -prune -exec rm -rf {} +

# A set-up that was interrupted leaves .unfinished, or no .packages at all: either way the next one starts from nothing.
define install
@if [ ! -e .venv/.packages ] || [ -e .venv/.unfinished ]; then \
	command -v $(PYTHON) >/dev/null || \
		{ echo "tendond: no '$(PYTHON)' found: install Python 3.11 to 3.13, or name one: make PYTHON=..." >&2; exit 1; }; \
	$(PYTHON) -c 'import sys; sys.exit(not (3, 11) <= sys.version_info < (3, 14))' || \
		{ echo "tendond: '$(PYTHON)' is not Python 3.11 to 3.13: name one: make PYTHON=python3.11" >&2; exit 1; }; \
	$(PYTHON) -c 'import venv, ensurepip' 2>/dev/null || \
		{ echo "tendond: '$(PYTHON)' cannot make a virtual environment: apt install python3-venv" >&2; exit 1; }; \
	$(PYTHON) -m venv --clear .venv || exit 1; \
fi
@touch .venv/.unfinished
@$(PIP) install --require-hashes -r $(1)
@$(PIP) install --no-deps --no-build-isolation -e .
@[ -e .venv/.packages ] || touch .venv/.packages # where an interrupted set-up of the test tools started from nothing
@rm .venv/.unfinished
endef

.venv/.packages: requirements.txt
	@echo "Setting up .venv from requirements.txt (once, takes about a minute)"
	$(call install,requirements.txt)
	@touch $@

.venv/.runtime: .venv/.packages
	@$(BIN)/tendond warm
	@touch $@

.venv/.dev: requirements-dev.txt .venv/.packages
	@echo "Adding the test tools to .venv from requirements-dev.txt (once, takes about a minute)"
	$(call install,requirements-dev.txt)
	@touch $@
