# hexid: `make help` lists the targets; V=1 shows the commands. Debian 12; missing packages are installed on the way.
VERSION := 0.9.0
BUILD   ?= build
VENV    ?= $(BUILD)/venv
CC      := gcc
CXX     := g++
AR      := gcc-ar
OPT     ?= -O3 -g1
SAN     ?=
Q       := $(if $(V),,@)
WARN    := -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wdouble-promotion -Wstrict-prototypes -Wmissing-prototypes -Wvla -Werror
WARNXX  := -Wall -Wextra -Wshadow -Werror
INCLUDE := -Iinclude -Isim -Ihal $(addprefix -I,$(wildcard src/*)) -I$(BUILD)/lcmtypes
# Hardening against memory errors of the program itself. Sanitizers bring their own, and without optimisation there is no _FORTIFY_SOURCE.
OPTIMISED := $(filter-out -O0 -Og,$(filter -O%,$(OPT)))
HARDEN  := $(if $(SAN),,$(if $(OPTIMISED),-D_FORTIFY_SOURCE=3 -fstack-protector-strong -fstack-clash-protection -fcf-protection -fPIE))
HARD_LD := $(if $(HARDEN),-pie -z relro -z now -z noexecstack)
# No contraction, so that every optimisation level and call site gives the same results.
CFLAGS   = -std=c17 -D_GNU_SOURCE $(OPT) -ffp-contract=off $(WARN) $(HARDEN) $(SAN) $(INCLUDE) -MMD -MP
CXXFLAGS = -std=c++17 $(OPT) -ffp-contract=off $(WARNXX) $(HARDEN) -fno-exceptions -fno-rtti $(SAN) $(INCLUDE) -isystem /usr/include/eigen3 -MMD -MP
LDLIBS  := -llcm -lyaml -ljansson -lode -lmodbus -lseccomp -lzstd -lz -lm -lpthread -lstdc++

LCM     := $(wildcard lcmtypes/*.lcm)
LCM_C   := $(LCM:lcmtypes/%.lcm=$(BUILD)/lcmtypes/%.c)
SRC     := $(wildcard src/*/*.c hal/*.c sim/*.c sim/effects/*.c)
LIB_SRC := $(filter-out src/cli/main.c,$(SRC))
EFFECTS := $(sort $(basename $(notdir $(wildcard sim/effects/*.c))))
PAGE    := $(sort $(wildcard src/monitor/page/*))
# The C++ is first, since it takes longest to compile.
LIB_OBJ := $(patsubst %.cpp,$(BUILD)/%.o,$(wildcard src/lin/*.cpp)) $(BUILD)/effect_table.o $(BUILD)/live_page.o $(LIB_SRC:%.c=$(BUILD)/%.o) $(LCM_C:.c=.o)
TESTS   := $(patsubst %.c,$(BUILD)/%,$(wildcard tests/test_*.c))
BENCHES := $(patsubst %.c,$(BUILD)/%,$(wildcard tests/bench/*.c))
COUNTS  := $(BUILD)/tests/rt/counts.so
FUZZERS := $(patsubst %.c,$(BUILD)/%,$(wildcard tests/fuzz/fuzz_*.c))
REPLAYS := $(subst /fuzz/fuzz_,/fuzz/replay_,$(FUZZERS))
# The longest are started first, so that all cores are busy to the end.
LONGEST := can modbus stop logs disguises
SCRIPTS := $(LONGEST:%=tests/scenarios/%.sh) $(filter-out $(LONGEST:%=tests/scenarios/%.sh),$(wildcard tests/scenarios/*.sh))
# The long tier, with MORE_CASES: the C tests and scenarios that have long cases, and tests/long/, whose programs take minutes and are
# therefore started before the others; the longest first.
LONG    := $(wildcard tests/long/*.sh) $(patsubst %.c,$(BUILD)/%,$(shell grep -lE 'long_case\(\)|more_cases\(\)' tests/test_*.c)) \
	$(shell grep -l MORE_CASES tests/scenarios/*.sh)
FIRST   := $(addprefix tests/long/,rig_laws.sh rig.sh) $(addprefix $(BUILD)/tests/test_,extremes axis oscillation)
# The fast tier: these scenarios, and the C tests without their slow cases (slow_case in tests/support.h). T=MODULE: what holds that one.
QUICK   := $(addprefix tests/scenarios/,modules.sh print_config.sh)
CHECKED := $(if $(T),$(or $(shell BUILD=$(BUILD) tests/of_module $(T)),$(error T=$(T): no module of src/, hal/ or sim/ and no test has this name)),$(QUICK) $(TESTS))
# What a sanitizer is for: AddressSanitizer sees every program; the scenarios left out run the same code for their numbers.
# ThreadSanitizer sees what has threads.
OF_NUMBERS  := $(addprefix tests/scenarios/,can.sh counts.sh faults.sh figures.sh install.sh machines.sh modbus.sh modules.sh pages.sh signals.sh stop.sh survey.sh table5.sh)
WITH_THREADS := $(addprefix tests/scenarios/,command.sh lcm.sh paced.sh same_seed.sh)
THREADED    := $(addprefix tests/test_,axis bus can_link confine loop modbus_line modbus_rtu modbus_tcp signals)

# Tests leave no files in the tree.
export PYTHONDONTWRITEBYTECODE := 1

# One job per core, unless the command line says otherwise.
ifeq ($(MAKELEVEL),0)
MAKEFLAGS += -j$(shell nproc)
endif

all: $(BUILD)/hexid ## build build/hexid (the default)

run: $(BUILD)/hexid ## run the simulated platform in real time: six tests, the inertia matrix, a log under runs/ (ARGS="..." adds options)
	@mkdir -p runs
	$(BUILD)/hexid run --log runs/$$(date +%Y-%m-%d_%H-%M-%S).lcm $(ARGS)

test: $(BUILD)/hexid $(TESTS) $(REPLAYS) $(COUNTS) $(VENV)/ready ## run all tests; the last line is "N passed, N failed"
	@BUILD=$(BUILD) VENV=$(VENV) NOT_RUN="what takes minutes: make test-long; what is claimed about the wall clock: make test-rt" \
		tests/run $(SCRIPTS) $(TESTS)

check: $(filter $(BUILD)/%,$(CHECKED)) $(if $(filter %.sh,$(CHECKED)),$(BUILD)/hexid $(VENV)/ready) ## the fast tier, half a minute of processor time; T=gap: the tests of src/gap/gap.c alone
	@CHECK=1 BUILD=$(BUILD) VENV=$(VENV) NOT_RUN="all else: make test" tests/run $(CHECKED)

test-long: $(BUILD)/hexid $(filter $(BUILD)/%,$(LONG)) $(BUILD)/tests/rig/rig $(BUILD)/tests/ident/venv/ready $(VENV)/ready | deps-deb ## what takes minutes: whole runs and faults on the field buses, the hidden cases of score.py, all motions of one axis, the spread over 30 seeds, the rig by other means, the package in a fresh root
	@MORE_CASES=1 BUILD=$(BUILD) VENV=$(VENV) NOT_RUN="what is claimed about the wall clock: make test-rt" tests/run $(FIRST) $(filter-out $(FIRST),$(LONG))

test-rt: $(BUILD)/hexid $(VENV)/ready | deps-bench ## what is claimed about the wall clock: the field buses at a real 2 ms, latencies beside cyclictest; on a quiet machine
	@BUILD=$(BUILD) VENV=$(VENV) CLOCK=real JOBS=1 tests/run $(addprefix tests/scenarios/,can.sh modbus.sh signals.sh stop.sh) $(wildcard tests/rt/*.sh)

bench-rt: $(BUILD)/hexid $(COUNTS) | deps-rt ## hexid's wake-ups beside cyclictest's, in turns, idle and under stress-ng, on sim: and Modbus; the highest rate, what each thread did, its stack: 10 minutes on a quiet machine -> build/bench_rt.md
	@HEXID=$(BUILD)/hexid BUILD=$(BUILD) tests/rt/bench_rt.py -o $(BUILD)/bench_rt.md --csv $(BUILD)/bench_rt.csv

bench-cycle: $(BUILD)/hexid $(BUILD)/tests/bench/cycle | deps-bench ## instructions of a cycle of the controller by state and fault: best, median, worst; 2 minutes
	@tests/bench/cycle.sh $(BUILD)

bench-control: $(BUILD)/tests/bench/control ## the control laws side by side, six sines from 2 to 12 Hz: the tables of docs/validation.md; 3 minutes
	@$(BUILD)/tests/bench/control

MOTIONS := take_off road earthquake circle
bench-trajectories: $(BUILD)/tests/bench/trajectories ## the control laws side by side on a take-off, a road, an earthquake and a circle: the tables of docs/validation.md; 8 minutes
	@tests/bench/motions.py $(BUILD)/trajectories
	@$(BUILD)/tests/bench/trajectories $(MOTIONS:%=$(BUILD)/trajectories/%.csv)

bench-robust: $(BUILD)/tests/bench/robust ## machines that differ from what the laws know: named ones, margins of 1000 and runs of 200 drawn ones; half an hour on a quiet machine
	@$(BUILD)/tests/bench/robust

bench-control-rig: $(BUILD)/tests/bench/rig/control ## the same on the rig by other means, its base as configured and off by each leg's own 5 %, beside hexid's own plant; 30 minutes
	@$(BUILD)/tests/bench/rig/control

bench-hour: $(BUILD)/hexid $(VENV)/ready | deps-bench ## processor time and memory of hexid identify on an hour of noise-like motion; 5 minutes, 1 GB of disk
	@tests/bench/hour.sh $(BUILD) $(VENV)/bin/python

soak-rt: $(BUILD)/hexid $(COUNTS) | deps-rt ## an hour at real pace: memory, descriptors, page faults, log parts, latencies by quarters; SOAK_S=3600 -> build/soak_rt.md
	@HEXID=$(BUILD)/hexid BUILD=$(BUILD) tests/rt/soak_rt.py --seconds $${SOAK_S:-3600} -o $(BUILD)/soak_rt.md

test-rt-kernel: $(BUILD)/hexid | deps-rt-kernel ## hexid on Debian's PREEMPT_RT kernel, in QEMU without hardware's help: does it run there? Says nothing about how fast
	@BUILD=$(BUILD) VENV=$(VENV) tests/run tests/rt/kernel/kernel.sh

asan: ## the same programs under AddressSanitizer and UndefinedBehaviorSanitizer
	@$(MAKE) --no-print-directory BUILD=$(BUILD)/asan VENV=$(VENV) SCRIPTS="$(filter-out $(OF_NUMBERS),$(SCRIPTS))" \
		LIGHT=yes SAN="-fsanitize=address,undefined -fno-sanitize-recover=all" test

# Disables address space randomisation if allowed: ThreadSanitizer refuses the layouts of newer kernels.
tsan: ## what has threads, under ThreadSanitizer
	@$$(setarch -R true 2>/dev/null && echo setarch -R) $(MAKE) --no-print-directory BUILD=$(BUILD)/tsan VENV=$(VENV) \
		REPLAYS= SCRIPTS="$(WITH_THREADS)" TESTS="$(THREADED:%=$(BUILD)/tsan/%)" LIGHT=yes SAN=-fsanitize=thread test

# Excludes -fsanitize=function, whose runtime is in the C++ driver's library, while C links here.
fuzz: | deps-fuzz ## every fuzzer of tests/fuzz/ for a minute (FUZZ_S=60 seconds)
	@$(MAKE) --no-print-directory BUILD=$(BUILD)/fuzz CC=clang CXX=clang++ WARN=-w WARNXX=-w \
		SAN="-fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=all -fno-sanitize=function" fuzz-run
fuzz-run: $(FUZZERS)
	@BUILD=$(BUILD) tests/fuzz/run $^

soak: $(BUILD)/tests/soak_supervisor ## the supervisor, fuzzed against a model for 100 million cycles on one core: minutes (CYCLES=..., SEED=1)
	@$(BUILD)/tests/soak_supervisor $(or $(CYCLES),100000000) $(or $(SEED),1)

mutation: | deps-test ## is a test red when a row of the transition table or a line marked SAFETY is gone? An hour (ONLY=src/core: a part)
	@VENV=$(abspath $(VENV)) tests/mutation/mutate.py --tree $(BUILD)/mutation $(if $(ONLY),--only $(ONLY)) $(if $(MINUTES),--minutes $(MINUTES))

bench: $(BENCHES) $(BUILD)/hexid | deps-bench ## time and instructions of every part of the cycle -> build/bench.csv
	@tests/bench/bench.sh $(BUILD)

bench-check: $(BENCHES) $(BUILD)/hexid $(BUILD)/tests/rig/rig $(BUILD)/tests/bench/rig/control $(VENV)/ready | deps-bench ## the short form of every benchmark: does it measure, and end with an error where it does not? 3 minutes
	@BUILD=$(BUILD) VENV=$(VENV) tests/run $(wildcard tests/bench/check_*.sh)

rig: $(BUILD)/tests/rig/rig ## the machine by other means, tests/rig/: a minute or two of Pinocchio's headers

check-rig: $(BUILD)/tests/rig/rig $(BUILD)/hexid ## the rig's own checks, then hexid's identification on a recording of it
	@BUILD=$(BUILD) tests/rig/check.sh

bench-gap: $(BUILD)/hexid $(BUILD)/tests/bench/signatures | deps-test ## hidden effects against hexid gap, hundreds of cases: hours; SEEDS=1 FIRST=1 -> build/gap_score/score.csv
	@tests/gap/bench.sh $(BUILD)

bench-paper: $(BUILD)/tests/bench/paper $(BUILD)/hexid | deps-test ## Tian 2015 Tables 3, 4, C1 and 5, hexid's own results and least squares -> build/bench_paper/
	@$(BUILD)/tests/bench/paper $(BUILD)/hexid tests/data tests/ident/least_squares.py $(BUILD)/bench_paper

bench-methods: $(BUILD)/hexid | deps-test ## methods A, B, C, least squares and wavelets on the same recordings with sensors: minutes
	@HEXID=$(BUILD)/hexid tests/ident/compare.py

bench-table5: $(BUILD)/hexid ## which effects make the simulated machine read Tian 2015 Table 5? docs/table5.md; 1900 runs, half an hour
	@HEXID=$(BUILD)/hexid python3 tests/paper/table5.py search --cache $(BUILD)/table5

bench-friction: $(BUILD)/hexid $(BUILD)/tests/rig/rig ## method C on the rig by other means, laws of friction that it fits and others; 12 minutes
	@HEXID=$(BUILD)/hexid RIG=$(BUILD)/tests/rig/rig python3 tests/ident/rig_friction.py

bench-springs: $(BUILD)/hexid $(BUILD)/tests/rig/rig ## method C's springs on the rig by other means, six hidden, at 4 and 2 Hz; 3 minutes
	@HEXID=$(BUILD)/hexid RIG=$(BUILD)/tests/rig/rig python3 tests/ident/rig_springs.py --seeds 12

bench-sensors: $(BUILD)/hexid $(if $(filter mujoco,$(TRUTH)),$(BUILD)/tests/ident/venv/ready,$(BUILD)/tests/rig/rig) ## method C with gains, zeros, lags, skew and pipes of real sensors, on the rig by other means; TRUTH=mujoco: on MuJoCo's bodies; 15 minutes
	@HEXID=$(BUILD)/hexid RIG=$(BUILD)/tests/rig/rig $(if $(filter mujoco,$(TRUTH)),$(BUILD)/tests/ident/venv/bin/)python3 \
		tests/ident/real_sensors.py --truth $(or $(TRUTH),rig) --recordings $(BUILD)/sensors

bench-faults: $(BUILD)/hexid $(BUILD)/tests/rig/rig ## what identify says of recordings with random faults, 400 draws: does a wrong result pass? 10 minutes
	@HEXID=$(BUILD)/hexid RIG=$(BUILD)/tests/rig/rig tests/ident/random_faults.py --recordings $(BUILD)/sensors --faults 400 --jobs 2

bench-coverage: $(BUILD)/hexid ## method C on 200 random machines: do its intervals hold? 3 minutes
	@HEXID=$(BUILD)/hexid python3 tests/ident/coverage.py --machines 200

format: | deps-format ## the C and C++ as .clang-format has it
	@tests/format.py apply

format-check: | deps-format ## is it? Names the files and the difference; also comments beyond column 100
	@tests/format.py

docs: $(BUILD)/hexid $(BUILD)/tests/test_commands ## the reference of all keys, what commands answer, why samples are excluded: tables of docs/
	sed -i '/^<!-- hexid doctor --keys -->$$/q' docs/configuration.md && $(BUILD)/hexid doctor --keys >>docs/configuration.md
	sed -i '/^<!-- hexid doctor --refusals -->$$/q' docs/troubleshooting.md && $(BUILD)/hexid doctor --refusals >>docs/troubleshooting.md
	if $(BUILD)/tests/test_commands --table >$(BUILD)/commands.md; then \
		sed -i '/^<!-- test_commands --table -->$$/q' docs/commands.md && cat $(BUILD)/commands.md >>docs/commands.md; \
	else echo "hexid: docs/commands.md stays as it is"; fi

pictures: $(BUILD)/hexid | deps-pictures ## docs/pictures/, out of a run and a report of it
	@HEXID=$(BUILD)/hexid docs/pictures/draw.py

python-types: $(BUILD)/python/hexid/__init__.py ## hexid's message types for Python -> build/python (docs/python.md)

# Installing. DESTDIR and prefix have their usual meaning; configuration goes to /etc for prefix /usr, where the program looks for it, else
# to prefix/etc.
prefix     ?= /usr/local
sysconfdir ?= $(if $(filter /usr,$(prefix)),/etc,$(prefix)/etc)
unitdir    ?= $(if $(filter /usr,$(prefix)),/lib,$(prefix)/lib)/systemd/system
DOC        := $(DESTDIR)$(prefix)/share/doc/hexid
install: $(BUILD)/hexid $(BUILD)/man/done ## install under prefix (/usr/local), with DESTDIR before it
	install -D -m 755 $(BUILD)/hexid $(DESTDIR)$(prefix)/bin/hexid
	install -d $(DESTDIR)$(sysconfdir)/hexid $(DESTDIR)$(prefix)/share/man/man1 $(DOC)
	install -m 644 $(wildcard config/*.yaml config/*.dbc config/*.eds) $(DESTDIR)$(sysconfdir)/hexid/
	install -m 644 $(BUILD)/man/*.1 $(DESTDIR)$(prefix)/share/man/man1/
	install -D -m 644 config/hexid.bash $(DESTDIR)$(prefix)/share/bash-completion/completions/hexid
	install -D -m 644 config/hexid.default $(DESTDIR)$(sysconfdir)/default/hexid
	install -d $(DESTDIR)$(unitdir)
	sed 's|@prefix@|$(prefix)|; s|@sysconfdir@|$(sysconfdir)|' config/hexid.service >$(DESTDIR)$(unitdir)/hexid.service
	chmod 644 $(DESTDIR)$(unitdir)/hexid.service
	install -m 644 README.md LICENSE $(DOC)/
	cp -R docs lcmtypes $(DOC)/
	rm -f $(DOC)/docs/pictures/draw.py $(addprefix $(DOC)/docs/recordings/,*.py *.tsv *.json)
	install -D -m 644 tests/scenarios/axis.py $(DOC)/examples/axis.py
	config/pages $(DOC) $(sysconfdir)/hexid $(prefix)/share/doc/hexid/examples

# A manual page per subcommand, made from --help.
$(BUILD)/man/done: $(BUILD)/hexid config/manual.awk
	@rm -rf $(@D) && mkdir -p $(@D)
	@echo man $(@D)
	$(Q)config/manual $(BUILD)/hexid $(VERSION) $(@D)
	@touch $@

deb: $(BUILD)/hexid $(BUILD)/man/done | deps-deb ## a Debian package for this machine's architecture -> build/hexid_VERSION_ARCH.deb
	+@config/debian/build $(BUILD) $(VERSION)

spy: has-display $(BUILD)/spy/hexid.jar ## lcm-spy with hexid's message types (needs a display)
	java -Djava.net.preferIPv4Stack=true -Xmx256m \
		-cp /usr/share/java/lcm.jar:/usr/share/java/jchart2d.jar:$(abspath $(BUILD)/spy/hexid.jar) lcm.spy.Spy

has-display:
	@[ -n "$$DISPLAY" ] || { echo "make spy: lcm-spy draws a window, and DISPLAY is not set" >&2; exit 1; }

clean: ## remove build/ (logs under runs/ stay)
	rm -rf build

help: ## this list
	@awk -F ' ## ' '/^[a-z-]+:.* ## / {sub(/:.*/, "", $$1); printf "  make %-12s %s\n", $$1, $$2}' Makefile

