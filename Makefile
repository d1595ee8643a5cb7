# SPDX-License-Identifier: MIT
# Builds Penumbra: build/penumbrad, build/penumbra, build/libpenumbra.a, build/libpenumbra.so.
# Results depend on the flags in PIXEL_FLAGS: no contraction, no fast-math, on every file.
# Files named *_isa.c are compiled once for each instruction set; those objects are entered only after a
# cpuid check.

BUILD ?= build
PREFIX ?= /usr/local
DESTDIR ?=
OPT ?= -O2 -g
# Optimisation of the rooms that compute pixels, where a build with sanitizers spends most of its time.
PIXEL_OPT ?=
SAN ?=
WERROR ?=
# V=1 shows whole commands; JOBS is how many run at once in check and demo.
V ?=
JOBS ?= $(shell nproc)
ifeq ($(V),)
Q := @
say = @echo "  $(1) $(2)";
endif
ifeq ($(origin CC),default)
CC := gcc
endif

VERSION := 0.1.0
VERSION_DATE := 2026-11-22
RENDER_ROOMS := base math geom accel scene shade film render io embed
SERVICE_ROOMS := study store jobs http
# A room's files: those in its folder and in folders of that.
room_files = $(sort $(wildcard src/$(1)/*.c src/$(1)/*/*.c))

WARN := -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wstrict-prototypes -Wmissing-prototypes -Wvla \
    -Wswitch-enum $(WERROR)
PIXEL_FLAGS := -std=c11 -ffp-contract=off -fno-math-errno
HARDEN := -fstack-protector-strong -fno-omit-frame-pointer
# All kernels of a build with sanitizers are one (src/shade/internal/surface.h).
SHARED_KERNELS ?= $(if $(SAN),-DPEN_SHARED_KERNELS)
CPP := -D_GNU_SOURCE -DPEN_VERSION='"$(VERSION)"' -Isrc -Iinclude $(SHARED_KERNELS) $(CPPFLAGS)
COMPILE = $(CC) $(CPP) $(OPT) $(ROOM_OPT) $(WARN) $(HARDEN) $(SAN) $(CFLAGS) $(PIXEL_FLAGS)
# The build id is in the reports of benchmarks (src/study/host.c).
LINK = $(CC) $(SAN) -pthread -Wl,--build-id=sha1 $(LDFLAGS)

PKGS := jansson expat libpng zlib sqlite3 libzstd libsodium libcurl
PKG_CFLAGS := $(shell pkg-config --cflags $(PKGS) 2>/dev/null)
# libcurl is loaded by the commands that need it, see src/cmd/client/curl_library.h.
PKG_LIBS := $(shell pkg-config --libs $(filter-out libcurl,$(PKGS)) 2>/dev/null) -lm
LIBRARY_PKGS := jansson expat libpng
LIBRARY_LIBS := $(shell pkg-config --libs $(LIBRARY_PKGS) 2>/dev/null) -lm
CHECK_CFLAGS := $(shell pkg-config --cflags check 2>/dev/null)
CHECK_LIBS := -Wl,--wrap=_mark_point $(shell pkg-config --libs check 2>/dev/null)

MACHINE := $(shell $(CC) -dumpmachine 2>/dev/null)
ifneq ($(findstring x86_64,$(MACHINE)),)
AVX2_FLAGS := -mavx2 -mfma
AVX512_FLAGS := $(AVX2_FLAGS) -mavx512f -mavx512vl -mavx512bw -mavx512dq
endif
# The instruction sets of PEN_ISA_LIST and the flags of each.
ISAS := $(shell sed -n 's/^ *X.[A-Z0-9]*, \([a-z0-9]*\),.*/\1/p' src/base/cpu.h)
ISA_FLAGS_avx2 := $(AVX2_FLAGS)
ISA_FLAGS_avx512 := $(AVX512_FLAGS)

