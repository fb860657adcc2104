/* The stream to and from other programs: LCM messages over UDP multicast (lcmtypes/README.md:
 * channels and types). Ordinary threads only, never the loop's; nothing here blocks but bus_wait().
 *
 * The protocol's short messages are spoken here and not by liblcm: a header of eight bytes, the
 * channel's name, the data. liblcm's receiver (1.3.1) puts fragments together at offsets that
 * the datagrams state, so that one datagram of 66 bytes from anybody ends the process; it can
 * be told neither from whom nor what to receive, and it tests itself for up to ten seconds.
 * Here a datagram is bounded and checked by bus_parse(), fragments are dropped (all of hexid's
 * messages are short), what is not for the group never arrives, and the kernel drops channels
 * that were not asked for. */
#ifndef HEXID_BUS_H
#define HEXID_BUS_H

#include <stdbool.h>
#include <stddef.h>

#include "status.h"

struct bus;

enum { BUS_CHANNEL_SIZE = 64, BUS_DATA_MAX = 65000, BUS_INTERFACE_SIZE = 16 };

struct bus_message {
    char channel[BUS_CHANNEL_SIZE];
    const unsigned char *data; /* valid until the next bus_receive() */
    int size;
};

/* From whom messages are taken. */
enum bus_source { BUS_ANYONE, BUS_THIS_HOST };

/* Asked of the system for what arrives while nobody looks; it gives as much as
 * net.core.rmem_max allows. */
enum { BUS_RECEIVE_BUFFER = 1 << 21 };

/* "udpm://239.255.76.67:7667?ttl=0"; a part that is left out is as here. STATUS_USAGE: no such URL;
 * STATUS_IO with the remedy: no multicast route. Nothing is received before bus_listen(). */
int bus_open(struct bus **bus, const char *url, struct error *error);
void bus_close(struct bus *bus);

/* Finds an interface that is up, has an IPv4 address and leads to a network. Returns false if
 * there is none. */
bool bus_network(char name[BUS_INTERFACE_SIZE]);

/* Shell commands that make a route for multicast: by a network's interface where this host has one,
 * else by the loopback. SAFETY: beside a network's address a route by lo makes LCM's programs deaf
 * to each other. */
void bus_remedy(char *text, size_t size);

/* The kernel's route to the group, by which messages are published. */
struct bus_route {
    char group[16];      /* 239.255.76.67 */
    int port, ttl;       /* ttl 0: stays on this host */
    char interface[BUS_INTERFACE_SIZE];  /* "": there is no route */
    bool loopback;
};
struct bus_route bus_route(const struct bus *bus);

/* 0, or -1 when the system did not take it at once: the stream is for watching, and who publishes
 * goes on. Several threads may publish. */
int bus_publish(struct bus *bus, const char *channel, const void *data, int size);

/* Receives the channels whose names begin with the prefix from now on. SAFETY: a datagram that
 * was not sent to the group, or with BUS_THIS_HOST comes from an address that is not this
 * host's, is dropped. */
int bus_listen(struct bus *bus, const char *prefix, enum bus_source source, struct error *error);

/* Takes messages from these hosts, too, whatever the source: up to BUS_OTHERS_MAX addresses as
 * "10.0.0.7 10.0.0.8", with blanks or commas between them. STATUS_USAGE: no such list. An address
 * is no proof of who sent. */
enum { BUS_OTHERS_MAX = 16 };
int bus_allow(struct bus *bus, const char *addresses, struct error *error);

/* For poll(); -1 before bus_listen(). */
int bus_fd(const struct bus *bus);

/* The next datagram that has come: 1 a message; BUS_DROPPED: it was none, or from elsewhere; 0:
 * none has come; STATUS_IO: the socket is broken. */
enum { BUS_DROPPED = 2 };
int bus_receive(struct bus *bus, struct bus_message *message);

/* Waits for one, at most so long: 1, 0 or STATUS_IO. */
int bus_wait(struct bus *bus, int timeout_ms);

/* A datagram of the protocol: false for anything that is no whole short message. Pure; the
 * message's data point into the datagram. */
bool bus_parse(const unsigned char *datagram, int size, struct bus_message *message);

#endif
