/* SAFETY: one master for each machine on this host: an advisory lock named after the
 * back-end's URL, released by the kernel however the process ends. What other hosts do is for
 * the device to refuse. */
#ifndef HEXID_HOST_LOCK_H
#define HEXID_HOST_LOCK_H

#include "status.h"

/* A descriptor to keep open, or STATUS_UNSAFE naming the process that holds it, STATUS_IO with the
 * remedy where no lock can be made. */
int host_lock(const char *url, struct error *error);

#endif
