# The first command of the README is `make lab`; `make` alone lists all targets.
# Everything is installed into .venv; tests/driver/needs.py lists what has to come from the system.

BIN := .venv/bin
DRIVER := $(BIN)/python -m tests.driver

.DEFAULT_GOAL := help
.PHONY: help lab test test-fast check format fuzz tcunit bench docs pictures coverage-of-manuals mutation lock clean
.DELETE_ON_ERROR:

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-21s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

lab: .venv/installed ## start the lab; Ctrl-C stops it
	@exec $(BIN)/fieldrig up configs/lab.yaml

test: .venv/dev-installed ## run all tests; installs missing programs if it may, and lists what was left out
	@$(DRIVER) test

test-fast: .venv/dev-installed ## run the checks and the short tests, which need no process, socket or foreign peer
	@$(DRIVER) fast

check: .venv/dev-installed ## check format, lint, types, prose and the import rule
	@$(DRIVER) check

format: .venv/dev-installed ## format the code, and fix what ruff can fix
	@$(BIN)/ruff format
	@$(BIN)/ruff check --fix

fuzz: .venv/dev-installed ## send 200,000 corrupted frames to a CANopen node, and a million inputs to all decoders, listeners, files and stores
	@FIELDRIG_FUZZ_FRAMES=200000 FIELDRIG_FUZZ_INPUTS=1000000 $(BIN)/python -m pytest -q tests/fuzz --timeout=7200

TCUNIT ?= ../TcUnit
tcunit: .venv/dev-installed ## judge our TcUnit by the verifier of TcUnit; TCUNIT=<its repository>
	@$(BIN)/python -m tests.bench.tcunit_verifier $(TCUNIT)

bench: .venv/dev-installed ## measure, and write docs/developers/benchmarks.md
	@$(DRIVER) bench

docs: .venv/dev-installed ## build the docs as a site, to be read and searched in a browser, into build/docs
	@$(BIN)/python -m tests.site

pictures: .venv/dev-installed ## draw the pictures of the docs from running rigs into docs/pictures
	@$(BIN)/python -m tests.pictures

coverage-of-manuals: .venv/dev-installed ## list which rows of the manuals the tests show, which they do not, and which are set aside
	@$(BIN)/python -m pytest -q --no-header -m "manual and not vcan and not ppp and not docker" --manual-rows \
		|| [ $$? = 5 ] # no test is marked

mutation: .venv/dev-installed ## change the code behind a sample of the rows and check that their tests fail; writes docs/developers/mutation.md
	@$(BIN)/python -m tests.mutation

lock: .venv/bin/pip ## resolve the dependencies of pyproject.toml, and update the lock files and THIRD-PARTY.md
	@$(BIN)/pip install --quiet uv
	@$(BIN)/python tests/driver/lock.py

clean: ## remove everything that make created
	rm -rf .venv build dist run .mypy_cache .pytest_cache .ruff_cache .import_linter_cache .hypothesis
	rm -rf tests/real/node/node_modules
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

.venv/installed: pyproject.toml docker/requirements.lock | .venv/bin/pip
	@$(BIN)/python tests/driver/install.py docker/requirements.lock
	@touch $@

.venv/dev-installed: pyproject.toml tests/requirements.lock | .venv/bin/pip
	@$(BIN)/python tests/driver/install.py tests/requirements.lock
	@touch .venv/installed $@

.venv/bin/pip:
	@sh tests/driver/make-venv.sh
