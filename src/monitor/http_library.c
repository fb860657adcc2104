#include "http_library.h"

#include <dlfcn.h>
#include <stdbool.h>

#include "library.h"

int http_library_load(struct http_library *l, struct error *error) {
    static const char name[] = "libmicrohttpd.so.12";
    void *handle = dlopen(name, RTLD_NOW | RTLD_LOCAL);
    bool there = handle && library_function(handle, "MHD_start_daemon", &l->start) &&
                 library_function(handle, "MHD_stop_daemon", &l->stop) && library_function(handle, "MHD_get_daemon_info", &l->info) &&
                 library_function(handle, "MHD_get_timeout", &l->timeout) && library_function(handle, "MHD_run", &l->run) &&
                 library_function(handle, "MHD_lookup_connection_value", &l->header) &&
                 library_function(handle, "MHD_create_response_from_buffer", &l->response) &&
                 library_function(handle, "MHD_create_response_from_callback", &l->response_of) &&
                 library_function(handle, "MHD_add_response_header", &l->add_header) &&
                 library_function(handle, "MHD_queue_response", &l->answer) &&
                 library_function(handle, "MHD_destroy_response", &l->destroy) &&
                 library_function(handle, "MHD_suspend_connection", &l->suspend) &&
                 library_function(handle, "MHD_resume_connection", &l->resume);
    return there ? STATUS_OK : error_set(error, STATUS_IO, "%s: cannot be loaded, so there is no live page: install libmicrohttpd12", name);
}
