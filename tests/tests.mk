# SPDX-License-Identifier: MIT
# The programs of the tests, and the targets of the checks. tests/README.md says what runs when.

TEST_SRC := $(sort $(wildcard tests/*/test_*.c))
TEST_BIN := $(TEST_SRC:%.c=$(BUILD)/%)
TEST_SUPPORT := $(sort $(wildcard tests/support/*.c))
TEST_ISA_SRC := $(filter %_isa.c,$(TEST_SUPPORT))
TEST_ISA_OBJ := $(foreach isa,$(ISAS),$(TEST_ISA_SRC:%.c=$(BUILD)/%_$(isa).o))
TEST_SUPPORT_OBJ := $(patsubst %.c,$(BUILD)/%.o,$(filter-out $(TEST_ISA_SRC),$(TEST_SUPPORT))) $(TEST_ISA_OBJ)
TEST_SUPPORT_LIB := $(BUILD)/tests/libsupport.a

CRASH_TEST := $(BUILD)/tests/crash/crash
STABILITY := $(BUILD)/tests/property/stability
FILMS := $(BUILD)/tests/property/films
INSTRUCTIONS := $(BUILD)/tests/effects/instructions
FAULTS := $(BUILD)/tests/faults/preload.so
FUZZ_NAMES := $(patsubst tests/fuzz/fuzz_%.c,%,$(sort $(wildcard tests/fuzz/fuzz_*.c)))
REPLAYS := $(FUZZ_NAMES:%=$(BUILD)/tests/fuzz/replay_%)
RECORD := $(BUILD)/tests/front/record
LOAD_NAMES := load strict early deadlines mutate stall
LOAD := $(LOAD_NAMES:%=$(BUILD)/tests/load/%)
.PHONY: tests run-tests check-all golden
tests: all $(TEST_BIN) $(CRASH_TEST) $(FAULTS) $(LOAD) $(RECORD) $(STABILITY) $(FILMS) $(INSTRUCTIONS) $(BENCHES) $(REPLAYS)

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

# Parts of the support that are compiled once for each instruction set.
define test_isa_rules
$(TEST_ISA_SRC:%.c=$(BUILD)/%_$(1).o): EXTRA := $(ISA_FLAGS_$(1)) -DPEN_ISA=$(1) -Itests
$(TEST_ISA_SRC:%.c=$(BUILD)/%_$(1).o): $(BUILD)/%_$(1).o: %.c Makefile
	$$(compile_object)
endef
$(foreach isa,$(ISAS),$(eval $(call test_isa_rules,$(isa))))

# The fuzz targets with a main of their own, which replays kept inputs.
$(REPLAYS): $(BUILD)/tests/fuzz/replay_%: tests/fuzz/fuzz_%.c tests/fuzz/replay.c $(wildcard tests/fuzz/*.h) \
    $(BUILD)/libservice.a $(BUILD)/librender.a
	@mkdir -p $(@D)
	$(call say,CC ,$<)
	$(Q)$(COMPILE) -Itests $(PKG_CFLAGS) -pthread $(LDFLAGS) -o $@ $< tests/fuzz/replay.c \
	    $(BUILD)/libservice.a $(BUILD)/librender.a $(PKG_LIBS)

# Proofs that a scene pays for its own effects alone (src/shade/KERNELS.md). The kernels that are
# stripped by hand are compiled as those of kernel_isa.c for AVX2.
STRIPPED_OBJ := $(patsubst %.c,$(BUILD)/%.o,$(sort $(wildcard tests/effects/stripped/*.c)))
$(STRIPPED_OBJ): HARDEN := $(if $(SAN),-fno-omit-frame-pointer,-fomit-frame-pointer)
$(STRIPPED_OBJ): LIB_FLAGS := -fPIC -fvisibility=hidden
$(STRIPPED_OBJ): MODULE_OPT := $(PIXEL_OPT)
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

# Numeric bugs of other renderers: writes tests/property/museum.md and its pictures.
.PHONY: museum
museum: all
	@python3 -B tests/property/museum.py $(BUILD)

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
$(CRASH_OBJ): EXTRA := -Itests
$(CRASH_TEST): $(CRASH_OBJ) $(TEST_SUPPORT_LIB) $(BUILD)/libservice.a $(BUILD)/librender.a
	$(LINK) -o $@ $^ $(CHECK_LIBS) $(PKG_LIBS)
.PHONY: crash
crash: all $(CRASH_TEST)
	$(CRASH_TEST) $(BUILD) $(ROUNDS) $(SEED)

# The tests of the store that hold for every engine, and the crash test, on a PostgreSQL server of their own.
POSTGRES_ROUNDS ?= 4
.PHONY: postgres
postgres: tests
	PEN_STORE_ENGINE=postgres sh tests/support/postgres.sh sh tests/run.sh $(BUILD) \
	    $(filter-out tests/store/test_sqlite%,$(wildcard tests/store/test_*.c))
	sh tests/support/postgres.sh $(CRASH_TEST) $(BUILD) $(POSTGRES_ROUNDS) $(SEED)

# Clients that hold connections without using them, send bad requests or large ones: some minutes.
LOAD_OBJ := $(patsubst %.c,$(BUILD)/%.o,$(sort $(wildcard tests/load/*.c)))
LOAD_SHARED := $(filter-out $(LOAD:%=%.o),$(LOAD_OBJ))
$(LOAD_OBJ): EXTRA := -Itests
$(LOAD): %: %.o $(LOAD_SHARED) $(BUILD)/libservice.a $(BUILD)/librender.a
	$(call say,LD ,$@)
	$(Q)$(LINK) -o $@ $^ $(PKG_LIBS)
.PHONY: load
load: all $(LOAD)
	@sh tests/load/load.sh $(BUILD)
	@sh tests/load/clients.sh $(BUILD)
	@sh tests/load/tls.sh $(BUILD) || [ $$? -eq 77 ]

# Mutated requests, MINUTES (10) long, against a daemon with sanitizers.
.PHONY: mutate
mutate: $(LOAD)
	$(MAKE) $(CLANG) all
	@sh tests/load/mutate.sh $(BUILD)-clang-asan $(BUILD)/tests/load/mutate

# deploy/nginx.conf before a daemon; says why if it is skipped.
$(RECORD): $(RECORD).o
	$(call say,LD ,$@)
	$(Q)$(LINK) -o $@ $^
.PHONY: front
front: all $(LOAD) $(RECORD)
	@sh tests/front/nginx.sh $(BUILD) || [ $$? -eq 77 ]

# The page at / and the reports, in headless Chromium; the pictures of the gallery and of README.md.
.PHONY: page page-pictures
page: all
	@sh deploy/install-deps.sh --page
	@sh tests/page/page.sh $(BUILD) run.mjs $(PARTS)
page-pictures: all
	@sh deploy/install-deps.sh --page
	@sh tests/page/page.sh $(BUILD) pictures.mjs thumbnails
	@$(MAKE) -s all
	@sh tests/page/page.sh $(BUILD) pictures.mjs

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

run-tests: tests
	@JOBS=$(JOBS) sh tests/run.sh $(BUILD) $(TESTS)

# Writes tests/golden/hashes.txt anew, after a change that is meant to change pictures.
golden: $(BUILD)/tests/golden/test_golden
	PENUMBRA_GOLDEN=write $<

# Everything: all cases, times, sanitizers, load, kills, mutants, fuzzing: hours. PARTS="NAME…": only these.
PARTS ?=
check-all: tests
	@JOBS=$(JOBS) sh tests/all.sh $(BUILD) $(PARTS)

# Every test with sanitizers, and with a part of the cases: rare numbers are not needed to find undefined
# behaviour. TESTS="PART…": only tests whose paths contain one of these.
.PHONY: asan tsan
TESTS ?=
SANITIZED = PEN_FEWER=10 CK_TIMEOUT_MULTIPLIER=4 $(MAKE) OPT="-O1 -g1" PIXEL_OPT=-O2 run-tests
UNDEFINED := -fsanitize=address,undefined -fno-sanitize-recover=undefined
asan:
	$(SANITIZED) BUILD=$(BUILD)-asan SAN="$(UNDEFINED)"
tsan:
	$(SANITIZED) BUILD=$(BUILD)-tsan SAN="-fsanitize=thread"

# The tests of the code that can hold memory errors, with sanitizers: a part of .ci/run. They are built
# by clang, whose warnings are errors, so that one build serves both; of other tests clang sees the syntax.
.PHONY: memory memory-build memory-programs
MEMORY_MODULES := base io film report scene store jobs access http
# These render for minutes with sanitizers and have little else that they could find; make asan runs them.
MEMORY_NOT := jobs/test_study_kept jobs/test_audits
MEMORY_TESTS := $(filter-out $(MEMORY_NOT:%=tests/%.c),$(filter $(MEMORY_MODULES:%=tests/%/%),$(TEST_SRC))) \
    tests/golden/test_golden.c tests/fuzz/check_corpus.sh
# The runtime of the sanitizers is shared, as gcc's is, since tests have a malloc of their own
# (tests/support/alloc.h).
CLANG = BUILD=$(BUILD)-clang-asan CC=clang SAN="$(UNDEFINED) -shared-libasan" OPT="-O1 -g1" PIXEL_OPT=-O2 \
    CPPFLAGS=-D__SANITIZE_ADDRESS__ WERROR=-Werror \
    LDFLAGS=-Wl,-rpath,$(dir $(shell clang -print-file-name=libclang_rt.asan-x86_64.so))
memory-programs: all $(patsubst %.c,$(BUILD)/%,$(filter %.c,$(MEMORY_TESTS))) $(REPLAYS)
	$(Q)printf '%s\n' $(wildcard tests/*/*.c tests/*/*/*.c) | grep -v _isa.c | xargs -P $(JOBS) -n 16 \
	    $(CC) $(CPP) -Itests $(WARN) $(CHECK_CFLAGS) $(PKG_CFLAGS) $(AVX2_FLAGS) -std=c11 -fsyntax-only
memory-build:
	$(MAKE) $(CLANG) memory-programs
memory:
	PEN_FEWER=10 CK_TIMEOUT_MULTIPLIER=4 JOBS=$(JOBS) sh tests/run.sh $(BUILD)-clang-asan \
	    $(MEMORY_TESTS)

# Feeds inputs made by libFuzzer to each target of tests/fuzz, MINUTES long; needs clang. TARGETS="NAME…":
# only these. What they find is kept in FUZZ_DIR; a crash belongs into tests/fuzz/corpus/TARGET.
MINUTES ?= 10
FUZZ := BUILD=$(BUILD)-fuzz CC=clang SAN="$(UNDEFINED) -fsanitize=fuzzer-no-link" OPT="-O1 -g"
FUZZ_DIR := $(BUILD)-fuzz/tests/fuzz
TARGETS ?= $(FUZZ_NAMES)
.PHONY: fuzz fuzz-libraries
fuzz-libraries: $(BUILD)/libservice.a $(BUILD)/librender.a
fuzz:
	$(MAKE) $(FUZZ) fuzz-libraries
	@for target in $(TARGETS); do \
	    mkdir -p $(FUZZ_DIR)/found/$$target && echo "fuzzing $$target for $(MINUTES) minutes" && \
	    clang $(CPP) -Itests $(PKG_CFLAGS) $(UNDEFINED) -fsanitize=fuzzer -O1 -g -pthread -o $(FUZZ_DIR)/$$target \
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


-include $(TEST_BIN:%=%.d) $(TEST_SUPPORT_OBJ:.o=.d) $(CRASH_OBJ:.o=.d) $(LOAD_OBJ:.o=.d) $(RECORD).d $(PROPERTY_OBJ:.o=.d) \
    $(STABILITY_OBJ:.o=.d) $(BUILD)/tests/property/main_films.d $(STRIPPED_OBJ:.o=.d) $(INSTRUCTIONS).d
