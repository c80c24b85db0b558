# Two commands to start with:  make demo   make test
# Each sets up everything it needs by itself (target venv), and does nothing twice.

PYTHON := .venv/bin/python
INSTALLED := .venv/.installed
export HF_HUB_OFFLINE := 1
export HF_DATASETS_OFFLINE := 1
export TOKENIZERS_PARALLELISM := false
export PYTHONHASHSEED := 0
# Threads that spin while they wait stall a machine that is shared with other work.
export OMP_WAIT_POLICY := passive

.PHONY: venv demo test test-slow gpu-check lint clean distclean

venv: $(INSTALLED)

$(INSTALLED): pyproject.toml scripts/make_venv.sh
	@env -u HF_HUB_OFFLINE bash scripts/make_venv.sh .venv
	@touch $@

demo: venv
	@$(PYTHON) -m hv_scripts.demo

lint: venv
	@.venv/bin/ruff check .
	@.venv/bin/mypy

test: venv
	@.venv/bin/ruff check .
	@.venv/bin/mypy
	@OMP_NUM_THREADS=$${OMP_NUM_THREADS:-2} $(PYTHON) -m pytest -m "not slow"

test-slow: venv
	@OMP_NUM_THREADS=$${OMP_NUM_THREADS:-2} $(PYTHON) -m pytest

gpu-check: venv  # on a machine with an NVIDIA GPU; half an hour; results in outputs/gpu_check
	@$(PYTHON) -m hv_scripts.gpu_check

clean:  # what was built; datasets and trainings in outputs/ are the user's
	rm -rf build .pytest_cache .mypy_cache .ruff_cache *.egg-info
	find . -path ./.venv -prune -o -name __pycache__ -type d -print0 | xargs -0 rm -rf

distclean: clean
	rm -rf .venv
