/* What `hexid --version` says: the Makefile's VERSION and, of a checkout, its commit. */
#ifndef HEXID_VERSION_H
#define HEXID_VERSION_H

extern const char version[];

#endif
