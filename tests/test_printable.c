/* Control codes and characters that a terminal cannot show never reach it. */
#include "support.h"

#include "printable.h"

static void is_printed(const char *text, const char *expected) {
    char out[200];
    assert_int_equal(text_printable(text, out, sizeof out), strlen(expected));
    assert_string_equal(out, expected);
}

static void ordinary_text_stays(void **unused) {
    (void)unused;
    static const char *const texts[] = {"", "limits.force_n 15000 N", "caf\xc3\xa9 \xe2\x82\xac \xf0\x9f\x98\x80 \xe6\xbc\xa2",
                                        "\xc2\xa0\xdf\xbf\xe0\xa0\x80\xed\x9f\xbf\xee\x80\x80\xf4\x8f\xbf\xbf"};
    for (unsigned i = 0; i < sizeof texts / sizeof *texts; i++) is_printed(texts[i], texts[i]);
}

static void what_a_terminal_obeys_is_replaced(void **unused) {
    (void)unused;
    is_printed("\033[2J\033]0;title\a", "?[2J?]0;title?");
    is_printed("a\nb\rc\td\be\x7f", "a?b?c?d?e?");
    is_printed("\xc2\x9b"
               "31m\xc2\x80\xc2\x9f",
               "?31m??"); /* a C1 control code: CSI as one character */
    is_printed("\xe2\x80\xae"
               "gpj.exe\xe2\x81\xa6\xe2\x80\xa8",
               "?gpj.exe??");
}

static void what_is_no_utf8_is_replaced_byte_by_byte(void **unused) {
    (void)unused;
    is_printed("\x9b"
               "31m\xff\xfe",
               "?31m??");
    is_printed("\xc0\xaf\xc1\xbf", "????");                 /* UTF-8 that is not the shortest
                                                             * form */
    is_printed("\xe0\x80\x9b\xf0\x80\x80\x9b", "???????");
    is_printed("\xed\xa0\x80", "???");                      /* surrogate */
    is_printed("\xf4\x90\x80\x80\xf8\x88\x80\x80\x80", "?????????");
    is_printed("\xe2\x82", "??");                           /* truncated */
    is_printed("\xe2\x82"
               "A\xc3",
               "??A?");
}

static void it_is_cut_off_between_characters(void **unused) {
    (void)unused;
    for (size_t size = 1; size < 8; size++) {
        char out[9];
        memset(out, 'x', sizeof out);
        size_t length = text_printable("a\xe2\x82\xac\xc3\xa9", out, size);
        assert_int_equal(length, size > 6 ? 6 : size > 4 ? 4 : size > 1 ? 1 : 0);
        assert_int_equal(out[length], '\0');
        assert_int_equal(out[size], 'x');
    }
}

static void nothing_that_is_no_text_comes_out(void **unused) {
    (void)unused;
    for (unsigned first = 1; first < 256; first++)
        for (unsigned second = 1; second < 256; second++) {
            const char text[] = {(char)first, (char)second, (char)0x80, (char)0x9b, '\033', '\0'};
            char out[16], again[16];
            size_t length = text_printable(text, out, sizeof out);
            for (size_t i = 0; i < length; i++) assert_true((unsigned char)out[i] >= 0x20 && out[i] != 0x7f);
            assert_int_equal(text_printable(out, again, sizeof again), length);
            assert_string_equal(out, again);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ordinary_text_stays),
        cmocka_unit_test(what_a_terminal_obeys_is_replaced),
        cmocka_unit_test(what_is_no_utf8_is_replaced_byte_by_byte),
        cmocka_unit_test(it_is_cut_off_between_characters),
        cmocka_unit_test(nothing_that_is_no_text_comes_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
