# Everything below works in a fresh clone with Python 3.11 or newer (with venv), make and a C library.
# Another Python than the first one found: make demo PYTHON=/path/to/python3.12

VENV := .venv
BIN := $(VENV)/bin
PYTHON ?=

.DEFAULT_GOAL := help
.PHONY: help demo test check docs docs-pictures format wheel clean

help:
	@echo "make demo    run the ramp scene: a table here, out/ramp.html, out/ramp.png and out/ramp.h5"
	@echo "make test    run every test"
	@echo "make check   formatting, lint, types and the layers of the package"
	@echo "make docs    build the documentation into docs/_build/html"
	@echo "make docs-pictures  take the screenshots in docs/_static anew (needs Chromium)"
	@echo "make format  format the sources and fix what ruff can fix"
	@echo "make wheel   build the wheel into dist/ and list what it carries besides Python"
	@echo "make clean   remove $(VENV) and everything that was built"

# ----------------------------------------------------------------------------------------------------------------------
# The environment. Each stamp says that one set of packages is in; a new pyproject.toml makes the stamps stale.

$(VENV)/.made:
	@for python in $(or $(PYTHON),python3.11 python3); do \
		"$$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1 || continue; \
		found=$$python; \
		"$$python" -c 'import venv, ensurepip' >/dev/null 2>&1 || continue; \
		echo "[1/3] making $(VENV) with $$("$$python" --version) ..."; \
		rm -rf $(VENV) && "$$python" -m venv $(VENV) && touch $@; exit; \
	done; \
	if [ -n "$$found" ]; then \
		echo "stiction needs a Python with venv, but $$found has none: install python3-venv or name another with 'make PYTHON=...'." >&2; \
	else \
		seen=$$($(or $(PYTHON),python3) --version 2>&1) || seen="no Python that runs"; \
		echo "stiction needs Python 3.11 or newer, but $(or $(PYTHON),python3) is $$seen: install one or name it with 'make PYTHON=...'." >&2; \
	fi; exit 1

# Installs the package itself (editable) with extras $(1), and names each package as it arrives.
# pip's exit status goes through a file, because a pipe in sh has only that of its last command.
define install
	@rm -f $(VENV)/.pip-failed; \
	{ $(BIN)/python -m pip install --disable-pip-version-check --no-input -e ".$(1)" || touch $(VENV)/.pip-failed; } \
	| while read -r verb file rest; do \
		if [ "$$verb $$file" = "Using cached" ]; then file=$${rest%% *}; rest=$${rest#* }; fi; \
		case "$$verb $$file" in \
			*.metadata) ;; \
			"Installing collected") echo "      unpacking them ..." ;; \
			*.whl) name=$${file##*/}; name=$${name%%-cp*}; name=$${name%%-py*}; \
				case "$$rest" in "(from"*) rest= ;; esac; echo "      $$name$${rest:+ $$rest}" ;; \
		esac; \
	done; \
	if [ -e $(VENV)/.pip-failed ]; then \
		echo "pip could not install the packages above: see its message, then run make again." >&2; exit 1; \
	fi
endef

$(VENV)/.installed-run: pyproject.toml | $(VENV)/.made
	@echo "[2/3] installing stiction and what it runs on (about 160 MB to download the first time) ..."
	$(call install)
	@touch $@

$(VENV)/.installed-dev: pyproject.toml | $(VENV)/.made
	@echo "[2/3] installing stiction, what it runs on and what it is tested with (about 300 MB to download the first time) ..."
	$(call install,[dev])
	@touch $(VENV)/.installed-run $@

$(VENV)/.installed-docs: pyproject.toml | $(VENV)/.made
	@echo "[2/3] installing stiction, what it runs on and Sphinx (about 180 MB to download the first time) ..."
	$(call install,[docs])
	@touch $(VENV)/.installed-run $@

# ----------------------------------------------------------------------------------------------------------------------
# What to do in it.

demo: $(VENV)/.installed-run
	@echo "[3/3] running the scene 'ramp' (the first run on a machine compiles for a while) ..."
	@mkdir -p out
	@$(BIN)/stiction run ramp --html out/ramp.html --plot out/ramp.png --record out/ramp.h5

test: $(VENV)/.installed-dev
	@echo "[3/3] running the tests on two processes (the first run on a machine compiles for a while) ..."
	@$(BIN)/python -m pytest -n 2

check: $(VENV)/.installed-dev
	@echo "[3/3] checking: format"
	@$(BIN)/ruff format --check .
	@echo "[3/3] checking: lint"
	@$(BIN)/ruff check .
	@echo "[3/3] checking: types"
	@$(BIN)/mypy
	@echo "[3/3] checking: layers"
	@$(BIN)/lint-imports

docs: $(VENV)/.installed-docs
	@echo "[3/3] building the documentation; when the package has changed it runs its examples and draws its figures first ..."
	@$(BIN)/sphinx-build -W --keep-going -d docs/_build/doctrees -b html docs docs/_build/html
	@echo "[3/3] running what the pages show ..."
	@$(BIN)/sphinx-build -W --keep-going -q -d docs/_build/doctrees -b doctest docs docs/_build/doctest
	@echo "The documentation is at docs/_build/html/index.html."

docs-pictures: $(VENV)/.installed-dev
	@echo "[3/3] taking the pictures of the live view ..."
	@$(BIN)/python docs/make_view_picture.py

format: $(VENV)/.installed-dev
	@$(BIN)/ruff check --fix --exit-zero .
	@$(BIN)/ruff format .

wheel: $(VENV)/.made
	@echo "[2/3] building the wheel ..."
	@rm -rf dist
	@$(BIN)/python -m pip wheel --quiet --disable-pip-version-check --no-input --no-deps --wheel-dir dist .
	@echo "[3/3] in the wheel, besides Python:"
	@$(BIN)/python -m zipfile -l dist/*.whl | grep -v -e '\.py ' -e '^File Name'

clean:
	rm -rf $(VENV) out dist build docs/_build docs/gallery docs/sg_execution_times.rst .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis
	find src tests docs examples benchmarks -name __pycache__ -type d -prune -exec rm -rf {} +
