#include "html.h"

#include <math.h>
#include <string.h>

#include "format.h"

static void escape(FILE *out, const char *text, size_t length) {
    for (const char *c = text; c < text + length; c++) switch (*c) {
        case '<': fputs("&lt;", out); break;
        case '>': fputs("&gt;", out); break;
        case '&': fputs("&amp;", out); break;
        case '"': fputs("&quot;", out); break;
        case '\'': fputs("&#39;", out); break;
        default: fputc(((unsigned char)*c < ' ' && *c != '\n') || *c == 127 ? ' ' : *c, out);
        }
}

static void write_segment(FILE *out, const struct format *f) {
    if (f->unknown) fputs("–", out);
    else if (f->argument) escape(out, f->text, f->length);
    else fwrite(f->text, 1, f->length, out);
}

void html_print(FILE *out, const char *format, ...) {
    struct format f = {.rest = format, .end = format + strlen(format)};
    va_start(f.args, format);
    while (format_next(&f)) write_segment(out, &f);
    va_end(f.args);
}

/* --- tables */

static void write_cell(FILE *out, struct format *f, bool heading) {
    bool number = *f->rest == '>', own = *f->rest == '*', known = true;
    f->rest += number || own;
    fprintf(out, "<t%c%s>", heading || own ? 'h' : 'd', number ? " class=\"n\"" : "");
    while (format_next(f)) {
        if (known) write_segment(out, f);
        known = known && !f->unknown;
    }
    fprintf(out, "</t%c>", heading || own ? 'h' : 'd');
}

static void write_cells(FILE *out, struct format *f, bool heading) {
    for (const char *cell = f->rest; cell; cell = *f->end ? f->end + 1 : NULL) {
        f->rest = cell, f->end = cell + strcspn(cell, "|");
        write_cell(out, f, heading);
    }
}

static void write_head(FILE *out, struct format *f) {
    fputs("<tr>", out);
    write_cells(out, f, true);
    fputs("</tr>\n", out);
}

void html_table(FILE *out, const char *class, const char *head, ...) {
    struct format f = {.rest = head};
    va_start(f.args, head);
    fputs("<div class=\"wide\"><table", out);
    if (class) html_print(out, " class=\"%s\"", class);
    fputs(">\n", out);
    write_head(out, &f);
    va_end(f.args);
}

void html_table_end(FILE *out) { fputs("</table></div>\n", out); }

void html_head(FILE *out, const char *format, ...) {
    struct format f = {.rest = format};
    va_start(f.args, format);
    write_head(out, &f);
    va_end(f.args);
}

void html_row(FILE *out, const char *format, ...) {
    struct format f = {.rest = format};
    va_start(f.args, format);
    fputs("<tr>", out);
    write_cells(out, &f, false);
    fputs("</tr>\n", out);
    va_end(f.args);
}

void html_cells(FILE *out, const char *format, ...) {
    struct format f = {.rest = format};
    va_start(f.args, format);
    write_cells(out, &f, false);
    va_end(f.args);
}

/* --- text and pictures */

static void base64(FILE *out, const unsigned char *data, size_t size) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < size; i += 3) {
        unsigned group = (unsigned)data[i] << 16;
        if (i + 1 < size) group |= (unsigned)data[i + 1] << 8;
        if (i + 2 < size) group |= data[i + 2];
        fputc(digits[group >> 18], out);
        fputc(digits[group >> 12 & 63], out);
        fputc(i + 1 < size ? digits[group >> 6 & 63] : '=', out);
        fputc(i + 2 < size ? digits[group & 63] : '=', out);
    }
}

void html_commands(FILE *out, const char *text) {
    for (const char *open, *close; (open = strchr(text, '`')) && (close = strchr(open + 1, '`')); text = close + 1) {
        escape(out, text, (size_t)(open - text));
        fputs("<code>", out);
        escape(out, open + 1, (size_t)(close - open - 1));
        fputs("</code>", out);
    }
    escape(out, text, strlen(text));
}

void html_svg(FILE *out, const char *svg, size_t size, const char *alt) {
    html_print(out, "<img alt=\"%s\" src=\"data:image/svg+xml;base64,", alt);
    base64(out, (const unsigned char *)svg, size);
    fputs("\">", out);
}

/* Returns the exponent of ten, a multiple of three, with which a number outside 0.01 .. 1e5 is
 * shown; 0 for other numbers. */
static int power_of(double value) {
    double size = fabs(value);
    if (!(size > 0.0) || (size >= 1e-2 && size < 1e5)) return 0;
    return 3 * (int)floor(log10(size) / 3.0);
}

void html_quantity(FILE *out, double value, double half, const char *unit) {
    if (!isfinite(value)) {
        fputs("not known", out);
        return;
    }
    int power = power_of(value);
    double scale = pow(10.0, -power), v = value * scale, s = half * scale;
    if (s > 0.0 && isfinite(s)) {
        int decimals = (int)fmin(fmax(1.0 - floor(log10(s)), 0.0), 9.0);
        html_print(out, "%s%.*f ± %.*f%s", power ? "(" : "", decimals, v, decimals, s, power ? ")" : "");
    } else html_print(out, "%.4g", v);
    if (power) fprintf(out, "·10<sup>%d</sup>", power);
    if (strcmp(unit, "-")) html_print(out, " %s", unit);
}
