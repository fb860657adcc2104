/* The hardware abstraction layer: the only way to the platform. The loop cannot tell which back-end
 * it talks to.
 *
 * The loop's thread calls read, write and safe; the crash handler (crash.h) calls safe in any
 * thread. All three are RT: they never block, and use no heap and no lock. A blocking device gets
 * its own thread inside its back-end. The main thread calls open and close while the loop does not
 * run. */
#ifndef HEXID_HAL_H
#define HEXID_HAL_H

#include <stddef.h>

#include "status.h"
#include "types.h"

struct params;
struct hal; /* each back-end embeds this as its first member */

/* Device that a back-end opens again after it has lost the connection to a machine that is driven:
 * none, internet sockets, a serial device, or a CAN socket (after the interface was removed and
 * created again). */
enum hal_reopens { HAL_REOPENS_NOTHING, HAL_REOPENS_SOCKETS, HAL_REOPENS_SERIAL, HAL_REOPENS_CAN };

struct hal_ops {
    const char *scheme;  /* part of the URL before ':' */
    const char *usage;   /* line for --help: syntax of the URL, and the machine that it reaches */
    bool simulated;      /* the back-end has no real machine behind it: --rt defaults to try, --fast
                          * is allowed */
    enum hal_reopens reopens; /* device that the back-end opens again by itself after a lost
                               * connection */
    /* Opens the back-end, as hal_open() does. address: part of the URL after "scheme:". */
    int (*open)(struct hal **hal, const char *address, const struct params *params, uint64_t seed, struct error *error);
    /* Reads the sample of this cycle, latched at or before now_ns (the loop's clock). Returns 0, or
     * -1 if nothing can be read (FAULT_IO). */
    int (*read)(struct hal *hal, int64_t now_ns, struct hal_sample *sample);
    /* Writes the command of this cycle. Returns 0, or -1 if nothing can be written (FAULT_IO). */
    int (*write)(struct hal *hal, const struct hal_command *command);
    /* SAFETY: centres the valves at once, whatever else is broken, and leaves the supply output as
     * it is. Called in every cycle in which the supply is off or a write has failed, at the loop's
     * end, and by the crash handler. Signal-safe. */
    void (*safe)(struct hal *hal);
    void (*close)(struct hal *hal);
    /* Describes the present failure between hexid and the machine, for the operator; "" if there is
     * none. If the interface itself fails, nothing behind the interface is mentioned. Any thread.
     * NULL: the back-end has no such function. */
    void (*describe)(const struct hal *hal, char *text, size_t size);
};

struct hal {
    const struct hal_ops *ops;
};

/* Opens "scheme:address". On failure `error` has the URL, the reason and the remedy, and nothing
 * has moved. */
int hal_open(struct hal **hal, const char *url, const struct params *params, uint64_t seed, struct error *error);

/* Returns the back-end that a URL names; NULL if there is none. */
const struct hal_ops *hal_find(const char *url);

/* All back-ends, ended by NULL. */
extern const struct hal_ops *const hal_table[];

#endif
