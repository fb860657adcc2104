/* Latency histogram up to 9.8 h: 16 linear steps per power of two of nanoseconds, so that a
 * quantile is right to 6.25 %. A negative latency counts as 0. No heap. */
#ifndef HEXID_HISTOGRAM_H
#define HEXID_HISTOGRAM_H

#include <stdint.h>

enum { HISTOGRAM_STEPS = 16, HISTOGRAM_BINS = 42 * HISTOGRAM_STEPS };

struct histogram {
    uint64_t count;
    int64_t max_ns;
    uint32_t bin[HISTOGRAM_BINS];
};

static inline void histogram_add(struct histogram *h, int64_t ns) {
    uint64_t value = ns > 0 ? (uint64_t)ns : 0;
    /* the shift with which value >> shift is 16..31; 0 for a value below 16 */
    int shift = value < HISTOGRAM_STEPS ? 0 : 59 - __builtin_clzll(value);
    uint64_t bin = (uint64_t)shift * HISTOGRAM_STEPS + (value >> shift);
    h->bin[bin < HISTOGRAM_BINS ? bin : HISTOGRAM_BINS - 1]++;
    h->count++;
    if (ns > h->max_ns) h->max_ns = ns;
}

/* Returns the upper edge of the bin that contains the quantile q (0..1), at most the maximum; 0 if
 * the histogram is empty. */
static inline int64_t histogram_quantile(const struct histogram *h, double q) {
    uint64_t seen = 0, wanted = (uint64_t)(q * (double)h->count);
    for (int bin = 0; bin < HISTOGRAM_BINS; bin++) {
        seen += h->bin[bin];
        if (seen <= wanted || !h->bin[bin]) continue;
        int shift = bin < 2 * HISTOGRAM_STEPS ? 0 : bin / HISTOGRAM_STEPS - 1;
        int64_t edge = ((int64_t)(bin - shift * HISTOGRAM_STEPS + 1) << shift) - 1;
        return edge < h->max_ns ? edge : h->max_ns;
    }
    return h->max_ns;
}

#endif
