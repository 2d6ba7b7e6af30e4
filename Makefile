# Two commands: make report, make test. `make help` lists the others.
PYTHON ?= python3
EFFORT ?= full
CORES ?=
PROFILE ?=
TRIALS ?=
SCALE ?=
RECORDED ?=
READINGS ?= open
PORT ?= 8000
ONLY ?= quick
MRCAL_PYTHON ?= python3.12
SITE = report/site$(if $(filter quick,$(EFFORT)),-quick)

# Snakemake's own plugin for Slurm slows each start: only this profile, or a copy of that name, has it.
SLURM_PLUGIN = $(filter slurm-plugin,$(notdir $(PROFILE)))

# Everything a run writes stays in the checkout; only package caches lie outside.
RUN = env PATH=".venv/bin:$$PATH" XDG_CACHE_HOME="$(CURDIR)/.cache" MPLCONFIGDIR="$(CURDIR)/.cache/matplotlib" \
  PYVISTA_USERDATA_PATH="$(CURDIR)/.cache/pyvista" PYTHONDONTWRITEBYTECODE= \
  $(if $(SLURM_PLUGIN),PYTHONPATH="$(CURDIR)/.venv/slurm-plugin:$$PYTHONPATH")
BUILD = $(RUN) .venv/bin/python -m repro.workflow
# A folder's name may hold what make or the shell would take for its own: it is only handed on.
export SETS_OF_REPORT := $(value RECORDED)
FOR_SETS = --recorded "$$SETS_OF_REPORT" --cores "$(CORES)" --profile "$(PROFILE)"
OPTIONS = --effort $(EFFORT) --trials "$(TRIALS)" --scale "$(SCALE)" --readings $(READINGS) $(FOR_SETS)

$(if $(filter quick full,$(EFFORT)),,$(error EFFORT=$(EFFORT): give quick or full))
$(if $(filter open all,$(READINGS)),,$(error READINGS=$(READINGS): give open or all))

.PHONY: report quick test verify test-formats test-cluster test-container costs compare reference recorded notebooks lab answers archive crate pdf bench readme where serve clean help setup ch% appendix_% fig_% table_% alg_% ext_% app_%

report: setup ## the whole report at full size: report/site/index.html
	@$(BUILD) report $(OPTIONS)

test: setup ## unit and property tests, and a quick build with checks on its numbers
	@$(RUN) OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 OPENCV_FOR_THREADS_NUM=1 \
	  .venv/bin/python -m pytest -n auto --dist loadfile --no-loadscope-reorder $(ARGS)

verify: setup ## two builds of quick, interrupted, killed and elsewhere, compared byte for byte (ONLY=ch02: of one chapter)
	@$(RUN) PYTHONPATH="$(CURDIR)" .venv/bin/python -m tests.verify $(ONLY)

test-formats: setup ## exports read by cv2.omnidir and mrcal in environments of their own; writes lib/raxel/formats/TABLE.md
	@$(RUN) PYTHONPATH="$(CURDIR)" .venv/bin/python -m tests.format_table $(MRCAL_PYTHON)

test-cluster: setup ## the quick report on a Slurm of four nodes on this machine, compared with a local build; as root on Debian
	@$(RUN) PYTHONPATH="$(CURDIR)" .venv/bin/python -m tests.cluster.accept --profile "$(or $(PROFILE),slurm)" $(ARGS)

test-container: ## the steps of the Containerfile in a bare Debian, and a chapter of the quick report there; as root on Debian
	@tests/container/chroot.sh

recorded: setup ## writes down the test of each claim, data/published/recorded.yaml; refuses one that was altered without a word in `changed`
	@$(RUN) .venv/bin/python -m repro.run.recorded

quick: override EFFORT = quick
quick: setup ## the whole report with few trials: report/site-quick/index.html
	@$(BUILD) quick $(OPTIONS)

costs: setup ## keep the measured costs of the built report, from which jobs are planned: lib/repro/workflow/costs.csv
	@$(RUN) .venv/bin/python -m repro.workflow.kept_costs --effort $(EFFORT) $(if $(SCALE),--scale $(SCALE))

compare: setup ## what moved since the accepted build, in SD over the trials; a changed verdict fails (EFFORT=quick)
	@$(RUN) .venv/bin/python -m repro.judge.reference compare --effort $(EFFORT)

reference: setup ## accept the built report: writes its verdicts and numbers to data/reference (EFFORT=quick)
	@$(RUN) .venv/bin/python -m repro.judge.reference reference --effort $(EFFORT)

notebooks: setup ## the chapters as notebooks: report/notebooks (EFFORT=quick)
	@$(BUILD) notebooks $(OPTIONS)

