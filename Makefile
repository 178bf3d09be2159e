PYTHON ?= /usr/bin/python3
RUFF_VERSION := 0.17.6
COLOUR_SCIENCE_VERSION := 0.4.6

.PHONY: help setup build demo test lint sanitize fuzz sanitized bench-tracer bench-peers bench-walls bench-accuracy compat clean

help: ## Show this list
	@echo "make TARGET, where TARGET is one of"
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/  \1	\2/p' $(MAKEFILE_LIST)

setup: ## Install what this machine lacks (Debian, Ubuntu)
	@tools/setup.sh

build: setup ## Build the native tracer and the native search for nearest points
	@for room in tracer spatial; do \
		echo "build: compiling what has changed in glassworkbench/$$room/native (all of it takes about a minute)"; \
		cmake -S glassworkbench/$$room/native -B build/$$room -DCMAKE_BUILD_TYPE=Release >/dev/null && \
		cmake --build build/$$room --parallel 2 >/dev/null || exit 1; \
	done

demo: build ## Hollow a wine bottle and render it, into out/demo
	@tools/demo.sh

test: build .venv/colour-science-$(COLOUR_SCIENCE_VERSION) ## Run all tests
	@$(PYTHON) -m pytest

lint: setup .venv/ruff-$(RUFF_VERSION) ## Check the style of Python and C++
	@.venv/bin/ruff check
	@.venv/bin/ruff format --check
	@find glassworkbench -name '*.cpp' -o -name '*.h' -o -name '*.hpp' | xargs clang-format --dry-run --Werror

.venv/bin/python:
	@$(PYTHON) -m venv .venv

.venv/ruff-$(RUFF_VERSION): | .venv/bin/python
	@echo "lint: installing ruff $(RUFF_VERSION) into .venv"
	@.venv/bin/python -m pip install --disable-pip-version-check ruff==$(RUFF_VERSION)
	@touch $@

# Without its dependencies: with them comes another numpy than that of FreeCAD's Python.
.venv/colour-science-$(COLOUR_SCIENCE_VERSION): | .venv/bin/python
	@echo "test: installing colour-science $(COLOUR_SCIENCE_VERSION) into .venv"
	@.venv/bin/python -m pip install --disable-pip-version-check --quiet --no-deps --upgrade --target .venv/colour-science \
		colour-science==$(COLOUR_SCIENCE_VERSION) imageio==2.37.0 typing-extensions==4.12.2
	@touch $@

SANITIZED := $(CURDIR)/build/sanitized
# Python itself is not built with the sanitizers: they must be there before it, and it never frees all its memory.
UNDER_SANITIZERS = GLASSWORKBENCH_LIBRARIES=$(SANITIZED)/lib ASAN_OPTIONS=detect_leaks=0 \
	LD_PRELOAD="$$($(CXX) -print-file-name=libasan.so) $$($(CXX) -print-file-name=libubsan.so)"
NATIVE_TESTS := native hard_cases patches physics surfaces render outside

sanitized: setup
	@for room in tracer spatial; do \
		cmake -S glassworkbench/$$room/native -B $(SANITIZED)/$$room -DGLASSWORKBENCH_SANITIZE=ON \
			-DGLASSWORKBENCH_LIBRARIES=$(SANITIZED)/lib >/dev/null && \
		cmake --build $(SANITIZED)/$$room --parallel 2 >/dev/null || exit 1; \
	done

sanitize: sanitized ## Run the tests of the native code under the address and undefined-behaviour sanitizers
	@$(UNDER_SANITIZERS) $(PYTHON) -m pytest -q -p no:cacheprovider -k "not reference and not both_tracers" \
		$(NATIVE_TESTS:%=tests/test_%.py)

fuzz: sanitized ## Trace random scenes under the sanitizers, for FUZZ_SECONDS (600 if not given)
	@$(UNDER_SANITIZERS) $(PYTHON) tests/fuzz.py $(or $(FUZZ_SECONDS),600)

bench-tracer: build ## Measure the tracer: speed beside Embree's, leaks, growth, the certificate, how soon it stops
	@for name in throughput leaks patches growth cancel certificate; do echo "== $$name"; $(PYTHON) benchmarks/$$name.py || exit 1; done

bench-peers: build ## Time to an error on the peers' bottle, beside Mitsuba's (the first run traces the truth, an hour)
	@$(PYTHON) benchmarks/peers.py

bench-walls: build ## Hollow every mold by every wall and method (hours; goes on where it stopped)
	@$(PYTHON) benchmarks/walls.py
	@$(PYTHON) benchmarks/wall_prices.py

bench-accuracy: build ## Prices as predicted and as measured, side by side, on a few scenes
	@$(PYTHON) benchmarks/accuracy.py

compat: build ## Run the tests on FreeCAD 0.20, 1.0 and 1.1, into docs/compat.md
	@$(PYTHON) tools/compat.py

clean: ## Remove what was built
	rm -rf build out .venv .pytest_cache .ruff_cache .hypothesis
	find . -name __pycache__ -prune -exec rm -rf {} +
	find glassworkbench -name '*.so' -delete
