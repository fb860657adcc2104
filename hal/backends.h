/* The back-ends of hal_table and the buses of device_buses; one file each. */
#ifndef HEXID_BACKENDS_H
#define HEXID_BACKENDS_H

#include "device.h"
#include "hal.h"

extern const struct hal_ops hal_sim, hal_can, hal_modbus, hal_fault;
extern const struct device_bus device_can, device_modbus;

#endif
