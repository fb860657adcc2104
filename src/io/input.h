/* Opens files that others may have made, and only regular ones, because reading them must end.
 * Ordinary threads. */
#ifndef HEXID_INPUT_H
#define HEXID_INPUT_H

/* Opens a regular file for reading; never waits, as opening a FIFO would. Returns a descriptor to
 * be closed by the caller, or -1 with *reason, a text that follows "FILE: cannot be read: ", with
 * the remedy if there is one. */
int input_open(const char *path, const char **reason);

#endif
