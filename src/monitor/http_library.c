#include "http_library.h"

#include <dlfcn.h>
#include <stdbool.h>
#include <string.h>

/* Looks up a function. The copy is allowed because POSIX makes pointers to functions and to objects
 * the same size; ISO C has no cast between them. */
static void *look_up(void *handle, const char *name, void *function) {
    void *symbol = dlsym(handle, name);
    memcpy(function, &symbol, sizeof symbol);
    return symbol;
}

int http_library_load(struct http_library *l, struct error *error) {
    static const char name[] = "libmicrohttpd.so.12";
    void *handle = dlopen(name, RTLD_NOW | RTLD_LOCAL);
    bool there = handle && look_up(handle, "MHD_start_daemon", &l->start) && look_up(handle, "MHD_stop_daemon", &l->stop) &&
                 look_up(handle, "MHD_get_daemon_info", &l->info) && look_up(handle, "MHD_get_timeout", &l->timeout) &&
                 look_up(handle, "MHD_run", &l->run) && look_up(handle, "MHD_lookup_connection_value", &l->header) &&
                 look_up(handle, "MHD_create_response_from_buffer", &l->response) &&
                 look_up(handle, "MHD_create_response_from_callback", &l->response_of) &&
                 look_up(handle, "MHD_add_response_header", &l->add_header) && look_up(handle, "MHD_queue_response", &l->answer) &&
                 look_up(handle, "MHD_destroy_response", &l->destroy) && look_up(handle, "MHD_suspend_connection", &l->suspend) &&
                 look_up(handle, "MHD_resume_connection", &l->resume);
    return there ? STATUS_OK : error_set(error, STATUS_IO, "%s: cannot be loaded, so there is no live page: install libmicrohttpd12", name);
}