# Packages. $(call install,...) prints nothing if none is missing, asks no questions, and waits its turn: one apt at a time.
define install
@command -v dpkg-query >/dev/null || exit 0; \
installed=$$(dpkg-query -W -f='$${Package} $${db:Status-Status}\n' $(1) 2>/dev/null | sed -n 's/ installed$$//p'); \
missing=$$(printf '%s\n' $(1) | grep -vxFe "$$installed"); \
[ -n "$$missing" ] || exit 0; \
as=; [ $$(id -u) -eq 0 ] || as='sudo -n'; \
$$as true 2>/dev/null || { echo "hexid: packages are missing, and this is neither root nor sudo without a password. Please run:" >&2; \
	echo "    sudo apt-get install" $$missing >&2; exit 1; }; \
echo "hexid: installing" $$missing; \
said=$$($$as apt-get -qq update && $$as env DEBIAN_FRONTEND=noninteractive apt-get -qqy -o DPkg::Lock::Timeout=300 -o Dpkg::Use-Pty=0 \
	install --no-install-recommends $$missing </dev/null 2>&1) || { echo "$$said" >&2; exit 1; }
endef

deps: deps-run deps-test ## install what is missing of the Debian packages for run and test
deps-run:
	$(call install,g++ gcc gnuplot-nox libeigen3-dev libjansson-dev liblcm-bin liblcm-dev libmatio-dev libmicrohttpd-dev libmodbus-dev libode-dev libseccomp-dev \
		libyaml-dev libzstd-dev zlib1g-dev)
