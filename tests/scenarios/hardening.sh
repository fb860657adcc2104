#!/bin/bash
# Hardening that compiler and linker built into the program against its own memory errors, read from the program itself. These are the
# checks of checksec and hardening-check, and three that they lack: shadow stacks, stack clash and immediate binding.
. tests/scenarios/lib
skip_under 'asan|tsan' "a hardened program" "sanitizers bring checks of their own"

header() { readelf -hW "$hexid" | grep -q "$1"; }
segment() { readelf -lW "$hexid" | grep -q "$1"; }
dynamic() { readelf -dW "$hexid" | grep -q "$1"; }
imports() { readelf --dyn-syms -W "$hexid" | grep -q " UND $1"; }
code_of() { objdump -d --no-show-raw-insn --disassemble="$1" "$hexid"; }

independent() { header 'Type: *DYN ' && segment INTERP && dynamic 'FLAGS_1.* PIE'; }
no_stack_code() { segment 'GNU_STACK' && ! segment 'GNU_STACK.*E '; }
no_writable_code() { ! segment '^ *LOAD .*WE '; }
fortified() { imports __snprintf_chk && imports __memcpy_chk; }
marked() { code_of main | grep -q endbr64; } # start of a function that may be called by address
probed() { objdump -d --no-show-raw-insn "$hexid" | grep -q "or.* \$0x0,.*(%rsp)"; } # for example before prefault_stack()'s 256 KiB

claim "position-independent: the addresses are drawn anew with every start" independent
claim "the table of imported functions is bound at the start" dynamic '\(BIND_NOW\|FLAGS .*NOW\)'
claim "and read-only from then on" segment GNU_RELRO
claim "the stack cannot be executed" no_stack_code
claim "nothing can be both written and executed" no_writable_code
claim "no code was relocated in place" eval '! dynamic TEXTREL'
claim "no path of the builder's is searched for libraries" eval '! dynamic "R\(UN\)\?PATH"'
claim "a function with a buffer sees it overrun" imports __stack_chk_fail
claim "copies into buffers of known size are checked" fortified
claim "indirect calls land on marked places only, where the processor has that" marked
claim "a large buffer does not step over the stack's guard page" probed
