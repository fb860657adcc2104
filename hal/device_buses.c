#include "backends.h"

const struct device_bus *const device_buses[] = {&device_can, &device_modbus, NULL};
