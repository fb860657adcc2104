/* The hardware abstraction layer: the only way to the platform. Nobody outside a back-end can tell
 * which one it is.
 *
 * read, write and safe are called from the loop thread: RT, never block, no heap, no lock. A
 * blocking device gets its own thread inside its back-end. open, start and close are called from
 * the main thread while the loop does not run. */
#ifndef HEXID_HAL_H
#define HEXID_HAL_H

#include <stddef.h>

#include "params.h"
#include "status.h"
#include "types.h"

struct hal; /* each back-end embeds this as its first member */

struct hal_ops {
    const char *scheme;  /* the URL's part before ':' */
    const char *usage;   /* one line for --help: the URL's form and what it reaches */
    bool simulated;      /* no machine behind it: --rt try is the default, and --fast is allowed */
    bool reconnects;     /* makes a lost connection again by itself, which
                          * takes new sockets or files */
    bool reopens_can;    /* opens its CAN socket again, on an interface that was made again */
    int (*open)(struct hal **hal, const char *address, const struct params *params, uint64_t seed, struct error *error);
    /* The sample of this cycle, latched at or before now_ns (the loop's clock). 0, or -1: nothing
     * can be read (FAULT_IO). */
    int (*read)(struct hal *hal, int64_t now_ns, struct hal_sample *sample);
    /* The command of this cycle. 0, or -1: nothing can be written (FAULT_IO). */
    int (*write)(struct hal *hal, const struct hal_command *command);
    /* SAFETY: valves to centre, now, whatever else is broken, and the supply output as it is;
     * called on every fault and at the end. Signal-safe. */
    void (*safe)(struct hal *hal);
    void (*close)(struct hal *hal);
    /* Optional, any thread: what has gone wrong first on the way to the machine, in words for the
     * operator; "" when all is well. */
    void (*describe)(const struct hal *hal, char *text, size_t size);
};

struct hal {
    const struct hal_ops *ops;
};

/* Opens "scheme:address". On error: the URL, the reason and the remedy; nothing has moved. */
int hal_open(struct hal **hal, const char *url, const struct params *params, uint64_t seed, struct error *error);

/* The back-end that a URL names, NULL if none. */
const struct hal_ops *hal_find(const char *url);

/* All back-ends, ended by NULL. */
extern const struct hal_ops *const hal_table[];

#endif
