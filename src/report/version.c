#include "version.h"

const char hexid_version[] = HEXID_VERSION;
