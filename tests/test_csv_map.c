/* --map maps the user's column names to hexid's, and refuses names that map to nothing. */
#include "csv_rig.h"

#include "csv_map.h"

static struct csv_map map;

static void parse(const char *text) {
    if (csv_map_parse(&map, text, &error)) fail_msg("%s: %s", text, error.text);
}

static int import_by(const char *text) {
    parse(text);
    return csv_import(&(struct csv_source){.path = in, .map = &map}, log_a, &report, &error);
}

static void own_names_and_their_stems_are_known(void **unused) {
    (void)unused;
    static const struct {
        const char *text, *column;
        double unit;
    } cases[] = {
        {"position=Weg", "position_m", 1.0},
        {"position_m=Weg:mm", "position_m", 1e-3},
        {"t=Zeit:ms", "t_s", 1e-3},
        {"p1=Druck A:bar", "p1_pa", 1e5},
        {"p1_3=p:MPa", "p1_3_pa", 1e6},
        {"l6=Bein 6:cm", "l6_m", 1e-2},
        {"ref_phi=Soll:deg", "ref_phi_rad", 3.14159265358979323846 / 180.0},
        {"u4=Ventil", "u4", 1.0},
        {"u=Ventil:%", "u", 0.01},
        {"force=Kraft [kN]", "force_n", 1e3},
        {"force = Kraft_kN ", "force_n", 1e3},
        {"position=Weg (µm) [mm]", "position_m", 1e-3},
        {"force=Drehmoment [N m]", "force_n", 1.0},
        {"force=Strom:85.2 N", "force_n", 85.2},
        {"force=Strom [A]:-0.5kN", "force_n", -500.0},
        {"force=Load [lbf]", "force_n", 4.4482216152605},
        {"force=Load kip", "force_n", 4448.2216152605},
        {"position=Disp (in)", "position_m", 0.0254},
        {"position=Weg / mm", "position_m", 1e-3},
        {"position=v [mm/s]", "position_m", 1e-3},
        {"p1=Druck [psi]", "p1_pa", 6894.757293168},
        {"p1=Druck:bar-1.013", "p1_pa", 1e5},
        {"u=Spannung:0.1", "u", 0.1},
        {"force=#3:MN", "force_n", 1e6},
        {"force=#3:mN", "force_n", 1e-3},
        {"t=#0:2 ms", "t_s", 2e-3},
        {"u=Ventil (roh)", "u", 1.0},
        {"position=Kanal:1:mm", "position_m", 1e-3},
        {"position=Kanal:1:", "position_m", 1.0},
        {"flags=Fehler", "flags", 1.0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        parse(cases[i].text);
        assert_int_equal(map.count, 1);
        assert_string_equal(csv_columns[map.alias[0].column].name, cases[i].column);
        double off = map.alias[0].unit.factor / cases[i].unit - 1.0; /* tolerance: rounding of a
                                                                      * product of factors */
        if (!(fabs(off) < 1e-12)) fail_msg("%s: times %.15g", cases[i].text, map.alias[0].unit.factor);
    }
}

static void what_cannot_be_meant_is_refused_with_the_remedy(void **unused) {
    (void)unused;
    static const struct {
        const char *text, *says;
    } cases[] = {
        {"Weg", "Weg|no \"=\"|position=Weg:mm"},
        {"", "no \"=\""},
        {"weight=Gewicht", "weight|no column of that name|position"},
        {"l7=Bein", "l7|l1..l6"},
        {"l1_mm=Bein", "l1_mm|no column of that name"},
        {"position=", "position_m|no name"},
        {"position= :mm", "position_m|no name"},
        {"position=Weg:bar", "Weg|bar|m, cm, mm, um"},
        {"position=Weg:furlong", "furlong|m, cm, mm, um"},
        {"force=Kraft:kg", "kg|N, kN"},
        {"p1=Druck:at", "at|Pa, kPa, MPa, bar, psi"},
        {"flags=F:mm", "flags|none"},
        {"position=Weg,position_m=Hub", "position_m|given twice|Weg|Hub"},
        {"force=Weg [mm]", "Weg [mm]|brackets|behind a colon|N, kN"},
        {"force=Kraft (Dose 2)", "Kraft (Dose 2)|brackets|N, kN"},
        {"position=Weg:?", "no unit for position_m: ?|m, cm, mm, um"},
        {"force=Load:mn", "mn|N, kN"}, /* meganewton or millinewton? */
        {"force=Strom:A", "A|N, kN|force=Strom:85.2 N"},
        {"force=Strom:0 N", "0 N"},
        {"force=#0:N", "#0|number of the row"},
        {"position=Weg,ref=Weg", "Weg|position_m|ref_m"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        assert_int_equal(csv_map_parse(&map, cases[i].text, &error), STATUS_USAGE);
        assert_says("--map");
        assert_says(cases[i].says);
    }
    char text[400];
    snprintf(text, sizeof text, "position=%0300d", 0);
    assert_int_equal(csv_map_parse(&map, text, &error), STATUS_USAGE);
    assert_says("at most");
}

static const char *rows(void) {
    static char text[BUFFER];
    int used = 0;
    for (int i = 0; i < 2000; i++) used += sprintf(text + used, "%d,%.6g,%.6g\n", 2 * i, 10.0 * sin(0.025 * i), 0.3 * cos(0.025 * i));
    return text;
}

/* Names contain spaces, umlauts, brackets and quotes. A column `position` makes the machine one
 * axis. */
static void foreign_names_give_the_log_that_our_names_give(void **unused) {
    (void)unused;
    static char text[BUFFER + 200];
    empty(NULL);
    snprintf(text, sizeof text, "# frequency_hz: 2\nt_ms,position_mm,force_kn\n%s", rows());
    put("1.csv", text);
    assert_imports();
    struct recording *ours = load(log_a);
    empty(NULL);
    snprintf(text, sizeof text, "\xef\xbb\xbf# frequency_hz: 2\nLaufzeit,\"Kolben Länge [mm] (roh)\",Kraft [kN]\n%s", rows());
    put("1.csv", text);
    if (import_by("t=Laufzeit:ms,position=Kolben Länge [mm] (roh):mm,force=Kraft [kN]")) fail_msg("%s", error.text);
    assert_string_equal(report.ignored, "");
    struct recording *theirs = load(log_a);
    assert_true(theirs->params.mechanism == MECHANISM_AXIS && theirs->count == 2000);
    for (int i = 0; i < theirs->count; i++) {
        assert_true(theirs->cycle[i].in.length_m[0] == ours->cycle[i].in.length_m[0]);
        assert_true(theirs->cycle[i].force_n[0] == ours->cycle[i].force_n[0]);
        assert_true(theirs->cycle[i].test_time_s == ours->cycle[i].test_time_s);
    }
}

static void a_name_that_no_file_has_is_refused(void **unused) {
    (void)unused;
    static char text[BUFFER + 200];
    empty(NULL);
    snprintf(text, sizeof text, "t_ms,position_mm,Last\n%s", rows());
    put("1.csv", text);
    assert_int_equal(import_by("force=Lasst:kN"), STATUS_USAGE);
    assert_says("force_n|Lasst|no file|did you mean Last?|left over");
    /* every file must have these columns; the message names the file without one */
    put("1.csv", "Zeit,Weg,Last\n0,1,1\n");
    assert_int_equal(import_by("t=Zeitt:ms,position=Weg:mm,force=Last:kN"), STATUS_USAGE);
    assert_says("1.csv:1|t_s|Zeitt|did you mean Zeit?|left over|Zeit");
    assert_int_equal(import_by("t=Zeit:ms,position=Wegg:mm,force=Last:kN"), STATUS_USAGE);
    assert_says("1.csv:1|position_m|Wegg|did you mean Weg?|left over|Weg");
    assert_int_equal(import_by("t=Zeit:ms,position=Hub:mm,force=Last:kN"), STATUS_USAGE);
    assert_says("1.csv:1|position_m|Hub|no column of that name; left over");
    snprintf(text, sizeof text, "t_ms,position_mm,Last\n%s", rows());
    put("1.csv", text);
    if (import_by("force=Last:kN")) fail_msg("%s", error.text);
}

/* The file's seconds are mapped as ms, with or without a stated rate, or its ms as seconds. */
static void another_unit_of_the_time_is_said_to_be_that(void **unused) {
    (void)unused;
    static char text[BUFFER + 200];
    for (int stated = 0; stated < 2; stated++) {
        empty(NULL);
        int used = sprintf(text, "%sZeit,Weg\n", stated ? "# rate_hz: 500\n" : "");
        for (int i = 0; i < 2000; i++) used += sprintf(text + used, "%.4f,%.6g\n", 0.002 * i, 10.0 * sin(0.025 * i));
        put("1.csv", text);
        assert_int_equal(import_by("t=Zeit:ms,position=Weg:mm"), STATUS_USAGE);
        assert_says("1.csv:|unit of time|thousand times too small|--map");
        assert_int_equal(import_by("t=Zeit:us,position=Weg:mm"), STATUS_USAGE);
        assert_says("1.csv:|unit of time|million times too small|--map");
        if (import_by("t=Zeit:s,position=Weg:mm")) fail_msg("%s", error.text);
    }
}

static void a_column_by_both_names_is_refused(void **unused) {
    (void)unused;
    empty(NULL);
    put("1.csv", "t_s,position_m,Weg\n0,1,1\n");
    assert_int_equal(import_by("position=Weg"), STATUS_USAGE);
    assert_says("1.csv:1|position_m|twice|--map");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(own_names_and_their_stems_are_known),
        cmocka_unit_test(what_cannot_be_meant_is_refused_with_the_remedy),
        cmocka_unit_test(foreign_names_give_the_log_that_our_names_give),
        cmocka_unit_test(a_name_that_no_file_has_is_refused),
        cmocka_unit_test(another_unit_of_the_time_is_said_to_be_that),
        cmocka_unit_test(a_column_by_both_names_is_refused),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