# libpenumbra, for other programs. A sanitizer's runtime belongs to a program, so those builds make no
# shared library.
SONAME := libpenumbra.so.0
SHARED := $(BUILD)/libpenumbra.so.$(VERSION)
LIBRARIES := $(BUILD)/libpenumbra.a $(if $(SAN),,$(SHARED))
# Only builds that can be installed have man pages and completion for shells.
MAN_NAMES := penumbra.1 penumbra.3 penumbra-scene.5 penumbrad.8
MAN_PAGES := $(if $(SAN),,$(MAN_NAMES:%=$(BUILD)/man/%))
COMPLETION := $(if $(SAN),,$(BUILD)/completion/penumbra.bash $(BUILD)/completion/penumbra.zsh)

LIB_SRC := $(foreach r,$(RENDER_ROOMS),$(call room_files,$(r)))
SVC_SRC := $(foreach r,$(SERVICE_ROOMS),$(call room_files,$(r)))
ISA_SRC := $(filter %_isa.c,$(LIB_SRC))
ISA_OBJ := $(foreach isa,$(ISAS),$(ISA_SRC:%.c=$(BUILD)/%_$(isa).o))
LIB_OBJ := $(patsubst %.c,$(BUILD)/%.o,$(filter-out $(ISA_SRC),$(LIB_SRC))) $(ISA_OBJ) $(BUILD)/gen/builtin_scenes.o
SVC_OBJ := $(SVC_SRC:%.c=$(BUILD)/%.o) $(BUILD)/gen/api_files.o
CMD_COMMON := $(sort $(wildcard src/cmd/*.c))
CMD_OBJ := $(CMD_COMMON:%.c=$(BUILD)/%.o)
CLIENT_OBJ := $(patsubst %.c,$(BUILD)/%.o,$(sort $(wildcard src/cmd/client/*.c)))
DAEMON_OBJ := $(patsubst %.c,$(BUILD)/%.o,$(sort $(wildcard src/cmd/daemon/*.c)))
TEST_SRC := $(sort $(wildcard tests/*/test_*.c))
TEST_BIN := $(TEST_SRC:%.c=$(BUILD)/%)
TEST_SUPPORT := $(sort $(wildcard tests/support/*.c))
TEST_ISA_SRC := $(filter %_isa.c,$(TEST_SUPPORT))
TEST_ISA_OBJ := $(foreach isa,$(ISAS),$(TEST_ISA_SRC:%.c=$(BUILD)/%_$(isa).o))
TEST_SUPPORT_OBJ := $(patsubst %.c,$(BUILD)/%.o,$(filter-out $(TEST_ISA_SRC),$(TEST_SUPPORT))) $(TEST_ISA_OBJ)
TEST_SUPPORT_LIB := $(BUILD)/tests/libsupport.a

.PHONY: asan-build have-deps all golden tests check run-tests demo lint asan tsan clean install conformance
all: have-deps $(BUILD)/penumbrad $(BUILD)/penumbra $(LIBRARIES) $(MAN_PAGES) $(COMPLETION)
.PHONY: librender
librender: $(BUILD)/librender.a
CRASH_TEST := $(BUILD)/tests/crash/crash
STABILITY := $(BUILD)/tests/property/stability
FILMS := $(BUILD)/tests/property/films
INSTRUCTIONS := $(BUILD)/tests/effects/instructions
FAULTS := $(BUILD)/tests/faults/preload.so
FUZZ_NAMES := $(patsubst tests/fuzz/fuzz_%.c,%,$(sort $(wildcard tests/fuzz/fuzz_*.c)))
REPLAYS := $(FUZZ_NAMES:%=$(BUILD)/tests/fuzz/replay_%)
BENCHES := $(patsubst %.c,$(BUILD)/%,$(sort $(wildcard tests/bench/*.c)))
LOAD := $(BUILD)/tests/load/load
tests: all $(TEST_BIN) $(CRASH_TEST) $(FAULTS) $(LOAD) $(STABILITY) $(FILMS) $(INSTRUCTIONS) $(BENCHES) $(REPLAYS)

have-deps:
	@pkg-config --exists $(PKGS) || { \
	    echo "libraries are missing (wanted: $(PKGS)): run sh deploy/install-deps.sh" >&2; exit 1; }

# Objects of the renderer serve the programs and both libraries. Only what penumbra.h declares is
# visible outside libpenumbra.
$(LIB_OBJ): LIB_FLAGS := -fPIC -fvisibility=hidden

# For programs and tests of this tree: every symbol of the rooms.
$(BUILD)/librender.a: $(LIB_OBJ)
	@rm -f $@
	$(call say,AR ,$@)
	$(Q)ar rcs $@ $(LIB_OBJ)

# For others: one object whose internal symbols are local, so that they clash with nobody's.
$(BUILD)/libpenumbra.a: $(LIB_OBJ)
	@rm -f $@
	$(call say,AR ,$@)
	$(Q)ld -r -o $(BUILD)/libpenumbra.o $(LIB_OBJ)
	$(Q)objcopy --localize-hidden $(BUILD)/libpenumbra.o
	$(Q)ar rcs $@ $(BUILD)/libpenumbra.o

$(SHARED): $(LIB_OBJ)
	$(call say,LD ,$@)
	$(Q)$(LINK) -shared -Wl,-soname,$(SONAME) -Wl,-z,defs -o $@ $(LIB_OBJ) $(LIBRARY_LIBS)
	$(Q)ln -sf $(@F) $(BUILD)/$(SONAME) && ln -sf $(SONAME) $(BUILD)/libpenumbra.so

$(BUILD)/libservice.a: $(SVC_OBJ)
	@rm -f $@
	$(call say,AR ,$@)
	$(Q)ar rcs $@ $(SVC_OBJ)

PROGRAM_LIBS := $(BUILD)/libservice.a $(BUILD)/librender.a
$(BUILD)/penumbra: $(CLIENT_OBJ) $(CMD_OBJ) $(PROGRAM_LIBS)
$(BUILD)/penumbrad: $(DAEMON_OBJ) $(CMD_OBJ) $(PROGRAM_LIBS)
$(BUILD)/penumbra $(BUILD)/penumbrad:
	$(call say,LD ,$@)
	$(Q)$(LINK) -o $@ $^ $(PKG_LIBS)

# Man pages contain what --help prints, the comments of penumbra.h, and the page on scenes.
$(MAN_PAGES): $(BUILD)/man/%: deploy/man/%.in $(wildcard deploy/man/*.awk) deploy/man/make.sh Makefile \
    include/penumbra.h api/scene-format.md $(BUILD)/penumbra $(BUILD)/penumbrad
	@mkdir -p $(@D)
	$(call say,MAN,$@)
	$(Q)sh deploy/man/make.sh $(BUILD) $(VERSION) $(VERSION_DATE) $< > $@.tmp && mv $@.tmp $@

# Completion knows the options and values that the programs themselves print.
$(BUILD)/completion/table: deploy/completion/table.sh $(BUILD)/penumbra $(BUILD)/penumbrad
	@mkdir -p $(@D)
	$(Q)sh deploy/completion/table.sh $(BUILD) > $@.tmp && mv $@.tmp $@
$(COMPLETION): $(BUILD)/completion/penumbra.%: deploy/completion/penumbra.% deploy/completion/make.sh $(BUILD)/completion/table
	$(call say,GEN,$@)
	$(Q)sh deploy/completion/make.sh $(BUILD)/completion/table $< > $@.tmp && mv $@.tmp $@

$(foreach r,math geom accel shade film,$(eval $$(BUILD)/src/$(r)/%.o: ROOM_OPT := $$(PIXEL_OPT)))
# Loops over bytes of pixels, which the compiler vectorises at -O3.
$(BUILD)/src/store/pixels.o: EXTRA := -O3
define compile_object
@mkdir -p $(@D)
$(call say,CC ,$<)
$(Q)$(COMPILE) $(PKG_CFLAGS) $(LIB_FLAGS) $(EXTRA) -MMD -MP -c -o $@ $<
endef
$(BUILD)/%.o: %.c Makefile
	$(compile_object)
# Hot code of many small functions, whose arrays have fixed sizes: no stack protector, no frame pointer.
define isa_rules
$(ISA_SRC:%.c=$(BUILD)/%_$(1).o): HARDEN := $(if $(SAN),-fno-omit-frame-pointer,-fomit-frame-pointer)
$(ISA_SRC:%.c=$(BUILD)/%_$(1).o): EXTRA := $(ISA_FLAGS_$(1)) -DPEN_ISA=$(1)
$(ISA_SRC:%.c=$(BUILD)/%_$(1).o): $(BUILD)/%_$(1).o: %.c Makefile
	$$(compile_object)
$(TEST_ISA_SRC:%.c=$(BUILD)/%_$(1).o): EXTRA := $(ISA_FLAGS_$(1)) -DPEN_ISA=$(1) -Itests
$(TEST_ISA_SRC:%.c=$(BUILD)/%_$(1).o): $(BUILD)/%_$(1).o: %.c Makefile
	$$(compile_object)
endef
$(foreach isa,$(ISAS),$(eval $(call isa_rules,$(isa))))

# Files that are compiled into the programs: scenes/*.json and api/*.
$(BUILD)/gen/builtin_scenes.c: $(sort $(wildcard scenes/*.json)) deploy/embed.sh
	@mkdir -p $(@D)
	$(Q)sh deploy/embed.sh --stem pen_builtin_files $(sort $(wildcard scenes/*.json)) > $@.tmp && mv $@.tmp $@
$(BUILD)/gen/api_files.c: $(sort $(wildcard api/*.yaml api/*.json)) deploy/embed.sh
	@mkdir -p $(@D)
	$(Q)sh deploy/embed.sh pen_api_files $(sort $(wildcard api/*.yaml api/*.json)) > $@.tmp && mv $@.tmp $@
$(BUILD)/gen/%.o: $(BUILD)/gen/%.c Makefile
	$(Q)$(COMPILE) $(LIB_FLAGS) -c -o $@ $<

$(BUILD)/tests/support/%.o: EXTRA := $(CHECK_CFLAGS) -Itests
# A library, so that a test links only the members that it uses.
$(TEST_SUPPORT_LIB): $(TEST_SUPPORT_OBJ)
	@rm -f $@
	$(call say,AR ,$@)
	$(Q)ar rcs $@ $^
$(TEST_BIN): $(BUILD)/tests/%: tests/%.c $(TEST_SUPPORT_LIB) $(BUILD)/libservice.a $(BUILD)/librender.a
	@mkdir -p $(@D)
	$(call say,CC ,$<)
	$(Q)$(COMPILE) -Itests $(CHECK_CFLAGS) $(PKG_CFLAGS) -MMD -MP -pthread $(LDFLAGS) -o $@ $< \
	    $(TEST_FIRST) $(TEST_SUPPORT_LIB) $(BUILD)/libservice.a $(BUILD)/librender.a $(CHECK_LIBS) $(PKG_LIBS) $(TEST_LIBS)
$(BUILD)/tests/math/%: TEST_LIBS := -lquadmath

# The fuzz targets with a main of their own, which replays kept inputs.
$(REPLAYS): $(BUILD)/tests/fuzz/replay_%: tests/fuzz/fuzz_%.c tests/fuzz/replay.c $(wildcard tests/fuzz/*.h) \
    $(BUILD)/libservice.a $(BUILD)/librender.a
	@mkdir -p $(@D)
	$(call say,CC ,$<)
	$(Q)$(COMPILE) -Itests $(PKG_CFLAGS) -pthread $(LDFLAGS) -o $@ $< tests/fuzz/replay.c \
	    $(BUILD)/libservice.a $(BUILD)/librender.a $(PKG_LIBS)

# Proofs that a scene pays for its own effects alone (src/shade/README.md). The kernels that are
# stripped by hand are compiled as those of kernel_isa.c for AVX2.
STRIPPED_OBJ := $(patsubst %.c,$(BUILD)/%.o,$(sort $(wildcard tests/effects/stripped/*.c)))
$(STRIPPED_OBJ): HARDEN := $(if $(SAN),-fno-omit-frame-pointer,-fomit-frame-pointer)
$(STRIPPED_OBJ): LIB_FLAGS := -fPIC -fvisibility=hidden
$(STRIPPED_OBJ): ROOM_OPT := $(PIXEL_OPT)
$(STRIPPED_OBJ): EXTRA := $(ISA_FLAGS_avx2) -DPEN_ISA=avx2 -Itests
$(INSTRUCTIONS).o: EXTRA := $(CHECK_CFLAGS) -Itests
$(INSTRUCTIONS): $(INSTRUCTIONS).o $(STRIPPED_OBJ) $(TEST_SUPPORT_LIB) $(BUILD)/librender.a
	$(call say,LD ,$@)
	$(Q)$(LINK) -o $@ $^ $(CHECK_LIBS) $(PKG_LIBS)
.PHONY: effects-proof
effects-proof: $(INSTRUCTIONS) $(filter $(BUILD)/tests/effects/% $(BUILD)/tests/scene/test_effects,$(TEST_BIN))
	@nice -n 10 sh tests/effects/proof.sh $(BUILD) "$(ISAS)"

# The stability suite: rows of properties, their oracles, the program that runs them in parallel and
# writes the report. The oracles need 128-bit floats, so gcc compiles them in a build with clang.
PROPERTY_SRC := $(filter-out tests/property/test_%.c %/stability.c %/standalone.c %/main_films.c,$(sort $(wildcard tests/property/*.c)))
PROPERTY_OBJ := $(PROPERTY_SRC:%.c=$(BUILD)/%.o)
PROPERTY_LIB := $(BUILD)/tests/libproperty.a
STABILITY_OBJ := $(BUILD)/tests/property/stability.o $(BUILD)/tests/property/standalone.o
MPFR_LIBS := $(shell pkg-config --libs mpfr 2>/dev/null)
ORACLE_CC := $(if $(shell command -v gcc 2>/dev/null),gcc,$(CC))
$(BUILD)/tests/property/%.o: EXTRA := $(CHECK_CFLAGS) -Itests
$(BUILD)/tests/property/%_avx2.o: EXTRA := $(CHECK_CFLAGS) -Itests $(AVX2_FLAGS)
$(BUILD)/tests/property/oracle_%.o: private CC := $(ORACLE_CC)
$(BUILD)/tests/property/oracle_%.o: private SAN :=
$(BUILD)/tests/property/oracle_%.o: EXTRA := $(if $(MPFR_LIBS),-DHAVE_MPFR) -Itests
$(PROPERTY_LIB): $(PROPERTY_OBJ)
	@rm -f $@
	$(call say,AR ,$@)
	$(Q)ar rcs $@ $^
PROPERTY_TEST := $(filter $(BUILD)/tests/property/%,$(TEST_BIN))
$(PROPERTY_TEST): $(PROPERTY_LIB)
$(PROPERTY_TEST): TEST_FIRST := $(PROPERTY_LIB)
$(PROPERTY_TEST): TEST_LIBS := $(MPFR_LIBS)
$(STABILITY): $(STABILITY_OBJ) $(PROPERTY_LIB) $(TEST_SUPPORT_LIB) $(BUILD)/librender.a
	$(call say,LD ,$@)
	$(Q)$(LINK) -o $@ $^ $(PKG_LIBS) $(MPFR_LIBS)

# The golden films alone, quickly built: for comparing builds.
$(FILMS): $(FILMS:%/films=%/main_films.o) $(FILMS).o $(BUILD)/librender.a
	$(call say,LD ,$@)
	$(Q)$(LINK) -o $@ $^ $(PKG_LIBS)

# CASES=N: so many cases per row; ROWS=text: only rows whose name contains it; SEED as for crash.
CASES ?=
ROWS ?=
.PHONY: stability
stability: $(STABILITY) $(if $(ROWS),,matrix)
	nice -n 10 $(STABILITY) --out $(BUILD)/stability --corpus tests/property/corpus/worst.txt --jobs $(JOBS) \
	    $(if $(SEED),--seed $(SEED)) $(if $(CASES),--cases $(CASES)) $(if $(ROWS),--rows $(ROWS)) \
	    $(if $(ROWS),,$$(ls $(BUILD)/stability/m*.json 2>/dev/null | sed 's/^/--also /'))

# Determinism across builds and processes; MATRIX="ROW…": only these rows.
MATRIX ?=
.PHONY: matrix
matrix: $(BUILD)/libpenumbra.a
	@-nice -n 10 sh tests/property/matrix.sh $(BUILD) $(MATRIX)

# Builds the renderer with one deliberate mistake at a time, each of which its row must find: some
# minutes. MUTANTS="NAME…": only these.
MUTANTS ?=
.PHONY: mutants
mutants:
	@nice -n 10 sh tests/property/mutants.sh $(BUILD) $(MUTANTS)

# Kills the daemon's processes at random: ROUNDS rounds, from SEED if that is given.
ROUNDS ?= 200
SEED ?=
CRASH_OBJ := $(patsubst %.c,$(BUILD)/%.o,$(sort $(wildcard tests/crash/*.c)))
$(CRASH_TEST): $(CRASH_OBJ) $(BUILD)/libservice.a $(BUILD)/librender.a
	$(LINK) -o $@ $^ $(PKG_LIBS)
.PHONY: crash
crash: all $(CRASH_TEST)
	$(CRASH_TEST) $(BUILD) $(ROUNDS) $(SEED)

# Clients that hold connections without using them, send bad requests or large ones: some minutes.
LOAD_OBJ := $(patsubst %.c,$(BUILD)/%.o,$(sort $(wildcard tests/load/*.c)))
$(LOAD_OBJ): EXTRA := -Itests
$(LOAD): $(LOAD_OBJ) $(BUILD)/src/base/clock.o
	$(call say,LD ,$@)
	$(Q)$(LINK) -o $@ $^
.PHONY: load
load: all $(LOAD)
	@sh tests/load/load.sh $(BUILD)

# A daemon that is used for MINUTES (30): jobs of all kinds, readers, cancels, kills, restarts, limits of what is kept.
.PHONY: soak
soak: all $(LOAD)
	@sh tests/load/soak.sh $(BUILD)

# A failing disk, which a test preloads into a daemon. Compiled without sanitizers, since it is loaded
# before their library.
$(FAULTS): tests/faults/preload.c
	@mkdir -p $(@D)
	$(call say,CC ,$<)
	$(Q)$(CC) $(CPP) $(OPT) $(WARN) -std=c11 -fPIC -shared -o $@ $< -ldl

# Benchmarks, one program each. The tests build them, so that they keep compiling, but do not run them.
BENCH_SCENES := $(patsubst %.c,$(BUILD)/%.o,$(sort $(wildcard tests/bench/scenes/*.c)))
$(BENCH_SCENES): EXTRA := -Itests
$(BUILD)/tests/bench/make_scene: BENCH_OBJ := $(BENCH_SCENES)
$(BUILD)/tests/bench/make_scene: $(BENCH_SCENES)
$(BUILD)/tests/bench/%: tests/bench/%.c $(BUILD)/libservice.a $(BUILD)/librender.a
	@mkdir -p $(@D)
	$(call say,CC ,$<)
	$(Q)$(COMPILE) -Itests $(PKG_CFLAGS) -pthread $(LDFLAGS) -o $@ $< $(BENCH_OBJ) $(BUILD)/libservice.a \
	    $(BUILD)/librender.a $(PKG_LIBS)

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
# if the promise of src/render/adaptive.h is broken. `accuracy-promise` leaves out the smallest target.
.PHONY: calibration accuracy-promise
calibration: all $(BENCHES)
	@sh tests/bench/calibration.sh $(BUILD)
accuracy-promise: all $(BENCHES)
	@TARGETS="0.02 0.01 0.005" sh tests/bench/calibration.sh $(BUILD) $(BUILD)/accuracy-promise

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

check:
	@sh deploy/install-deps.sh
	@$(MAKE) --no-print-directory -j$(JOBS) tests
	@JOBS=$(JOBS) sh tests/run.sh $(BUILD)
run-tests: tests
	@JOBS=$(JOBS) sh tests/run.sh $(BUILD)

# Writes tests/golden/hashes.txt anew, after a change that is meant to change pictures.
golden: $(BUILD)/tests/golden/test_golden
	PENUMBRA_GOLDEN=write $<

demo:
	@sh deploy/install-deps.sh
	@$(MAKE) --no-print-directory -j$(JOBS) all
	@sh deploy/demo.sh $(BUILD)

lint:
	sh deploy/lint.sh $(BUILD)

# Sanitizers find undefined behaviour with a part of the cases of heavy tests as well.
FEWER ?= 10
FEWER_ENV := PEN_FEWER=$(FEWER) CK_TIMEOUT_MULTIPLIER=4
CHECKED := OPT="-O1 -g1" PIXEL_OPT=-O2
ASAN := BUILD=$(BUILD)-asan SAN="-fsanitize=address,undefined -fno-sanitize-recover=undefined" $(CHECKED)
asan-build:
	$(MAKE) $(ASAN) tests
asan:
	$(FEWER_ENV) $(MAKE) $(ASAN) run-tests
tsan:
	$(FEWER_ENV) $(MAKE) BUILD=$(BUILD)-tsan SAN="-fsanitize=thread" $(CHECKED) run-tests

# Feeds inputs made by libFuzzer to each target of tests/fuzz, MINUTES long; needs clang. TARGETS="NAME…":
# only these. What they find is kept in FUZZ_DIR; a crash belongs into tests/fuzz/corpus/TARGET.
MINUTES ?= 10
FUZZ_SAN := -fsanitize=address,undefined -fno-sanitize-recover=undefined
FUZZ := BUILD=$(BUILD)-fuzz CC=clang SAN="$(FUZZ_SAN) -fsanitize=fuzzer-no-link" OPT="-O1 -g"
FUZZ_DIR := $(BUILD)-fuzz/tests/fuzz
TARGETS ?= $(FUZZ_NAMES)
.PHONY: fuzz fuzz-libraries
fuzz-libraries: $(BUILD)/libservice.a $(BUILD)/librender.a
fuzz:
	$(MAKE) $(FUZZ) fuzz-libraries
	@for target in $(TARGETS); do \
	    mkdir -p $(FUZZ_DIR)/found/$$target && echo "fuzzing $$target for $(MINUTES) minutes" && \
	    clang $(CPP) -Itests $(PKG_CFLAGS) $(FUZZ_SAN) -fsanitize=fuzzer -O1 -g -pthread -o $(FUZZ_DIR)/$$target \
	        tests/fuzz/fuzz_$$target.c $(BUILD)-fuzz/libservice.a $(BUILD)-fuzz/librender.a $(PKG_LIBS) && \
	    ASAN_OPTIONS=allocator_may_return_null=1 $(FUZZ_DIR)/$$target -max_total_time=$$(($(MINUTES) * 60)) \
	        -timeout=10 -rss_limit_mb=2048 $$(sh tests/fuzz/options.sh $$target) -artifact_prefix=$(FUZZ_DIR)/$$target- \
	        -print_final_stats=1 $(FUZZ_DIR)/found/$$target $$(sh tests/fuzz/corpora.sh $$target) || exit 1; \
	done

$(BUILD)/tests/conformance/compare_pair: tests/conformance/compare_pair.c $(BUILD)/librender.a
	@mkdir -p $(@D)
	$(call say,CC ,$<)
	$(Q)$(COMPILE) -pthread $(LDFLAGS) -o $@ $^ $(PKG_LIBS)

conformance: all $(BUILD)/tests/conformance/compare_pair
	sh tests/conformance.sh $(BUILD) $(REF)

# FLIP against the published figures in the folder REF.
.PHONY: conformance-flip
conformance-flip: all
	sh tests/conformance_flip.sh $(BUILD) $(REF)

# Where things go. `make uninstall` with the same PREFIX and DESTDIR removes the same list.
LIBDIR ?= $(PREFIX)/lib
INCLUDEDIR ?= $(PREFIX)/include
MANDIR ?= $(PREFIX)/share/man
BASH_COMPLETION_DIR ?= $(PREFIX)/share/bash-completion/completions
ZSH_COMPLETION_DIR ?= $(PREFIX)/share/zsh/site-functions
man_path = $(MANDIR)/man$(subst .,,$(suffix $(1)))/$(1)
INSTALLED := $(PREFIX)/bin/penumbra $(PREFIX)/bin/penumbrad $(INCLUDEDIR)/penumbra.h $(LIBDIR)/libpenumbra.a \
    $(LIBDIR)/libpenumbra.so.$(VERSION) $(LIBDIR)/$(SONAME) $(LIBDIR)/libpenumbra.so \
    $(LIBDIR)/pkgconfig/penumbra.pc $(foreach page,$(MAN_NAMES),$(call man_path,$(page))) \
    $(BASH_COMPLETION_DIR)/penumbra $(BASH_COMPLETION_DIR)/penumbrad $(ZSH_COMPLETION_DIR)/_penumbra
.PHONY: uninstall
install: all
	$(if $(SAN),$(error a build with sanitizers is not for installing))
	install -d $(addprefix $(DESTDIR),$(sort $(dir $(INSTALLED))))
	install $(BUILD)/penumbrad $(BUILD)/penumbra $(DESTDIR)$(PREFIX)/bin
	install -m 644 include/penumbra.h $(DESTDIR)$(INCLUDEDIR)
	install -m 644 $(BUILD)/libpenumbra.a $(SHARED) $(DESTDIR)$(LIBDIR)
	ln -sf libpenumbra.so.$(VERSION) $(DESTDIR)$(LIBDIR)/$(SONAME)
	ln -sf $(SONAME) $(DESTDIR)$(LIBDIR)/libpenumbra.so
	sed -e 's|@PREFIX@|$(PREFIX)|' -e 's|@LIBDIR@|$(LIBDIR)|' -e 's|@INCLUDEDIR@|$(INCLUDEDIR)|' \
	    -e 's|@VERSION@|$(VERSION)|' -e 's|@REQUIRES@|$(LIBRARY_PKGS)|' deploy/penumbra.pc.in \
	    > $(DESTDIR)$(LIBDIR)/pkgconfig/penumbra.pc
	$(foreach page,$(MAN_NAMES),install -m 644 $(BUILD)/man/$(page) $(DESTDIR)$(call man_path,$(page)) &&) :
	install -m 644 $(BUILD)/completion/penumbra.bash $(DESTDIR)$(BASH_COMPLETION_DIR)/penumbra
	ln -sf penumbra $(DESTDIR)$(BASH_COMPLETION_DIR)/penumbrad
	install -m 644 $(BUILD)/completion/penumbra.zsh $(DESTDIR)$(ZSH_COMPLETION_DIR)/_penumbra

uninstall:
	rm -f $(addprefix $(DESTDIR),$(INSTALLED))

clean:
	rm -rf $(BUILD) $(BUILD)-asan $(BUILD)-tsan $(BUILD)-fuzz

-include $(LIB_OBJ:.o=.d) $(SVC_OBJ:.o=.d) $(CMD_OBJ:.o=.d) $(TEST_BIN:%=%.d) $(TEST_SUPPORT_OBJ:.o=.d) $(CRASH_OBJ:.o=.d) $(LOAD_OBJ:.o=.d) $(BENCH_SCENES:.o=.d) \
    $(PROPERTY_OBJ:.o=.d) $(STABILITY_OBJ:.o=.d) $(BUILD)/tests/property/main_films.d \
    $(STRIPPED_OBJ:.o=.d) $(INSTRUCTIONS).d
-include $(CLIENT_OBJ:.o=.d) $(DAEMON_OBJ:.o=.d)