deps-test: deps-run
	$(call install,can-utils chromium iproute2 kmod libcmocka-dev man-db python3-numpy python3-venv strace user-mode-linux util-linux)
deps-pictures: deps-test
	$(call install,pngquant)
deps-fuzz: deps-run
	$(call install,clang libclang-rt-14-dev)
deps-format:
	$(call install,clang-format-22)
deps-deb: deps-run
	$(call install,dpkg-dev lintian mmdebstrap)
deps-bench: deps-test
	$(call install,rt-tests valgrind)
deps-rt: deps-bench
	$(call install,stress-ng)
deps-rt-kernel: deps-run
	$(call install,busybox-static cpio qemu-system-x86)
deps-spy: has-display deps-run
	$(call install,default-jdk-headless default-jre libjchart2d-java liblcm-java)

# Building.
$(BUILD)/hexid: $(BUILD)/src/cli/main.o $(BUILD)/version.o $(BUILD)/libhexid.a
	@echo link $@
	$(Q)$(CC) $(SAN) $(HARD_LD) -o $@ $^ $(LDLIBS)

$(BUILD)/libhexid.a: $(LIB_OBJ)
	@rm -f $@
	$(Q)$(AR) rcs $@ $^

$(BENCHES): $(BUILD)/version.o
$(BUILD)/tests/bench/bench: LDLIBS += -Wl,--wrap=dWorldStep
$(BUILD)/tests/test_% $(BUILD)/tests/soak_%: LDLIBS += -lcmocka
# The linker of binutils that takes half the time, and programs without debug information, a quarter in size: a change in any module links a
# hundred tests anew. For a debugger: make OPT='-Og -g' BUILD=build/debug.
$(TESTS): LDLIBS += $(if $(SAN),,$(if $(wildcard /usr/bin/ld.gold),-fuse-ld=gold)) $(if $(HARDEN),-Xlinker -S)
$(BUILD)/tests/test_doctor $(BUILD)/tests/test_commands: LDLIBS += -Wl,--wrap=bus_receive
$(BUILD)/tests/test_can_link: LDLIBS += -Wl,--wrap=can_socket_open,--wrap=can_realtime_ns
$(BUILD)/tests/test_measured: LDLIBS += -Wl,--wrap=spectrum_measure,--wrap=spectrum_cut,--wrap=sampling_step_s
$(BUILD)/tests/%: $(BUILD)/tests/%.o $(BUILD)/libhexid.a
	@echo link $@
	$(Q)$(CC) $(SAN) -o $@ $^ $(LDLIBS)

