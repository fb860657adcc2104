/* The parts that all pages have in common. Each page is one file without scripts. Ordinary threads;
 * heap; gnuplot as a child process. */
#ifndef HEXID_PAGE_H
#define HEXID_PAGE_H

#include <stdio.h>

#include "status.h"

/* A page while it is written. */
struct page {
    FILE *out;
    struct error picture;  /* why the first failed picture was not drawn; status 0: none failed */
};

/* Makes a page about a subject by calling `write`, which begins with page_begin(). The caller frees
 * *text. Returns 0, or -3 with the reason: no memory (*text is NULL), or pictures are missing
 * (*text is complete except for the pictures, and names the reason). */
typedef void page_writer(struct page *p, const void *subject);
int page_make(page_writer *write, const void *subject, char **text, struct error *error);

/* Writes the beginning of a page of `hexid COMMAND`, up to the list of sources in its header. The
 * caller writes the sources, closes <code> and <span>, and ends the header. about: words of the
 * title after the command; NULL: none. */
void page_begin(struct page *p, const char *command, const char *about);

/* Writes the style sheet. The live page has the same palette and type. */
void page_style(FILE *out);

/* Writes the picture of a subject with its caption; `write` makes the picture's gnuplot script
 * (plot.h). If the picture cannot be drawn, the page says so, and no later picture is tried. An
 * empty script is no error; the page then says that this picture is not drawn. */
typedef void page_script(FILE *script, const void *subject);
__attribute__((format(printf, 4, 5))) void page_figure(struct page *p, page_script *write, const void *subject, const char *caption, ...);

#endif
