#include "local_socket.h"

#include <sys/socket.h>

int local_socket(void) {
#ifndef SO_PASSRIGHTS
    enum { SO_PASSRIGHTS = 83 };
#endif
    int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd >= 0) setsockopt(fd, SOL_SOCKET, SO_PASSRIGHTS, &(int){0}, sizeof(int));
    return fd;
}