# Preloaded into a hexid without sanitizers, so it takes none of its flags.
$(COUNTS): tests/rt/counts.c | deps-run
	@mkdir -p $(@D)
	@echo link $@
	$(Q)$(CC) -std=c17 -D_GNU_SOURCE -O2 $(WARN) -Iinclude -fPIC -shared -o $@ $< -ldl

$(FUZZERS): LDLIBS += -fsanitize=fuzzer
$(BUILD)/tests/fuzz/replay_%: $(BUILD)/tests/fuzz/fuzz_%.o $(BUILD)/tests/fuzz/replay.o $(BUILD)/libhexid.a
	@echo link $@
	$(Q)$(CC) $(SAN) -o $@ $^ $(LDLIBS)

$(TESTS:=.o) $(BUILD)/tests/soak_supervisor.o: | deps-test
$(BENCHES:=.o): | deps-bench
# A test's own code takes little of its time, except in these two, and -O0 halves the time of compiling it.
$(BUILD)/tests/test_%.o: OPT = $(if $(SAN),-O1 -g1,-O0)
$(BUILD)/tests/test_%.o: HARDEN =
$(BUILD)/tests/test_supervisor.o $(BUILD)/tests/test_quality.o: OPT = -O1 -g1
# Under a sanitizer -O3 takes three times as long to compile as -O1, and gains a fifth of the time where numbers are computed: not here.
# With -O1 and a sanitizer, GCC 12 does not see what bounds the length of a text; the ordinary build does, and warns.
ifneq ($(LIGHT),)
$(foreach d,src/cli src/io src/monitor src/report hal tests/fuzz,$(BUILD)/$d/%.o): OPT = -O1 -g1 -Wno-format-truncation
endif
$(BUILD)/%.o: %.c | $(LCM_C) deps-run
	@mkdir -p $(@D)
	@echo cc $<
	$(Q)$(CC) $(CFLAGS) -c -o $@ $<

