/* A drawing that is turned or mirrored about z, and legs in another order, are found against a
 * reference and named, whatever gains, lags and coupling the loop has; a drawing that is right is
 * not refuted. */
#include "support.h"

#include "leg_places.h"
#include "random.h"
#include "reference_match.h"
#include "units.h"

enum { SAMPLES = 1000 };

/* A machine, its loop, and how the drawing and the reference differ from them. */
struct world {
    struct params drawn;
    struct kinematics machine;
    double gain[DOFS][DOFS];  /* motion of an axis by the reference of another one, in units of
                               * their amplitudes */
    double lag[DOFS];         /* of the motion along an axis, rad */
    double noise;             /* motion that is not the reference's, in units of the amplitudes */
    bool moved[DOFS], against[DOFS];
    bool circle;              /* the reference is a circle in x and y, and one in phi and theta */
    struct leg_places order;  /* of the channels */
};

static uint64_t state;

static double amplitude(int dof) { return dof < DOF_PHI ? 0.004 : 0.006; }

/* Returns a machine with unequal legs and a mass centre off the axis, moved along all axes by a
 * loop with different gains, a lag, and a random coupling of the axes. */
static struct world world_of(double coupling) {
    struct world w = {0};
    struct leg_places common[LEG_PLACES_COMMON];
    leg_places_common(common);
    w.order = common[0];
    config_default(&w.drawn);
    kinematics_place(&w.machine, &w.drawn);
    w.drawn.geometry.upper.given = w.drawn.geometry.lower.given = true;
    for (int k = 0; k < LEGS; k++)
        for (int x = 0; x < 2; x++) {
            w.drawn.geometry.upper.leg[k][x] = w.machine.upper[k][x] + 0.1 * random_unit(&state);
            w.drawn.geometry.lower.leg[k][x] = w.machine.lower[k][x] + 0.1 * random_unit(&state);
        }
    w.drawn.payload.center_x_m = 0.08, w.drawn.payload.center_y_m = -0.05;
    kinematics_place(&w.machine, &w.drawn);
    for (int i = 0; i < DOFS; i++) {
        w.moved[i] = true;
        for (int j = 0; j < DOFS; j++) w.gain[i][j] = i == j ? 0.8 + 0.2 * random_unit(&state) : coupling * random_unit(&state);
    }
    for (int i = 0; i < DOFS; i++) w.lag[i] = 0.4 * random_unit(&state);
    return w;
}

/* Turns both lists of joints by an angle; mirrored: mirrors y before. */
static void turn(struct world *w, double angle_deg, bool mirrored) {
    struct geometry_params *g = &w->drawn.geometry;
    double c = cos(PI / 180.0 * angle_deg), s = sin(PI / 180.0 * angle_deg);
    for (int k = 0; k < 2 * LEGS; k++) {
        double *joint = k < LEGS ? g->upper.leg[k] : g->lower.leg[k - LEGS], x = joint[0], y = mirrored ? -joint[1] : joint[1];
        joint[0] = c * x - s * y, joint[1] = s * x + c * y;
    }
}

/* Reference along an axis in units of its amplitude, late_rad late: two tones of the axis' own, or
 * a circle. */
static double reference_at(const struct world *w, double phase[DOFS][2], int dof, double time, double late_rad) {
    if (!w->moved[dof]) return 0.0;
    if (w->circle) return sin(20.0 * time - late_rad + (dof % 3 == 1 ? 0.5 * PI : 0.0));
    double first = 17.0 + 2.3 * dof;
    return 0.7 * sin(first * time - late_rad + phase[dof][0]) + 0.7 * sin(1.37 * first * time - late_rad + phase[dof][1]);
}

