#include "gap_pictures.h"

#include <math.h>

#include "residual.h"
#include "units.h"

enum { POINTS = 180 };

const struct picture_unit picture_units[GAP_CHANNELS] = {
    [GAP_LENGTH] = {1e3, 1e6, "mm", "µm"},  [GAP_FORCE] = {1.0, 1.0, "N", "N"}, [GAP_P1] = {1e-3, 1e-3, "kPa", "kPa"},
    [GAP_P2] = {1e-3, 1e-3, "kPa", "kPa"}, [GAP_VALVE] = {1e2, 1e2, "%", "%"},
};

static const char *const labels[GAP_CHANNELS] = {"length - mean", "force", "P1", "P2", "valve command"};

static const char style[] =
    "set encoding utf8\n"
    "set border 3 lc rgb '#777777'\n"
    "set tics nomirror out scale 0.5 tc rgb '#444444'\n"
    "set grid lc rgb '#e8e8e8' lt 1 lw 0.6\n"
    "set key outside top center horizontal samplen 2.5 spacing 1 tc rgb '#444444'\n"
    "set style line 1 lc rgb '#1a1a1a' lw 2.4\n"
    "set style line 2 lc rgb '#8a8a8a' lw 2.2 dt (6,4)\n"
    "set style line 3 lc rgb '" PICTURE_ACCENT "' lw 1.8\n";

/* A step for about four tics between -size and size. */
static double tic_step(double size) {
    double power = pow(10.0, floor(log10(size / 2.0))), lead = size / 2.0 / power;
    return power * (lead < 1.5 ? 1.0 : lead < 3.5 ? 2.0 : lead < 7.5 ? 5.0 : 10.0);
}

static void begin(FILE *script, int width, int height) {
    fprintf(script, "set terminal svg noenhanced size %d,%d font 'sans-serif,12' background '#ffffff'\n%s", width, height, style);
}

static double value_at(const double row[SPECTRUM_SIZE], const struct wave_test *t, double t_s) {
    double value[3];
    spectrum_value(row, SPECTRUM_HARMONICS, t->omega, t_s, value);
    return value[0];
}

/* Of the harmonics that the equations use: a higher one is mostly noise once differentiated. */
static double rate_at(const double row[SPECTRUM_SIZE], const struct wave_test *t, double t_s) {
    double value[3];
    spectrum_value(row, RESIDUAL_HARMONICS, t->omega, t_s, value);
    return value[1];
}

/* Columns: ms, measured, before, after, measured less before, measured less after. Returns the largest difference shown. */
static double wave_data(FILE *script, const struct picture *p, enum gap_channel channel) {
    const struct wave *w = &p->test->wave[channel][p->leg];
    const struct picture_unit *u = &picture_units[channel];
    double origin = channel == GAP_LENGTH ? w->measured[0] : 0.0, largest = u->difference_scale * w->noise;
    fputs("$wave << EOD\n", script);
    for (int i = 0; i <= POINTS; i++) {
        double t_s = 2.0 * PI * i / POINTS / p->test->omega;
        double m = value_at(w->measured, p->test, t_s), b = value_at(w->before, p->test, t_s), a = value_at(w->after, p->test, t_s);
        fprintf(script, "%g %g %g %g %g %g\n", 1e3 * t_s, u->scale * (m - origin), u->scale * (b - origin), u->scale * (a - origin),
                u->difference_scale * (m - b), u->difference_scale * (m - a));
        largest = fmax(largest, u->difference_scale * fmax(fabs(m - b), fabs(m - a)));
    }
    fputs("EOD\n", script);
    return largest > 0.0 ? largest : 1.0;
}

