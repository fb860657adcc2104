/* What a browser may ask of the live page, and where the page is served. Pure but
 * for live_listen(). */
#ifndef HEXID_LIVE_REQUEST_H
#define HEXID_LIVE_REQUEST_H

#include <stdbool.h>
#include <stddef.h>

#include "status.h"

enum { LIVE_HOST_SIZE = 256, LIVE_URL_SIZE = LIVE_HOST_SIZE + 24 };

struct live_address {
    char host[LIVE_HOST_SIZE]; /* as it was given, without brackets; "127.0.0.1" where none was */
    int port;                  /* 0: one that is free */
};

/* "127.0.0.1:8321", "localhost:8321", "[::1]:8321", "8321". -2. */
int live_address_parse(const char *text, struct live_address *address, struct error *error);

/* A socket that listens there, not blocking, or -3: the name is not known, the address is not this
 * host's, the port is taken or needs rights. url: what a browser on this host is given. loopback:
 * nobody on another host reaches it. */
struct live_listener {
    int fd;
    bool loopback;
    char url[LIVE_URL_SIZE];
};
int live_listen(const struct live_address *address, struct live_listener *listener, struct error *error);

/* The request is for this page. SAFETY: a page from elsewhere whose name is made to mean this host
 * (DNS rebinding) could read the machine's state through its user's browser; its requests carry
 * that name. So a name must be one that is known here: localhost, this host's own (own_name) or the
 * one the page is served under (served); an address cannot be made to mean another. Any port: a
 * tunnel has its own. */
bool live_host_allowed(const char *host, const char *served, const char *own_name);

#endif
