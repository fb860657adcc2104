/* Head, style and figures of all pages, each of which is one file without scripts. Ordinary
 * threads. */
#ifndef HEXID_PAGE_H
#define HEXID_PAGE_H

#include <stddef.h>
#include <stdio.h>

#include "status.h"

/* Writes the style sheet. The live page has the same palette and type. */
void page_style(FILE *out);

/* Writes the page up to and with <body>. */
void page_begin(FILE *out, const char *title);

/* Writes the picture of a gnuplot script (plot.h) with its caption. If it cannot be drawn, the page
 * says so, *picture gets the reason, and no later picture is tried. script: NULL if none could be
 * made. */
void page_figure(FILE *out, const char *script, size_t script_size, const char *caption, struct error *picture);

/* Writes a picture as page_figure() does, by the script that `write` makes of a subject. */
typedef void page_script(FILE *script, const void *subject);
void page_draw(FILE *out, page_script *write, const void *subject, const char *caption, struct error *picture);

#endif
