/* The sockets by which programs of this host reach the daemon. Any thread. */
#ifndef HEXID_LOCAL_SOCKET_H
#define HEXID_LOCAL_SOCKET_H

/* Opens a Unix-domain socket of packets, which never blocks. SAFETY: it and the connections that it
 * accepts refuse packets with descriptors. The kernel drops descriptors that nobody takes within
 * the call that reads the packet or closes the connection, which a TCP socket that lingers holds up
 * for as long as its sender likes. Linux has this option from 6.16 on; before, the loop parks
 * (loop_attend()). Returns the descriptor, or -1 with errno. */
int local_socket(void);

#endif
