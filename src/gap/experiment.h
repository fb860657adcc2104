/* The one experiment that would tell two effects apart. Const data. */
#ifndef HEXID_EXPERIMENT_H
#define HEXID_EXPERIMENT_H

/* By names in the catalogue, in any order; a general advice where the pair has none of its own. Options of `hexid run` stand in backquotes; the
 * new log goes to `hexid gap` with the same --set. */
const char *experiment_between(const char *a, const char *b);

/* What to measure when no effect of the catalogue explains the gap. */
const char *experiment_unknown(void);

#endif
