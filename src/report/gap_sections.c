#include "gap_sections.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "gap_pictures.h"
#include "html.h"
#include "hypothesis.h"
#include "words.h"

enum { PICTURES = 6, TEST_WORDS = 32, PLACE_WORDS = 40 };

const char *section_channel_words(int legs, enum gap_channel channel) {
    static const char *const words[GAP_CHANNELS] = {"leg length", "leg force", "pressure P1", "pressure P2", "valve command"};
    if (legs == 1 && channel == GAP_LENGTH) return "position";
    if (legs == 1 && channel == GAP_FORCE) return "force";
    return words[channel];
}

/* Returns the words for a channel's place, such as ", leg force of leg 3"; ", force" for a single
 * axis. */
static const char *place_words(int legs, enum gap_channel channel, int leg, char words[PLACE_WORDS]) {
    int length = snprintf(words, PLACE_WORDS, ", %s", section_channel_words(legs, channel));
    if (legs > 1) snprintf(words + length, (size_t)(PLACE_WORDS - length), " of leg %d", leg + 1);
    return words;
}

/* --- words */

const char *section_feature_words(const char *feature) {
    static const char *const words[][2] = {
        {"static", "the constant part"},
        {"velocity_reversal", "where the velocity reverses"},
        {"spool_reversal", "where the spool passes zero"},
        {"one_direction", "in one direction of motion only"},
        {"peak_speed", "where the speed is highest"},
        {"peak_acceleration", "where the acceleration is highest"},
    };
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (!strcmp(words[i][0], feature)) return words[i][1];
    return feature;
}

/* Writes the words of an effect, which are meant for a platform, with singular nouns, because a
 * single axis has one cylinder, valve and sensor. */
static void singular(FILE *out, const char *plain) {
    static const char *const words[][2] = {
        {"cylinders", "cylinder"}, {"pistons", "piston"}, {"slower spools", "a slower spool"},     {"spools", "spool"},
        {"valves' ", "valve's "},  {"valves", "valve"},   {"position sensors", "position sensor"},
    };
    enum { PAIRS = sizeof words / sizeof *words };
    while (*plain) {
        int i = 0;
        while (i < PAIRS && strncmp(plain, words[i][0], strlen(words[i][0])) != 0) i++;
        if (i < PAIRS) html_print(out, "%s", words[i][1]), plain += strlen(words[i][0]);
        else html_print(out, "%c", *plain++);
    }
}

void section_effect_words(FILE *out, int effect, int pattern, int legs) {
    if (legs == 1) singular(out, effect_table[effect]->plain);
    else html_print(out, "%s", effect_table[effect]->plain);
    if (pattern >= 0) fprintf(out, " (leg %d only)", pattern + 1);
    if (pattern == PATTERN_EACH) fputs(" (each leg its own)", out);
}

bool section_named(const struct gap_result *r, int effect) {
    bool named = false;
    for (int i = 0; i < r->effects; i++) named = named || r->effect[i].effect == effect || hypothesis_contains(effect, r->effect[i].effect);
    for (int i = 0; i < r->ambiguous; i++) named = named || r->ambiguous_with[i] == effect;
    return named;
}

/* --- pictures */

/* One channel of one leg in one test, as the subject of a picture. */
struct spot {
    const struct wave_test *test;
    enum gap_channel channel;
    int leg;
    double size; /* rms difference of the measurement and the model without the effects found, as a
                  * share of the channel's rms variation */
};

static double spot_size(const struct waves *w, const struct wave_test *t, int channel, int leg, bool after) {
    const struct wave *v = &t->wave[channel][leg];
    return waves_distance(t, v->measured, after ? v->after : v->before) / w->variation[channel];
}

static int by_size(const void *a, const void *b) {
    const struct spot *x = a, *y = b;
    return x->size < y->size ? 1 : x->size > y->size ? -1 : 0;
}

/* Lists the spots of all tests, channels and legs, largest difference first. The caller frees the
 * list. */
