/* Writes HTML to a stream: markup with escaped arguments, and tables whose head and rows are printf
 * formats. */
#ifndef HEXID_HTML_H
#define HEXID_HTML_H

#include <stddef.h>
#include <stdio.h>

/* Writes markup given as a printf format. The arguments may come from outside (file names,
 * messages): they are escaped, so that they are safe between tags and inside a double-quoted
 * attribute; control characters other than the newline become spaces. A number that is not finite
 * is written as a dash. */
__attribute__((format(printf, 2, 3))) void html_print(FILE *out, const char *format, ...);

/* Tables. The cells of a format are separated by '|', and are markup with escaped arguments. A cell
 * that begins with '>' holds numbers and is aligned to the right; one that begins with '*' is a
 * heading of its row. If a number is not finite, a dash replaces it and the rest of its cell.
 *
 *     html_table(out, "survey", "test|>rate");
 *     html_row(out, "%s|>%.3g Hz", name, rate_hz);
 *     html_table_end(out);
 *
 * class: CSS class of the table; NULL for none. html_head() writes another row of headings.
 * html_cells() writes some cells of a row; the caller writes <tr> and </tr>. */
__attribute__((format(printf, 3, 4))) void html_table(FILE *out, const char *class, const char *head, ...);
__attribute__((format(printf, 2, 3))) void html_head(FILE *out, const char *format, ...);
__attribute__((format(printf, 2, 3))) void html_row(FILE *out, const char *format, ...);
__attribute__((format(printf, 2, 3))) void html_cells(FILE *out, const char *format, ...);
void html_table_end(FILE *out);

/* Writes a text in which commands in backquotes become <code>. */
void html_commands(FILE *out, const char *text);

/* Writes an SVG as an <img> that needs no other file. */
void html_svg(FILE *out, const char *svg, size_t size, const char *alt);

/* Writes a value and, after a plus-minus sign, `half` to two significant digits. half: half the
 * width of the value's interval; if it is 0 or not finite, the value stands alone, to four
 * significant digits. Values outside 0.01 .. 1e5 are written with a power of ten, values that are
 * not finite as "not known". unit: "-" for none. */
void html_quantity(FILE *out, double value, double half, const char *unit);

#endif
