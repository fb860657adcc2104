/* Writes HTML to a stream. Text from outside (file names, messages) must go through html_text(). */
#ifndef HEXID_HTML_H
#define HEXID_HTML_H

#include <stddef.h>
#include <stdio.h>

/* Formats a text and escapes it, so that it is safe between tags and inside a double-quoted
 * attribute. Control characters become spaces; a text longer than HTML_TEXT bytes is cut. */
enum { HTML_TEXT = 8192 };
__attribute__((format(printf, 2, 3))) void html_text(FILE *out, const char *format, ...);

/* Writes a text in which commands in backquotes become <code>. */
void html_commands(FILE *out, const char *text);

/* Writes an SVG as an <img> that needs no other file. */
void html_svg(FILE *out, const char *svg, size_t size, const char *alt);

/* Writes value +- std with two digits of std, or without a std four digits of value, with a power
 * of ten if the value is large or small. NaN: "not known". */
void html_quantity(FILE *out, double value, double std, const char *unit);

#endif
