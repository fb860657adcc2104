/* The stream to and from other programs: LCM messages over UDP multicast (lcmtypes/README.md:
 * channels and types). Ordinary threads only, never the loop's; nothing here blocks but bus_wait().
 *
 * This module implements the protocol's short messages itself: a header of eight bytes, the
 * channel's name, the data. liblcm's receiver (1.3.1) writes fragments to whatever offsets the
 * datagrams state, so one datagram of 66 bytes from anybody crashes the process; it cannot select
 * senders or channels, and its self-test at the start takes up to ten seconds. Here bus_parse()
 * checks each datagram, fragments are dropped (all of hexid's messages are short), datagrams that
 * were not sent to the group never arrive, and the kernel drops channels that bus_listen() does not
 * name. */
#ifndef HEXID_BUS_H
#define HEXID_BUS_H

#include <stdbool.h>
#include <stddef.h>

#include "status.h"

struct bus;

enum { BUS_CHANNEL_SIZE = 64, BUS_DATA_MAX = 65000, BUS_INTERFACE_SIZE = 16 };

struct bus_message {
    char channel[BUS_CHANNEL_SIZE];
    const unsigned char *data; /* bytes of the message; valid until the next bus_receive() */
    int size;
};

/* Senders whose messages are accepted. */
enum bus_source { BUS_ANYONE, BUS_THIS_HOST };

/* Size of the receive buffer requested from the system, which grants at most net.core.rmem_max. */
enum { BUS_RECEIVE_BUFFER = 1 << 21 };

/* Opens "udpm://239.255.76.67:7667?ttl=0"; these values are the defaults of omitted parts.
 * Nothing is received before bus_listen(). STATUS_USAGE: malformed URL; STATUS_IO: no multicast
 * route, with the remedy. */
int bus_open(struct bus **bus, const char *url, struct error *error);
void bus_close(struct bus *bus);

/* Finds an interface that is up, has an IPv4 address and is no loopback. Returns false if there is
 * none. */
bool bus_network(char name[BUS_INTERFACE_SIZE]);

/* Writes the shell commands that add a multicast route: by a network's interface if this host has
 * one, else by the loopback. SAFETY: on a host with a network address, a route by lo keeps LCM's
 * programs from receiving each other's messages. */
void bus_remedy(char *text, size_t size);

/* The kernel's route to the group, by which messages are sent. */
struct bus_route {
    char group[16];      /* address of the group, "239.255.76.67" */
    int port, ttl;       /* port of the group, and time to live of datagrams; with ttl 0 they stay
                          * on this host */
    char interface[BUS_INTERFACE_SIZE];  /* name of the interface by which messages leave; "": there
                                          * is no route */
    bool loopback;
};
struct bus_route bus_route(const struct bus *bus);

/* Sends a message to the bus. Returns 0, or -1 if the message or the name of its channel is too
 * long, or if the system did not accept it at once; callers may ignore that, because the stream is
 * only for watching. Several threads may publish. */
int bus_publish(struct bus *bus, const char *channel, const void *data, int size);

/* Starts to receive the channels whose names begin with the prefix, of at most 20 letters.
 * SAFETY: a datagram is dropped if it was not sent to the group, or with BUS_THIS_HOST if it comes
 * from an address that is neither this host's nor one of bus_allow(). Returns 0 or STATUS_IO. */
int bus_listen(struct bus *bus, const char *prefix, enum bus_source source, struct error *error);

/* Accepts messages from these hosts, too, whatever `source` bus_listen() was given: up to
 * BUS_OTHERS_MAX addresses separated by blanks or commas, "10.0.0.7 10.0.0.8". STATUS_USAGE:
 * malformed list. An address does not prove who sent a message. */
enum { BUS_OTHERS_MAX = 16 };
int bus_allow(struct bus *bus, const char *addresses, struct error *error);

/* Returns the receiving descriptor, for poll(); -1 before bus_listen(). */
int bus_fd(const struct bus *bus);

/* Takes the next datagram. Returns 1: a message; BUS_DROPPED: malformed or from a sender that is
 * not accepted; 0: no datagram waits; STATUS_IO: the socket is broken. */
enum { BUS_DROPPED = 2 };
int bus_receive(struct bus *bus, struct bus_message *message);

/* Waits for a datagram, at most timeout_ms. Returns 1: a datagram waits; 0: none came, or a signal
 * ended the wait; STATUS_IO: the wait failed. */
int bus_wait(struct bus *bus, int timeout_ms);

/* Parses a datagram of the protocol. Returns false unless the datagram is a short message with a
 * whole channel name. Pure; message->data points into the datagram. */
bool bus_parse(const unsigned char *datagram, int size, struct bus_message *message);

#endif
