/* Runs a fuzz harness over files without libFuzzer, so that the stored corpora are ordinary
 * tests. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { INPUT_MAX = 1 << 20 };

int main(int argc, char **argv) {
    static uint8_t buffer[INPUT_MAX];
    for (int i = 1; i < argc; i++) {
        FILE *file = fopen(argv[i], "rb");
        if (!file) {
            perror(argv[i]);
            return 1;
        }
        size_t size = fread(buffer, 1, sizeof buffer, file);
        fclose(file);
        /* exact size, so that AddressSanitizer sees an overrun */
        uint8_t *input = malloc(size + 1);
        if (!input) return 1;
        for (size_t n = 0; n < size; n++) input[n] = buffer[n];
        LLVMFuzzerTestOneInput(input, size);
        free(input);
    }
    printf("%d inputs\n", argc - 1);
    return 0;
}
