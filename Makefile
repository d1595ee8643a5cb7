# SPDX-License-Identifier: MIT
# Builds Penumbra: build/penumbrad, build/penumbra, build/libpenumbra.a, build/libpenumbra.so.
# Results depend on the flags in PIXEL_FLAGS: no contraction, no fast-math, on every file.
# Files named *_isa.c are compiled once for each instruction set; those objects are entered only after a
# cpuid check.

BUILD ?= build
PREFIX ?= /usr/local
DESTDIR ?=
OPT ?= -O2 -g
# Optimisation of the modules that compute pixels, where a build with sanitizers spends most of its time.
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
RENDER_MODULES := base math geom accel scene shade film render io embed
SERVICE_MODULES := report study store jobs access http
# A module's files: those in its folder and in folders of that.
module_files = $(sort $(wildcard src/$(1)/*.c src/$(1)/*/*.c))

WARN := -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wstrict-prototypes -Wmissing-prototypes -Wvla \
    -Wswitch-enum $(WERROR)
PIXEL_FLAGS := -std=c11 -ffp-contract=off -fno-math-errno
HARDEN := -fstack-protector-strong -fno-omit-frame-pointer
# All kernels of a build with sanitizers are one (src/shade/internal/surface.h).
SHARED_KERNELS ?= $(if $(SAN),-DPEN_SHARED_KERNELS)
CPP := -D_GNU_SOURCE -DPEN_VERSION='"$(VERSION)"' -Isrc -Iinclude $(SHARED_KERNELS) $(CPPFLAGS)
COMPILE = $(CC) $(CPP) $(OPT) $(MODULE_OPT) $(WARN) $(HARDEN) $(SAN) $(CFLAGS) $(PIXEL_FLAGS)
# The build id is in the reports of benchmarks (src/study/host.c).
LINK = $(CC) $(SAN) -pthread -Wl,--build-id=sha1 $(LDFLAGS)

# FARM=0 builds without PostgreSQL.
FARM ?= 1
PKGS := jansson expat libpng zlib sqlite3 libzstd libsodium libmicrohttpd gnutls libcurl $(if $(filter 1,$(FARM)),libpq)
PKG_CFLAGS := $(shell pkg-config --cflags $(PKGS) 2>/dev/null)
# libcurl is loaded by the commands that need it, see src/cmd/client/curl_library.h.
# A program links only the libraries that it uses.
PKG_LIBS := -Wl,--as-needed $(shell pkg-config --libs $(filter-out libcurl,$(PKGS)) 2>/dev/null) -lm
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

