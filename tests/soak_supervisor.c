/* Runs the fuzzer of tests/test_supervisor.c for longer: soak_supervisor [CYCLES [SEED]], by
 * default 100 million cycles from seed 1 on; then a fiftieth of that on the simulated platform.
 * Progress goes to standard error; status 1 means that the model was broken and the shortest
 * history was printed. */
#include "supervisor_fuzz.h"

static void tell(uint64_t seed, int64_t cycles) {
    if (cycles % 1000000 == 0) fprintf(stderr, "\rseed %llu, %lld million cycles", (unsigned long long)seed, (long long)(cycles / 1000000));
}

int main(int count, char **words) {
    static struct run run;
    int64_t cycles = count > 1 ? atoll(words[1]) : 100000000;
    uint64_t seed = count > 2 ? strtoull(words[2], NULL, 10) : 1;
    bool good = fuzz(seed, cycles, false, &run, tell) && fuzz(seed, cycles / 50, true, &run, tell);
    fprintf(stderr, "\n");
    if (good) printf("%lld cycles from seed %llu on: no rule of the model was broken\n", (long long)cycles, (unsigned long long)seed);
    return good ? 0 : 1;
}
