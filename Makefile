# Every target sets up what it needs. SUITE=sid make test: the same on Debian unstable.
.PHONY: help demo test quick oracles paraview sanitize lint site image try-image suite docs-tables tables

RUFF := $(or $(shell command -v ruff),.cache/lint/bin/ruff)

help:
	@echo "make demo    free rocking of the granite block, with pictures and ParaView files"
	@echo "make test    the test suite"
	@echo "make quick   the tests that are neither slow nor run mpirun: some two minutes"
	@echo "make oracles the contract: key numbers of 230 scenes beside closed forms, programs and other engines"
	@echo "make paraview   runs opened in a real ParaView, in an image of its own (tests/in_paraview)"
	@echo "make sanitize   the compiled kernels under the sanitizers of addresses and of undefined behaviour"
	@echo "make lint    ruff, mypy and clang-tidy"
	@echo "make site    the documents as a site: site/index.html"
	@echo "make suite   the paper's platform under 30 synthetic motions, 120 runs, long; goes on where it was stopped"
	@echo "make docs-tables   the tables of docs/output.md and docs/scene.md, from the code"
	@echo "make tables  all tables and pictures anew, hours; ONLY=hertz for one"
	@echo "make image   the container image 'rockslip', by docker, podman or buildah"
	@echo "make try-image   the same, and a demo in it as another user"

demo:
	./in-env python3 demos/free_rocking/free_rocking.py

test:
	./in-env python3 -m pytest tests -n 2 --dist loadfile

quick:
	./in-env python3 -m pytest tests -n 2 --dist loadfile -m "not slow and not mpi" --ignore tests/oracles

# ONLY=stacks: those whose topic or name has it; BESIDE=--beside: the values of today by another engine or step.
oracles:
	./in-env python3 -m tests.oracles $(ONLY) $(BESIDE)

# ParaView has a VTK of its own: the runs are made in the environment, and looked at elsewhere.
paraview:
	rm -rf output/paraview
	./in-env python3 tests/in_paraview/runs.py output/paraview
	ROCKSLIP_TOOL=paraview ./in-env python3 -m pytest --noconftest -p no:cacheprovider tests/in_paraview

sanitize:
	./in-env python3 -m pytest tests/unit/test_kernels.py -k sanitizers

lint: $(RUFF) .cache/lint/kernels
	$(RUFF) check .
	$(RUFF) format --check .
	./in-env python3 -m mypy

# Debian 13 has no ruff: one of our own, on the host, where the package index is reached.
.cache/lint/bin/ruff:
	python3 -m venv .cache/lint
	.cache/lint/bin/pip install --quiet --disable-pip-version-check ruff==0.17.5

# .clang-tidy has the checks. It needs the headers of the environment, where Debian's own would take 180 MB;
# kernels that have not changed since are not looked at again.
.cache/lint/kernels: .cache/lint/clang-tidy .clang-tidy $(wildcard solver/kernels/*.?pp)
	./in-env sh -c '.cache/lint/clang-tidy --quiet solver/kernels/*.cpp -- -std=c++17 $$(solver/kernels/build.sh --headers)'
	touch $@

.cache/lint/clang-tidy:
	python3 -m venv .cache/lint
	.cache/lint/bin/pip install --quiet --disable-pip-version-check clang-tidy==23.1.4
	cd .cache/lint && ln -sf lib/python3*/site-packages/clang_tidy/data/bin/clang-tidy clang-tidy

# On the host, too; a warning is an error, and every link of the result leads somewhere.
site: .cache/site/done
	NO_MKDOCS_2_WARNING=1 .cache/site/bin/mkdocs build --quiet --strict --clean
	python3 docs/check_site.py site

.cache/site/done: docs/requirements.txt
	python3 -m venv --clear .cache/site
	.cache/site/bin/pip install --quiet --disable-pip-version-check -r docs/requirements.txt
	touch $@

image:
	./in-env --image

try-image:
	.ci/image

suite:
	./in-env python3 demos/suite/platform_suite.py

docs-tables:
	./in-env python3 docs/generate_tables.py

tables:
	./in-env python3 -m benchmarks.tables $(ONLY)