$(BUILD)/%.o: %.cpp | deps-run
	@mkdir -p $(@D)
	@echo c++ $<
	$(Q)$(CXX) $(CXXFLAGS) -c -o $@ $<

# An effect is just a file in sim/effects/.
$(BUILD)/effect_table.c: sim/effects | deps-run
	@mkdir -p $(@D)
	@printf '%s\n' '#include "effect.h"' $(EFFECTS:%='extern const struct effect %;') 'const struct effect *const effect_table[] = {' \
		$(EFFECTS:%='    &%,') '    0};' '_Static_assert(sizeof effect_table / sizeof *effect_table <= EFFECTS_MAX + 1, "raise EFFECTS_MAX");' >$@

# The live page's files as arrays in the program.
$(BUILD)/live_page.c: $(PAGE) Makefile | deps-run
	@mkdir -p $(@D)
	@{ echo '#include "live_page.h"'; \
		$(foreach f,$(PAGE),echo 'static const unsigned char $(subst .,_,$(notdir $f))[] = {'; od -An -v -tu1 $f | sed 's/[0-9][0-9]*/&,/g'; echo '};';) \
		echo 'const struct live_file live_files[] = {'; \
		printf '    {"%s", %s, sizeof %s},\n' $(foreach f,$(notdir $(PAGE)),$f $(subst .,_,$f) $(subst .,_,$f)); echo '    {0}};'; } >$@

