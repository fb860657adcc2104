/* Size of every text in the configuration (params.h), NUL included. */
#ifndef HEXID_PARAMS_TEXT_H
#define HEXID_PARAMS_TEXT_H

enum { PARAMS_TEXT_SIZE = 256 };

#endif
