/* The live page's server: serves the files of src/monitor/page/ and a stream of server-sent events
 * to browsers that may be slow, gone or hostile. It runs in one thread and never waits for a
 * browser: a slow browser gets the newest state later, and delays neither other browsers nor LCM.
 * It is read-only: no request has an effect.
 *
 * Memory is bounded: LIVE_CLIENTS browsers, each with one chunk of the stream under way; idle
 * connections are closed. */
#ifndef HEXID_LIVE_SERVER_H
#define HEXID_LIVE_SERVER_H

#include "live_request.h"
#include "live_state.h"

enum { LIVE_CLIENTS = 16 };

struct live_server;

/* Starts the server, which owns the listener's descriptor from then on; if the start fails, the
 * descriptor is closed. `served` is the host name under which the page is served; `served` and
 * `state` must outlive the server. Returns 0, or -3 on failure. */
int live_server_start(struct live_server **server, const struct live_listener *listener, const char *served, const struct live_state *state,
                      struct error *error);
void live_server_stop(struct live_server *server);

/* Returns a descriptor for poll(), which is readable when a browser has sent something or can
 * receive more. */
int live_server_fd(const struct live_server *server);

/* Returns the longest time, at most 50 ms, until the next live_server_turn() must be called; 0 if
 * more can be sent at once. */
int live_server_patience_ms(const struct live_server *server);

/* Does one turn of work: handles requests, and sends what is new in the state. Call it when the
 * descriptor is ready, and when live_server_patience_ms() has passed. */
void live_server_turn(struct live_server *server, int64_t now_ms);

#endif