LIB_SRC := $(foreach r,$(RENDER_MODULES),$(call module_files,$(r)))
SVC_SRC := $(filter-out $(if $(filter 1,$(FARM)),,src/store/db_postgres%),$(foreach r,$(SERVICE_MODULES),$(call module_files,$(r))))
ISA_SRC := $(filter %_isa.c,$(LIB_SRC))
ISA_OBJ := $(foreach isa,$(ISAS),$(ISA_SRC:%.c=$(BUILD)/%_$(isa).o))
LIB_OBJ := $(patsubst %.c,$(BUILD)/%.o,$(filter-out $(ISA_SRC),$(LIB_SRC))) $(ISA_OBJ) $(BUILD)/gen/builtin_scenes.o
SVC_OBJ := $(SVC_SRC:%.c=$(BUILD)/%.o) $(BUILD)/gen/api_files.o $(BUILD)/gen/page_files.o $(BUILD)/gen/report_files.o $(BUILD)/gen/schema.o
CMD_COMMON := $(sort $(wildcard src/cmd/*.c))
CMD_OBJ := $(CMD_COMMON:%.c=$(BUILD)/%.o)
CLIENT_OBJ := $(patsubst %.c,$(BUILD)/%.o,$(sort $(wildcard src/cmd/client/*.c)))
DAEMON_OBJ := $(patsubst %.c,$(BUILD)/%.o,$(sort $(wildcard src/cmd/daemon/*.c)))
.PHONY: have-deps all check demo lint clean
all: have-deps $(BUILD)/penumbrad $(BUILD)/penumbra $(LIBRARIES) $(MAN_PAGES) $(COMPLETION)
.PHONY: librender
librender: $(BUILD)/librender.a

have-deps:
	@pkg-config --exists $(PKGS) || { \
	    echo "libraries are missing (wanted: $(PKGS)): run sh deploy/install-deps.sh" >&2; exit 1; }

# Objects of the renderer serve the programs and both libraries. Only what penumbra.h declares is
# visible outside libpenumbra.
$(LIB_OBJ): LIB_FLAGS := -fPIC -fvisibility=hidden

# For programs and tests of this tree: every symbol of the modules.
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

$(foreach r,math geom accel shade film,$(eval $$(BUILD)/src/$(r)/%.o: MODULE_OPT := $$(PIXEL_OPT)))
# Loops over bytes of pixels, which the compiler vectorises at -O3.
$(BUILD)/src/store/pixels.o: EXTRA := -O3
$(BUILD)/src/store/db.o: EXTRA := $(if $(filter 1,$(FARM)),-DPEN_FARM)
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
endef
$(foreach isa,$(ISAS),$(eval $(call isa_rules,$(isa))))

# Files that are compiled into the programs: scenes/*.json, api/*, api/page/* and the tables of the store.
$(BUILD)/gen/builtin_scenes.c: $(sort $(wildcard scenes/*.json)) deploy/embed.sh
	@mkdir -p $(@D)
	$(Q)sh deploy/embed.sh --stem pen_builtin_files $(sort $(wildcard scenes/*.json)) > $@.tmp && mv $@.tmp $@
$(BUILD)/gen/api_files.c: $(sort $(wildcard api/*.yaml api/*.json)) deploy/embed.sh
	@mkdir -p $(@D)
	$(Q)sh deploy/embed.sh pen_api_files $(sort $(wildcard api/*.yaml api/*.json)) > $@.tmp && mv $@.tmp $@
PAGE_FILES := $(sort $(filter-out api/page/report.%,$(wildcard api/page/*)))
$(BUILD)/gen/page_files.c: $(PAGE_FILES) deploy/embed.sh
	@mkdir -p $(@D)
	$(Q)sh deploy/embed.sh pen_page_files $(PAGE_FILES) > $@.tmp && mv $@.tmp $@
$(BUILD)/gen/report_files.c: $(sort $(wildcard api/page/report.*)) deploy/embed.sh
	@mkdir -p $(@D)
	$(Q)sh deploy/embed.sh pen_report_files $(sort $(wildcard api/page/report.*)) > $@.tmp && mv $@.tmp $@
$(BUILD)/gen/schema.c: src/store/schema.sql deploy/embed.sh
	@mkdir -p $(@D)
	$(Q)sh deploy/embed.sh pen_store_schema src/store/schema.sql > $@.tmp && mv $@.tmp $@
$(BUILD)/gen/%.o: $(BUILD)/gen/%.c Makefile
	$(Q)$(COMPILE) $(LIB_FLAGS) -c -o $@ $<

# What a change needs; `.ci/run` and `make check-all` do more: tests/README.md.
check:
	@sh deploy/install-deps.sh
	@$(MAKE) --no-print-directory -j$(JOBS) tests
	@JOBS=$(JOBS) sh tests/run.sh $(BUILD)

demo:
	@sh deploy/install-deps.sh
	@$(MAKE) --no-print-directory -j$(JOBS) all
	@sh deploy/demo.sh $(BUILD)

lint:
	sh deploy/lint.sh $(BUILD)

clean:
	rm -rf $(BUILD) $(BUILD)-asan $(BUILD)-tsan $(BUILD)-fuzz $(BUILD)-clang-asan

-include $(LIB_OBJ:.o=.d) $(SVC_OBJ:.o=.d) $(CMD_OBJ:.o=.d) $(CLIENT_OBJ:.o=.d) $(DAEMON_OBJ:.o=.d)

# What only tests, benches and packages need; tests/README.md names the checks.
include tests/bench/bench.mk tests/tests.mk deploy/install.mk
