/* What every page of hexid begins with, and its figures: one file, no scripts, no network. Ordinary
 * threads. */
#ifndef HEXID_PAGE_H
#define HEXID_PAGE_H

#include <stddef.h>
#include <stdio.h>

#include "status.h"

/* The style of all of them, CSS; palette and type are those of the live page, too. */
void page_style(FILE *out);

/* Up to and with <body>. */
void page_begin(FILE *out, const char *title);

/* A gnuplot script's picture (plot.h) with its caption. One that cannot be drawn becomes a line in
 * the page, and the reason goes to *picture; where that has one already, no other is tried. script
 * NULL: none could be made. */
void page_figure(FILE *out, const char *script, size_t script_size, const char *caption, struct error *picture);

/* The same with the script that `write` makes of a subject. */
typedef void page_script(FILE *script, const void *subject);
void page_draw(FILE *out, page_script *write, const void *subject, const char *caption, struct error *picture);

#endif