# Text of --version: VERSION and in a checkout the commit, with a + if any source was changed or added since. Rewritten only when it
# differs.
GIT    := git -c safe.directory='*'
COMMIT := $(shell $(GIT) describe --always --exclude='*' --abbrev=12 --dirty 2>/dev/null)
NEW    := $(if $(COMMIT),$(shell $(GIT) ls-files --others --exclude-standard -- include sim hal src lcmtypes 2>/dev/null))
COMMIT := $(COMMIT:%-dirty=%)$(if $(NEW)$(filter %-dirty,$(COMMIT)),+)
$(BUILD)/version.c: always
	@mkdir -p $(@D)
	@printf '#include "version.h"\nconst char version[] = "%s";\n' '$(VERSION)$(COMMIT:%= (commit %))' >$@.new
	@cmp -s $@.new $@ && rm $@.new || mv $@.new $@

$(BUILD)/version.o $(BUILD)/effect_table.o $(BUILD)/live_page.o: %.o: %.c | deps-run
	@echo cc $<
	$(Q)$(CC) $(CFLAGS) -c -o $@ $<

# Generated code does not comply with our warnings.
$(BUILD)/lcmtypes/%.o: $(BUILD)/lcmtypes/%.c
	$(Q)$(CC) -std=gnu17 $(OPT) $(HARDEN) $(SAN) -w -I$(BUILD)/lcmtypes -c -o $@ $<

