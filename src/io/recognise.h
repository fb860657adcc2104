/* Recordings are recognised by what is in them, whatever they are called: what others have measured
 * is never overwritten by a result. Ordinary threads. */
#ifndef HEXID_RECOGNISE_H
#define HEXID_RECOGNISE_H

/* Says what the file is: "an LCM event log", "an MCAP file", "a MAT file", "a CSV file of numbers"
 * (as of hexid import, hexid export and trajectories: names of columns, then numbers). NULL: none
 * of these, not a regular file, or it cannot be read. Never waits. */
const char *recognise(const char *path);
extern const char recognise_log[]; /* what it says of an LCM event log */

/* The name of the first such file in a directory, copied to name[size]; what it is. csv: CSV files
 * count. NULL: there is none, or the directory cannot be read. */
const char *recognise_in(const char *directory, int csv, char *name, unsigned long size);

#endif
