#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "doctor.h"
#include "force.h"
#include "kinematics.h"
#include "params.h"
#include "units.h"

/* A limit protects only if the machine can exceed it, and if it trips before harm is done. The
 * constants below are bounds for the limits. */
static const double FORCE_MOST = 1.0;      /* largest limits.force_n, as a share of the supply's
                                            * largest force on a leg */
static const double RATE_MOST = 2.0;       /* largest limits.leg_rate_mps, as a multiple of a leg's
                                            * speed at full opening */
static const double FOLLOWING_MOST = 0.1;  /* largest limits.following_m and standstill_m, as a
                                            * share of the stroke */
static const double PRESSURE_MOST = 2.5;   /* largest limits.pressure_max_pa, as a multiple of the
                                            * supply's pressure (or 1.1 of the sensors' full scale
                                            * if that is more); a chamber's peaks are lower */
static const double PRESSURE_LEAST_PA = -1.01325e5; /* gauge pressure of a vacuum, the lowest
                                                     * possible */
static const double PRESSURE_SPAN = 0.5;   /* lowest limits.pressure_min_pa: minus this share of the
                                            * supply's pressure, or minus two atmospheres if that is
                                            * lower; only a faulty sensor reads less */
static const double STEPS_LEAST = 5.0;     /* smallest limits.following_m and standstill_m, in steps
                                            * of the length transducer; a smaller limit trips on
                                            * rounding */

/* Finding about the limits, with a line and a remedy for each limit that does not suit the
 * machine. */
struct saying {
    struct finding f;
};

__attribute__((format(printf, 4, 5))) static void say(struct saying *s, bool holds, const char *remedy, const char *format, ...) {
    size_t found = strlen(s->f.found), told = strlen(s->f.remedy);
    va_list args;
    if (holds) return;
    s->f.level = LEVEL_WARN;
    if (found && found < sizeof s->f.found - 1) s->f.found[found++] = '\n';
    va_start(args, format);
    vsnprintf(s->f.found + found, sizeof s->f.found - found, format, args);
    va_end(args);
    snprintf(s->f.remedy + told, sizeof s->f.remedy - told, "%s%s", told ? "; " : "", remedy);
}

/* Returns the largest force of any leg, N: supply pressure on the rodless side, tank pressure on
 * the rod side. */
static double strongest_n(const struct params *p) {
    struct cylinder_areas areas = cylinder_areas(&p->actuator);
    double most = 0.0;
    for (int i = 0; i < LEGS; i++) most = fmax(most, areas.a1_m2[i] * p->hydraulics.supply_pa - areas.a2_m2[i] * p->hydraulics.tank_pa);
    return most;
}

static void force(struct saying *s, const struct params *p) {
    double most_n = strongest_n(p), suits_n = 0.5 * most_n;
    char remedy[80];
    snprintf(remedy, sizeof remedy, "set limits.force_n to %.2g or less", suits_n);
    say(s, p->limits.force_n <= FORCE_MOST * most_n, remedy,
        "limits.force_n %g: the supply pushes a leg with %.3g N at most, so no obstacle trips it", p->limits.force_n, most_n);
}

static void leg_rate(struct saying *s, const struct params *p, const struct loop_check *c) {
    double fastest_mps = fmax(c->out_mps, c->in_mps);
    char remedy[80];
    if (c->state == LOOP_UNKNOWN) return;
    snprintf(remedy, sizeof remedy, "set limits.leg_rate_mps to %.2g or less", fastest_mps);
    say(s, p->limits.leg_rate_mps <= RATE_MOST * fastest_mps, remedy,
        "limits.leg_rate_mps %g: a leg at full opening makes %.3g m/s, and a length that jumps twice as fast is still believed",
        p->limits.leg_rate_mps, fastest_mps);
    double cycle_m = p->limits.leg_rate_mps * p->loop.period_s, step_m = p->sensors.position_resolution_m;
    snprintf(remedy, sizeof remedy, "set limits.leg_rate_mps to %.2g or more", 2.0 * step_m / p->loop.period_s);
    say(s, !p->sensors.enabled || cycle_m >= step_m, remedy,
        "limits.leg_rate_mps %g is %.2g m in a cycle, and sensors.position_resolution_m is %g: a single step of the transducer trips it",
        p->limits.leg_rate_mps, cycle_m, step_m);
}

/* Compares following_m and standstill_m with the stroke, the step of the length transducer, and
 * each other. */
