#include "backends.h"

const struct device_bus *const device_buses[] = {&device_can, NULL};
