# Two commands do everything, set-up included:  make demo  and  make test.
# PYTHON picks the interpreter (3.11 or newer), VENV the folder of the environment.
PYTHON ?= python3
VENV ?= .venv
BIN = $(VENV)/bin
PIP = $(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt

.PHONY: demo test test-slow test-all machines check docs site bench bench-quick proofs proofs-quick page wheels clean exports

demo: $(VENV)/installed
	$(BIN)/dehyst reproduce --quick --plant preisach,none --alone braid,lugre,pinched,ageing --compensator paper,best --out demo

test: $(VENV)/installed-test
	$(BIN)/python -m pytest -n auto --dist worksteal -m 'not slow'

# What `make test` leaves out: compilers and emulators, pages, long properties, measured logs, the experiment.
test-slow: $(VENV)/installed-test
	$(BIN)/python -m pytest -n auto --dist worksteal -m 'slow and not exhaustive' --durations 20

# Every case of every test: before a release, and once a week.
test-all: test $(VENV)/installed-test
	$(BIN)/python -m pytest -n auto --dist worksteal -m slow --durations 20

# The numeric part of the tests as on other machines: kernels of BLAS, vector units, threads, time zone, locale, HOME.
machines: $(VENV)/installed-test
	$(BIN)/python tests/support/machines.py

check: $(VENV)/installed-test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/python proofs/run.py --stale

docs: $(VENV)/installed-test
	$(BIN)/python docs/build.py

# The page that fits a log in a browser, as the package ships it; needs npm.
page: $(VENV)/installed-test
	$(PIP) ziglang
	$(BIN)/python packages/dehyst-studio/page/build.py

# The pages as a searchable site that asks no other server for anything: python3 -m http.server --directory site
site: $(VENV)/installed-site
	$(BIN)/python docs/generate/site.py

bench: $(VENV)/installed-bench
	$(BIN)/python benchmarks/startup.py
	$(BIN)/python benchmarks/reading.py
	$(BIN)/python benchmarks/robot.py
	$(BIN)/python benchmarks/step.py --instructions
	$(BIN)/python benchmarks/elements.py --instructions
	$(BIN)/python benchmarks/step.py
	$(BIN)/python benchmarks/elements.py
	$(BIN)/python benchmarks/instructions.py
	$(BIN)/python benchmarks/speed.py
	$(BIN)/python benchmarks/memory.py
	$(BIN)/python benchmarks/target.py

# What does not depend on the machine being quiet: counted instructions, and a quarter of each ratio.
bench-quick: $(VENV)/installed-bench
	$(BIN)/python benchmarks/step.py --instructions
	$(BIN)/python benchmarks/elements.py --instructions
	$(BIN)/python benchmarks/instructions.py
	$(BIN)/python benchmarks/speed.py --quick

# 1 000 random models over 1 000 samples: exported C against the extension, every compiler and level, bit for bit; and
# Structured Text in the own checker.
exports: $(VENV)/installed-bench
	$(BIN)/python benchmarks/exports.py
	$(BIN)/python benchmarks/structured_text.py

# The core under Frama-C, bitwuzla, libFuzzer and others: docs/explanation/proofs.md. Nothing of Python is proved, but the
# models that the proofs are tried on come from the installed kernel.
proofs: $(VENV)/installed $(VENV)/installed-proofs
	$(BIN)/python proofs/run.py --json proofs/results.json

proofs-quick: $(VENV)/installed $(VENV)/installed-proofs
	$(BIN)/python proofs/run.py --quick

# Wheels for x86-64 and ARM64 that need no compiler where they are installed, by zig; each is tried where there is none,
# those for ARM64 if ARM64 names folders with a Python for it (docs/contributing/make-a-release.md).
wheels: $(VENV)/installed-wheels
	$(BIN)/python wheels/make.py $(if $(ARM64),--arm64 $(ARM64))

# Installed again whenever a source file of the package is newer than the installation.
SOURCES = $(shell find packages -type f ! -name '*.pyc' ! -path '*/tests/*' ! -path '*/node_modules/*' ! -path '*/build/*') constraints.txt
PACKAGES = './packages/dehyst[all]' './packages/dehyst-targets[fmi]' './packages/dehyst-robot[gym]' './packages/dehyst-studio[watch]'

$(VENV)/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	    { echo "dehyst needs Python 3.11 or newer; name one: make PYTHON=python3.12"; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || \
	    { echo "this Python has no venv; on Debian: apt-get install python3-venv python3-dev g++"; exit 1; }
	@command -v c++ >/dev/null || { echo "no C++ compiler; on Debian: apt-get install g++ python3-dev"; exit 1; }
	$(PYTHON) -m venv $(VENV)

$(VENV)/installed: $(VENV)/bin/python $(SOURCES)
	$(PIP) ./packages/dehyst ./packages/dehyst-robot
	@touch $@

$(VENV)/installed-test: $(VENV)/bin/python $(SOURCES)
	$(PIP) 'pip>=25.1'
	$(PIP) $(PACKAGES) --group test
	@touch $@ $(VENV)/installed

$(VENV)/installed-bench: $(VENV)/bin/python $(SOURCES)
	$(PIP) 'pip>=25.1'
	$(PIP) $(PACKAGES) --group test --group bench
	@touch $@ $(VENV)/installed $(VENV)/installed-test

$(VENV)/installed-site: $(VENV)/bin/python pyproject.toml constraints.txt
	$(PIP) 'pip>=25.1'
	$(PIP) --group site
	@touch $@

$(VENV)/installed-proofs: $(VENV)/bin/python proofs/requirements.txt proofs/install.sh constraints.txt
	sh proofs/install.sh
	$(PIP) -r proofs/requirements.txt
	@touch $@

$(VENV)/installed-wheels: $(VENV)/bin/python pyproject.toml constraints.txt
	$(PIP) 'pip>=25.1'
	$(PIP) --group wheels
	@touch $@

clean:
	rm -rf $(VENV) packages/*/build demo dist site
