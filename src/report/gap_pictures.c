#include "gap_pictures.h"

#include <math.h>

#include "residual.h"
#include "units.h"

enum { POINTS = 180, LOOP_WIDTH = 372, LOOP_HEIGHT = 320 };

const struct picture_unit picture_units[GAP_CHANNELS] = {
    [GAP_LENGTH] = {1e3, 1e6, "mm", "µm"}, [GAP_FORCE] = {1.0, 1.0, "N", "N"}, [GAP_P1] = {1e-6, 1e-6, "MPa", "MPa"},
    [GAP_P2] = {1e-6, 1e-6, "MPa", "MPa"}, [GAP_VALVE] = {1e2, 1e2, "%", "%"},
};

static const char *const labels[GAP_CHANNELS] = {"length - mean", "force", "P1", "P2", "valve command"};

/* Returns a spacing of tics at which about four intervals fit between -size and size. */
static double tic_step(double size) {
    double power = pow(10.0, floor(log10(size / 2.0))), lead = size / 2.0 / power;
    return power * (lead < 1.5 ? 1.0 : lead < 3.5 ? 2.0 : lead < 7.5 ? 5.0 : 10.0);
}

static double time_at(const struct wave_test *t, int point) { return t->from_s + point * t->span_s / POINTS; }

static double value_at(const double row[SPECTRUM_SIZE], const struct wave_test *t, double t_s) {
    double value[3];
    spectrum_value(row, SPECTRUM_HARMONICS, t->omega, t_s, value);
    return value[0];
}

/* Returns the rate of change of a curve. A steady test contributes only the harmonics that the
 * equations use: after differentiation, higher ones are mostly noise. A segment contributes all
 * harmonics. */
static double rate_at(const double row[SPECTRUM_SIZE], const struct wave_test *t, double t_s) {
    double value[3];
    spectrum_value(row, t->segment_s > 0.0 ? SPECTRUM_HARMONICS : RESIDUAL_HARMONICS, t->omega, t_s, value);
    return value[1];
}

/* Returns the mean of a curve over the plotted time. */
static double middle(const struct wave_test *t, const double row[SPECTRUM_SIZE]) {
    double sum = 0.0;
    for (int i = 0; i < POINTS; i++) sum += value_at(row, t, time_at(t, i)) / POINTS;
    return sum;
}

/* Writes columns: time in ms, measured, before, after, measured less before, measured less after.
 * Returns the largest difference, but at least the noise of a sample, in the display unit of
 * differences; 1 if both are 0. */
static double wave_data(FILE *script, const struct picture *p) {
    const struct wave *w = &p->test->wave[p->channel][p->leg];
    const struct picture_unit *u = &picture_units[p->channel];
    double origin = p->channel == GAP_LENGTH ? middle(p->test, w->measured) : 0.0, largest = u->difference_scale * w->noise;
    fputs("$data << EOD\n", script);
    for (int i = 0; i <= POINTS; i++) {
        double t_s = time_at(p->test, i);
        double m = value_at(w->measured, p->test, t_s), b = value_at(w->before, p->test, t_s), a = value_at(w->after, p->test, t_s);
        fprintf(script, "%g %g %g %g %g %g\n", 1e3 * t_s, u->scale * (m - origin), u->scale * (b - origin), u->scale * (a - origin),
                u->difference_scale * (m - b), u->difference_scale * (m - a));
        largest = fmax(largest, u->difference_scale * fmax(fabs(m - b), fabs(m - a)));
    }
    fputs("EOD\n", script);
    return largest > 0.0 ? largest : 1.0;
}

/* Plots $data by pairs of columns such as "1:2": measured (may be NULL), before, and after if there
 * is one. */
static void plot(FILE *script, const struct picture *p, const char *measured, const char *before, const char *after) {
    fputs("plot ", script);
    if (measured) fprintf(script, "$data using %s with lines ls 1 title 'measured', ", measured);
    fprintf(script, "$data using %s with lines ls 2 title 'before'", before);
    if (p->after) fprintf(script, ", $data using %s with lines ls 3 title 'after'", after);
    fputc('\n', script);
}