# Jupyter's own files stay in the checkout too. Its settings are in lib/repro/jupyter: no
# host is asked for news, and root may start it, as in a container.
LAB = env JUPYTER_CONFIG_PATH="$(CURDIR)/lib/repro/jupyter" JUPYTER_CONFIG_DIR="$(CURDIR)/.cache/jupyter/config" \
  JUPYTER_DATA_DIR="$(CURDIR)/.cache/jupyter/data" JUPYTER_RUNTIME_DIR="$(CURDIR)/.cache/jupyter/runtime" \
  JUPYTERLAB_SETTINGS_DIR="$(CURDIR)/.cache/jupyter/settings" \
  JUPYTERLAB_WORKSPACES_DIR="$(CURDIR)/.cache/jupyter/workspaces" IPYTHONDIR="$(CURDIR)/.cache/ipython"

lab: setup ## the notebooks in JupyterLab, to do the exercises (those of make quick, if there are none)
	@$(PYTHON) lib/repro/bootstrap.py --lab
	@test -e report/notebooks/.done || $(BUILD) notebooks --effort quick $(FOR_SETS)
	@$(RUN) $(LAB) .venv/bin/jupyter lab report/notebooks $(ARGS)

answers: notebooks ## the exercises with their answers, a sheet per lesson, for the lecturer: report/answers (EFFORT=quick)
	@$(RUN) .venv/bin/python -m chapters.guides.for_teachers.exercises --effort $(EFFORT)

archive: setup ## the built report as one file: report/raxel-report-full.zip (EFFORT=quick)
	@test -f $(SITE)/index.html || { echo "no $(SITE) yet: make report (or quick)"; exit 1; }
	@cd report && $(CURDIR)/.venv/bin/python -m zipfile -c raxel-report-$(EFFORT).zip $(notdir $(SITE))

crate: setup ## the built report, brought up to date, as a Workflow Run RO-Crate, validated: report/raxel-crate-full.zip (EFFORT=quick)
	@test -f $(SITE)/index.html || { echo "no $(SITE) yet: make report (or quick)"; exit 1; }
	@$(PYTHON) lib/repro/bootstrap.py --crate
	@$(BUILD) report --effort $(EFFORT) --readings $(READINGS) $(FOR_SETS)
	@$(RUN) PYTHONPATH=lib .venv/crate/bin/python -m repro.site.crate --effort $(EFFORT)

pdf: setup ## the chapters of the built report as one document, by Chromium: report/raxel-report.pdf (EFFORT=quick)
	@$(RUN) .venv/bin/python -m repro.site.book $(SITE) report/raxel-report.pdf

bench: setup ## times of decoder, detectors, CGSP, bundle adjustment and mirror update beside their peers
	@$(PYTHON) lib/repro/bootstrap.py --bench
	@$(RUN) .venv/bin/python -m pytest -q tests/bench/speed.py --benchmark-group-by=group \
	  --benchmark-columns=min,median,rounds

readme: ext_zoo_room fig_3_4 fig_2_3 ## the figures of README.md, from those of the full report
	@$(RUN) .venv/bin/python -m repro.site.readme_figures

# The words after `where` are ids: what they name is looked up and not made.
ifeq ($(firstword $(MAKECMDGOALS)),where)
IDS = $(wordlist 2,$(words $(MAKECMDGOALS)),$(MAKECMDGOALS))
.PHONY: $(subst :,\:,$(IDS))
$(eval $(subst :,\:,$(IDS)):;@:)
endif

where: setup ## where something is made, as file:line: make where table_3_4 (any figure, claim, number, page)
	@$(RUN) .venv/bin/python -m repro.run.where $(foreach id,$(IDS),'$(id)')

serve: ## show the report on a local port (PORT=8000; EFFORT=quick for the quick one)
	@test -f $(SITE)/index.html || { echo "no $(SITE) yet: make report (or quick)"; exit 1; }
	@$(PYTHON) -u -m http.server --bind 127.0.0.1 --directory $(SITE) $(PORT) 2>&1 \
	  | sed -un 's/^OSError: .*Address already in use/port $(PORT) is taken: make serve PORT=8001/p; /HTTP/p'

ch% appendix_%: setup ## one chapter: make ch02, make appendix_a
	@$(BUILD) $@ $(OPTIONS)

fig_% table_% alg_% ext_% app_%: setup ## one artefact: make fig_2_3 (TRIALS=500 for a what-if)
	@$(BUILD) $@ $(OPTIONS)

setup:
	@$(PYTHON) lib/repro/bootstrap.py --rendering $(if $(SLURM_PLUGIN),--slurm-plugin)

clean: ## remove what was built; .venv and the photographs stay
	@rm -rf figures/full figures/quick figures/what-if report/site report/site-*/ report/.cache report/*.zip report/*.pdf \
	  report/build report/notebooks report/answers data/synthetic/*/ data/synthetic/.records .snakemake .pytest_cache .hypothesis .ruff_cache

help: ## this list
	@grep -E '^[a-z_%][a-z_% -]*:.*##' Makefile | sed -E 's/:.*##/\t/' | expand -t 38
