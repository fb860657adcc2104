/* The table is found in files of other programs, whatever stands before it, and a --map is proposed
 * if the names are unknown. */
#include "csv_rig.h"

#include <math.h>

#include "csv_map.h"
#include "units.h"

static char text[2 * BUFFER];
static struct csv_map map;

#define assert_near(a, b, within) assert_true(fabs((a) - (b)) <= (within))

static int import_by(const char *names) {
    if (names && csv_map_parse(&map, names, &error)) fail_msg("%s", error.text);
    return csv_import(&(struct csv_source){.path = in, .map = names ? &map : NULL}, log_a, &report, &error);
}

enum { ROWS = 1000 };
static const double HZ = 1.0;

/* Writes a file: head, then rows of time [s], position [mm] and force [N] in the form of row. */
static void put_rows(const char *head, const char *row, char point) {
    int used = sprintf(text, "%s", head);
    for (int i = 0; i < ROWS; i++) {
        char number[3][32];
        double t_s = 0.01 * i;
        snprintf(number[0], sizeof number[0], "%.4f", t_s);
        snprintf(number[1], sizeof number[1], "%.6f", 20.0 * sin(2.0 * PI * HZ * t_s));
        snprintf(number[2], sizeof number[2], "%.6f", 500.0 * cos(2.0 * PI * HZ * t_s));
        for (int k = 0; k < 3; k++)
            for (char *c = number[k]; *c; c++)
                if (*c == '.') *c = point;
        const char *form = row;
        for (int k = 0; *form; form++) {
            if (*form == '@') used += sprintf(text + used, "%s", number[k++]);
            else text[used++] = *form;
        }
        text[used++] = '\n', text[used] = '\0';
    }
    empty(NULL);
    put("1.csv", text);
}

static void assert_read(const char *names) {
    if (import_by(names)) fail_msg("%s", error.text);
    struct recording *r = load(log_a);
    assert_int_equal(r->count, ROWS);
    for (int i = 0; i < ROWS; i++) {
        assert_near(1e3 * r->cycle[i].in.length_m[0], 20.0 * sin(0.02 * PI * HZ * i), 1e-6);
        assert_near(r->cycle[i].force_n[0], 500.0 * cos(0.02 * PI * HZ * i), 1e-6);
        assert_near(r->cycle[i].test_time_s, 0.01 * i, 1e-9);
    }
}

