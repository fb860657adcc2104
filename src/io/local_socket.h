/* The sockets by which programs of this host reach the daemon. Any thread. */
#ifndef HEXID_LOCAL_SOCKET_H
#define HEXID_LOCAL_SOCKET_H

/* Opens a Unix-domain socket of packets, which never blocks. SAFETY: this socket and the
 * connections that it accepts refuse packets with descriptors. A call that reads such a packet, or
 * closes its connection, would also close the descriptors in it; if one of these is a TCP socket
 * with SO_LINGER, its sender can block that call for as long as he likes. Linux can refuse such
 * packets from 6.16 on; with earlier versions the loop parks in this case (loop_attend()). Returns
 * the descriptor, or -1 with errno. */
int local_socket(void);

#endif