void picture_wave(FILE *script, const struct picture *p, enum gap_channel channel) {
    const struct picture_unit *u = &picture_units[channel];
    double noise = u->difference_scale * p->test->wave[channel][p->leg].noise;
    begin(script, 540, 350);
    double largest = wave_data(script, p, channel);
    fprintf(script, "set multiplot\nset lmargin at screen 0.13\nset rmargin at screen 0.98\nset xrange [0:%g]\n", 2e3 * PI / p->test->omega);
    fprintf(script, "set tmargin at screen 0.91\nset bmargin at screen 0.48\nset format x ''\nset ylabel '%s [%s]' offset 1\n", labels[channel],
            u->unit);
    fprintf(script, "plot $wave using 1:2 with lines ls 1 title 'measured', '' using 1:3 with lines ls 2 title 'model before'%s\n",
            p->after ? ", '' using 1:4 with lines ls 3 title 'model after'" : "");
    fprintf(script, "unset key\nset tmargin at screen 0.43\nset bmargin at screen 0.16\nset format x '%%g'\n"
                    "set xlabel 'time in the cycle [ms]' offset 0,0.5\nset ylabel 'difference [%s]' offset 1\nset yrange [%g:%g]\nset ytics %g\n",
            u->difference_unit, -1.05 * largest, 1.05 * largest, tic_step(largest));
    fprintf(script, "set style fill solid 1.0 noborder\n"
                    "plot $wave using 1:(%g):(%g) with filledcurves lc rgb '#ececec', '' using 1:5 with lines ls 2%s\nunset multiplot\n", -noise, noise,
            p->after ? ", '' using 1:6 with lines ls 3" : "");
}

void picture_force_loop(FILE *script, const struct picture *p) {
    const struct wave *force = &p->test->wave[GAP_FORCE][p->leg], *length = &p->test->wave[GAP_LENGTH][p->leg];
    begin(script, 744, 320);
    fputs("$loop << EOD\n", script);
    for (int i = 0; i <= POINTS; i++) {
        double t_s = 2.0 * PI * i / POINTS / p->test->omega;
        double m = value_at(force->measured, p->test, t_s), b = value_at(force->before, p->test, t_s), a = value_at(force->after, p->test, t_s);
        fprintf(script, "%g %g %g %g %g %g\n", 1e3 * rate_at(length->measured, p->test, t_s), m, b, a, m - b, m - a);
    }
    fputs("EOD\nset multiplot layout 1,2\nset xlabel 'leg velocity [mm/s]' offset 0,0.5\n", script);
    fprintf(script, "set ylabel 'force [N]' offset 1\nplot $loop using 1:2 with lines ls 1 title 'measured', '' using 1:3 with lines ls 2 title "
                    "'before'%s\n", p->after ? ", '' using 1:4 with lines ls 3 title 'after'" : "");
    fprintf(script, "set ylabel 'measured less model [N]' offset 1\nset xzeroaxis lc rgb '#777777'\n"
                    "plot $loop using 1:5 with lines ls 2 title 'before'%s\nunset multiplot\n",
            p->after ? ", '' using 1:6 with lines ls 3 title 'after'" : "");
}

void picture_valve_loop(FILE *script, const struct picture *p) {
    const struct wave *valve = &p->test->wave[GAP_VALVE][p->leg], *length = &p->test->wave[GAP_LENGTH][p->leg];
    begin(script, 372, 320);
    fputs("$loop << EOD\n", script);
    for (int i = 0; i <= POINTS; i++) {
        double t_s = 2.0 * PI * i / POINTS / p->test->omega;
        const double *rows[][2] = {{valve->measured, length->measured}, {valve->before, length->before}, {valve->after, length->after}};
        for (int side = 0; side < 3; side++)
            fprintf(script, "%g %g ", 1e2 * value_at(rows[side][0], p->test, t_s), 1e3 * rate_at(rows[side][1], p->test, t_s));
        fputc('\n', script);
    }
    fprintf(script, "EOD\nset xlabel 'valve command [%%]' offset 0,0.5\nset ylabel 'leg velocity [mm/s]' offset 1\n"
                    "plot $loop using 1:2 with lines ls 1 title 'measured', '' using 3:4 with lines ls 2 title 'before'%s\n",
            p->after ? ", '' using 5:6 with lines ls 3 title 'after'" : "");
}