static struct spot *spots(const struct waves *w, int *count) {
    struct spot *spot = malloc(((size_t)w->tests * GAP_CHANNELS * LEGS + 1) * sizeof *spot);
    *count = 0;
    for (int i = 0; i < w->tests && spot; i++)
        for (int ch = 0; ch < GAP_CHANNELS; ch++)
            for (int leg = 0; leg < w->legs && w->evaluated[ch]; leg++) {
                double size = spot_size(w, &w->test[i], ch, leg, false);
                spot[(*count)++] = (struct spot){&w->test[i], (enum gap_channel)ch, leg, size};
            }
    if (spot) qsort(spot, (size_t)*count, sizeof *spot, by_size);
    return spot;
}

/* Names a test: "x"; with several runs "x at 4 Hz"; a segment of a motion "at 3.21 s". */
static const char *test_words(const struct recording *r, int test, enum dof dof, double at_s, double segment_s, char words[TEST_WORDS]) {
    if (segment_s > 0.0) {
        snprintf(words, TEST_WORDS, "at %.4g s", at_s);
        return words;
    }
    snprintf(words, TEST_WORDS, "%s", words_axes[dof]);
    for (int i = 0; i < r->tests && r->runs > 1; i++)
        if (r->test[i].test == test) snprintf(words, TEST_WORDS, "%s at %.3g Hz", words_axes[dof], r->test[i].frequency_hz);
    return words;
}

static bool has_after(const struct gap_report *report) { return report->result->effects > 0; }

static const struct wave_test *find_test(const struct waves *w, const struct gap_place *place) {
    for (int i = 0; i < w->tests; i++)
        if (w->test[i].test == place->test && w->test[i].at_s == place->at_s) return &w->test[i];
    return NULL;
}

/* Lists candidates for a picture in order: first the places of the gap, which are weighted by
 * noise, then the largest differences. The caller frees the list. */
static struct spot *list_spots(const struct gap_report *report, int *count) {
    const struct waves *w = report->waves;
    const struct gap_result *r = report->result;
    int others;
    struct spot *by = spots(w, &others), *list = by ? malloc(((size_t)others + GAP_PLACES) * sizeof *list) : NULL;
    *count = 0;
    for (int i = 0; i < r->places && list; i++) {
        const struct gap_place *place = &r->where[i];
        const struct wave_test *t = find_test(w, place);
        if (!t || !w->evaluated[place->channel]) continue;
        double size = spot_size(w, t, place->channel, place->leg, false);
        list[(*count)++] = (struct spot){t, place->channel, place->leg, size};
    }
    for (int i = 0; i < others && list; i++) list[(*count)++] = by[i];
    free(by);
    return list;
}

/* Chooses the first spots of the list, but takes no channel more often than PICTURES divided by the
 * number of evaluated channels (rounded up), and no channel of a test twice. Returns their
 * number. */
static int choose(const struct waves *w, const struct spot *list, int count, struct spot chosen[PICTURES]) {
    int channels = 0, taken[GAP_CHANNELS] = {0}, n = 0;
    for (int ch = 0; ch < GAP_CHANNELS; ch++) channels += w->evaluated[ch];
    for (int i = 0; i < count && n < PICTURES; i++) {
        bool seen = taken[list[i].channel] >= (PICTURES + channels - 1) / channels;
        for (int j = 0; j < n; j++) seen = seen || (chosen[j].test == list[i].test && chosen[j].channel == list[i].channel);
        if (!seen) taken[list[i].channel]++, chosen[n++] = list[i];
    }
    return n;
}

void section_waveforms(struct page *p, const struct gap_report *report) {
    int count;
    struct spot *list = list_spots(report, &count), chosen[PICTURES];
    int n = list ? choose(report->waves, list, count, chosen) : 0;
    html_print(p->out,
               "<section id=\"waveforms\"><h2>Where they disagree most</h2>\n<p>Measured, and the model driven %s. Below each: measured "
               "less model; the grey band is one standard deviation of the noise of a single sample.</p>\n<div class=\"two\">\n",
               report->result->simulated ? "as the rig was (same reference, same controller)" : "by the measured motion and commands");
    for (const struct spot *s = chosen; s < chosen + n; s++) {
        char words[TEST_WORDS], place[PLACE_WORDS];
        page_figure(p, picture_wave, &(struct picture){s->test, s->leg, s->channel, has_after(report)},
                    "Test %s%s: before, the model is off by %.1f %% of the channel's variation",
                    test_words(report->measured, s->test->test, s->test->dof, s->test->at_s, s->test->segment_s, words),
                    place_words(report->waves->legs, s->channel, s->leg, place), 100.0 * s->size);
    }
    fputs("</div></section>\n", p->out);
    free(list);
}

