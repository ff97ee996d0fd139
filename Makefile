# Two commands for everyone: `make validate` and `make test`. They need Python 3.11+ with headers, a C11 compiler, make, and
# a package index; no root. Everything goes into .venv and build/; unchanged sources install nothing.
.DELETE_ON_ERROR:
.PHONY: validate test test-all test-elsewhere test-touched test-machines sanitized certify certify-sample nightly mutants fuzz
.PHONY: kernel-lines coverage alarms manual resolution docs lint
.PHONY: develop codes field lock clean help

PYTHON ?= python3
JOBS ?= 2
SEEDS ?= 0:7
PAIRS ?= 2000
BIN := .venv/bin
PIP := $(BIN)/pip --disable-pip-version-check install --quiet
# Nothing is installed of which requirements.lock does not have the digest.
HASHED := $(PIP) --require-hashes --requirement
# What the wheel is made of. Generated Python (caches, kernels built in place) does not count.
SOURCES := pyproject.toml meson.build ci/packaging/list-sources.py README.md LICENSE $(shell find refdem validation -type f \
	-not -path '*/__pycache__/*' -not -name '*.so' -not -name '.*')
# A file that is gone changes the list, and so the wheel.
$(shell mkdir -p build && echo '$(SOURCES)' | cmp -s - build/sources.txt || echo '$(SOURCES)' >build/sources.txt)
# Tests that need more than Python and a compiler: `make test-all` runs these, the longest first.
ELSEWHERE := tests/validation/codes tests/browser tests/foreign/fortran tests/foreign/starters tests/packaging
# Every fault at twenty settings: `make nightly`, and of a change the part that it can touch.
MATRIX := tests/matrix
# Where the time of the tests goes.
TIMES := --durations=25 --durations-min=2

help:
	@echo 'make validate   run every case in the reference, and in the other engines what they can say; write reports/'
	@echo 'make test       all tests that need no root'
	@echo 'make test-all   the others too: browser, sanitizers, packaging, lint'
	@echo 'make test-machines  the tests as on other processors, on a busy machine, in another order'
	@echo 'make nightly    all of that, every fault at every seed, the full campaign, mutants'
	@echo 'make mutants    plant small errors in the code and count those that no test sees'
	@echo 'make kernel-lines  the lines of the kernels that campaign main runs'
	@echo 'make coverage   the lines of Python that the tests run, file by file, the least first'
	@echo 'make alarms     every engine, and PAIRS=2000 of programs that are right, at settings drawn at random'
	@echo 'make fuzz       give refdem inputs that are wrong, MINUTES=10 of them or a fixed number'
	@echo 'make certify    prove the certified truth again where its code changed; killed, it resumes'
	@echo 'make manual     write the verification manual, a page a case, into reports/manual'
	@echo 'make resolution the smallest misreading of every number that campaign main would notice, into reports/resolution.md'
	@echo 'make docs       build the site, tutorial, reference and results in one, into reports/site'
	@echo 'make codes      DEM codes that the gates in validation/codes run, in .venv-codes'
	@echo 'make field      widely used codes, each in .venv-field, under their gates; CODES=name for some; reports/field'
	@echo 'make lint       ruff, clang-format, mypy, import-linter, codespell'
	@echo 'make develop    build the kernels beside their sources and run from the tree'
	@echo 'make lock       pin the newest versions in requirements.lock, with the digests of their files'

validate: .venv/refdem
	$(BIN)/refdem run --campaign main --out reports

test: .venv/refdem .venv/for-tests
	$(BIN)/pytest tests validation -n $(JOBS) $(TIMES) $(ELSEWHERE:%=--ignore=%) --ignore=$(MATRIX)

test-all: lint docs sanitized certify-sample test-elsewhere test-touched

sanitized: .venv/refdem .venv/for-all
	ci/testing/sanitized $(BIN)/python $(JOBS)

certify-sample: .venv/refdem
	$(BIN)/refdem certify --check --jobs $(JOBS)

test-elsewhere: .venv/refdem .venv/for-all codes
	$(BIN)/pytest $(ELSEWHERE) -n $(JOBS) $(TIMES) --dist loadfile

test-touched: .venv/refdem .venv/for-tests
	faults=$$($(BIN)/python ci/testing/touched_faults.py) && \
	if [ -n "$$faults" ]; then REFDEM_FAULTS="$$faults" $(BIN)/pytest $(MATRIX) -n $(JOBS) $(TIMES) --dist loadfile; \
	else echo 'no fault of the matrix can be touched by this change'; fi

test-machines: .venv/refdem .venv/for-tests
	PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/python ci/testing/test_machines.py --jobs $(JOBS)

nightly: test test-all
	$(BIN)/pytest $(MATRIX) -n $(JOBS) $(TIMES) --dist loadfile
	REFDEM_RANDOM_SETTINGS=20 $(BIN)/pytest tests/documents/test_printed_commands.py -n $(JOBS) $(TIMES)
	$(BIN)/refdem run --campaign full --out build/nightly
	$(MAKE) test-machines
	$(MAKE) kernel-lines
	$(MAKE) coverage
	$(MAKE) alarms
	$(MAKE) fuzz MINUTES=60
	$(MAKE) mutants
	$(MAKE) field

