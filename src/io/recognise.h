/* Recognises recordings by their content, whatever their names, so that a result never overwrites
 * measurements. Ordinary threads. */
#ifndef HEXID_RECOGNISE_H
#define HEXID_RECOGNISE_H

/* Returns the kind of a file: "an LCM event log", "an MCAP file", "a MAT file", "a CSV file of
 * numbers" (for hexid import, hexid export and trajectories: names of columns, then numbers).
 * NULL: none of these, not a regular file, or unreadable. Never waits. */
const char *recognise(const char *path);
extern const char recognise_log[]; /* result of recognise() for an LCM event log */

/* Finds the first recording in a directory, copies its name to name[size] and returns its kind.
 * csv: CSV files count, too. NULL: there is none, or the directory cannot be read. */
const char *recognise_in(const char *directory, int csv, char *name, unsigned long size);

#endif
