# hexid: `make help` lists the targets.
BUILD   ?= build
CC      := gcc
CXX     := g++
AR      := gcc-ar
OPT     ?= -O2 -g
SAN     ?=
WARN    := -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wdouble-promotion -Wstrict-prototypes -Wmissing-prototypes -Wvla -Werror
WARNXX  := -Wall -Wextra -Wshadow -Werror
INCLUDE := -Iinclude -Isim -Ihal $(addprefix -I,$(wildcard src/*)) -I$(BUILD)/lcmtypes
# No contraction: the same results from every optimisation level and every call site.
CFLAGS   = -std=c17 -D_GNU_SOURCE $(OPT) -ffp-contract=off $(WARN) $(SAN) $(INCLUDE) -MMD -MP
CXXFLAGS = -std=c++17 $(OPT) -ffp-contract=off $(WARNXX) -fno-exceptions -fno-rtti $(SAN) $(INCLUDE) -isystem /usr/include/eigen3 -MMD -MP
LDLIBS  := -llcm -lyaml -ljansson -lode -lmodbus -lm -lpthread -lstdc++

LCM     := $(wildcard lcmtypes/*.lcm)
LCM_C   := $(LCM:lcmtypes/%.lcm=$(BUILD)/lcmtypes/%.c)
SRC     := $(wildcard src/*/*.c hal/*.c sim/*.c sim/effects/*.c)
LIB_SRC := $(filter-out src/cli/main.c,$(SRC))
LIB_OBJ := $(LIB_SRC:%.c=$(BUILD)/%.o) $(patsubst %.cpp,$(BUILD)/%.o,$(wildcard src/lin/*.cpp)) $(LCM_C:.c=.o)
TESTS   := $(patsubst tests/%.c,$(BUILD)/tests/%,$(wildcard tests/test_*.c))

all: $(BUILD)/hexid

$(BUILD)/hexid: $(BUILD)/src/cli/main.o $(BUILD)/libhexid.a
	$(CC) $(SAN) -o $@ $^ $(LDLIBS)

$(BUILD)/libhexid.a: $(LIB_OBJ)
	rm -f $@ && $(AR) rcs $@ $^

$(BUILD)/tests/%: $(BUILD)/tests/%.o $(BUILD)/libhexid.a
	$(CC) $(SAN) -o $@ $^ -lcmocka $(LDLIBS)

$(BUILD)/%.o: %.c | $(LCM_C)
	@mkdir -p $(@D)
	$(CC) $(CFLAGS) -c -o $@ $<

$(BUILD)/%.o: %.cpp
	@mkdir -p $(@D)
	$(CXX) $(CXXFLAGS) -c -o $@ $<

# Generated code does not meet our warnings.
$(BUILD)/lcmtypes/%.o: $(BUILD)/lcmtypes/%.c
	$(CC) -std=gnu17 $(OPT) $(SAN) -w -I$(BUILD)/lcmtypes -c -o $@ $<

$(BUILD)/lcmtypes/%.c: lcmtypes/%.lcm
	@mkdir -p $(@D)
	lcm-gen -c --c-cpath $(BUILD)/lcmtypes --c-hpath $(BUILD)/lcmtypes $<

clean:
	rm -rf build

.PHONY: all clean
.SECONDARY:
-include $(shell find $(BUILD) -name '*.d' 2>/dev/null)
