/* Writes HTML to a stream: markup with escaped arguments, and tables whose head and rows are
 * formats. */
#ifndef HEXID_HTML_H
#define HEXID_HTML_H

#include <stddef.h>
#include <stdio.h>

/* Writes a format that is markup. Its arguments may come from outside (file names, messages): they
 * are escaped, so that they are safe between tags and inside a double-quoted attribute; control
 * characters other than the newline become spaces. A number that is not finite is a dash. */
__attribute__((format(printf, 2, 3))) void html_print(FILE *out, const char *format, ...);

/* Tables. The cells of a format are separated by '|', and are markup with escaped arguments. A cell
 * that begins with '>' is of numbers and stands to the right; one that begins with '*' is a heading
 * of its row. If a number is not finite, a dash replaces it and what follows it in its cell.
 *
 *     html_table(out, "survey", "test|>rate");
 *     html_row(out, "%s|>%.3g Hz", name, rate_hz);
 *     html_table_end(out);
 *
 * class: NULL for none. html_cells() writes a part of a row, between <tr> and </tr>; html_head()
 * one more row of headings. */
__attribute__((format(printf, 3, 4))) void html_table(FILE *out, const char *class, const char *head, ...);
__attribute__((format(printf, 2, 3))) void html_head(FILE *out, const char *format, ...);
__attribute__((format(printf, 2, 3))) void html_row(FILE *out, const char *format, ...);
__attribute__((format(printf, 2, 3))) void html_cells(FILE *out, const char *format, ...);
void html_table_end(FILE *out);

/* Writes a text in which commands in backquotes become <code>. */
void html_commands(FILE *out, const char *text);

/* Writes an SVG as an <img> that needs no other file. */
void html_svg(FILE *out, const char *svg, size_t size, const char *alt);

/* Writes a value ± half its interval, to two digits of the half; without an interval, the value to
 * four digits. A very large or small value is written with a power of ten. NaN: "not known". */
void html_quantity(FILE *out, double value, double half, const char *unit);

#endif