$(BUILD)/lcmtypes/%.c: lcmtypes/%.lcm | deps-run
	@mkdir -p $(@D)
	@echo lcm-gen $<
	$(Q)lcm-gen -c --c-cpath $(BUILD)/lcmtypes --c-hpath $(BUILD)/lcmtypes $<

# Third-party programs that are the peers in tests.
$(VENV)/ready: tests/peers/requirements.txt | deps-test
	@rm -rf $(VENV)
	@echo venv $(VENV)
	$(Q)python3 -m venv $(VENV)
	$(Q)$(VENV)/bin/pip install --quiet --disable-pip-version-check -r $<
	@touch $@

# A second truth of the identification.
$(BUILD)/tests/ident/venv/ready: tests/ident/requirements.txt | deps-test
	@rm -rf $(@D)
	@echo venv $(@D)
	$(Q)python3 -m venv $(@D)
	$(Q)$(@D)/bin/pip install --quiet --disable-pip-version-check -r $<
	@touch $@

# An independent rig. RIG selects the scorecard's. It uses only Pinocchio's headers; its variant has more types than Boost.MPL's
# preprocessed headers allow.
RIG_BUILD := $(BUILD)/tests/rig
$(RIG_BUILD)/venv/ready: tests/rig/requirements.txt | deps-test
	@rm -rf $(@D)
	@echo venv $(@D)
	$(Q)python3 -m venv $(@D)
	$(Q)$(@D)/bin/pip install --quiet --disable-pip-version-check --no-deps -r $<
	@touch $@
