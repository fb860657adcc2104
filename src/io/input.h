/* Files that somebody else has written or made: opened only where reading them must come to an end.
 * Ordinary threads. */
#ifndef HEXID_INPUT_H
#define HEXID_INPUT_H

/* Opens a regular file for reading; never waits, as opening a FIFO would. -1: *reason says why, in
 * words that follow "FILE: cannot be read: ", with the remedy where there is one. The descriptor
 * is the caller's. */
int input_open(const char *path, const char **reason);

#endif
