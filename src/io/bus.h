/* The stream to and from other programs: raw messages over LCM. Channels and types: lcmtypes/README.md.
 * Publishing takes a mutex and a blocking system call, and receiving has a thread of liblcm's own: ordinary threads only, never the loop's.
 * One thread may publish while another handles. */
#ifndef HEXID_BUS_H
#define HEXID_BUS_H

#include "status.h"
#include "types.h"

struct bus;

/* "udpm://239.255.76.67:7667?ttl=0", or "memq://" within one program. -3 with the remedy when there is no multicast route. */
int bus_open(struct bus **bus, const char *url, struct error *error);
void bus_close(struct bus *bus);

/* 0, or -1 when the system did not take it: the stream is for watching, and who publishes goes on. A channel has at most 63 characters. */
int bus_publish(struct bus *bus, const char *channel, const void *data, int size);

typedef void bus_callback(void *context, const char *channel, const void *data, int size);
typedef void bus_command_callback(void *context, enum command command);

/* Each message of a channel that the regular expression matches as a whole; data are gone when the callback returns. One context and
 * callback at a time: a later call replaces those of an earlier one. 0 or -3. */
int bus_subscribe_raw(struct bus *bus, const char *channel_regex, bus_callback *callback, void *context);

/* Each command that is one: what else arrives on HEXID_COMMAND is dropped. Whether it may move anything is for the receiver to decide. */
int bus_subscribe_commands(struct bus *bus, bus_command_callback *callback, void *context);

/* Calls back, in this thread, for one message; waits for it at most timeout_ms. 1 a message, 0 none, -3 the bus is broken. */
int bus_handle(struct bus *bus, int timeout_ms);

#endif
