# Two commands do everything on a fresh machine: `make run` and `make test`.
# `make` alone lists the targets.

PYTHON  ?= python3
VENV    ?= .venv
CASE    ?= cases/halfspace.toml
W       ?=
RESULTS ?= results
SEED    ?= 1

JKR     := $(VENV)/bin/jkr
PYTEST  := OPENBLAS_NUM_THREADS=$${OPENBLAS_NUM_THREADS:-1} $(VENV)/bin/python -m pytest -n auto
STUDY   := PYTHONPATH=docs $(VENV)/bin/python -m studies
READY   := $(VENV)/.ready
WHEELS  := build/wheels
PIN     := uv pip compile --universal --python-version 3.11 --generate-hashes --upgrade \
             --no-emit-index-url --no-emit-find-links --no-header
QUOTE    = '$(subst ','\'',$(1))'
# As it stands, with nothing in it carried out; a unit may stand apart from its number.
override W := $(value W)
WORKS    = $(shell printf '%s' $(call QUOTE,$(W)) | sed 's/ *\([^ 0-9.]\)/\1/g')
STEM     = $(shell basename -- $(call QUOTE,$(CASE)) .toml)
CASES   := $(notdir $(basename $(wildcard cases/*.toml)))
SOURCES := $(shell find jkrcli -name '*.py')

.DEFAULT_GOAL := help
.PHONY: help study setup run test test-all core test-minimal test-nanite test-processors wheel fuzz lint docs validation gallery notebooks benchmarks cases bench paper noise noise-study chart chart-peers failures kinds cost bounds point-bounds node-study mesh-study range-bounds stack-bounds record-bounds relaxation-bounds adhesion-bounds speed-bounds relaxing-speeds tension-bounds record-rivals guards golden mutants tuning constants sweep audit clean requirements
.DELETE_ON_ERROR:

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## /{printf "  make %-14s %s\n", $$1, $$2}' $(MAKEFILE_LIST)
	@echo "  variables: CASE=my.toml  W='40 mJ/m^2 50 mJ/m^2'  RESULTS=folder  FULL=no  MEASURED=my.csv  PYTHON=python3.12"

study: ## studies of errors, costs and constants, and upkeep: NAME=bounds runs one, without NAME they are listed
ifdef NAME
	@$(MAKE) --no-print-directory $(call QUOTE,$(NAME))
else
	@awk -F ':.*#: ' '/^[a-z-]+:.*#: /{printf "  make study NAME=%-18s %s\n", $$1, $$2}' $(MAKEFILE_LIST)
	@echo "  variables: SEED=7  RESULTS=folder  AGAINST=commit"
endif

setup: $(READY) ## virtual environment and the system libraries that the mesher needs

$(READY): requirements.txt pyproject.toml .ci/system-libraries
	@sh .ci/system-libraries $(PYTHON)
	@echo "setting up $(VENV): about 100 pinned packages, half a minute to two; pip is silent until it is done"
	@$(PYTHON) -m venv --clear $(VENV)
	@$(VENV)/bin/python -m pip install --quiet --require-hashes -r requirements.txt
	@$(VENV)/bin/python -m pip install --quiet --no-deps --no-build-isolation -e .
	@touch $@

run: $(READY) ## solve and transform CASE (default: the half-space), optionally for the works of adhesion W
	@mkdir -p $(call QUOTE,$(RESULTS))
	$(JKR) run $(call QUOTE,$(CASE)) -o $(call QUOTE,$(RESULTS)/$(STEM).h5)
	$(JKR) transform $(call QUOTE,$(RESULTS)/$(STEM).h5) $(foreach w,$(WORKS),--w $(call QUOTE,$(w))) -o $(call QUOTE,$(RESULTS))
	@echo "look at:"; ls -t $(call QUOTE,$(RESULTS))/$(call QUOTE,$(STEM))-w*.png | head -n $(words $(or $(WORKS),1)) | sed 's/^/  /'

test: $(READY) ## the fast tests
	$(PYTEST) -m "not slow"

test-all: $(READY) ## every test
	$(PYTEST)

core: $(READY) #: the core alone, without its wings: the shipped cases as by the whole, and its tests (six minutes)
	$(STUDY).core

test-processors: $(READY) #: the fast tests of TESTS as other processors compute: MOST settings [default: all that this machine has]
	$(STUDY).processors $(TESTS) $(if $(MOST),--most $(call QUOTE,$(MOST)))

fuzz: $(READY) #: wrong files and random bodies of a SEED that the tests do not try (an hour)
	$(VENV)/bin/python -m pytest -n auto --fuzz-seed $(call QUOTE,$(SEED)) tests/properties/test_fuzz.py tests/properties/test_hostile_files.py tests/studies/test_failures.py

$(WHEELS): requirements.txt | $(READY) # the pinned packages themselves, checked, to install some of them from
	@rm -rf $@ $@.part
	$(VENV)/bin/python -m pip download --quiet --require-hashes -r $< -d $@.part
	@mv $@.part $@

test-minimal: $(READY) $(WHEELS) ## the fast tests with the fewest packages (no optional ones, no finite elements), in an environment of their own
	$(PYTHON) -m venv --clear $(VENV)-minimal
	$(VENV)-minimal/bin/python -m pip install --quiet --no-index --find-links $(WHEELS) -e '.[test]'
	$(VENV)-minimal/bin/python -m pip uninstall --quiet --yes gmsh scikit-fem meshio
	$(VENV)-minimal/bin/python -m pytest -n auto -m "not slow"

test-nanite: $(READY) #: the model of jkr export --nanite in an installed nanite, in an environment of its own
	$(PYTHON) -m venv --clear $(VENV)-nanite
	$(VENV)-nanite/bin/python -m pip install --quiet nanite==4.2.3
	$(VENV)/bin/python -m pytest -rs tests/report/test_nanite.py

wheel: $(READY) $(WHEELS) ## build sdist and wheel into dist, install it into an empty environment and use it from another folder
	$(VENV)/bin/python .ci/wheel.py $(WHEELS)

lint: $(READY) ## style and types
	$(VENV)/bin/ruff check .
	$(VENV)/bin/ruff format --check .
	$(VENV)/bin/mypy

docs: $(READY) ## the documentation as a site, every warning an error: build/docs/index.html; PYODIDE=folder: with jkr in the browser
	$(VENV)/bin/python -m sphinx --quiet --nitpicky --fail-on-warning --keep-going docs build/docs
	@echo "documentation: build/docs/index.html"

validation: $(READY) #: tables against published and independent values: docs/project/validation-tables.md (a minute)
	$(VENV)/bin/python -m docs.validation.validate

gallery: $(READY) #: the pictures of docs/gallery from the commands that stand there
	$(VENV)/bin/python -m docs.gallery.draw

notebooks: $(READY) #: run the notebooks of docs/notebooks and keep what they print and draw
	$(VENV)/bin/python docs/site_parts/notebooks.py

benchmarks: $(READY) #: whole processes of six commands, twenty runs each, into docs/benchmarks/history.csv
	$(VENV)/bin/python -m docs.benchmarks.measure --keep $(if $(AGAINST),--against $(call QUOTE,$(AGAINST)))

cases: $(CASES:%=$(RESULTS)/%.done) ## every shipped case to results

$(RESULTS)/%.h5: cases/%.toml $(READY) $(SOURCES)
	@mkdir -p $(RESULTS)
	$(JKR) run $< -o $@

$(RESULTS)/%.done: $(RESULTS)/%.h5
	$(JKR) transform $< -o $(RESULTS)
	@touch $@

.PRECIOUS: $(RESULTS)/%.h5

bench: $(READY) #: time the stages of a run
	$(JKR) bench $(call QUOTE,$(CASE))

paper: $(READY) ## the paper by its own method: figures 5, 7, 8, 10, its numbers beside ours (two minutes, 5 GiB; FULL=no: one, 1 GiB)
	$(STUDY).paper -o $(RESULTS)/paper $(if $(filter no,$(FULL)),,--full-mesh) $(if $(MEASURED),--measured $(call QUOTE,$(MEASURED)))

noise: $(READY) #: how pull-off errs over noise and rows by every rule for slopes, with the part that fails (five minutes)
	$(STUDY).noise --body hertz -o $(RESULTS)/noise

noise-study: $(READY) #: the same on four bodies, and what is wrong with noise (hours)
	$(STUDY).noise -o $(RESULTS)/noise
	$(STUDY).disturbed

chart: $(READY) ## speed against accuracy on four bodies, other programs in the same run where they are installed (ten minutes)
	@mkdir -p $(RESULTS)/chart
	PYTHONPATH=docs $(VENV)/bin/python docs/peers/run.py --longest 10 -o $(RESULTS)/chart/peers.json \
	  --python $(firstword $(wildcard $(VENV)-peers/bin/python) $(VENV)/bin/python)
	for name in halfspace thin-layer gel coating; do \
	  $(STUDY).chart cases/$$name.toml --repeat 2 --patience 15 --peers docs/peers/timings.json \
	    --peers-now $(RESULTS)/chart/peers.json -o $(RESULTS)/chart || exit 1; done

chart-peers: $(READY) #: run other programs on the same work, in an environment of their own (half an hour; needs ccx)
	$(PYTHON) -m venv --clear $(VENV)-peers
	$(VENV)-peers/bin/python -m pip install --quiet ContactMechanics==1.8.3 tamaas==2.9.0 scikit-fem==12.0.2 scipy
	PYTHONPATH=docs $(VENV)/bin/python docs/peers/run.py --python $(VENV)-peers/bin/python

tuning: $(READY) #: every tuned number halved and doubled: errors and times of reference bodies (half an hour)
	@mkdir -p $(RESULTS)/tuning
	$(STUDY).tuning -o $(RESULTS)/tuning | tee $(RESULTS)/tuning/tuning.txt

constants: $(READY) #: every chosen number halved and doubled: which results move, by how much of their stated errors (an hour)
	@mkdir -p $(RESULTS)/constants
	$(STUDY).constants -o $(RESULTS)/constants | tee $(RESULTS)/constants/constants.txt

failures: $(READY) #: where each method is right, refuses, or errs, told as it goes (an hour)
	$(STUDY).failures -o $(RESULTS)/failures

bounds: $(READY) #: whether stated errors bound the true ones and are near them, on 500 random bodies (half an hour)
	$(STUDY).bounds --seed $(call QUOTE,$(SEED)) -o $(RESULTS)/bounds

point-bounds: $(READY) #: whether stated errors of pull-off points by fem bound the true ones and are near them, on 200 random bodies
	$(STUDY).point_bounds --seed $(call QUOTE,$(SEED)) -o $(RESULTS)/point-bounds

node-study: $(READY) #: whether bands of imported series with contact radii of nodes hold, on 400 drawn series (five minutes)
	PYTHONPATH=docs:tests $(VENV)/bin/python -m studies.nodes -o $(RESULTS)/nodes

mesh-study: $(READY) #: the same on meshes with elements of any sizes, on 600 drawn series (five minutes)
	PYTHONPATH=docs:tests $(VENV)/bin/python -m studies.meshes --seed $(call QUOTE,$(SEED)) -o $(RESULTS)/meshes

guards: $(READY) #: forecasts against costs over all that grows, and how soon too much is refused (ten minutes)
	$(STUDY).guards

record-bounds: $(READY) #: whether 95 % intervals of raw records hold E*, w and w_approach, on 300 made records (ten minutes)
	PYTHONPATH=docs:tests $(VENV)/bin/python -m studies.record_bounds $(call QUOTE,$(SEED)) 300

relaxation-bounds: $(READY) #: whether 95 % intervals of records that relax hold E*, ratio and time, on 1,000 made records (half an hour)
	PYTHONPATH=docs:tests $(VENV)/bin/python -m studies.relaxation_bounds $(call QUOTE,$(SEED)) 1000

adhesion-bounds: $(READY) #: whether 95 % intervals of whole adhesive force curves on relaxing bodies hold w and E*(t), on 120 made records (half an hour)
	PYTHONPATH=docs:tests $(VENV)/bin/python -m studies.adhesion_bounds $(call QUOTE,$(SEED)) 0 120

speed-bounds: $(READY) #: whether 95 % intervals of joint fits of three speeds hold bulk, stress and the law of w, on 20 made triples (an hour)
	PYTHONPATH=docs:tests $(VENV)/bin/python -m studies.speed_bounds $(call QUOTE,$(SEED)) 20

relaxing-speeds: $(READY) #: the three force curves of a relaxing specimen in cases/measured, made again (a quarter of a minute)
	PYTHONPATH=docs:tests $(VENV)/bin/python -m studies.relaxing_speeds cases/measured

tension-bounds: $(READY) #: whether 95 % intervals of E*, surface tension and w from two tip radii hold, on 1,000 made pairs (an hour)
	PYTHONPATH=docs:tests $(VENV)/bin/python -m studies.tension_bounds $(call QUOTE,$(SEED)) 1000

dirt: $(READY) #: what fits make of 24 kinds of dirt in force curves, 20 of each, and of 200 clean ones (fifteen minutes)
	PYTHONPATH=docs:tests $(VENV)/bin/python -m studies.dirt $(call QUOTE,$(SEED)) 20

kinds: $(READY) #: what fits make of force curves of 26 kinds, 20 of each, and of 200 clean ones, on half-spaces and layers (ten minutes)
	$(STUDY).kinds $(call QUOTE,$(SEED)) 20

cost: $(READY) #: what fits of disturbed force curves take, in units of a clean one of as many rows (three minutes)
	OPENBLAS_NUM_THREADS=1 $(STUDY).cost $(call QUOTE,$(SEED))

record-rivals: $(READY) #: whether wrong models of raw records are told and right ones are not accused, on 20 records of each kind (fifteen minutes)
	PYTHONPATH=docs:tests $(VENV)/bin/python -m studies.record_rivals $(call QUOTE,$(SEED)) 20

golden: $(READY) #: what users get of every command, beside that of the commit AGAINST, to the byte (ten minutes a commit)
	$(STUDY).golden --against $(call QUOTE,$(AGAINST))

mutants: $(READY) #: deliberate slips in what is computed, one at a time, which the fast tests must notice (five minutes)
	$(STUDY).mutants

range-bounds: $(READY) #: whether stated errors of adhesion of finite range bound the true ones, on 200 random bodies
	PYTHONPATH=docs:tests $(VENV)/bin/python -m studies.range_bounds --seed $(call QUOTE,$(SEED)) -o $(RESULTS)/range-bounds

stack-bounds: $(READY) #: whether stated errors of method layered hold on 300 stacks whose thicknesses lie up to 1e8 apart (five minutes)
	$(STUDY).stack_bounds --seed $(call QUOTE,$(SEED)) -o $(RESULTS)/stack-bounds

sweep: $(READY) ## a small map over thickness and Poisson's ratio
	$(JKR) sweep cases/sweeps/gel.toml -o $(RESULTS)/sweep-gel

audit: $(READY) #: look the pinned packages up among known vulnerabilities (needs the network)
	$(PYTHON) -m venv --clear $(VENV)-audit
	$(VENV)-audit/bin/python -m pip install --quiet --require-hashes -r .ci/audit.txt
	$(VENV)-audit/bin/pip-audit --strict --require-hashes --disable-pip -r requirements.txt

requirements: #: pin the dependencies, and those of make audit, anew (needs uv)
	$(PIN) pyproject.toml --extra dev -o requirements.txt
	echo pip-audit | $(PIN) - -c requirements.txt -o .ci/audit.txt

clean: ## remove results and caches (the virtual environment stays)
	rm -rf $(RESULTS) build dist *.egg-info .pytest_cache .hypothesis .ruff_cache .mypy_cache
	find jkrcli tests -name __pycache__ -prune -exec rm -rf {} +
