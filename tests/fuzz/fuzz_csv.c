/* libFuzzer: any bytes as an imported CSV file. */
#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "csv.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static char directory[40], path[60];

static void tidy(void) {
    unlink(path);
    rmdir(directory);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    struct csv_report report;
    struct error error = {0};
    if (!*directory) {
        const char *fastest = access("/dev/shm", W_OK) ? "/tmp" : "/dev/shm";
        snprintf(directory, sizeof directory, "%s/fuzz_csv_%d", fastest, (int)getpid());
        snprintf(path, sizeof path, "%s/1_z.csv", directory);
        if (mkdir(directory, 0700)) abort();
        atexit(tidy);
    }
    FILE *file = fopen(path, "w");
    if (!file || fwrite(data, 1, size, file) != size || fclose(file)) abort();
    int status = csv_import(&(struct csv_source){.path = directory}, "/dev/null", &report, &error);
    /* a file's content is never an I/O error */
    assert(status == STATUS_OK || (status == STATUS_USAGE && error.text[0]));
    if (!status) assert(report.files == 1 && report.rows > 0);
    return 0;
}
