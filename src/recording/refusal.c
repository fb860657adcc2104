#include "refusal.h"

#include <math.h>

/* clang-format off */
const struct refusal_row refusals[REFUSALS] = {
    [REFUSED_NOT] = {"", "", "", ""},
    [REFUSED_STALE] = {"stale", "sample", "stale: the device delivered nothing new",
        "[the link](hardware.md); a longer `loop.period_s` where the device is slower"},
    [REFUSED_LATE] = {"late", "sample", "late: latched longer ago than a cycle", "the link and its load, [real time](real-time.md)"},
    [REFUSED_DROPPED] = {"dropped", "sample", "samples are missing before it", "the link and its load, [real time](real-time.md)"},
    [REFUSED_INVALID] = {"invalid", "sample", "invalid: a value is no number, or outside its sensor's range",
        "`hexid monitor` shows which; the sensor, its wire, the limits of the configuration"},
    [REFUSED_OVERRUN] = {"overrun", "sample", "overrun: the loop missed a deadline before it, its command was held too long",
        "`hexid doctor`, [real time](real-time.md)"},
    [REFUSED_IO] = {"io", "sample", "not read, or the command before it not written", "[the link](hardware.md), the device's supply"},
    [REFUSED_FOREIGN] = {"foreign", "sample", "another master commanded the machine", "end the other program, or unplug its computer"},
    [REFUSED_OPEN] = {"open", "sample", "an interlock was open", "close it, or mend its wire"},
    [REFUSED_UNWRITTEN] = {"unwritten", "sample", "read, but the command before it was not written", "[the link](hardware.md)"},
    [REFUSED_TWIN] = {"twin", "sample", "two devices answered as one", "a number of its own for each device"},
    [REFUSED_NO_NUMBER] = {"not_a_number", "sample", "a measured value is no number",
        "fill the empty cells of the CSV, or remove the column that has them: nothing is excluded for a channel that is not there"},
    [REFUSED_NO_POSE] = {"no_pose", "sample", "no pose of this machine has its lengths",
        "the geometry of the configuration, the transducers"},
    [REFUSED_UNPLACED] = {"unplaced", "sample", "the time is missing, or does not increase", "sort the rows, remove doubles"},
    [REFUSED_OUTSIDE] = {"outside", "sample", "outside the evaluated part: between tests, settling, or in a ramp",
        "nothing; `tests.ramp_s` and `tests.duration_s` say which part is evaluated"},
    [REFUSED_SURPLUS] = {"surplus", "sample, piece", "the record is longer than what is evaluated of it",
        "nothing: what is evaluated is spread over the record; method C takes the first 100 s of a test of one axis"},
    [REFUSED_GAP] = {"gap", "piece, cycle", "more than a tenth of its samples are excluded or missing, or too many of them at once",
        "look what excludes the samples; keep every row"},
    [REFUSED_TURN] = {"turn", "piece", "samples are missing where the motion turns", "keep every row, the reversals', too"},
    [REFUSED_REST] = {"rest", "piece", "nothing moves in it, or by less than three steps of the sensor", "nothing, or a larger motion"},
    [REFUSED_NOISE] = {"noise", "piece", "noise is more than half of what varies in force and pressures",
        "larger or faster motion, or finer sensors"},
    [REFUSED_EMPTY] = {"empty", "test", "no sample is in the evaluated part",
        "nothing where it was broken off; else the column `phase` is not that of this test: leave it out and import again"},
    [REFUSED_INCOMPLETE] = {"incomplete", "test", "not complete: less than 99.9 % of the evaluated part was seen",
        "run it again, or state the `tests.duration_s` that was recorded"},
    [REFUSED_UNDETERMINED] = {"undetermined", "test, cycle", "the samples that are used do not determine amplitude and phase",
        "look what excludes the samples"},
};
/* clang-format on */

_Static_assert(REFUSED_STALE + SAMPLE_FLAGS == REFUSED_NO_NUMBER, "a reason for each flag");

enum refusal refusal_of(const struct cycle *c, int legs) {
    for (int i = 0; c->in.flags; i++) /* an imported log may have a flag beyond those of types.h */
        if (c->in.flags >> i & 1u) return i < SAMPLE_FLAGS ? (enum refusal)(REFUSED_STALE + i) : REFUSED_INVALID;
    for (int k = 0; k < legs; k++)
        if (!isfinite(c->in.length_m[k])) return REFUSED_NO_NUMBER;
    return REFUSED_NOT;
}

void refusal_print(FILE *out) {
    fputs("| reason | of a | why it is excluded | what to do |\n| --- | --- | --- | --- |\n", out);
    for (const struct refusal_row *r = refusals + 1; r < refusals + REFUSALS; r++)
        fprintf(out, "| %s | %s | %s | %s |\n", r->word, r->what, r->why, r->remedy);
}
