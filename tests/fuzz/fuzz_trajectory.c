/* libFuzzer: any bytes as a trajectory file. An accepted one yields finite numbers at every
 * instant. */
#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "trajectory_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static char path[60];

static void tidy(void) { unlink(path); }

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    struct trajectory t;
    struct error error = {0};
    if (!*path) {
        const char *fastest = access("/dev/shm", W_OK) ? "/tmp" : "/dev/shm";
        snprintf(path, sizeof path, "%s/fuzz_trajectory_%d.csv", fastest, (int)getpid());
        atexit(tidy);
    }
    FILE *file = fopen(path, "w");
    if (!file || fwrite(data, 1, size, file) != size || fclose(file)) abort();
    int status = trajectory_load(&t, path, 1 + (int)(size % 3), &error);
    /* a file's content is never an I/O error */
    assert(status == STATUS_OK || (status == STATUS_USAGE && error.text[0]));
    for (int i = -1; !status && i <= 101; i++) {
        double pose[DOFS];
        trajectory_at(&t, 0.01 * i * trajectory_s(&t), pose);
        for (int axis = 0; axis < DOFS; axis++) assert(!isnan(pose[axis]));
    }
    trajectory_free(&t);
    return 0;
}
