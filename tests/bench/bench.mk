# SPDX-License-Identifier: MIT
# Benchmarks, one program each. The tests build them, so that they keep compiling, but do not run them.
BENCHES := $(patsubst %.c,$(BUILD)/%,$(sort $(wildcard tests/bench/*.c)))
BENCH_SCENES := $(patsubst %.c,$(BUILD)/%.o,$(sort $(wildcard tests/bench/scenes/*.c)))
$(BENCH_SCENES): EXTRA := -Itests
$(BUILD)/tests/bench/make_scene: BENCH_OBJ := $(BENCH_SCENES)
$(BUILD)/tests/bench/make_scene: $(BENCH_SCENES)
$(BUILD)/tests/bench/%: tests/bench/%.c $(BUILD)/libservice.a $(BUILD)/librender.a
	@mkdir -p $(@D)
	$(call say,CC ,$<)
	$(Q)$(COMPILE) -Itests $(PKG_CFLAGS) -pthread $(LDFLAGS) -o $@ $< $(BENCH_OBJ) $(BUILD)/libservice.a \
	    $(BUILD)/librender.a $(PKG_LIBS)

# Single rays against meshes, beside Embree where its headers are installed.
.PHONY: bench-trace
EMBREE := $(wildcard /usr/include/embree3/rtcore.h)
$(BUILD)/tests/bench/bench_trace: BENCH_OBJ := $(if $(EMBREE),-DPEN_EMBREE -lembree3)
bench-trace: $(BUILD)/tests/bench/bench_trace
	@mkdir -p $(BUILD)/trace
	@$(BUILD)/tests/bench/bench_trace $(BUILD)/trace/trace.json $(BUILD)/trace/trace.md

# Whole programs by the clock, against POV-Ray where it is installed: tests/bench/README.md has the
# variables. SCENES="NAME…" takes only these.
.PHONY: bench-frames bench-compare bench-growth bench-auto
bench-frames: all $(BENCHES)
	@sh tests/bench/frames.sh $(BUILD)

# Soft shadows beside POV-Ray's adaptive area lights, at equal or lower true error (tests/bench/soft_lights.sh).
.PHONY: bench-povray-soft
bench-povray-soft: all $(BENCHES)
	@sh tests/bench/soft_lights.sh $(BUILD)

# This tree against revision BASE, which is built in a worktree below BUILD.
bench-compare: all $(BENCHES)
	$(if $(BASE),,$(error say BASE=revision))
	@sh tests/bench/compare.sh $(BUILD) $(BASE)

# A chart of how cost grows with primitives, pixels, lights, samples and threads.
bench-growth: all $(BENCHES)
	@sh tests/bench/growth.sh $(BUILD)

# `auto` against the best of the five accelerators.
bench-auto: all $(BENCHES)
	@sh tests/bench/auto.sh $(BUILD)

# The choices of `auto`, beside what its cost model expects (src/accel/auto_choice.c).
.PHONY: bench-choices
bench-choices: all $(BENCHES)
	@sh tests/bench/choices.sh $(BUILD)

# How often benchmarks judge rightly (tests/bench/verdicts.sh): some 20 minutes on an idle host.
.PHONY: bench-verdicts
bench-verdicts: all $(BENCHES)
	@sh tests/bench/verdicts.sh $(BUILD)

# Errors asked for with target_error against errors reached: a table and a chart, some minutes. Fails
# if the promise of src/render/adaptive.h is broken. `accuracy-promise` leaves out the smallest target,
# and goes on with random scenes whose light is small and bright (tests/bench/families.sh).
.PHONY: calibration accuracy-promise
calibration: all $(BENCHES)
	@sh tests/bench/calibration.sh $(BUILD)
accuracy-promise: all $(BENCHES)
	@TARGETS="0.02 0.01 0.005" sh tests/bench/calibration.sh $(BUILD) $(BUILD)/accuracy-promise
	@sh tests/bench/families.sh $(BUILD) $(BUILD)/accuracy-promise/families

# The time left that jobs tell beside what was left (tests/bench/eta.sh): some minutes on an idle host. Fails
# beyond its bar.
.PHONY: eta-promise
eta-promise: all
	@sh tests/bench/eta.sh $(BUILD)

# What a target error costs beside fixed numbers of samples, at equal true error: some 20 minutes.
.PHONY: equal-error
equal-error: all
	@sh tests/bench/equal_error.sh $(BUILD)

# What the presets of `quality` cost, and how their pictures look.
.PHONY: presets
presets: all
	@sh tests/bench/presets.sh $(BUILD)

# How often the bounds of audits hold, against references.
.PHONY: audit-promise
audit-promise: all $(BENCHES)
	@sh tests/bench/audits.sh $(BUILD)

# The table of accelerators and threads, see tests/bench/table.sh: some minutes.
.PHONY: table
table: all
	@sh tests/bench/table.sh $(BUILD)

-include $(BENCH_SCENES:.o=.d)
