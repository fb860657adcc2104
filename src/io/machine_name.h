/* Machines of this host by name: where their sockets are, who may use a name, and which machines
 * run. A machine NAME has two SOCK_SEQPACKET sockets (command_server.h) in one directory:
 * NAME.stop, which accepts `stop` and `park` from everybody, and NAME for all commands.
 *
 * The directory is $HEXID_RUNTIME_DIR if that is set (containers, tests). Otherwise a daemon takes
 * /run/hexid (made by the unit's RuntimeDirectory=, or by root), else hexid/ in its user's runtime
 * directory; a client looks in both, and root in those of all users. SAFETY: a directory that is a
 * link, that others may write (unless it is sticky), or that belongs to neither root nor this user
 * is not used, because another user's program there could answer for the machine. The last rule
 * does not apply to root, nor to /run/hexid, which only root can make.
 *
 * A name is owned by a lock on NAME.lock, which the kernel releases however the daemon ends; the
 * next owner removes sockets left behind. SAFETY: nobody else may open that file, because
 * whoever can read a file can lock it and thereby deny the daemon its name. Main thread; opens
 * files. */
#ifndef HEXID_MACHINE_NAME_H
#define HEXID_MACHINE_NAME_H

#include <stdbool.h>
#include <sys/types.h>
#include <sys/un.h>

#include "status.h"

#define MACHINE_NAME_DEFAULT "hexid"

enum {
    MACHINE_NAME_SIZE = 33,
    MACHINE_DIRECTORY_SIZE = 80,
    MACHINE_PLACES = 16,                               /* most directories that are searched */
    MACHINES_EACH = 32,                            /* most machines that are found in a directory */
    MACHINES_MAX = MACHINE_PLACES * MACHINES_EACH,
};

struct machine_name {
    char name[MACHINE_NAME_SIZE];
    char directory[MACHINE_DIRECTORY_SIZE];
};

/* Returns true if the name has 1 to 32 characters of A-Z a-z 0-9 - _ */
bool machine_name_valid(const char *name);

/* Makes the address of the machine's socket NAME.stop (`stop`) or NAME. Returns false if the path
 * is too long. */
bool machine_address(const struct machine_name *m, bool stop, struct sockaddr_un *address);

/* For the daemon: takes the machine's name. With name "" it takes MACHINE_NAME_DEFAULT, or, if that
 * is taken, the first free one of MACHINE_NAME_DEFAULT-2, -3 ... *lock is a descriptor to keep
 * open. STATUS_UNSAFE: the name is taken, the directory cannot be trusted, or a file that is no
 * socket is in the way; STATUS_IO: no directory, or it is not writable; STATUS_USAGE: too long a
 * path. */
int machine_claim(const char *name, struct machine_name *m, int *lock, struct error *error);

/* For clients: finds the running machines with this name; the name "" finds all. Returns their
 * number, at most MACHINES_MAX. SAFETY: it takes at most MACHINES_EACH machines from a directory,
 * so that sockets in one user's directory do not displace a machine in another's. If a machine may
 * have been missed, *doubt says where and why; otherwise its status is STATUS_OK. */
int machine_find(const char *name, struct machine_name list[MACHINES_MAX], struct error *doubt);

/* For clients: connects to the machine's socket, non-blocking. Returns -1 with errno: EACCES: not
 * permitted; ECONNREFUSED, ENOENT: the daemon has ended; EPERM: the directory cannot be trusted, or
 * the daemon's user is neither root, this user nor the directory's owner; EAGAIN: too many clients
 * wait, try again. */
int machine_connect(const struct machine_name *m, bool stop);

/* Lists the directories in which a client looks, for messages: "/run/hexid,
 * /run/user/1000/hexid". */
void machine_places(char *text, size_t size);

#endif
