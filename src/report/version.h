/* Which hexid this is: the commit it was built from, "-dirty" where files differed; "unknown" outside a clone. */
#ifndef HEXID_VERSION_H
#define HEXID_VERSION_H

extern const char hexid_version[];

#endif
