/* ip_filter CGROUP COMMAND...: runs a command as systemd runs a service with IPAddressDeny=any and
 * IPAddressAllow=localhost multicast: in its own cgroup, whose BPF programs filter incoming IPv4
 * packets by source and outgoing ones by destination. Status 77: the system allows no such
 * programs. */
#include <fcntl.h>
#include <linux/bpf.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

enum { SOURCE = 12, DESTINATION = 16, IPV4 = 0x0008 /* as __be16 */, LOCALHOST = 127, MULTICAST = 0xe0, CANNOT = 77 };
#define DO(code_, dst, src, off_, imm_) \
    ((struct bpf_insn){.code = (code_), .dst_reg = (dst), .src_reg = (src), .off = (off_), .imm = (imm_)})

static int give_up(const char *what) {
    perror(what);
    exit(CANNOT);
}

/* Writes a program that returns 1 if the first byte of the address at this place of the IP header
 * is 127 or 224 to 239. */
static int load(int place) {
    const struct bpf_insn code[] = {
        DO(BPF_ALU64 | BPF_MOV | BPF_X, 6, 1, 0, 0),
        DO(BPF_LDX | BPF_MEM | BPF_W, 7, 1, offsetof(struct __sk_buff, protocol), 0),
        DO(BPF_JMP | BPF_JNE | BPF_K, 7, 0, 10, IPV4),
        DO(BPF_ALU64 | BPF_MOV | BPF_X, 1, 6, 0, 0),
        DO(BPF_ALU64 | BPF_MOV | BPF_K, 2, 0, 0, place),
        DO(BPF_ALU64 | BPF_MOV | BPF_X, 3, 10, 0, 0),
        DO(BPF_ALU64 | BPF_ADD | BPF_K, 3, 0, 0, -4),
        DO(BPF_ALU64 | BPF_MOV | BPF_K, 4, 0, 0, 4),
        DO(BPF_JMP | BPF_CALL, 0, 0, 0, BPF_FUNC_skb_load_bytes),
        DO(BPF_LDX | BPF_MEM | BPF_B, 7, 10, -4, 0),
        DO(BPF_JMP | BPF_JEQ | BPF_K, 7, 0, 2, LOCALHOST),
        DO(BPF_ALU64 | BPF_AND | BPF_K, 7, 0, 0, 0xf0),
        DO(BPF_JMP | BPF_JNE | BPF_K, 7, 0, 2, MULTICAST),
        DO(BPF_ALU64 | BPF_MOV | BPF_K, 0, 0, 0, 1),
        DO(BPF_JMP | BPF_EXIT, 0, 0, 0, 0),
        DO(BPF_ALU64 | BPF_MOV | BPF_K, 0, 0, 0, 0),
        DO(BPF_JMP | BPF_EXIT, 0, 0, 0, 0),
    };
    union bpf_attr a = {.prog_type = BPF_PROG_TYPE_CGROUP_SKB,
                        .insns = (unsigned long)code,
                        .insn_cnt = sizeof code / sizeof *code,
                        .license = (unsigned long)"GPL"};
    long program = syscall(SYS_bpf, BPF_PROG_LOAD, &a, sizeof a);
    return program < 0 ? give_up("BPF program") : (int)program;
}

static void attach(int cgroup, int place, enum bpf_attach_type type) {
    union bpf_attr a = {.target_fd = (unsigned)cgroup, .attach_bpf_fd = (unsigned)load(place), .attach_type = type};
    if (syscall(SYS_bpf, BPF_PROG_ATTACH, &a, sizeof a)) give_up("cgroup's filter");
}

int main(int argc, char **argv) {
    char path[400];
    if (argc < 3) return CANNOT;
    if (mkdir(argv[1], 0755)) give_up(argv[1]);
    int cgroup = open(argv[1], O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (cgroup < 0) give_up(argv[1]);
    attach(cgroup, SOURCE, BPF_CGROUP_INET_INGRESS);
    attach(cgroup, DESTINATION, BPF_CGROUP_INET_EGRESS);
    snprintf(path, sizeof path, "%s/cgroup.procs", argv[1]);
    FILE *file = fopen(path, "w");
    if (!file || fprintf(file, "%d\n", getpid()) < 0 || fclose(file)) give_up(path);
    execvp(argv[2], argv + 2);
    return give_up(argv[2]);
}
