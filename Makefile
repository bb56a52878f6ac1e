# The commands of this project. `make demo` and `make test` need a fresh Debian with git, make, a C compiler and Rust.

CARGO ?= cargo
RUN = $(CARGO) run --quiet --locked --
DEMO = sample_maps/crossing_right.osm

.PHONY: help demo gallery rules test browser-test soak fuzz bench movements lint docs wheel dist fittings deps clean

help:
	@echo "make demo   build the program, turn $(DEMO) into a Lanelet2 map, check and draw it"
	@echo "make gallery   pictures of every intersection of the corpus, or of the sample maps, in target/gallery"
	@echo "make test   formatting, lints and all tests (a slice of the long ones)"
	@echo "make browser-test   the tests of the HTML report in Chromium; pictures of them in target/tmp"
	@echo "make rules  write anew what the rules say of their maps, their pictures and their index; then look at git diff"
	@echo "make soak   the long tests whole"
	@echo "make bench  how fast we are: against netconvert and the Lanelet2 library, and road by road (docs/benchmarks.md)"
	@echo "make movements   who may drive where on the corpus, against netconvert (docs/benchmarks.md)"
	@echo "make fuzz   the fuzzers, FUZZ_SECONDS (300) each"
	@echo "make lint   formatting and lints alone"
	@echo "make docs   build the documentation site"
	@echo "make wheel  the Python wheel, command and module, for any Linux of this processor, in dist/"
	@echo "make dist   the program alone as .tar.gz, in dist/"
	@echo "make fittings   check the action, the hooks and the Dockerfile with the tools that read them"
	@echo "make deps   install what the build needs, or say what is missing"

demo: deps
	$(CARGO) build --locked
	$(RUN) build $(DEMO) -o out/demo
	$(RUN) check out/demo
	$(RUN) draw out/demo -o out/demo/picture.svg
	$(RUN) draw out/demo -o out/demo/picture.png
	@echo
	@echo "The map:     $(CURDIR)/out/demo/lanelet2_map.osm"
	@echo "Its picture: $(CURDIR)/out/demo/picture.png (picture.svg to zoom and point at)"

gallery: deps
	$(CARGO) build --locked
	@scripts/gallery.sh

test: deps
	@CARGO="$(CARGO)" scripts/test.sh

rules: deps
	LANEWRIGHT_UPDATE=1 $(CARGO) test --locked --test checking rules

browser-test: deps
	@scripts/browser.sh
	$(CARGO) test --locked --test browser -- --nocapture

soak: deps
	@CARGO="$(CARGO)" LANEWRIGHT_SOAK=1 scripts/test.sh

bench: deps
	@CARGO="$(CARGO)" scripts/bench.sh

movements: deps
	@CARGO="$(CARGO)" scripts/movements.sh

fuzz: deps
	@CARGO="$(CARGO)" scripts/fuzz.sh

lint: deps
	$(CARGO) fmt --all --check
	$(CARGO) clippy --locked --workspace --all-targets -- -D warnings

docs: deps
	@CARGO="$(CARGO)" scripts/docs.sh

wheel:
	@CARGO="$(CARGO)" scripts/release.sh wheel

dist:
	@CARGO="$(CARGO)" scripts/release.sh archive

fittings: deps
	$(CARGO) build --locked
	@ls dist/*.whl >/dev/null 2>&1 || CARGO="$(CARGO)" scripts/release.sh wheel
	@scripts/fittings.sh "$${CARGO_TARGET_DIR:-target}/debug/lanewright" dist/*.whl

deps:
	@scripts/deps.sh

clean:
	rm -rf out
	$(CARGO) clean