/* Returns the place of the largest gap in a force. If no force has a gap, returns the place of the
 * largest gap; NULL if there is none. */
static const struct gap_place *loop_place(const struct gap_result *r) {
    for (int i = 0; i < r->places; i++)
        if (r->where[i].channel == GAP_FORCE) return &r->where[i];
    return r->places ? &r->where[0] : NULL;
}

void section_loops(struct page *p, const struct gap_report *report) {
    const struct gap_place *place = loop_place(report->result);
    const struct wave_test *motion = place ? find_test(report->motion, place) : NULL;
    const struct wave_test *simulated = place && report->result->simulated ? find_test(report->waves, place) : NULL;
    char words[TEST_WORDS], leg[PLACE_WORDS] = "";
    if (!motion) return;
    const struct picture loop = {motion, place->leg, GAP_FORCE, has_after(report)};
    if (report->waves->legs > 1) snprintf(leg, sizeof leg, ", leg %d", place->leg + 1);
    fputs("<section id=\"loops\"><h2>Loops over velocity</h2>\n<p>The area of a force loop is the energy lost in a cycle. In what the "
          "model leaves over, dry friction is a jump at zero velocity, viscous friction a slope, inertia and stiffness an open "
          "loop.</p>\n<div class=\"loops\">\n",
          p->out);
    page_figure(p, picture_force_loop, &loop,
                "Test %s%s: measured force, A1 P1 - A2 P2 where there are pressures, and the force that the "
                "model needs for the measured motion",
                test_words(report->measured, motion->test, motion->dof, motion->at_s, motion->segment_s, words), leg);
    page_figure(p, picture_rest_loop, &loop, "What the model leaves over: the measured force less the one that the model needs");
    if (simulated)
        page_figure(p, picture_valve_loop, &(struct picture){simulated, place->leg, GAP_VALVE, has_after(report)},
                    "Velocity over valve command, each with its own motion");
    fputs("</div></section>\n", p->out);
}

/* --- disagreement map */

/* Returns the difference that is drawn in the darkest colour, as a share of the channel's
 * variation: the largest difference, or the largest noise of a sample if that is larger. */
static double full_colour(const struct waves *w) {
    double full = 0.0;
    for (int ch = 0; ch < GAP_CHANNELS; ch++)
        for (int i = 0; i < w->tests && w->evaluated[ch]; i++)
            for (int leg = 0; leg < w->legs; leg++) {
                full = fmax(full, w->test[i].wave[ch][leg].noise / w->variation[ch]);
                for (int after = 0; after < 2; after++) full = fmax(full, spot_size(w, &w->test[i], ch, leg, after));
            }
    return full;
}

/* Computes the colour of a share, from white for 0 through light blue to dark blue for 1. Lightness
 * falls all the way, so that the order is visible to colour-blind readers and in a grey print. */
static void colour(double share, int rgb[3]) {
    static const double stops[3][3] = {{255, 255, 255}, {86, 164, 209}, {0, 52, 96}};
    double place = 2.0 * fmin(fmax(share, 0.0), 1.0);
    int from = place < 1.0 ? 0 : 1;
    for (int i = 0; i < 3; i++) rgb[i] = (int)(stops[from][i] + (place - from) * (stops[from + 1][i] - stops[from][i]));
}

/* Returns the relative luminance of WCAG 2, without WCAG's linear formula for the darkest tones.
 * Below 0.179, white text has more contrast than black. */
static double luminance(const int rgb[3]) {
    static const double weight[3] = {0.2126, 0.7152, 0.0722};
    double sum = 0.0;
    for (int i = 0; i < 3; i++) sum += weight[i] * pow((rgb[i] / 255.0 + 0.055) / 1.055, 2.4);
    return sum;
}