static struct reference_match match_of(const struct world *w) {
    struct leg_moments m = {0};
    struct reference_match match;
    struct kinematics drawn;
    static double length[SAMPLES][LEGS], asked[SAMPLES][LEGS];
    double mean[2][LEGS] = {{0}}, phase[DOFS][2], step = 20.0 / SAMPLES;
    for (int i = 0; i < DOFS; i++) phase[i][0] = PI * random_unit(&state), phase[i][1] = PI * random_unit(&state);
    kinematics_place(&drawn, &w->drawn);
    for (int n = 0; n < SAMPLES; n++) {
        double pose[DOFS], legs[LEGS], said[DOFS];
        for (int i = 0; i < DOFS; i++) {
            pose[i] = w->noise * random_unit(&state);
            for (int j = 0; j < DOFS; j++) pose[i] += w->gain[i][j] * reference_at(w, phase, j, step * n, w->lag[j]);
            pose[i] *= amplitude(i);
            said[i] = (w->against[i] ? -1.0 : 1.0) * amplitude(i) * reference_at(w, phase, i, step * n, 0.0);
        }
        ik_lengths(&w->machine, pose, legs), ik_lengths(&drawn, said, asked[n]);
        for (int k = 0; k < LEGS; k++) {
            length[n][w->order.place[k]] = legs[k];
            mean[0][w->order.place[k]] += legs[k] / SAMPLES, mean[1][k] += asked[n][k] / SAMPLES;
        }
    }
    for (int n = 0; n < SAMPLES; n++)
        for (int a = 0; a < LEGS; a++) {
            double x = length[n][a] - mean[0][a], y = asked[n][a] - mean[1][a], rate = n ? (asked[n][a] - asked[n - 1][a]) / step : 0.0;
            m.measured[a] += x * x;
            for (int b = 0; b < LEGS; b++) {
                double other = asked[n][b] - mean[1][b], other_rate = n ? (asked[n][b] - asked[n - 1][b]) / step : 0.0;
                m.product[a][b] += x * other, m.asked[a][b] += y * other;
                m.late[a][b] += x * other_rate, m.mixed[a][b] += rate * other, m.rates[a][b] += rate * other_rate;
            }
        }
    reference_match_find(&w->drawn, &m, &match);
    return match;
}

static void expect(const struct reference_match *m, const char *words) {
    if (!m->refuted || !strstr(m->text, words))
        fail_msg("stated %.4f, best %.4f: \"%s\" does not say \"%s\"", m->stated, m->best, m->text, words);
}

static double angle_in(const struct reference_match *m, const char *before) {
    const char *at = strstr(m->text, before);
    assert_true(m->refuted && at);
    return atof(at + strlen(before));
}

static void expect_right(const struct world *w) {
    struct reference_match m = match_of(w);
    if (m.refuted) fail_msg("stated %.4f: %s", m.stated, m.text);
}

/* A loop couples its axes by up to 40 %, or by 20 % if it moves only some of them. */
static void a_drawing_that_is_right_is_not_refuted(void **unused) {
    (void)unused;
    for (int i = 0; i < (more_cases() ? 300 : random_cases(100)); i++) {
        struct world w = world_of(0.1 * (1 + i % 4));
        expect_right(&w);
        w = world_of(0.2);
        for (int dof = 0; dof < DOFS; dof++) w.moved[dof] = random_unit(&state) > 0.0;
        expect_right(&w);
    }
}

/* A lag on a circle is a turn of the motion, and the lag of a single axis may be of any size. */
static void a_lag_is_no_turn(void **unused) {
    (void)unused;
    for (int i = 0; i < random_cases(100); i++) {
        struct world w = world_of(0.05);
        w.circle = true;
        for (int dof = 0; dof < DOFS; dof++)
            w.lag[dof] = PI / 4.0 * fabs(random_unit(&state)), w.moved[dof] = dof % 3 < 2 && (dof < 3 || i % 2);
        expect_right(&w);
        w = world_of(0.05);
        w.lag[i % DOFS] = PI * fabs(random_unit(&state));
        for (int dof = 0; dof < DOFS; dof++) w.moved[dof] = dof == i % DOFS || random_unit(&state) > 0.0;
        if (w.lag[i % DOFS] < 0.65 * PI) expect_right(&w);
    }
}

