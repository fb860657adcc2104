/* Sections `security`, `machine` and `lcm` of the configuration (params.h): the daemon on its host
 * and on the LCM bus. */
#ifndef HEXID_PARAMS_DAEMON_H
#define HEXID_PARAMS_DAEMON_H

#include <stdbool.h>

#include "params/text.h"

struct security_params {
    bool confine;                 /* restrict the system calls of the running daemon
                                   * (src/rt/confine.h) */
};

struct machine_params {
    char name[PARAMS_TEXT_SIZE]; /* name by which commands find this daemon (src/io/machine_name.h);
                                  * "": the first free name of hexid, hexid-2, ... */
};

struct lcm_params {
    char url[PARAMS_TEXT_SIZE];   /* URL of the LCM bus; "": none. A udpm URL with ttl 0 stays on
                                   * this host */
    int state_every;      /* number of cycles from one HEXID_STATE message on the bus to the next */
    bool commands;                /* SAFETY: accept commands that move; stop and
                                   * park are always accepted */
    double lease_s;               /* SAFETY: longest time without a message from the operator who
                                   * engaged or started the platform by command; then the platform
                                   * is parked. 0: no limit */
    char remote_stop[PARAMS_TEXT_SIZE]; /* addresses of other hosts whose stop and park are
                                         * accepted; "": none */
};

#endif
