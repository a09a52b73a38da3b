# SPDX-License-Identifier: GPL-3.0-or-later
# Every target sets up what it needs itself; what is there already is left untouched.

# The first Python of at least 3.11 that runs.
PYTHON ?= $(shell for python in python3 python3.13 python3.12 python3.11 python3.14; do \
	$$python -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo $$python && break; done)
TOOL = $(if $(PYTHON),$(PYTHON) addon/tools,$(error Python 3.11 or newer is needed: none was found on PATH))

.PHONY: help demo docs gallery screenshots extension wheel stubs test format bench bench-gpu clean distclean

help:
	@echo 'make demo        build everything and render the bouncing ball into out/bouncing-ball/'
	@echo 'make gallery     render the pictures of the user guide into out/gallery/; make gallery PAGES=corrections renders'
	@echo '                 some, make gallery PUBLISH=1 puts those that the documentation shows into docs/pictures/'
	@echo 'make screenshots take pictures of the real window into out/gallery/screenshots/'
	@echo 'make extension   build the installable zip dist/isochor-<version>-<platform>.zip'
	@echo 'make test        run every test there is; make test LEGS="rust native" runs some legs of it, and'
	@echo '                 make test LEGS=bpy-3.13 TESTS="tests/blender/test_set_rest.py -k clear" some tests of a leg'
	@echo 'make docs        write the reference of the Python module and the Rust crates into out/docs/'
	@echo 'make bench       measure against the volume paper and against Blender'"'"'s own Lattice modifier'
	@echo 'make bench-gpu   measure on a graphics card, into native/gpu/BENCHMARKS.md'
	@echo 'make wheel       build the Python wheel of the native library into .build/wheels/'
	@echo 'make stubs       write the type stubs of the native library anew'
	@echo 'make format      format the Rust and Python code'
	@echo 'make clean       remove what was built and rendered, keeping Blender and the Python environments'
	@echo 'make distclean   remove everything that is not in git'

gallery:
	@$(TOOL)/run_gallery.py $(if $(PUBLISH),--publish) $(PAGES)

docs:
	@$(TOOL)/build_docs.py

demo:
	@$(TOOL)/run_demo.py

screenshots:
	@$(TOOL)/run_screenshots.py

extension:
	@$(TOOL)/build_extension.py

wheel:
	@$(TOOL)/build_wheel.py

stubs:
	@$(TOOL)/build_stubs.py

test:
	@$(TOOL)/run_tests.py $(if $(LEGS),--only $(LEGS)) $(if $(TESTS),--tests="$(TESTS)")

bench:
	@$(TOOL)/run_benchmarks.py

bench-gpu:
	@$(TOOL)/run_benchmarks.py --gpu

format:
	@$(TOOL)/format_code.py

clean:
	rm -rf dist out target .build/wheels .build/stubs .build/extension .build/extension.stamp .build/blender-user

distclean: clean
	rm -rf .build
