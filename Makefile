# pt.h needs no build: include it. This file draws the examples and runs the tests. Everything it makes goes to out/.
CC      ?= cc
CFLAGS  ?= -O2
LDLIBS   = -lm -lpthread
DEMO     = 01_hello 02_glass_and_mirrors 03_instances 05_user_shape 06_sky
PICTURES = 01_hello 02_glass_and_mirrors 03_instances 04_user_bsdf 05_user_shape 06_sky 07_progressive 08_own_threads \
           09_depth_of_field 10_textures 11_materials 12_prism 13_daylight 14_cameras 15_lens_flare 16_motion_blur \
           17_caustic 18_measured 19_media
FIGURES  = sampling figure_mixture figure_nee figure_plates figure_roulette figure_filters figure_many_lights figure_caustic \
           figure_guide figure_media figure_march figure_cloud figure_volumes figure_millions
TOOLS    = render_obj make_assets
STB      = $(if $(wildcard /usr/include/stb/stb_image.h),out/stb_texture)
TESTS    = $(patsubst tests/%.c,out/tests/%.o,$(wildcard tests/test_*.c))
FUZZERS  = $(patsubst tests/fuzz/%.c,out/fuzz/%,$(wildcard tests/fuzz/*.c))
FUZZ_SECONDS ?= 60

.PHONY: help demo test bench figures portable fuzz check clean

help:                             # the default
	@echo 'make demo      build some examples and draw their pictures into out/ (a minute or two)'
	@echo 'make test      build and run the tests; the last line is "N passed, N failed"'
	@echo 'make bench     how fast: two scenes, mesh reading, rays and trees against Embree (QUICK=1: smaller and less exact)'
	@echo 'make figures   the pictures of the README, and how well directions are drawn: tables (hours; SPP=64: minutes)'
	@echo 'make check     the compiler matrix, the symbols an object needs, the tests under sanitizers'
	@echo 'make portable  the same pictures from other compilers, flags and machines: are all bits equal?'
	@echo 'make fuzz      the fuzzers, FUZZ_SECONDS=$(FUZZ_SECONDS) each (needs clang)'
	@echo 'make clean     remove out/'

out/%: examples/%.c pt.h
	@mkdir -p out
	$(CC) $(CFLAGS) $< -o $@ $(LDLIBS)

out/knot.obj: out/make_assets     # and out/sky.hdr
	out/make_assets out

demo:
	@$(MAKE) --no-print-directory -j2 $(DEMO:%=out/%) $(TOOLS:%=out/%) out/knot.obj
	@sh examples/demo.sh out $(DEMO)

out/tests/test_%.o: tests/test_%.c pt.h $(wildcard tests/*.h)
	@mkdir -p out/tests
	$(CC) $(CFLAGS) -I. -c $< -o $@
out/tests/run: $(TESTS)
	$(CC) $(CFLAGS) $(TESTS) -o $@ $(LDLIBS)

test:
	@$(MAKE) --no-print-directory -j2 out/tests/run out/render_obj $(STB)
	@echo 'running the tests: a minute or two'
	@sh tests/run.sh "out/tests/run $$(out/tests/run --list | grep -v '^ ' | awk 'NR % 2' | tr '\n' ' ')" \
	    "out/tests/run $$(out/tests/run --list | grep -v '^ ' | awk 'NR % 2 == 0' | tr '\n' ' ')" 'sh tests/test_examples.sh out'

bench: out/knot.obj
	$(CC) -O2 tests/bench/bench.c -o out/bench $(LDLIBS)
	out/bench
	@sh tests/bench/bench_mesh.sh out
	@sh tests/bench/kernels.sh out --csv out/kernels.csv $(if $(QUICK),--quick) && sh tests/bench/kernels_plot.sh out/kernels.csv out/kernels.png

figures: out/render_obj out/knot.obj
	@sh examples/figures.sh out $(PICTURES)
	@for f in $(FIGURES); do \
	    echo "$$f"; $(CC) -O2 tests/bench/$$f.c -o out/$$f $(LDLIBS) && out/$$f $(if $(SPP),--quick) || exit 1; \
	done

portable:
	@sh tests/portable.sh out/portable

out/fuzz/%: tests/fuzz/%.c pt.h
	@mkdir -p out/fuzz
	clang -g -O1 -fsanitize=fuzzer,address,undefined -fno-sanitize-recover=undefined -I. $< -o $@ $(LDLIBS)
fuzz: $(FUZZERS)
	@for f in $(FUZZERS); do \
	    echo "$$f, $(FUZZ_SECONDS) s"; mkdir -p $$f.corpus; \
	    $$f -max_total_time=$(FUZZ_SECONDS) -timeout=10 -rss_limit_mb=2048 -print_final_stats=0 -verbosity=0 \
	        -artifact_prefix=$$f. $$f.corpus || exit 1; \
	done; echo "no fuzzer found anything"

check:
	@sh tests/check.sh out/check

clean:
	rm -rf out