static void following(struct saying *s, const struct params *p) {
    const struct {
        const char *key;
        double value;
    } limits[] = {{"limits.following_m", p->limits.following_m}, {"limits.standstill_m", p->limits.standstill_m}};
    double stroke_m = HUGE_VAL, least_m = p->sensors.enabled ? STEPS_LEAST * p->sensors.position_resolution_m : 0.0;
    char remedy[80];
    for (int i = 0; i < LEGS; i++) stroke_m = fmin(stroke_m, p->actuator.stroke_m[i]);
    for (int i = 0; i < 2; i++) {
        snprintf(remedy, sizeof remedy, "set %s to %.2g or less", limits[i].key, 0.5 * FOLLOWING_MOST * stroke_m);
        say(s, limits[i].value <= FOLLOWING_MOST * stroke_m, remedy,
            "%s %g: with a stroke of %g m a leg that does not follow goes far first", limits[i].key, limits[i].value, stroke_m);
        snprintf(remedy, sizeof remedy, "set %s to %.2g or more", limits[i].key, 2.0 * least_m);
        say(s, limits[i].value >= least_m, remedy, "%s %g: sensors.position_resolution_m is %g, what it rounds trips it", limits[i].key,
            limits[i].value, p->sensors.position_resolution_m);
    }
    snprintf(remedy, sizeof remedy, "set limits.standstill_m to %.2g or less", 0.5 * p->limits.following_m);
    say(s, p->limits.standstill_m < p->limits.following_m, remedy,
        "limits.standstill_m %g is not below limits.following_m %g: a frozen transducer is not told from a leg that does not follow",
        p->limits.standstill_m, p->limits.following_m);
}

static void pressures(struct saying *s, const struct params *p) {
    const struct limit_params *l = &p->limits;
    double supply_pa = p->hydraulics.supply_pa, top_pa = p->sensors.pressure_full_scale_pa;
    char remedy[80];
    snprintf(remedy, sizeof remedy, "set limits.pressure_max_pa to %.2g", 1.65 * supply_pa);
    say(s, l->pressure_max_pa <= fmax(PRESSURE_MOST * supply_pa, 1.1 * top_pa), remedy,
        "limits.pressure_max_pa %g: supply and sensors end at %.3g and %.3g Pa, so no reading trips it", l->pressure_max_pa, supply_pa,
        top_pa);
    snprintf(remedy, sizeof remedy, "set limits.pressure_min_pa to %.2g", -0.02 * supply_pa);
    say(s, l->pressure_min_pa >= -fmax(PRESSURE_SPAN * supply_pa, 2.0 * -PRESSURE_LEAST_PA), remedy,
        "limits.pressure_min_pa %g: no oil has less than %.3g Pa, so only a sensor far below its range trips it", l->pressure_min_pa,
        PRESSURE_LEAST_PA);
}

/* Checks the limits of time: they must tolerate one late or bad sample, and a leg must not go far
 * in the time that they allow. */
static void times(struct saying *s, const struct params *p, const struct loop_check *c) {
    double period_s = p->loop.period_s, patience_s = p->limits.bad_cycles * period_s;
    double blind_m = fmax(c->out_mps, c->in_mps) * (p->limits.sensor_age_s + patience_s), room_m = HUGE_VAL;
    for (int i = 0; i < LEGS; i++) room_m = fmin(room_m, p->actuator.stroke_m[i]);
    say(s, p->limits.sensor_age_s >= 2.0 * period_s, "set limits.sensor_age_s to two periods or more",
        "limits.sensor_age_s %g: loop.period_s is %g, so that one sample that is late is a fault", p->limits.sensor_age_s, period_s);
    say(s, p->limits.bad_cycles > 1, "set limits.bad_cycles to 2 or more", "limits.bad_cycles 1: one sample that is bad is a fault");
    say(s, c->state == LOOP_UNKNOWN || blind_m <= FOLLOWING_MOST * room_m, "lower limits.sensor_age_s or limits.bad_cycles",
        "limits.sensor_age_s %g and bad_cycles %d: a leg at full opening goes %.2g m in that time, and its stroke is %g",
        p->limits.sensor_age_s, p->limits.bad_cycles, blind_m, room_m);
}

/* Checks that the range of each pressure channel on the bus includes the supply's pressure, because
 * a reading beyond the range counts as missing. */
static void channels(struct saying *s, const struct doctor *d) {
    const struct params *p = d->params;
    const struct {
        const char *key;
        const struct channel_params *channel;
        double needs;
    } ends[] = {{"p1_channel.high", &p->p1_channel, p->hydraulics.supply_pa}, {"p2_channel.high", &p->p2_channel, p->hydraulics.supply_pa}};
    for (int n = 0; n < 2 && d->machine; n++)
        for (int i = 0; i < LEGS; i++)
            say(s, ends[n].channel->high[i] >= ends[n].needs, "raise it, or choose a sensor that reaches the supply",
                "%s %g of leg %d: hydraulics.supply_pa is %g, so that an ordinary pressure counts as no reading", ends[n].key,
                ends[n].channel->high[i], i + 1, ends[n].needs);
}

struct finding check_limits(const struct doctor *d) {
    if (!doctor_drives(d)) return finding_none();
    struct saying s = {.f = {.level = LEVEL_OK}};
    const struct params *p = d->params;
    struct loop_check c = doctor_loop(d);
    force(&s, p);
    leg_rate(&s, p, &c);
    following(&s, p);
    pressures(&s, p);
    times(&s, p, &c);
    channels(&s, d);
    if (s.f.level != LEVEL_OK) return s.f;
    return finding(LEVEL_OK, "", "force %.3g of %.3g N, leg rate %.3g of %.3g m/s, following %.3g m: within what the machine can reach",
                   p->limits.force_n, strongest_n(p), p->limits.leg_rate_mps, fmax(c.out_mps, c.in_mps), p->limits.following_m);
}