void picture_wave(FILE *script, const void *picture) {
    const struct picture *p = picture;
    const struct picture_unit *u = &picture_units[p->channel];
    double noise = u->difference_scale * p->test->wave[p->channel][p->leg].noise;
    char value[40], difference[40];
    snprintf(value, sizeof value, "%s [%s]", labels[p->channel], u->unit);
    snprintf(difference, sizeof difference, "difference [%s]", u->difference_unit);
    plot_begin(script, 540, 350);
    double largest = wave_data(script, p);
    plot_panels(script, 0.13, 1e3 * p->test->from_s, 1e3 * (p->test->from_s + p->test->span_s));
    plot_panel(script, 0.91, 0.48, NULL, value);
    plot(script, p, "1:2", "1:3", "1:4");
    plot_panel(script, 0.43, 0.16, p->test->segment_s > 0.0 ? "time [ms]" : "time in the cycle [ms]", difference);
    fprintf(script,
            "unset key\n"
            "set ytics %g\n"
            "set yrange [%g:%g]\n"
            "set object rectangle from graph 0, first %g to graph 1, first %g fc rgb '#ececec' fs noborder behind\n",
            tic_step(largest), -1.05 * largest, 1.05 * largest, -noise, noise);
    plot(script, p, NULL, "1:5", "1:6");
}

/* Spaces the tics so far apart that their numbers do not overlap. */
static void set_xtics(FILE *script, double low, double high) {
    if (high > low) fprintf(script, "set xtics %g\n", tic_step(0.5 * (high - low)));
}

/* Writes columns: velocity, force measured, before, after, measured less before, measured less
 * after. */
static void force_data(FILE *script, const struct picture *p) {
    const struct wave *force = &p->test->wave[GAP_FORCE][p->leg], *length = &p->test->wave[GAP_LENGTH][p->leg];
    double low = HUGE_VAL, high = -HUGE_VAL;
    fputs("$data << EOD\n", script);
    for (int i = 0; i <= POINTS; i++) {
        double t_s = time_at(p->test, i), rate = 1e3 * rate_at(length->measured, p->test, t_s);
        double m = value_at(force->measured, p->test, t_s), b = value_at(force->before, p->test, t_s);
        double a = value_at(force->after, p->test, t_s);
        fprintf(script, "%g %g %g %g %g %g\n", rate, m, b, a, m - b, m - a);
        low = fmin(low, rate), high = fmax(high, rate);
    }
    fputs("EOD\n", script);
    set_xtics(script, low, high);
}

void picture_force_loop(FILE *script, const void *picture) {
    plot_begin(script, LOOP_WIDTH, LOOP_HEIGHT);
    force_data(script, picture);
    plot_axes(script, "velocity [mm/s]", "force [N]");
    plot(script, picture, "1:2", "1:3", "1:4");
}

void picture_rest_loop(FILE *script, const void *picture) {
    plot_begin(script, LOOP_WIDTH, LOOP_HEIGHT);
    force_data(script, picture);
    plot_axes(script, "velocity [mm/s]", "measured less model [N]");
    fputs("set xzeroaxis lc rgb '#777777'\n", script);
    plot(script, picture, NULL, "1:5", "1:6");
}

/* Writes pairs of columns, valve and velocity: measured, before, after. */
static void valve_data(FILE *script, const struct picture *p) {
    const struct wave *valve = &p->test->wave[GAP_VALVE][p->leg], *length = &p->test->wave[GAP_LENGTH][p->leg];
    const double *rows[][2] = {{valve->measured, length->measured}, {valve->before, length->before}, {valve->after, length->after}};
    double low = HUGE_VAL, high = -HUGE_VAL;
    fputs("$data << EOD\n", script);
    for (int i = 0; i <= POINTS; i++) {
        double t_s = time_at(p->test, i);
        for (int side = 0; side < 3; side++) {
            double opening = 1e2 * value_at(rows[side][0], p->test, t_s);
            fprintf(script, "%g %g ", opening, 1e3 * rate_at(rows[side][1], p->test, t_s));
            low = fmin(low, opening), high = fmax(high, opening);
        }
        fputc('\n', script);
    }
    fputs("EOD\n", script);
    set_xtics(script, low, high);
}

void picture_valve_loop(FILE *script, const void *picture) {
    plot_begin(script, LOOP_WIDTH, LOOP_HEIGHT);
    valve_data(script, picture);
    plot_axes(script, "valve command [%]", "velocity [mm/s]");
    plot(script, picture, "1:2", "3:4", "5:6");
}
