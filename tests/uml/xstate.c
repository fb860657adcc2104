/* A preload for linux.uml. Debian 12's user-mode kernel keeps 2696 bytes of a process's vector registers: all there is up to AVX-512. A
 * host with AMX has tile registers behind them and refuses to set less than the whole, and the kernel dies with its first process. So the
 * whole is read, the part that the kernel knows is laid over it, and the whole is written. Nothing that runs in there uses the tiles. */
#include <dlfcn.h>
#include <elf.h>
#include <stdarg.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/types.h>
#include <sys/uio.h>

/* Not on the stack: a kernel's is small. The kernel is one thread. */
static long (*real)(enum __ptrace_request request, ...);
static unsigned char whole[16384];

__attribute__((constructor)) static void find_real(void) { *(void **)&real = dlsym(RTLD_NEXT, "ptrace"); }

static long set_registers(pid_t pid, void *set, struct iovec *part) {
    struct iovec all = {.iov_base = whole, .iov_len = sizeof whole};
    if (real(PTRACE_GETREGSET, pid, set, &all) < 0) return -1;
    if (part->iov_len >= all.iov_len) return real(PTRACE_SETREGSET, pid, set, part);
    memcpy(whole, part->iov_base, part->iov_len);
    return real(PTRACE_SETREGSET, pid, set, &all);
}

long ptrace(enum __ptrace_request request, ...) {
    va_list args;
    va_start(args, request);
    pid_t pid = va_arg(args, pid_t);
    void *address = va_arg(args, void *), *data = va_arg(args, void *);
    va_end(args);
    if (request == PTRACE_SETREGSET && address == (void *)NT_X86_XSTATE) return set_registers(pid, address, data);
    return real(request, pid, address, data);
}
