/* Addresses of the live page, and the check of a request's Host header. Pure, except
 * live_listen(). */
#ifndef HEXID_LIVE_REQUEST_H
#define HEXID_LIVE_REQUEST_H

#include <stdbool.h>
#include <stddef.h>

#include "status.h"

enum { LIVE_HOST_SIZE = 256, LIVE_URL_SIZE = LIVE_HOST_SIZE + 24 };

struct live_address {
    char host[LIVE_HOST_SIZE]; /* host to listen on, without brackets; "127.0.0.1" if not given */
    int port;                  /* port to listen on; 0: any free one */
};

/* Accepts HOST:PORT and PORT, such as "127.0.0.1:8321", "localhost:8321", "[::1]:8321" and "8321".
 * Returns -2 for anything else. */
int live_address_parse(const char *text, struct live_address *address, struct error *error);

/* A listening socket. `url` is the address for a browser on this host; `loopback` means that no
 * other host reaches it. */
struct live_listener {
    int fd;
    bool loopback;
    char url[LIVE_URL_SIZE];
};
/* Opens a non-blocking listening socket. Returns -3 if the name is unknown, the address is not this
 * host's, or the port is taken or needs privileges. */
int live_listen(const struct live_address *address, struct live_listener *listener, struct error *error);

/* Returns true if the request's Host header names this server. SAFETY: a foreign page whose name is
 * made to resolve to this host (DNS rebinding) could read the machine's state through its user's
 * browser, but the requests of such a page carry its name. So only known names pass: localhost,
 * this host's own name (own_name), and the name under which the page is served (served). Any
 * literal address passes, because an address cannot be rebound; any port passes, because tunnels
 * have ports of their own. */
bool live_host_allowed(const char *host, const char *served, const char *own_name);

#endif
