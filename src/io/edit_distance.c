#include "edit_distance.h"

#include <string.h>

int edit_distance(const char *a, const char *b) {
    int row[EDIT_DISTANCE_MAX];
    const int height = (int)strnlen(a, EDIT_DISTANCE_MAX - 1), width = (int)strnlen(b, EDIT_DISTANCE_MAX - 1);
    for (int j = 0; j <= width; j++) row[j] = j;
    for (int i = 1; i <= height; i++, a++) {
        int diagonal = row[0];
        row[0] = i;
        for (int j = 1; j <= width; j++) {
            int best = diagonal + (*a != b[j - 1]);
            if (row[j] + 1 < best) best = row[j] + 1;
            if (row[j - 1] + 1 < best) best = row[j - 1] + 1;
            diagonal = row[j];
            row[j] = best;
        }
    }
    return row[width];
}

int edit_distance_too_far(const char *word) { return (int)strlen(word) / 3 + 1; }

const char *edit_nearest(const char *word, const char *name(int i)) {
    const char *nearest = NULL, *at;
    int best = edit_distance_too_far(word);
    for (int i = 0; (at = name(i)); i++) {
        int distance = strlen(word) > 2 && !strncmp(word, at, strlen(word)) ? 0 : edit_distance(word, at);
        if (distance > best || (distance == best && nearest)) continue;
        best = distance;
        nearest = at;
    }
    return nearest;
}
