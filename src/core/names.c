#include <stddef.h>

#include "types.h"

const char *const dof_names[DOFS + 1] = {
    [DOF_X] = "x", [DOF_Y] = "y", [DOF_Z] = "z", [DOF_PHI] = "phi", [DOF_THETA] = "theta", [DOF_PSI] = "psi", [DOFS] = NULL,
};

const char *const state_names[STATES] = {
    [STATE_INIT] = "init",       [STATE_SETTLED] = "settled", [STATE_ENGAGING] = "engaging", [STATE_READY] = "ready",
    [STATE_TESTING] = "testing", [STATE_PARKING] = "parking", [STATE_FAULT] = "fault",       [STATE_PRESSURISING] = "pressurising",
};

const char *const command_names[COMMANDS] = {
    [COMMAND_NONE] = "none", [COMMAND_ENGAGE] = "engage", [COMMAND_START] = "start", [COMMAND_STOP] = "stop",
    [COMMAND_PARK] = "park", [COMMAND_RESET] = "reset",   [COMMAND_SET] = "set",
};
