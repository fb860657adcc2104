/* Head, style and figures of all pages: one file, no scripts, no network. Ordinary threads. */
#ifndef HEXID_PAGE_H
#define HEXID_PAGE_H

#include <stddef.h>
#include <stdio.h>

#include "status.h"

/* The style sheet; the live page has the same palette and type. */
void page_style(FILE *out);

/* Writes the page up to and with <body>. */
void page_begin(FILE *out, const char *title);

/* Writes a gnuplot script's picture (plot.h) with its caption. If it cannot be drawn, the page
 * says so and *picture gets the reason; after that no other is tried. script NULL: none could be
 * made. */
void page_figure(FILE *out, const char *script, size_t script_size, const char *caption, struct error *picture);

/* The same, with the script that `write` makes of a subject. */
typedef void page_script(FILE *script, const void *subject);
void page_draw(FILE *out, page_script *write, const void *subject, const char *caption, struct error *picture);

#endif
