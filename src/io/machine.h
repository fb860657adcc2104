/* Machines of this host by name: where the sockets of each stand, who may have a name, and which
 * machines there are. A machine NAME has two SOCK_SEQPACKET sockets (command_server.h) in one
 * directory: NAME.stop, for `stop` and `park` and everybody, and NAME, for all commands.
 *
 * The directory is $HEXID_RUNTIME_DIR where that is set (containers, tests). Otherwise a daemon
 * takes /run/hexid (made by the unit's RuntimeDirectory=, or by root), else hexid/ in its user's
 * runtime directory; a client looks in both, and root in those of all users. SAFETY: a directory
 * that is a link, that others may write, or that belongs to neither root nor this user is not
 * used: another's program there would answer for the machine. /run/hexid is excepted from the last
 * rule: only root makes it.
 *
 * A name is owned by a lock on NAME.lock, which the kernel releases however the daemon ends;
 * sockets that it left behind are removed by the next owner. SAFETY: nobody else may open that
 * file: who may read one may lock it, and keep the daemon from its name. Main thread; files are
 * opened. */
#ifndef HEXID_MACHINE_H
#define HEXID_MACHINE_H

#include <stdbool.h>
#include <sys/types.h>
#include <sys/un.h>

#include "status.h"

#define MACHINE_NAME_DEFAULT "hexid"

enum {
    MACHINE_NAME_SIZE = 33,
    MACHINE_DIRECTORY_SIZE = 80,
    MACHINE_PLACES = 16,                               /* directories, */
    MACHINES_EACH = 32,                                /* and machines in each */
    MACHINES_MAX = MACHINE_PLACES * MACHINES_EACH,
};

struct machine {
    char name[MACHINE_NAME_SIZE];
    char directory[MACHINE_DIRECTORY_SIZE];
};

/* 1 to 32 of A-Z a-z 0-9 - _ */
bool machine_name_valid(const char *name);

/* Address of the machine's socket, of NAME.stop or NAME. False: the path is too long for one. */
bool machine_address(const struct machine *m, bool stop, struct sockaddr_un *address);

/* Daemon: takes the name, or with "" MACHINE_NAME_DEFAULT or the first of -2, -3 ... that is free.
 * *lock is a descriptor to keep open. STATUS_UNSAFE: the name is taken, or the directory is not to
 * be trusted; STATUS_IO: there is no directory, or nothing can be made in it. */
int machine_claim(const char *name, struct machine *m, int *lock, struct error *error);

/* Client: the machines that run, with this name or with "" all. Returns how many, at most
 * MACHINES_MAX. SAFETY: at most MACHINES_EACH of a directory, so that sockets in one user's do
 * not crowd out the machine in another's. What kept it from looking somewhere is in *doubt
 * (status STATUS_OK: nothing). */
int machine_find(const char *name, struct machine list[MACHINES_MAX], struct error *doubt);

/* Client: a connection to the machine's socket, not blocking, or -1 with errno: EACCES: not
 * allowed to; ECONNREFUSED, ENOENT: the daemon has ended; EPERM: it belongs to neither root, this
 * user nor the directory's owner; EAGAIN: too many wait, try again. */
int machine_connect(const struct machine *m, bool stop);

/* "/run/hexid, /run/user/1000/hexid": where a client looks, for messages. */
void machine_places(char *text, size_t size);

#endif
