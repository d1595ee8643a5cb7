# SPDX-License-Identifier: MIT
# Man pages, completion, installation.

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