static void tables_are_found_below_what_instruments_write(void **unused) {
    (void)unused;
    static const char ours[] = "t=Time:s,position=Stroke:mm,force=Load:N";
    static const struct {
        const char *head, *row;
        char point;
        const char *map;
    } cases[] = {
        {"Instrument;MTS 370\nOperator;Bo, Li\nRate;100\n\nTime;Stroke;Load\ns;mm;N\n", "@;@;@", ',', "t=Time,position=Stroke,force=Load"},
        {"Specimen 4\nSaved: 2024-11-24 12:00\nTime [s]\tStroke [mm]\tLoad [N]\n", "@\t@\t@", ',',
         "t=Time [s],position=Stroke [mm],force=Load [N]"},
        {"\"Time\",\"Stroke\",\"Load\"\n\"(s)\",\"(mm)\",\"(N)\"\n", "\"@\",\"@\",\"@\"", '.', "t=Time,position=Stroke,force=Load"},
        {"# rig: 4\n# Time Stroke Load\n", "@ @ @", '.', ours},
        {"  Time     Stroke   Load\n", "  @    @  @", '.', ours},
        {"", "@,@,@", '.', "t=#1:s,position=#2:mm,force=#3:N"},
        {"Time,Stroke,Load,\n", "@,@,@,", '.', ours},
        {"Time,Stroke,Load\n", "@,@,@,", '.', ours},
        {"Sample Rate: 100\n Sample   Time s   Com Pos   Load Cell\n\n[", "  1   @   @   @;", '.',
         "t=#2:s,position=Com Pos:mm,force=Load Cell:N"},
        {"Force (V),Time,Stroke,Force (N)\n", "0,@,@,@", '.', "t=Time:s,position=Stroke:mm"},
        {"Name,Crane,\nStart,12,today,13:25\n\nName,Stroke,Load,Other\n\n", "@,@,@,1", '.', "t=Name:s,position=Stroke:mm,force=Load:N"},
        {"Channel,1,2,3,4\nTime,Stroke,Load,State,Note\n", "@,@,@,running,ok", '.', ours},
        {"Zeit in s;Weg, roh;Kraft\n", "@;@;@", ',', "t=Zeit in s,position=#2:mm,force=Kraft:N"},
        {"#1;Time;Stroke;Load\n", "1;@;@;@", ',', ours},
        {"Time,Stroke,Stroke,Load\n", "@,@,0,@", '.', "t=Time:s,position=#2:mm,force=Load:N"},
        {"Time,Stroke,Load,Extra\n", "@,@,@,N/A", '.', "t=Time:s,position=Stroke:mm,force=Load:N,u=Extra"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        put_rows(cases[i].head, cases[i].row, cases[i].point);
        assert_read(cases[i].map);
    }
}

static void what_was_left_out_is_said(void **unused) {
    (void)unused;
    put_rows("Instrument;MTS\nOperator;Bo\nTime;Stroke;Load\ns;mm;N\n", "@;@;@", ',');
    assert_read("t=Time,position=Stroke,force=Load");
    assert_non_null(strstr(report.notes, "1.csv: 2 lines of text before the names left out"));
    assert_non_null(strstr(report.notes, "line 4 has the units"));
}

static void a_unit_that_is_not_known_is_refused_in_the_line_of_units_too(void **unused) {
    (void)unused;
    put_rows("Time,Stroke,Load\ns,mm,stone\n", "@,@,@", '.');
    assert_int_equal(import_by("t=Time,position=Stroke,force=Load"), STATUS_USAGE);
    assert_says("1.csv:2|Load|stone|N, kN");
    assert_int_equal(import_by("t=Time,position=Stroke,force=Load:0.5 N"), 0);
    put_rows("Time [s],position [cubit],Load\n", "@,@,@", '.');
    assert_int_equal(import_by("t=Time [s],force=Load:N"), STATUS_USAGE);
    assert_says("position [cubit]|m, cm, mm");
}

/* The recording begins at 23:59:55 and passes midnight. Its clock has 12 hours with AM and PM, or
 * 24 hours. */
static void times_of_day_go_on_behind_midnight(void **unused) {
    (void)unused;
    for (int noon = 0; noon < 2; noon++) {
        int used = sprintf(text, "Clock,Stroke,Load\n");
        for (int i = 0; i < ROWS; i++) {
            double s = fmod(86395.0 + 0.01 * i, 86400.0);
            int h = (int)(s / 3600.0), m = (int)(s / 60.0) % 60;
            double rest = s - 3600.0 * h - 60.0 * m;
            if (noon) used += sprintf(text + used, "11/24/2024 %02d:%02d:%06.3f %s", (h + 11) % 12 + 1, m, rest, h < 12 ? "AM" : "PM");
            else used += sprintf(text + used, "2024-11-24T%02d:%02d:%06.3fZ", h, m, rest);
            used += sprintf(text + used, ",%.6f,%.6f\n", 20.0 * sin(0.02 * PI * i), 500.0 * cos(0.02 * PI * i));
        }
        empty(NULL);
        put("1.csv", text);
        if (import_by("t=Clock:s,position=Stroke:mm,force=Load:N")) fail_msg("%s", error.text);
        struct recording *r = load(log_a);
        assert_true(r->count == ROWS && report.lost == 0);
        assert_near(r->cycle[900].test_time_s - r->cycle[0].test_time_s, 9.0, 1e-6);
    }
}

#define LONG "rig 1 behind the wall of the second hall on channel "

static void a_map_is_proposed_for_names_that_are_not_known(void **unused) {
    (void)unused;
    static const struct {
        const char *names, *row, *says;
    } cases[] = {
        {"Time [s],Stroke [mm],Load [kN]", "@,@,@", "try --map 't=Time [s],position=Stroke [mm],force=Load [kN]'"},
        {"elapsed,LoadCell,cmd_pos,Pos", "@,1,0,@,@", "t=elapsed:?,position=Pos:?,force=LoadCell:?|with the column or unit for each ?"},
        {"Zeit;Weg;Kraft\ns;mm;kN", "@;@;@", "--map 't=Zeit,position=Weg,force=Kraft'"},
        {"time,velocity [mm/s],current", "@,@,@", "t=time:?,position=velocity [mm/s],force=current:?"},
        {"position,a,f", "1,@,@", "t=a:?,position=position:?,force=f:?"}, /* a is the time, because
                                                                           * only its values rise */
        {"position,f", "1,@", "t=f:?,position=position:?,force=?"},
        {"a,b,c", "1,2,@", "t=c:?,position=?,force=?|columns: a, b, c"},
        {"a,b", "1,2", "t=#0:? ms,position=?,force=?"},
        {"Name,x,Name,F", "@,1,@,2", "t=Name:?,position=x:?,force=F:?"},
        {"time,x, y,Druck A [bar],Druck B [bar]", "@,@,1,@,3", "position=x:?|p1=Druck A [bar],p2=Druck B [bar]"},
        {"t_s,Weg (mm),Moment [N m],Winkel [deg],Temperatur", "@,@,@,1,2", "position="},
        {"time,Stroke,Stroke,Force", "@,@,0,@", "position=#2:?"},
        {LONG "time," LONG "Stroke," LONG "Force," LONG "target", "@,@,0,@", "not understood: rig"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char head[400];
        snprintf(head, sizeof head, "%s\n", cases[i].names);
        put_rows(head, cases[i].row, '.');
        assert_int_equal(import_by(NULL), STATUS_USAGE);
        assert_says(cases[i].says);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tables_are_found_below_what_instruments_write),
        cmocka_unit_test(what_was_left_out_is_said),
        cmocka_unit_test(a_unit_that_is_not_known_is_refused_in_the_line_of_units_too),
        cmocka_unit_test(times_of_day_go_on_behind_midnight),
        cmocka_unit_test(a_map_is_proposed_for_names_that_are_not_known),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
