#include "page.h"

#include <stdarg.h>
#include <stdlib.h>

#include "html.h"
#include "plot.h"

enum { CAPTION = 600 };

static const char style[] =
    ":root{color-scheme:light dark;--ink:#1a1a1a;--soft:#5c5c5c;--line:#dcdcdc;--paper:#fff;--mark:#fff3d6;--code:#333;--shade:#0006;"
    "--accent:" PICTURE_ACCENT ";--off:#b34a00}\n"
    "@media(prefers-color-scheme:dark){"
    ":root{--ink:#e8e8e8;--soft:#aaa;--line:#444;--paper:#1a1a1a;--mark:#4a3a10;--code:#ccc;--shade:#fff6;--accent:#6db9ee;--off:#f59a5c}\n"
    "img,table.map td{filter:invert(.9) hue-rotate(180deg)}}\n" /* dark mode inverts pictures and
                                                                 * keeps their hues */
    "*{box-sizing:border-box}\n"
    "body{margin:0 auto;max-width:1180px;padding:18px 32px 64px;"
    "font:15px/1.45 system-ui,'Segoe UI','Helvetica Neue',Arial,'Liberation Sans',sans-serif;color:var(--ink);background:var(--paper)}\n"
    "header{display:flex;flex-wrap:wrap;justify-content:space-between;gap:0 24px;font-size:13px;color:var(--soft);"
    "border-bottom:1px solid var(--line);padding-bottom:8px}\n"
    ".kicker{margin:18px 0 0;color:var(--accent);font-size:15px;font-weight:600}\n"
    "h1{margin:2px 0 4px;font-size:32px;line-height:1.18;font-weight:600;letter-spacing:-.01em}\n"
    "h1.long{font-size:25px}\n"
    "h2{margin:44px 0 6px;font-size:21px;font-weight:600;border-top:1px solid var(--line);padding-top:18px}\n"
    "h3{margin:16px 0 6px;font-size:15px;font-weight:600}\n"
    "p{margin:6px 0;max-width:52em}\n"
    "sup{font-size:75%;line-height:0}\n"
    "code,.anywhere{overflow-wrap:anywhere}\n"
    "code{font:13px ui-monospace,'DejaVu Sans Mono','Liberation Mono',monospace;color:var(--code)}\n"
    ".lead{color:var(--soft);margin-top:0}\n"
    ".cards{display:grid;grid-template-columns:minmax(0,1.15fr) minmax(0,1fr) minmax(0,1.15fr);gap:36px;margin-top:16px}\n"
    ".cards h2{margin:0 0 8px;font-size:15px;border-top:2px solid var(--ink);padding-top:8px}\n"
    ".big{font-size:34px;line-height:1.1;font-weight:600;color:var(--accent);margin:0 0 2px}\n"
    ".small,figcaption{font-size:13px;color:var(--soft)}\n"
    ".notice{background:var(--mark);padding:2px 6px}\n"
    "p.notice{padding:8px 12px}\n"
    ".next{border-left:3px solid var(--accent);padding:4px 0 4px 14px;margin-top:18px}\n"
    ".two{display:grid;grid-template-columns:repeat(2,minmax(0,1fr));gap:16px 32px}\n"
    ".loops{display:grid;grid-template-columns:repeat(3,minmax(0,1fr));gap:0 8px}\n"
    "figure{margin:8px 0}\n"
    "img{max-width:100%;height:auto;display:block}\n"
    "table{border-collapse:collapse;font-size:14px;font-variant-numeric:tabular-nums}\n"
    "th,td{text-align:left;padding:3px 12px 3px 0;border-bottom:1px solid var(--line);font-weight:400;vertical-align:top}\n"
    "th{color:var(--soft)}\n"
    ".n{text-align:right;white-space:nowrap}\n"
    "table.map{border-collapse:separate;border-spacing:1px;font-size:12px}\n"
    "table.map td{color:#000;width:32px;min-width:28px;height:24px;padding:0;text-align:center;vertical-align:middle;border:0}\n"
    "table.map th{border:0;padding:2px 6px 2px 0;text-align:center;vertical-align:middle}\n"
    "table.map td:nth-child(6n+2){border-left:3px solid var(--paper)}\n"
    "table.map th.side{text-align:left;font-weight:600;color:var(--ink);padding-top:8px}\n"
    "table.map .none{background:repeating-linear-gradient(135deg,var(--paper) 0 5px,var(--line) 5px 6px)}\n"
    "td.bar{width:240px;vertical-align:middle}\n"
    ".bar i{display:block;height:12px;background:#a9a9a9}\n"
    ".found .bar i{background:var(--accent)}\n"
    ".found td{font-weight:600}\n"
    ".ranking td:last-child{min-width:170px}\n"
    ".sizes{display:grid;grid-template-columns:auto 1fr auto;gap:3px 10px;align-items:center;font-size:13px;margin:4px 0 10px}\n"
    ".sizes i{display:block;height:12px}\n"
    ".sizes b{grid-column:1/4;font-weight:600;margin-top:2px}\n";