/* The angle is as good as the coupling of 2 % allows. */
static void a_turned_drawing_is_named_with_its_angle(void **unused) {
    (void)unused;
    for (int i = 0; i < random_cases(50); i++) {
        struct world w = world_of(0.02);
        double angle = (i % 2 ? -1.0 : 1.0) * (10.0 + 80.0 * fabs(random_unit(&state)));
        turn(&w, angle, false);
        struct reference_match m = match_of(&w);
        expect(&m, "the drawing is turned by ");
        assert_close(angle_in(&m, "the drawing is turned by "), angle, 3.0);
        assert_close(angle_in(&m, "turn both lists of joints by "), -angle, 3.0);
    }
}

static void a_mirrored_drawing_is_named_with_its_plane(void **unused) {
    (void)unused;
    struct world w = world_of(0.0);
    turn(&w, 0.0, true);
    struct reference_match m = match_of(&w);
    expect(&m,
           "the drawing is mirrored in y against the reference: change the sign of y in both lists of joints, or of ref_y_m, ref_phi_rad");
    w = world_of(0.0);
    turn(&w, 180.0, true);
    m = match_of(&w);
    expect(&m, "the drawing is mirrored in x against the reference");
    assert_null(strstr(m.text, "turned"));
    w = world_of(0.02);
    turn(&w, 70.0, true);
    m = match_of(&w);
    assert_close(angle_in(&m, "in the plane through z at "), 35.0, 2.0);
}

/* One wrong sign is no drawing's; a wrong sign of the only axis that moves may be. */
static void signs_of_the_reference_are_not_taken_for_a_drawing(void **unused) {
    (void)unused;
    for (int dof = 0; dof < DOFS; dof++) {
        struct world w = world_of(0.02);
        w.against[dof] = true;
        struct reference_match m = match_of(&w);
        if (m.refuted) fail_msg("%s", m.text);
    }
    struct world w = world_of(0.0);
    for (int dof = 0; dof < DOFS; dof++) w.moved[dof] = dof == DOF_X;
    w.against[DOF_X] = true;
    struct reference_match m = match_of(&w);
    expect(&m, "mirrored in x against the reference: change the sign of x in both lists of joints, or of ref_x_m");
    expect(&m, "turned by");
}

static void every_order_of_the_legs_is_named(void **unused) {
    (void)unused;
    for (int i = 0; i < random_cases(50); i++) {
        struct world w = world_of(0.02);
        char name[LEG_PLACES_NAME], words[LEG_PLACES_NAME + 60];
        for (int k = LEGS - 1; k > 0; k--)
            w.order = leg_places_exchanged(&w.order, k, (int)(fabs(random_unit(&state)) * (k + 1)) % (k + 1));
        struct reference_match m = match_of(&w);
        leg_places_name(&w.order, name);
        snprintf(words, sizeof words, "the lengths follow the reference with %s, not as stated", name);
        if (leg_places_stated(&w.order)) assert_false(m.refuted);
        else expect(&m, words);
    }
}

/* A loop that does not follow says nothing of the drawing. */
static void lengths_that_do_not_follow_are_not_judged(void **unused) {
    (void)unused;
    struct world w = world_of(0.02);
    turn(&w, 60.0, false);
    w.noise = 3.0;
    assert_false(match_of(&w).refuted);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_lag_is_no_turn),
        cmocka_unit_test(a_drawing_that_is_right_is_not_refuted),
        cmocka_unit_test(a_turned_drawing_is_named_with_its_angle),
        cmocka_unit_test(a_mirrored_drawing_is_named_with_its_plane),
        cmocka_unit_test(signs_of_the_reference_are_not_taken_for_a_drawing),
        cmocka_unit_test(every_order_of_the_legs_is_named),
        cmocka_unit_test(lengths_that_do_not_follow_are_not_judged),
    };
    state = 41;
    return cmocka_run_group_tests(tests, NULL, NULL);
}
