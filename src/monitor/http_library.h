/* libmicrohttpd, loaded only if a live page is requested, because it loads GnuTLS and ten more
 * libraries, which do not belong in the process that moves a machine. Ordinary threads. */
#ifndef HEXID_HTTP_LIBRARY_H
#define HEXID_HTTP_LIBRARY_H

#include <microhttpd.h>

#include "status.h"

struct http_library {
    __typeof__(&MHD_start_daemon) start;
    __typeof__(&MHD_stop_daemon) stop;
    __typeof__(&MHD_get_daemon_info) info;
    __typeof__(&MHD_get_timeout) timeout;
    __typeof__(&MHD_run) run;
    __typeof__(&MHD_lookup_connection_value) header;
    __typeof__(&MHD_create_response_from_buffer) response;
    __typeof__(&MHD_create_response_from_callback) response_of;
    __typeof__(&MHD_add_response_header) add_header;
    __typeof__(&MHD_queue_response) answer;
    __typeof__(&MHD_destroy_response) destroy;
    __typeof__(&MHD_suspend_connection) suspend;
    __typeof__(&MHD_resume_connection) resume;
};

/* Loads the library, which stays loaded. Returns -3 if it is not installed or lacks a function. */
int http_library_load(struct http_library *library, struct error *error);

#endif
