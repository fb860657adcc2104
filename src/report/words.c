#include "words.h"

#include <string.h>

#include "format.h"

const char *const words_axes[6] = {"x", "y", "z", "φ", "θ", "ψ"};

/* Returns the length of the next word. Text in backquotes is one word, so that it can be copied
 * whole. */
static int word_length(const char *text) {
    const char *quote = *text == '`' ? strchr(text + 1, '`') : NULL;
    size_t quoted = quote ? (size_t)(quote - text) : 0;
    return (int)(quoted + strcspn(text + quoted, " "));
}

void words_print(FILE *out, const char *label, const char *text) {
    int column = fprintf(out, "%s", label);
    while (*(text += strspn(text, " "))) {
        int length = word_length(text);
        if (column + 1 + length > WORDS_COLUMNS) column = fprintf(out, "\n    ") - 1;
        column += fprintf(out, " %.*s", length, text);
        text += length;
    }
    fputc('\n', out);
}

void words_row(FILE *out, const char *format, ...) {
    struct format f = {.rest = format, .end = format + strlen(format)};
    va_start(f.args, format);
    while (format_next(&f)) fwrite(f.text, 1, f.length, out);
    va_end(f.args);
}