static const char more_style[] = /* a string of its own, because C limits the length of a string
                                  * constant */
    ".beside{display:grid;grid-template-columns:minmax(0,1fr) minmax(0,1fr);gap:8px 40px;align-items:start}\n"
    ".third{display:grid;grid-template-columns:repeat(auto-fill,minmax(300px,1fr));gap:8px 24px}\n"
    ".n small{display:block;color:var(--soft)}\n"
    ".off{font-weight:600;color:var(--off)}\n"
    ".group{border-left:1px solid var(--line);padding-left:12px}\n"
    "th.group:not(.n){text-align:center}\n"
    ".off small{font-weight:400}\n"
    /* In a table, a key is broken across lines only if it does not fit on one line. */
    "td code{overflow-wrap:break-word}.facts code{overflow-wrap:anywhere}\n"
    ".facts th,.values td:first-child{white-space:nowrap}\n"
    ".facts td{min-width:170px}\n"
    "table.matrix{font-size:12.5px}\n"
    "table.matrix td,table.matrix th{padding:2px 0 2px 8px}\n"
    "table.matrix td:first-child,table.matrix th:first-child{padding-left:0}\n"
    /* The name of a test is not broken at every word, and stays in sight while the rest of its row
     * is scrolled. */
    ".survey th{vertical-align:bottom}\n"
    ".survey td:first-child,.survey th:first-child{position:sticky;left:0;background:var(--paper)}\n"
    ".survey span{display:inline-block;width:max-content;max-width:38vw;overflow-wrap:anywhere}\n"
    "details{margin:10px 0}\n"
    "summary{cursor:pointer}\n"
    /* A shade at an edge marks a table that continues there; covers that scroll with the table hide
     * the shade where the table ends. */
    ".wide,pre{overflow-x:auto;background:linear-gradient(90deg,var(--paper) 50%,transparent) 0 0/36px 100% no-repeat local,"
    "linear-gradient(270deg,var(--paper) 50%,transparent) 100% 0/36px 100% no-repeat local,"
    "linear-gradient(90deg,var(--shade),transparent) 0 0/18px 100% no-repeat scroll,"
    "linear-gradient(270deg,var(--shade),transparent) 100% 0/18px 100% no-repeat scroll}\n"
    "pre{font:12px/1.4 ui-monospace,'DejaVu Sans Mono','Liberation Mono',monospace;overflow-wrap:normal}\n"
    /* Backgrounds carry data here, so they are printed; a map is made to fit on A4. */
    "@media print{*{print-color-adjust:exact;-webkit-print-color-adjust:exact}body{max-width:none;padding:0}section{break-inside:avoid}"
    ".wide,pre{overflow:visible;background:none}"
    "table.map{width:100%;font-size:9px}table.map td{width:auto;min-width:0;height:18px}table.map th{padding:1px}}\n"
    "@media(max-width:800px){.picture{overflow-x:auto}"
    ".panels img{width:800px;max-width:none}" /* the labels cannot be read in a narrower picture */
    ".cards,.two,.loops,.beside{grid-template-columns:minmax(0,1fr)}body{padding:12px}th.n{white-space:normal}"
    ".survey th.n{white-space:nowrap}}\n";

void page_style(FILE *out) { fprintf(out, "%s%s", style, more_style); }

void page_begin(struct page *p, const char *command, const char *about) {
    html_print(p->out,
               "<!DOCTYPE html>\n"
               "<html lang=\"en\">\n"
               "<head>\n"
               "<meta charset=\"utf-8\">\n"
               "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
               "<title>hexid %s%s%s</title>\n<style>\n",
               command, about ? ": " : "", about ? about : "");
    page_style(p->out);
    html_print(p->out, "</style>\n</head>\n<body>\n<header><span>hexid %s: <code>", command);
}

int page_make(page_writer *write, const void *subject, char **text, struct error *error) {
    struct page p = {0};
    size_t size;
    *text = NULL;
    p.out = open_memstream(text, &size);
    if (!p.out) return error_set(error, STATUS_IO, "the page: out of memory");
    write(&p, subject);
    if (p.picture.status) html_print(p.out, "<p class=\"notice\">%s</p>\n", p.picture.text);
    fputs("</body>\n</html>\n", p.out);
    int cut = ferror(p.out);
    if (fclose(p.out) || cut) {
        free(*text);
        *text = NULL;
        return error_set(error, STATUS_IO, "the page: out of memory");
    }
    *error = p.picture;
    return p.picture.status;
}

static char *draw(page_script *write, const void *subject, size_t *size, struct error *error) {
    char *script = NULL, *svg = NULL;
    size_t script_size = 0;
    FILE *stream = open_memstream(&script, &script_size);
    if (stream) write(stream, subject);
    if (!stream || fclose(stream)) error_set(error, STATUS_IO, "out of memory");
    else if (script_size) plot_draw(script, script_size, &svg, size, error);
    free(script);
    return svg;
}

void page_figure(struct page *p, page_script *write, const void *subject, const char *caption, ...) {
    char words[CAPTION];
    va_list args;
    va_start(args, caption);
    vsnprintf(words, sizeof words, caption, args);
    va_end(args);
    size_t size;
    char *svg = p->picture.status ? NULL : draw(write, subject, &size, &p->picture);
    fputs("<figure>", p->out);
    if (svg) {
        fputs("<div class=\"picture\">", p->out);
        html_svg(p->out, svg, size, words);
        fputs("</div>", p->out);
    } else fputs("<p class=\"notice\">picture not drawn</p>", p->out);
    html_print(p->out, "<figcaption>%s</figcaption></figure>\n", words);
    free(svg);
}
