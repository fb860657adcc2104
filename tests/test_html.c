/* Pages escape the arguments of a format, and a number that is not known is a dash on a page and on
 * a terminal. */
#include "support.h"

#include <stdio.h>
#include <stdlib.h>

#include "html.h"
#include "words.h"

static FILE *out;
static char *written;
static size_t size;

static void begin(void) {
    out = open_memstream(&written, &size);
    assert_non_null(out);
}

static void assert_written(const char *expected) {
    assert_int_equal(fclose(out), 0);
    assert_string_equal(written, expected);
    free(written);
}

static void arguments_are_escaped_and_markup_is_not(void **unused) {
    (void)unused;
    begin();
    html_print(out, "<b>%s</b> & %c%5.1f%% %-4d|%.3s", "<script> \"'&\n\033", '<', 2.25, 7, "a&bc");
    assert_written("<b>&lt;script&gt; &quot;&#39;&amp;\n </b> & &lt;  2.2% 7   |a&amp;b");
}

static void every_conversion_prints_as_printf_does(void **unused) {
    (void)unused;
    char expected[200];
    begin();
    html_print(out, "%d %+ld %lld %u %x %c %g %e %.*f %*s", -3, 123456789012l, -5ll, 7u, 255u, 'x', 0.1, 1e9, 2, 1.005, 6, "six");
    snprintf(expected, sizeof expected, "%d %+ld %lld %u %x %c %g %e %.*f %*s", -3, 123456789012l, -5ll, 7u, 255u, 'x', 0.1, 1e9, 2, 1.005,
             6, "six");
    assert_written(expected);
}

static void a_long_text_is_written_whole(void **unused) {
    (void)unused;
    char text[20000];
    memset(text, 'a', sizeof text - 1);
    text[sizeof text - 1] = '\0';
    begin();
    html_print(out, "%s", text);
    assert_written(text);
}

static void a_table_is_its_formats(void **unused) {
    (void)unused;
    begin();
    html_table(out, "of_tests", "test|>%s|", "rate <Hz>");
    html_row(out, "*<i>%s</i>|>%.2f Hz|%s", "a|b", 4.0, "");
    html_table_end(out);
    assert_written("<div class=\"wide\"><table class=\"of_tests\">\n"
                   "<tr><th>test</th><th class=\"n\">rate &lt;Hz&gt;</th><th></th></tr>\n"
                   "<tr><th><i>a|b</i></th><td class=\"n\">4.00 Hz</td><td></td></tr>\n"
                   "</table></div>\n");
}

static void a_cell_ends_at_a_number_that_is_not_known(void **unused) {
    (void)unused;
    begin();
    html_cells(out, ">%.2f %s|>%d|>%g", (double)NAN, "Hz", 3, (double)INFINITY);
    assert_written("<td class=\"n\">–</td><td class=\"n\">3</td><td class=\"n\">–</td>");
}

static void on_a_terminal_a_number_that_is_not_known_keeps_its_columns(void **unused) {
    (void)unused;
    begin();
    words_row(out, "%-6s|%8.3g|%-+9.*f|%5d\n", "x<", (double)NAN, 2, -(double)INFINITY, 42);
    words_row(out, "%-6s|%8.3g|%-+9.*f|%5d\n", "y", 0.5, 2, 1.0, 42);
    assert_written("x<    |       -|-        |   42\n"
                   "y     |     0.5|+1.00    |   42\n");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arguments_are_escaped_and_markup_is_not),
        cmocka_unit_test(every_conversion_prints_as_printf_does),
        cmocka_unit_test(a_long_text_is_written_whole),
        cmocka_unit_test(a_table_is_its_formats),
        cmocka_unit_test(a_cell_ends_at_a_number_that_is_not_known),
        cmocka_unit_test(on_a_terminal_a_number_that_is_not_known_keeps_its_columns),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
