/* CSV, one directory a run, one file a test: for data from elsewhere and for people. Between a
 * directory and a log; main thread.
 *
 *     # dof: x                 x y z phi theta psi, or none: recorded, but no sinusoidal test. The
 *                              one key that must be there.
 *     # frequency_hz: 4        what is missing is taken from the configuration; frequency and
 *     # amplitude: 0.004       amplitude (m or rad) may be each file's own, in all else they agree
 *     # rate_hz: 500           checked against the step of most rows to 1 %
 *     # settle_s: 3            before t_s = 0, where the ramp-in starts; where t_s begins behind
 *                              ramp_s, the motion tells which t_s that is
 *     # ramp_s: 1
 *     # duration_s: 5          evaluated; missing: all that follows ramp_s is
 *     # ramp_out_s: 0.5
 *     t_s,ref_x_m,...,ref_psi_rad,l1_m,...,l6_m,p1_1_pa,...,p1_6_pa,p2_1_pa,...,u1,...,flags,phase
 *     -3,0,0,0,...
 *
 * A file of one axis has "# mechanism: axis", or is known by its column position_m;
 * it needs no dof:
 *
 *     t_s,position_m,ref_m,force_n,p1_pa,p2_pa,u      force: of a load cell or a drive; p1 on
 *                                                     the rodless side; each may be missing but
 *                                                     the first two, and with pressures the
 *                                                     force is not used
 *
 * Other programs' files: cells may be quoted, and parted by semicolons or tabs (numbers may have
 * decimal commas then); lines that begin with # between rows are passed over. A name may end in
 * another unit, "p1_3_bar" or "t [ms]": m cm mm um, s ms us, rad mrad deg, Pa kPa MPa bar psi, N
 * kN; names of the user's own are told apart by a map (csv_map.h). Values that cannot be what their
 * names say are reported as doubtful, and hexid gap refuses them.
 *
 * Columns may stand in any order; only t_s must be there. A missing column and an empty cell are
 * NaN in the log: what needs them is not evaluated. `flags` (SAMPLE_..., decimal) and `phase` (enum
 * phase) are ours: without them no sample is flagged, and the phase follows from t_s, rounded to
 * whole periods. Files are taken in the order of the numbers in their names (1_x.csv ... 10_x.csv).
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

enum { CSV_FILES_MAX = 100 }; /* of a directory */

struct csv_file {
    char name[256];
    int64_t rows;
};

struct csv_report {
    int files;             /* one a test */
    int found;             /* import: in the directory */
    struct csv_file file[CSV_FILES_MAX]; /* import: in the order of the log */
    int64_t rows;
    int64_t lost;          /* cycles of the tests that have no row */
    char aside[PATH_MAX];  /* import: where the log went that was there; "": none was */
    int64_t empty;         /* import: cells without a number: NaN in the log */
    int64_t unreadable;    /* export: messages on HEXID_STATE that are none */
    bool several;          /* import: an axis has files of several frequencies */
    double rate_hz;        /* import: by the first file's times, where that is another than the
                            * configuration's or the head's; else 0 */
    double stated_hz;      /* import: the head's, of which that differs; 0: it has none */
    bool cut;              /* export: the log is cut off or damaged, read up to cut_offset */
    int64_t cut_offset;
    char missing[600];     /* import: columns, "1_x.csv: u1..u6; 2_y.csv: ...": NaN in the log */
    char ignored[600];     /* import: columns and keys that mean nothing here, likewise */
    bool no_areas;         /* import: pressures of an axis whose diameters nobody stated */
    char areas[AREAS_TEXT_SIZE]; /* import: with which areas pressures become forces, or what is not
                            * stated of them (areas.h); "" without pressures */
    char defaults[CONFIG_DEFAULTS_SIZE]; /* import: what pressures stand on and is not this
                            * machine's own (config_defaults()); "" without pressures */
    char zero[600];        /* import: "2_y.csv: 6.500; ...": t_s that is taken as t = 0, where
                            * the file's does not begin near that */
    bool no_lengths;       /* import: a platform's file lacks lengths of its legs */
    char doubtful[600];    /* import: columns whose values cannot be what their names say, and
                            * what they might be instead */
};

/* The tests of a log as DIRECTORY/1_x.csv ..., and its configuration. The directory is made
 * when it is not there; one that has CSV files is refused, and no file overwritten. -3 with
 * the file's name. run: of a log that holds several (log_runs.h), else 0. */
int csv_export(const char *log_path, int run, const char *directory, struct csv_report *report, struct error *error);

struct csv_map;

/* A directory of CSV files, and how it is read. */
struct csv_source {
    const char *path;      /* of the directory, or of one file, whose configuration is the base */
    const char *base;      /* configuration, YAML text; NULL: the built-in one */
    struct csv_map *map;   /* columns by the user's own names (csv_map.h); NULL: none */
    int only;              /* this one of its files alone, from 1, which need not have all
                            * names of the map; 0: all */
};

/* A log of the CSV files in a directory. Configuration: DIRECTORY/config.yaml where there is one,
 * else the base; what the files' heads say (frequency, amplitude, times, rate) and their times' own
 * rate replace its values, and the tests its list unless that has all their axes. Every file is
 * checked to its last row before the log is begun. -2 with file, line and column for what the files
 * say, -3 for what cannot be read or written. */
int csv_import(const struct csv_source *source, const char *log_path, struct csv_report *report, struct error *error);

#endif
