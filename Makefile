# Two doors: `make book` builds and reads, `make test` proves. Both set up what they need.
PROFILE ?= book
SHELL := bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help
MAKEFLAGS += --no-print-directory --no-builtin-rules

BIN := .venv/bin

# recipes read these from their environment: make would paste them into the shell's own words
export F P MACHINES TESTS

PROFILES := ci book paper
ifneq ($(words $(PROFILE))$(filter-out $(PROFILES),$(PROFILE)),1)
$(error Expected PROFILE as one of $(PROFILES), got «$(PROFILE)». Choose one)
endif
# one thread a process: the notebooks share the cores between them
export OMP_NUM_THREADS := 1
export OPENBLAS_NUM_THREADS := 1

CORES ?= $(shell nproc 2>/dev/null || echo 2)
NO_DIGITS := $(CORES)
$(foreach digit,0 1 2 3 4 5 6 7 8 9,$(eval NO_DIGITS := $$(subst $(digit),,$$(NO_DIGITS))))
ifneq ($(words $(CORES))$(NO_DIGITS),1)
$(error Expected CORES as a number, got «$(CORES)». Try CORES=2)
endif
# a killed run leaves Snakemake's own lock behind, but never this one
WAIT := Waiting for another make to end. If none runs, a killed one left its Snakemake: pgrep -af snakemake
ONE_AT_A_TIME := $(if $(shell command -v flock),{ flock -n build/.lock true || echo "$(WAIT)"; } && \
	flock build/.lock )
SNAKEMAKE := $(BIN)/snakemake $(if $(ONE_AT_A_TIME),--nolock) --cores $(CORES) --keep-going \
	--rerun-incomplete --max-checksum-file-size 1000000000 --quiet host reason rules

# what remains of Snakemake's talk: the table of jobs, the steps done, and every error
CHATTER := ^(Assuming |Config file |Building DAG|Using shell|Provided cores|Rules claiming|Select jobs|Execute [0-9])
CHATTER := $(CHATTER)|^(Finished jobid|Elapsed time|Complete log|\[.*20[0-9][0-9]\]$$)

# $(call build,PROFILE,TARGET)
build = mkdir -p build && $(ONE_AT_A_TIME)$(SNAKEMAKE) --config profile=$(1) -- $(2) 2>&1 | \
	{ grep --line-buffered -vE '$(CHATTER)' || true; }

.PHONY: help setup book figure figures pdf test test-slow test-machines test-book fuzz size lab lint pairs reference \
	bench lock clean

help: ## List what can be made
	@echo "make TARGET [PROFILE=ci|book|paper] [CORES=$(CORES)]"; echo
	@sed -nE 's/^([a-z-]+):.*## (.*)/  \1\t\2/p' $(MAKEFILE_LIST) | expand -t 13

setup: ## Make .venv from environment.lock (every target does this first)
	@tools/setup.sh

book: setup ## Run the notebooks and build the book: build/PROFILE/html/index.html
	@$(call build,$(PROFILE))
	@echo "Open build/$(PROFILE)/html/index.html"

figures: book ## Accept the figures and numbers of the build into figures/
	@$(BIN)/python -m cmtof_book.figures build/$(PROFILE)/results figures

# a name that a notebook puts together stands there as its first word and a brace
figure: setup ## Draw a figure with your own parameters: make figure F=fig13 [P="seed=1 repeats=6"]
	@stem=; [[ ! "$$F" =~ ^[a-z0-9_]+$$ ]] || stem=$$({ grep -lE "\"$$F(_|\")" notebooks/*.py; \
		grep -lF "\"$${F%%_*}_{" notebooks/*.py || true; } | sed -n '1s/\.py$$//p'); \
	stem=$${stem#*/}; [ "$$stem" ] || { echo "Expected a figure, got F=$$F. Try F=fig13." >&2; exit 1; }; \
	folder=build/$${P:+own}; [ "$$P" ] || folder+=$(PROFILE); \
	$(call build,$(PROFILE),$$folder/results/$$stem); ls $$folder/results/$$stem/"$$F"*

pdf: book ## Print the whole book to build/PROFILE/book.pdf (Debian: apt-get install chromium)
	@$(BIN)/jupyter-book build build/$(PROFILE)/stage --builder=custom --custom-builder=singlehtml -q \
		--path-output build/$(PROFILE)/print
	@cd build/$(PROFILE)/print/_build/singlehtml && mv book/intro.html whole.html && chromium --headless \
		--no-sandbox --disable-gpu --no-pdf-header-footer --virtual-time-budget=120000 \
		--print-to-pdf="$(CURDIR)/build/$(PROFILE)/book.pdf" "file://$$PWD/whole.html"

test: setup ## Check sizes, build the book with the small ci profile, then run the tests
	@$(BIN)/python -m cmtof_book.size
	@$(call build,ci)
	@$(BIN)/python -m pytest -m "not slow" -n $(CORES)

test-slow: setup ## The long tests: kills at random moments, sweeps over seeds, every page
	@$(BIN)/python -m pytest -m slow

test-machines: setup ## Test the numbers as other processors compute them: make test-machines [MACHINES="oldest zen"]
	@mkdir -p build && $(ONE_AT_A_TIME)tools/machines.sh $$MACHINES

test-book: setup ## Read the built book in a browser without a network
	@$(BIN)/python -m pytest tests/reader

fuzz: setup ## Five thousand hostile inputs for the command line
	@$(BIN)/python tests/hostile/fuzz.py 5000

size: setup ## Volume and density of every part, and what else exceeds its budget
	@$(BIN)/python -m cmtof_book.size

lab: setup ## Open the notebooks in JupyterLab, each as its newer half is
	@$(BIN)/python -m cmtof_book.pairs --newer
	@CMTOF_OUTPUT="$(CURDIR)/build/figures" $(BIN)/jupyter lab --ServerApp.root_dir=. \
		--LabApp.default_url=/lab/tree/notebooks $(if $(filter 0,$(shell id -u)),--allow-root)

lint: setup ## Check style, types, notebook pairs and words
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .
	@$(BIN)/pyright
	@$(BIN)/python -m pytest tests/book/test_tools.py -k pairs
	@! grep -nEf tools/words.txt README.md CONTRIBUTING.md book/*.md notebooks/*.py \
		$$(git ls-files 'src/*.py') || { echo "Words to replace (tools/words.txt)." >&2; exit 1; }

pairs: setup ## Write each .ipynb again from its .py
	@$(BIN)/python -m cmtof_book.pairs

reference: setup ## Store the numbers of the ci profile as the ones that tests compare with
	@$(call build,ci)
	@$(BIN)/python -m cmtof_book.reference

bench: setup ## Time the hot loops against what bounds them
	@$(BIN)/python -m cmtof_book.benchmarks

lock: setup ## Solve for new versions of every package into environment.lock
	@tools/lock.sh --upgrade

clean: ## Remove what was built; .venv and figures stay
	@rm -rf build .snakemake .pytest_cache .ruff_cache
