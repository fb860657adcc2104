/* HTML to a stream. Text from outside (file names, messages) goes through html_text() only. */
#ifndef HEXID_HTML_H
#define HEXID_HTML_H

#include <stddef.h>
#include <stdio.h>

/* Formats, then escapes: safe between tags and inside a double-quoted attribute. Control characters
 * become spaces; a text longer than HTML_TEXT bytes is cut. */
enum { HTML_TEXT = 8192 };
__attribute__((format(printf, 2, 3))) void html_text(FILE *out, const char *format, ...);

/* Writes a text, with its commands in backquotes as <code>. */
void html_commands(FILE *out, const char *text);

/* Writes an SVG as an <img> that needs no other file. */
void html_svg(FILE *out, const char *svg, size_t size, const char *alt);

/* Writes value +- std with two digits of std (without one: four digits of value), and a power of
 * ten for large and small values. NaN: "not known". */
void html_quantity(FILE *out, double value, double std, const char *unit);

#endif