static void map_cell(FILE *out, double size, double full) {
    int rgb[3];
    colour(full > 0.0 ? size / full : 0.0, rgb);
    fprintf(out, "<td style=\"background:#%02x%02x%02x%s\">%.*f</td>", rgb[0], rgb[1], rgb[2], luminance(rgb) < 0.179 ? ";color:#fff" : "",
            size < 0.0995 ? 1 : 0, 100.0 * size);
}

static void map_rows(FILE *out, const struct gap_report *report, bool after, double full) {
    const struct waves *w = report->waves;
    char words[TEST_WORDS];
    fprintf(out, "<tr><th class=\"side\" colspan=\"%d\">%s</th></tr>\n", 1 + GAP_CHANNELS * w->legs, after ? "after" : "before");
    for (const struct wave_test *t = w->test; t < w->test + w->tests; t++) {
        fprintf(out, "<tr><th>%s</th>", test_words(report->measured, t->test, t->dof, t->at_s, t->segment_s, words));
        for (int i = 0; i < GAP_CHANNELS * w->legs; i++) {
            int ch = i / w->legs, leg = i % w->legs;
            if (w->evaluated[ch]) map_cell(out, spot_size(w, t, ch, leg, after), full);
            else fputs("<td class=\"none\"></td>", out);
        }
        fputs("</tr>\n", out);
    }
}

static void place_row(FILE *out, const struct gap_report *report, const struct gap_place *w) {
    int legs = report->waves->legs;
    char words[TEST_WORDS];
    fputs("<tr>", out);
    html_cells(out, "%s|%s", test_words(report->measured, w->test, w->dof, w->at_s, w->segment_s, words),
               section_channel_words(legs, w->channel));
    if (legs > 1) html_cells(out, "%d", w->leg + 1);
    if (w->segment_s > 0.0) html_cells(out, "near %.2g Hz", w->frequency_hz);
    else html_cells(out, "harmonic %d%s", w->harmonic, w->harmonic ? "" : " (constant)");
    html_cells(out, "%s|>%.1f %%", section_feature_words(w->feature), 100.0 * w->share);
    fputs("</tr>\n", out);
}

static void list_places(FILE *out, const struct gap_report *report) {
    const struct gap_result *r = report->result;
    fputs("<h3>Largest places of the gap in the equations, before</h3>\n", out);
    html_table(out, NULL,
               report->waves->legs > 1 ? "test|channel|leg|frequency|feature of the motion|>share of the squared gap"
                                       : "test|channel|frequency|feature of the motion|>share of the squared gap");
    for (int i = 0; i < r->places; i++) place_row(out, report, &r->where[i]);
    html_table_end(out);
}

void section_map(FILE *out, const struct gap_report *report) {
    const struct waves *w = report->waves;
    double full = full_colour(w);
    fputs("<section id=\"map\"><h2>Disagreement map</h2>\n<p>Rms difference between model and measurement, of mean cycles or of pieces of "
          "any motion, in % of the channel's measured variation; one row a test",
          out);
    fputs(w->legs == LEGS ? ", six legs a channel." : ".", out);
    if (!w->evaluated[GAP_LENGTH]) fputs(" Length and valve command are inputs of a replay by motion and are not evaluated.", out);
    fputs("</p>\n<div class=\"wide\"><table class=\"map\"><tr><th></th>", out);
    for (int ch = 0; ch < GAP_CHANNELS; ch++)
        fprintf(out, "<th colspan=\"%d\">%s</th>", w->legs, section_channel_words(w->legs, (enum gap_channel)ch));
    fputs(w->legs > 1 ? "</tr>\n<tr class=\"legs\"><th>leg</th>" : "", out);
    for (int i = 0; w->legs > 1 && i < GAP_CHANNELS * w->legs; i++) fprintf(out, "<th>%d</th>", i % w->legs + 1);
    fputs("</tr>\n", out);
    map_rows(out, report, false, full);
    if (has_after(report)) map_rows(out, report, true, full);
    html_table_end(out);
    list_places(out, report);
    fputs("</section>\n", out);
}