mutants: .venv/refdem .venv/for-mutants
	PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/python ci/mutants/mutants.py --jobs $(JOBS)

kernel-lines: .venv/refdem .venv/for-mutants
	PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/python ci/mutants/kernel_lines.py

# By itself and at night: counting lines slows the tests down by more than a tenth.
coverage: .venv/refdem .venv/for-mutants
	rm -rf build/coverage && mkdir -p build/coverage
	$(BIN)/coverage run -m pytest tests validation -n $(JOBS) $(ELSEWHERE:%=--ignore=%) --ignore=$(MATRIX)
	$(BIN)/coverage combine --quiet
	$(BIN)/coverage report

# Every engine at settings drawn up to threefold from the defaults; `make alarms SEEDS=8:15` draws others.
# Then programs that are right at settings drawn over the whole range; `make alarms PAIRS=20000` for a night.
alarms: .venv/refdem .venv/for-tests
	REFDEM_SEEDS=$(SEEDS) $(BIN)/pytest tests/properties/test_every_row.py -k drawn -n $(JOBS) $(TIMES)
	$(BIN)/python ci/fuzz/alarms.py --pairs $(PAIRS)

# Inputs that are wrong: `make fuzz MINUTES=10` for so long from the seed of the day, and what it learns goes
# into tests/corpus; without MINUTES the same so many every time, as in CI.
fuzz: .venv/refdem .venv/for-tests
	$(BIN)/python ci/fuzz/fuzz.py $(if $(MINUTES),--minutes $(MINUTES) --grow,--inputs 15000 --seed 1)

certify: .venv/refdem
	$(BIN)/refdem certify --folder validation/truth --jobs $(JOBS)

manual: .venv/refdem
	$(BIN)/refdem manual reports

# The smallest misreading of every number of every scene that each method would notice: 10 minutes.
resolution: .venv/refdem
	$(BIN)/refdem resolution --campaign main --out reports

# Without the sources beside it, so that Sphinx reads the refdem that is installed.
docs: .venv/refdem .venv/for-docs
	$(BIN)/python -P -m sphinx --quiet --fail-on-warning --keep-going --nitpicky \
		--conf-dir docs --doctree-dir build/site . reports/site

codes: .venv-codes/made

# At night: an environment of its own for each code, and a gate each.
field: .venv/refdem
	$(BIN)/python ci/field/field.py $(CODES)

lint: .venv/for-all
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/clang-format --dry-run --Werror $$(git ls-files '*.c' '*.h')
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/codespell $$(git ls-files '*.md' '*.ipynb')
	$(BIN)/python ci/develop/density.py

develop: .venv/for-all
	ci/develop/build-in-place $(BIN)/python
	$(BIN)/pip --disable-pip-version-check uninstall --quiet --yes refdem
	rm -f .venv/refdem
	ci/develop/run-from-tree $(BIN)/python

lock:
	ci/packaging/lock $(PYTHON) --upgrade

clean:
	rm -rf .venv .venv-codes .venv-field build dist

# Stamps: each says that its step was done with the files it depends on.
.venv/made:
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "refdem needs Python 3.11 or newer; set PYTHON=...")'
	$(PYTHON) -m venv .venv
	touch $@

.venv/for-runs: .venv/made pyproject.toml requirements.lock ci/packaging/dependencies.py $(wildcard refdem/engines/*/requirements.in)
	$(BIN)/python ci/packaging/dependencies.py --locked engines >.venv/wanted.txt
	$(HASHED) .venv/wanted.txt
	touch $@

.venv/for-tests: .venv/for-runs
	$(BIN)/python ci/packaging/dependencies.py --locked test bench distributed >.venv/wanted.txt
	$(HASHED) .venv/wanted.txt
	touch $@

.venv/for-all: .venv/for-tests
	$(BIN)/python ci/packaging/dependencies.py --locked browser lint >.venv/wanted.txt
	$(HASHED) .venv/wanted.txt
	touch $@

.venv/for-docs: .venv/for-all
	$(BIN)/python ci/packaging/dependencies.py --locked docs >.venv/wanted.txt
	$(HASHED) .venv/wanted.txt
	touch $@

.venv/for-mutants: .venv/for-all
	$(BIN)/python ci/packaging/dependencies.py --locked mutants >.venv/wanted.txt
	$(HASHED) .venv/wanted.txt
	touch $@

# DEM codes have an environment of their own, so that nothing of theirs comes into refdem's.
.venv-codes/made: validation/codes/requirements.txt
	rm -rf .venv-codes
	$(PYTHON) -m venv .venv-codes
	.venv-codes/bin/pip --disable-pip-version-check install --quiet --require-hashes --requirement $<
	touch $@

# Built in a folder as deep as that of ci/develop/build-in-place, ccache finds there what was compiled here, and the other way round.
.venv/refdem: .venv/for-runs build/sources.txt $(SOURCES)
	rm -rf build/wheel
	PATH="$(CURDIR)/$(BIN):$$PATH" $(PIP) --no-deps --no-build-isolation --force-reinstall -Cbuild-dir=build/wheel .
	touch $@