$(RIG_BUILD)/%.o: tests/rig/%.cpp $(wildcard tests/rig/*.hpp) tests/rig/bridge.h $(RIG_BUILD)/venv/ready
	@echo c++ $<
	$(Q)$(CXX) -std=c++17 -O3 -DNDEBUG -Wall -Wextra -Wshadow -DBOOST_MPL_LIMIT_LIST_SIZE=30 -DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS \
		$(addprefix -isystem ,$(wildcard $(RIG_BUILD)/venv/lib/python3*/site-packages/cmeel.prefix/include) /usr/include/eigen3) -c $< -o $@
$(RIG_BUILD)/rig: $(patsubst %.cpp,$(BUILD)/%.o,$(filter-out tests/rig/bridge.cpp,$(wildcard tests/rig/*.cpp)))
	@echo link $@
	$(Q)$(CXX) -o $@ $^

# hexid's controller on the rig.
$(BUILD)/tests/bench/rig/control: $(BUILD)/tests/bench/rig/control.o $(BUILD)/version.o \
		$(addprefix $(RIG_BUILD)/,bodies.o bridge.o machine.o rig.o settings.o) $(BUILD)/libhexid.a
	@echo link $@
	$(Q)$(CXX) -o $@ $^ $(LDLIBS)

$(BUILD)/python/hexid/__init__.py: $(LCM) | deps-run
	@rm -rf $(BUILD)/python
	@echo lcm-gen $(BUILD)/python
	$(Q)lcm-gen -p --ppath $(BUILD)/python $^

$(BUILD)/spy/hexid.jar: $(LCM) | deps-spy
	@rm -rf $(@D) && mkdir -p $(@D)
	@echo jar $@
	$(Q)lcm-gen -j --jpath $(@D) $^
	$(Q)javac -cp /usr/share/java/lcm.jar -d $(@D) $(@D)/hexid/*.java
	$(Q)cd $(@D) && jar cf $(@F) hexid/*.class

.PHONY: all always check install deb has-display run test test-long test-rt asan tsan fuzz fuzz-run soak bench bench-paper bench-gap bench-coverage bench-friction bench-springs bench-sensors bench-faults bench-methods bench-table5 rig check-rig format format-check docs pictures python-types spy clean help
.PHONY: bench-check bench-control bench-control-rig bench-robust bench-cycle bench-hour bench-rt bench-trajectories soak-rt test-rt-kernel deps-rt deps-rt-kernel
.PHONY: deps deps-run deps-test deps-deb deps-format deps-pictures deps-fuzz deps-bench deps-spy
.SECONDARY:
-include $(BUILD)/tests/soak_supervisor.d $(patsubst %.o,%.d,$(LIB_OBJ)) $(BUILD)/src/cli/main.d $(TESTS:=.d) $(BENCHES:=.d) $(BUILD)/tests/bench/rig/control.d $(FUZZERS:=.d)
