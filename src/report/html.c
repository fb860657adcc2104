#include "html.h"

#include <math.h>
#include <stdarg.h>
#include <string.h>

static void escape(FILE *out, unsigned char c) {
    switch (c) {
    case '<': fputs("&lt;", out); break;
    case '>': fputs("&gt;", out); break;
    case '&': fputs("&amp;", out); break;
    case '"': fputs("&quot;", out); break;
    case '\'': fputs("&#39;", out); break;
    default: fputc(c < ' ' || c == 127 ? ' ' : c, out);
    }
}

void html_text(FILE *out, const char *format, ...) {
    char text[HTML_TEXT];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    for (const char *c = text; *c; c++) escape(out, (unsigned char)*c);
}

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
        html_text(out, "%.*s", (int)(open - text), text);
        fputs("<code>", out);
        html_text(out, "%.*s", (int)(close - open - 1), open + 1);
        fputs("</code>", out);
    }
    html_text(out, "%s", text);
}

void html_svg(FILE *out, const char *svg, size_t size, const char *alt) {
    fputs("<img alt=\"", out);
    html_text(out, "%s", alt);
    fputs("\" src=\"data:image/svg+xml;base64,", out);
    base64(out, (const unsigned char *)svg, size);
    fputs("\">", out);
}

/* Exponent of ten, a multiple of three, by which a number outside 0.01 .. 1e5 is shown; otherwise
 * 0. */
static int power_of(double value) {
    double size = fabs(value);
    if (!(size > 0.0) || (size >= 1e-2 && size < 1e5)) return 0;
    return 3 * (int)floor(log10(size) / 3.0);
}

void html_quantity(FILE *out, double value, double std, const char *unit) {
    if (!isfinite(value)) {
        fputs("not known", out);
        return;
    }
    int power = power_of(value);
    double scale = pow(10.0, -power), v = value * scale, s = std * scale;
    if (s > 0.0 && isfinite(s)) {
        int decimals = (int)fmin(fmax(1.0 - floor(log10(s)), 0.0), 9.0);
        html_text(out, "%s%.*f ± %.*f%s", power ? "(" : "", decimals, v, decimals, s, power ? ")" : "");
    } else html_text(out, "%.4g", v);
    if (power) fprintf(out, "·10<sup>%d</sup>", power);
    if (strcmp(unit, "-")) html_text(out, " %s", unit);
}
