/* CSV: a directory for each run, a file for each test; for data from elsewhere and for people.
 * Converts between a directory and a log; main thread.
 *
 *     # dof: x                 x y z phi theta psi, or none: no sinusoidal test. The only key
 *                              that is required.
 *     # frequency_hz: 4        missing keys are taken from the configuration; frequency and
 *     # amplitude: 0.004       amplitude (m or rad) may differ between files, other keys may not
 *     # rate_hz: 500           checked against the step of most rows to 1 %
 *     # settle_s: 3            before t_s = 0, the start of the ramp-in; if t_s begins after
 *                              ramp_s or ends before 0, the start is found from the motion
 *     # ramp_s: 1
 *     # duration_s: 5          evaluated part; missing: everything after ramp_s
 *     # ramp_out_s: 0.5
 *     t_s,ref_x_m,...,ref_psi_rad,l1_m,...,l6_m,p1_1_pa,...,p1_6_pa,p2_1_pa,...,u1,...,flags,phase
 *     -3,0,0,0,...
 *
 * A file of a single axis has "# mechanism: axis" or the column position_m; it needs no dof:
 *
 *     t_s,position_m,ref_m,force_n,p1_pa,p2_pa,u      force of a load cell or a drive, ignored if
 *                                                     there are pressures; p1 on the rodless side;
 *                                                     only the first two are required
 *
 * Other programs' files: cells may be quoted and separated by semicolons, tabs or blanks
 * (numbers may then have decimal commas); lines of text before the names, and lines between rows
 * that begin with # are skipped, and a line of units below the names is taken (csv_layout.h). A
 * name may end in another unit, "p1_3_bar" or "t [ms]" (csv_units.h); a map translates the
 * user's own names (csv_map.h). Values that are implausible for their names are reported as
 * doubtful, and hexid gap refuses them. Time may be a time of day.
 *
 * A file may have several columns of time, each for the columns after it; rows may have only some
 * of the channels; a slow channel may have its last value in several rows (csv_hold.h); a position
 * may be given as a speed; and files of a directory that share no column except the time are one
 * test. Such channels are brought onto one clock (csv_table.h). MAT and MCAP files are read as
 * tables, too (csv_foreign.h).
 *
 * Columns may stand in any order; a platform's file needs only t_s. A missing column or an empty
 * cell is NaN in the log, and whatever needs it is not evaluated. `flags` (SAMPLE_..., decimal) and
 * `phase` (enum phase) are hexid's own: without them no sample is flagged, and the phase follows
 * from t_s, rounded to whole periods. Files are ordered by the numbers in their names (1_x.csv ...
 * 10_x.csv).
 *
 * config.yaml in the directory is the run's configuration. Numbers are written in the shortest form
 * that reads back bit for bit, so CSV -> log -> CSV gives the same values, and log -> CSV -> log
 * the same identification. */
#ifndef HEXID_CSV_H
#define HEXID_CSV_H

#include <limits.h>

#include "areas.h"
#include "config.h"
#include "status.h"
#include "types.h"

enum { CSV_FILES_MAX = 100 }; /* largest number of files in a directory */
enum { CSV_DOUBTS_SIZE = 600 };

struct csv_file {
    char name[256];
    int64_t rows;
};

struct csv_report {
    int files;             /* number of tests; export writes a file for each */
    int found;             /* import: number of CSV, MAT and MCAP files in the directory */
    struct csv_file file[CSV_FILES_MAX]; /* import: file name and number of rows of each test, in
                                          * the order of the log */
    int64_t rows;
    int64_t lost;          /* number of the tests' cycles without a row */
    char aside[PATH_MAX];  /* import: new name of a log that existed at the output's path; "":
                            * none */
    int64_t empty;         /* import: number of empty cells in columns that have numbers; 0 if
                            * channels had to be brought onto one clock */
    int64_t unreadable;    /* export: number of malformed messages on HEXID_STATE */
    bool several;          /* import: files of the same test axis state different frequencies */
    double rate_hz;        /* import: rate of the first file's time stamps, Hz, if it replaces the
                            * rate of the head or of the configuration; else 0 */
    double stated_hz;     /* import: rate stated in the head, Hz, if rate_hz replaces it; else 0 */
    bool cut;              /* export: the log is cut off or damaged; it was read up to cut_offset */
    int64_t cut_offset;
    char missing[600];     /* import: missing columns, NaN in the log: "1_x.csv: u1..u6; 2_y.csv:
                            * ..." */
    char ignored[600];     /* import: unknown columns and keys, in the form of `missing` */
    bool no_areas; /* import: there are pressures of a single axis whose diameters are not stated */
    char areas[AREAS_TEXT_SIZE]; /* import: piston areas used for forces, or which diameters are
                                  * not stated (areas.h); "" without pressures */
    char defaults[CONFIG_DEFAULTS_SIZE]; /* import: built-in values that the evaluation of
                                          * pressures uses (config_defaults()); "" without
                                          * pressures */
    char zero[600];        /* import: times taken as t = 0 in files whose t_s begins after the
                            * ramp-in or ends before it: "2_y.csv: 6.500; ..." */
    char overruled[600];   /* import: values in heads that csv_source.settings overrule */
    char notes[1200];      /* import: changes made to bring channels onto one clock (csv_table.h),
                            * and lines left out */
    bool turns;            /* import: the axis rotates; angles and torques are read as lengths and
                            * forces at a lever of 1 m (csv_units.h) */
    bool no_lengths;       /* import: a platform's file lacks leg lengths */
    char doubtful[CSV_DOUBTS_SIZE]; /* import: columns with values implausible for their names, and
                                     * the units that they might have (csv_doubts.h) */
};

/* Writes the tests of a log as DIRECTORY/1_x.csv ..., and its configuration. Creates the directory
 * if needed; refuses one that has CSV files, and overwrites no file. run: number of the run in a
 * log that contains several (log_runs.h), else 0. Returns -2 if there is no such run, -3 with the
 * file's name on any other error. */
int csv_export(const char *log_path, int run, const char *directory, struct csv_report *report, struct error *error);

struct csv_map;

/* A directory of CSV files and how to read it. */
struct csv_source {
    const char *path;      /* path of the directory, or of a single file; a single file always takes
                            * the base as its configuration */
    const char *base;      /* configuration as YAML text; NULL: the built-in one */
    struct csv_map *map;   /* columns under the user's own names (csv_map.h); NULL: none */
    bool configured;       /* true: the user chose the base configuration; false: its tests are only
                            * assumed, so import leaves frequency and amplitudes out of the log's
                            * configuration unless a file states them */
    const char *const *settings; /* settings of --set, which `base` already contains; they win over
                                  * the values in the files */
    int setting_count;
    int only;              /* number, from 1, of the only file to read, which need not have all
                            * names of the map; 0: all files */
};

/* Makes a log from the CSV files of a directory. The configuration is DIRECTORY/config.yaml if
 * there is one, else the base. The files' heads replace the configuration's frequencies,
 * amplitudes, durations and rate, and the rate of the time stamps can replace the rate; the list of
 * tests is made from the files unless the configuration lists all their axes. Every file is checked
 * to its last row before the log is begun. The frequency and the amplitude that a file states are
 * kept beside its rows (csv_stated.h). Returns -2 with file, line and column for bad content, -3
 * for files that cannot be read or written. */
int csv_import(const struct csv_source *source, const char *log_path, struct csv_report *report, struct error *error);

#endif
