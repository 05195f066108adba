# make demo     sets up, builds, renders the pictures into out/
# make test     sets up, runs the tests
# CARGO_TARGET_DIR and CURVETRI_MESHES are respected if set.

CARGO ?= cargo
OUT ?= out

.PHONY: demo test setup clean
.DEFAULT_GOAL := demo

setup:
	@ci/setup.sh

demo: setup
	$(CARGO) build --release --locked --bin curvetri --bin figure_2
	@CARGO='$(CARGO)' ci/demo.sh '$(OUT)'

test: setup
	$(CARGO) test --locked --workspace

clean:
	$(CARGO) clean
	rm -rf '$(OUT)'
