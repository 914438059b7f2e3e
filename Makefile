# The two commands of the README are `make lab` and `make test`; `make` alone says what else there is.
# Everything is installed into .venv; what has to come from the system is asked for in tests/driver/needs.py.

BIN := .venv/bin
DRIVER := $(BIN)/python -m tests.driver

.DEFAULT_GOAL := help
.PHONY: help lab test test-fast check format fuzz bench pictures coverage-of-manuals mutation clean
.DELETE_ON_ERROR:

help: ## say what there is
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-21s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

lab: .venv/installed ## start the lab and stay; Ctrl-C stops it
	@exec $(BIN)/fieldrig up configs/lab.yaml

test: .venv/dev-installed ## all tests; installs what they need where it may, says what was left out
	@$(DRIVER) test

test-fast: .venv/dev-installed ## the checks, and the short tests that need no process, socket or foreign peer
	@$(DRIVER) fast

check: .venv/dev-installed ## format, lint, types, import rule
	@$(DRIVER) check

format: .venv/dev-installed ## format the code, and mend what ruff can mend
	@$(BIN)/ruff format
	@$(BIN)/ruff check --fix

fuzz: .venv/dev-installed ## 200,000 spoilt frames at a CANopen node, a million inputs at all decoders, listeners, files and stores
	@FIELDRIG_FUZZ_FRAMES=200000 FIELDRIG_FUZZ_INPUTS=1000000 $(BIN)/python -m pytest -q tests/fuzz --timeout=7200

bench: .venv/dev-installed ## measure, and write docs/benchmarks.md
	@$(DRIVER) bench

pictures: .venv/dev-installed ## draw the pictures of the docs from running rigs into docs/pictures
	@$(BIN)/python -m tests.pictures

coverage-of-manuals: .venv/dev-installed ## which rows of the manuals the tests show, which not, which are set aside
	@$(BIN)/python -m pytest -q --no-header -m "manual and not vcan and not docker" --manual-rows \
		|| [ $$? = 5 ] # no test is marked

mutation: .venv/dev-installed ## change the code behind a sample of the rows, see their tests fail; writes docs/mutation.md
	@$(BIN)/python -m tests.mutation

clean: ## remove everything that was made here
	rm -rf .venv build dist run .mypy_cache .pytest_cache .ruff_cache .import_linter_cache .hypothesis
	rm -rf tests/real/node/node_modules
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

.venv/installed: pyproject.toml | .venv/bin/pip
	@echo "installing fieldrig into .venv"
	@$(BIN)/pip install --quiet --editable .
	@touch $@

.venv/dev-installed: pyproject.toml | .venv/bin/pip
	@echo "installing fieldrig and its tools into .venv"
	@$(BIN)/pip install --quiet --editable '.[dev]'
	@touch .venv/installed $@

.venv/bin/pip:
	@sh tests/driver/make-venv.sh
