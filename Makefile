# `make demo` and `make test` set up all that they need in .venv.
PYTHON ?= python3
BIN := .venv/bin
READY := .venv/.ready

.PHONY: demo test test-all lint format bench codemirror check-codemirror clean

demo: $(READY)
	$(BIN)/i2p run stories/kitchen/help.story --out out --format png,svg,gif,mp4,html
	@echo
	@echo "The first story is made. Open out/help/page.html in a browser, or look at"
	@echo "out/help/comic.png (the story) and out/help/mind.png (what viewers believe)."

test: $(READY)
	$(BIN)/pytest -n 2 --dist loadfile --no-loadscope-reorder -m "not slow"

# Whole stories on many seeds, long searches, and all examples of tests that draw them by chance.
test-all: $(READY)
	I2PDSL_TESTS=full $(BIN)/pytest -n 2 --dist loadfile --no-loadscope-reorder

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

format: $(READY)
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

bench: $(READY)
	$(BIN)/python benchmarks/kitchen.py
	$(BIN)/python benchmarks/hill.py
	$(BIN)/python benchmarks/new_world.py
	$(BIN)/python benchmarks/peers.py

# The studio's text editor, one committed file: users need no Node, who changes codemirror/ does.
codemirror: codemirror/node_modules
	node codemirror/build.mjs

check-codemirror: codemirror/node_modules
	node codemirror/build.mjs --check

codemirror/node_modules: codemirror/package-lock.json
	cd codemirror && npm ci --no-audit --no-fund
	@touch $@

# pip would compile the packages, and the tests that they bring, on one processor; our own sources
# would be compiled by each of the first processes that need them.
$(READY): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "i2pdsl needs Python 3.11 or newer; try: make PYTHON=python3.12 $(MAKECMDGOALS)")'
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile -c constraints.txt -e '.[dev]'
	@$(BIN)/python -m compileall -qq -j 0 -x 'site-packages/.*/tests?/' .venv/lib i2pdsl
	@touch $(READY)

clean:
	rm -rf .venv codemirror/node_modules out dist build .pytest_cache .ruff_cache .mypy_cache .hypothesis
