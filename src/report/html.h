/* HTML to a stream. What comes from outside (file names, texts) goes through html_text only. */
#ifndef HEXID_HTML_H
#define HEXID_HTML_H

#include <stddef.h>
#include <stdio.h>

/* Formatted, then escaped: safe between tags and inside a double-quoted attribute. Control
 * characters become spaces; a text of more than HTML_TEXT bytes is cut. */
enum { HTML_TEXT = 8192 };
__attribute__((format(printf, 2, 3))) void html_text(FILE *out, const char *format, ...);

/* A text whose commands stand in backquotes: those go into <code>. */
void html_commands(FILE *out, const char *text);

/* An SVG as an <img> that needs no other file. */
void html_svg(FILE *out, const char *svg, size_t size, const char *alt);

/* value +- std with two digits of std (without one: four digits of value), a power of ten taken out
 * of large and small ones. NaN: "not known". */
void html_quantity(FILE *out, double value, double std, const char *unit);

#endif
