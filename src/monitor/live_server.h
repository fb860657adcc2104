/* The live page's server: files of src/monitor/page/ and a stream of server-sent events, to
 * browsers that may be slow, gone or hostile. One thread, which waits for nobody: a browser that
 * does not keep up with what it is sent is told the newest later, and holds up neither the others
 * nor LCM. It reads only: there is nothing to ask for but the files and the stream, and no
 * request has an effect.
 *
 * Bounded: LIVE_CLIENTS browsers, each with one piece of the stream under way; connections that
 * stand still are ended. */
#ifndef HEXID_LIVE_SERVER_H
#define HEXID_LIVE_SERVER_H

#include "live_request.h"
#include "live_state.h"

enum { LIVE_CLIENTS = 16 };

struct live_server;

/* Takes over the listener, also where it fails. `served`: the host that the page was asked to be
 * served under; both it and `state` stay in use. -3. */
int live_server_start(struct live_server **server, const struct live_listener *listener, const char *served, const struct live_state *state,
                      struct error *error);
void live_server_stop(struct live_server *server);

/* For poll(): something has come from a browser. */
int live_server_fd(const struct live_server *server);

/* So long at most may the next turn wait; 0: more can be sent at once. */
int live_server_patience_ms(const struct live_server *server);

/* Does what is due for the browsers, and hands on what is new in the state: to be called when the
 * descriptor is ready, and when patience is over. */
void live_server_turn(struct live_server *server, int64_t now_ms);

#endif
