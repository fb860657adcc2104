/* Version for `hexid --version`: the Makefile's VERSION and, in a checkout, its commit. */
#ifndef HEXID_VERSION_H
#define HEXID_VERSION_H

extern const char version[];

#endif
