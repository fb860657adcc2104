#include "failure.h"

#include <assert.h>
#include <inttypes.h>
#include <math.h>

#include "interlock.h"

#define OFF "supply off, valves centred, latched"
#define STOPS REACTION_STOP, OFF
#define PARKS REACTION_PARK, "put down slowly, then supply off, latched"

const struct failure failure_table[] = {
    {FAULT_MASTER, "second_master", "another master commands this machine, or has tried to",
     "the device's own count of it (Modbus); a frame on CAN that only a master sends and that is not hexid's own", "its first attempt",
     REACTION_STOP, OFF "; on CAN both masters, where the other is a hexid",
     "a second hexid, or another program or tool that writes to the machine", "end the other one", NULL, NULL, NULL, 0.0},
    {FAULT_EMERGENCY_STOP, "emergency_stop", "somebody pressed an emergency stop, or its chain is broken", "the input", "1 cycle", STOPS,
     "an emergency stop that was pressed; a broken wire; the node of the inputs lost or restarted",
     "see that nobody is in danger, release it; look at the link", NULL, NULL, NULL, 0.0},
    {FAULT_ENABLE, "enable_switch", "the enable switch is let go while the platform is driven", "the input", "1 cycle", STOPS,
     "somebody let it go; a broken wire", "hold it again", NULL, NULL, NULL, 0.0},
    {FAULT_DOOR, "door", "a door is opened while the platform is driven", "the input", "1 cycle", STOPS,
     "somebody who enters; a broken wire", "see that nobody is inside, close it", NULL, NULL, NULL, 0.0},
    {FAULT_TWIN, "duplicate_node", "two devices answer as one, or one answers twice or in another form",
     "two different readings of one leg, or inputs, in one cycle; answers, heartbeats or readings that come twice and go on coming twice",
     "5 cycles; 0.1 s where both say the same", STOPS, "two devices with one node number or unit, or a device that repeats itself",
     "give each device a number of its own; `hexid doctor` and a look at the bus say which", NULL, NULL, NULL, 0.0},
    {FAULT_ANTIVALENCE, "input_contradiction", "the two contacts of an input contradict each other",
     "both set, or neither, for more than `interlocks.discrepancy_s`; until then the input is open", "that time", STOPS,
     "a broken wire or a welded contact; a module whose inputs are wired once",
     "mend wire or contact; where each input has one contact only, set interlocks.antivalent: false", NULL, NULL, NULL, 0.0},
    {FAULT_SUPPLY, "supply", "the supply loses its pressure while the platform is driven, or gets none",
     "the input; after `engage`: not within `interlocks.pressure_s`", "5 cycles", STOPS,
     "a pump that is off, a dump valve that is open, the relay that the supply output keeps closed", "look at the power unit", NULL, NULL,
     NULL, 0.0},
    {FAULT_SENSOR_AGE, "sensor_age", "samples lost, late or stale; the device hangs",
     "age above `limits.sensor_age_s`, by time stamp or by the device's own count", "5 + 5 cycles", STOPS,
     "a link that drops or delays readings, or a device that hangs", "check link and device", NULL, "limits.sensor_age_s", "ms", 1e3},
    {FAULT_SENSOR_INVALID, "sensor_invalid", "a length is not a number, a node is not in operation",
     "plausibility; the back-end's own diagnosis", "5 cycles", STOPS, "a sensor or its wiring; a node that was reset or reports an error",
     "mend the sensor", NULL, NULL, "mm", 1e3},
    {FAULT_STROKE, "stroke", "a length is out of range", "`limits.length_min_m`, `limits.length_max_m`", "5 cycles", STOPS,
     "a leg at the end of its stroke, or a length transducer that lies", "compare the reading with the leg itself", "limits.length_min_m",
     "limits.length_max_m", "mm", 1e3},
    {FAULT_LEG_RATE, "leg_rate", "a length jumps", "rate of change above `limits.leg_rate_mps`", "5 cycles", STOPS,
     "a length transducer or its wiring, lengths of two legs exchanged, or a loop that is unstable",
     "mend the sensor; see that `hexid doctor` finds the loop damped", NULL, "limits.leg_rate_mps", "m/s", 1.0},
    {FAULT_FOLLOWING, "following_error", "a leg does not follow: valve stuck, supply gone, lengths exchanged",
     "more than `limits.following_m` off", "10 mm, and 5 cycles", REACTION_STOP,
     "supply off, which alone stops a spool that is stuck; valves centred, latched",
     "a valve that sticks, no supply pressure, wiring, a loop that is unstable, or a limit too tight for it",
     "look at valve, supply and wiring; see that `hexid doctor` finds loop and feed-forward good; compare the limit with a good run", NULL,
     "limits.following_m", "mm", 1e3},
    {FAULT_FORCE, "force", "a leg's force is too large; P1 and P2 exchanged", "`limits.force_n`", "5 cycles above it", STOPS,
     "an obstacle, a loop that is unstable (control.kpf and kp of another machine), a pressure sensor that lies, or P1 and P2 exchanged",
     "look for an obstacle; see that `hexid doctor` finds the loop damped; mend the sensor", "limits.force_n", "limits.force_n", "kN",
     1e-3},
    {FAULT_OSCILLATION, "oscillation", "the platform shakes by what nobody asked for",
     "1.8 times the acceleration that is asked for, and `limits.oscillation_mps2`; of pose and valve commands", "0.3 s above it", STOPS,
     "a loop that is unstable: control.kp, ki, kd, kpf or modal too high for this machine, more delay than before, much air in the oil",
     "`hexid doctor` looks at the loop: set the gain that it names, or lower the gains; a coarse or noisy length transducer shakes the "
     "platform, too: mend it",
     NULL, "limits.oscillation_mps2", "m/s^2", 1.0},
    {FAULT_KINEMATICS, "kinematics", "lengths that fit no pose", "forward kinematics", "5 cycles", STOPS,
     "a length transducer that lies, or a geometry that is another machine's", "compare lengths and configuration with the machine", NULL,
     NULL, "mm", 1e3},
    {FAULT_OVERRUN, "overrun", "the loop is late, stopped or starved",
     "`loop.overrun_limit` deadlines missed in a row (real time only: the simulated platform's time stretches instead)",
     "its first cycle then", STOPS, "a busy or virtual host, or no real-time permission",
     "free the host, `hexid doctor` says what it lacks; on `sim:`, `--rt try` lets time stretch", NULL, "loop.overrun_limit", "missed",
     1.0},
    {FAULT_IO, "io", "the back-end cannot read or write", "the back-end", "5, 6 cycles", REACTION_STOP,
     OFF "; `safe` is called every cycle", "the link to the machine is down, or a node is lost",
     "mend the link; `hexid doctor` looks at it", NULL, NULL, NULL, 0.0},
    {FAULT_STANDSTILL, "standstill", "a length is frozen", "unchanged while its reference moves by `limits.standstill_m`",
     "2 mm of motion, and 5 cycles", STOPS, "a dead transducer or valve, or no supply pressure", "mend the sensor; check the supply", NULL,
     "limits.standstill_m", "mm", 1e3},
    {FAULT_PRESSURE_SENSOR, "pressure_sensor", "a chamber's pressure is not a number, or out of range",
     "`limits.pressure_min_pa`, `limits.pressure_max_pa`; the channel's own range", "5 cycles", PARKS, "a pressure sensor or its wiring",
     "mend the sensor", "limits.pressure_min_pa", "limits.pressure_max_pa", "MPa", 1e-6},
    {0, "samples excluded; above 1 % the verdict fails", "single samples lost, repeated, out of order", "flags, device count", "1 cycle",
     REACTION_NONE, "goes on; command held for what is not believed", "a link under load", "none", NULL, NULL, NULL, 0.0},
    {0, "no messages", "the daemon is killed", "the device's watchdog, and the relay of the supply output", "the device's time",
     REACTION_NONE, "the device centres its valves, the supply goes off", "somebody, or a lack of memory", "start hexid", NULL, NULL, NULL,
     0.0},
    {0, "parking", "the operator's program is gone, or hangs", "the end of its connection; `lcm.lease_s`", "at once; that time",
     REACTION_PARK, "put down slowly", "a program that ended or was stopped", "engage again", NULL, NULL, NULL, 0.0},
    {0, "parking, with the reason", "nothing takes stops: the thread that does is held up",
     "the loop, which that thread tells that it lives", "1 s of cycles, at a stretch or in pieces", REACTION_PARK,
     "put down slowly; the run ends with status 3", "a user of this host who holds it up on purpose, or a program that starves it",
     "see who and what runs on this host", NULL, NULL, NULL, 0.0},
    {0, "file and reason", "the log cannot be written", "the recorder", "the write", REACTION_PARK, "put down slowly, ends with status 3",
     "a full or missing disk, or a log that was deleted, renamed or cut",
     "make room, or name another file; leave a log alone while it is written", NULL, NULL, NULL, 0.0},
    {0, "verdict fail, with the leg", "a pressure is wrong but plausible, or drifts slowly", "witnesses (below)", "the end of the test",
     REACTION_NONE,
     "goes on: the law pid does not lean on pressures; the law model does in its feed-forward, and feedback carries the error",
     "a sensor that drifts", "mend the sensor, test again", NULL, NULL, NULL, 0.0},
    {0},
};

uint32_t failures_with(enum reaction reaction, uint32_t faults) {
    uint32_t with = 0;
    for (const struct failure *f = failure_table; faults && f->name; f++)
        if (f->reaction == reaction) with |= faults & f->fault;
    return with;
}

const struct failure *failure_of(uint32_t faults) {
    for (const struct failure *f = failure_table; f->name; f++)
        if (faults & f->fault) return f;
    return NULL;
}

const char *fault_name(uint32_t faults) {
    const struct failure *f = failure_of(faults);
    return f ? f->name : "none";
}

void fault_describe(uint32_t first_fault, uint32_t faults, char text[FAULT_TEXT_SIZE]) {
    uint32_t legs = faults & FAULT_LEGS;
    bool several = (legs & (legs - 1)) != 0;
    int used = snprintf(text, FAULT_TEXT_SIZE, "%s", fault_name(first_fault));
    const char *before = several ? ", legs" : ", leg";
    for (int i = 0; i < LEGS; i++) {
        if (!(faults & fault_leg(i))) continue;
        used += snprintf(text + used, (size_t)(FAULT_TEXT_SIZE - used), "%s %d", before, i + 1);
        before = "";
    }
}

/* Formats a number for people: "12.4", "1420". */
static void say_number(double x, char text[16]) { snprintf(text, 16, fabs(x) >= 1000.0 ? "%.5g" : "%.3g", x); }

const char *fault_measured(uint32_t first_fault, const struct fault_measure *measure, char text[FAULT_MEASURE_SIZE]) {
    const struct failure *f = failure_of(first_fault);
    char value[16], limit[16];
    *text = '\0';
    if (measure->inputs) {
        interlock_names(measure->inputs, text, FAULT_MEASURE_SIZE);
        return text;
    }
    if (!f || !f->unit || (isnan(measure->value) && measure->leg < 0)) return text;
    if (!isfinite(measure->value)) {
        snprintf(text, FAULT_MEASURE_SIZE, isnan(measure->value) ? "not a number" : "infinite");
        return text;
    }
    const char *key = measure->value < measure->limit ? f->least_key : f->most_key;
    say_number(measure->value * f->per_si, value);
    say_number(measure->limit * f->per_si, limit);
    int used = snprintf(text, FAULT_MEASURE_SIZE, "%s %s", value, f->unit);
    char explained[16], configured[16];
    say_number(measure->explained * f->per_si, explained);
    say_number((measure->limit - measure->explained) * f->per_si, configured);
    if (key && isfinite(measure->limit) && measure->explained > 0.0)
        snprintf(text + used, (size_t)(FAULT_MEASURE_SIZE - used), ", limit %s %s (%s %s, and %s for what is asked)", limit, f->unit, key,
                 configured, explained);
    else if (key && isfinite(measure->limit))
        snprintf(text + used, (size_t)(FAULT_MEASURE_SIZE - used), ", limit %s %s (%s)", limit, f->unit, key);
    return text;
}

void fault_line(uint32_t first_fault, uint32_t faults, const struct fault_measure *measure, char text[FAULT_LINE_SIZE]) {
    char name[FAULT_TEXT_SIZE], measured[FAULT_MEASURE_SIZE];
    fault_describe(first_fault, faults, name);
    fault_measured(first_fault, measure, measured);
    snprintf(text, FAULT_LINE_SIZE, "%s%s%s", name, *measured ? ": " : "", measured);
}

void failure_explain(uint32_t first_fault, int64_t missed, double longest_s, bool automatic, char cause[FAILURE_TEXT_SIZE],
                     char remedy[FAILURE_TEXT_SIZE]) {
    const struct failure *f = failure_of(first_fault);
    assert(f);
    if (f->fault == FAULT_OVERRUN)
        snprintf(cause, FAILURE_TEXT_SIZE, "%" PRId64 " deadline%s missed in a row, the longest by %.0f ms; most likely %s", missed,
                 missed == 1 ? "" : "s", longest_s * 1e3, f->cause);
    else snprintf(cause, FAILURE_TEXT_SIZE, "%s; most likely %s", f->what, f->cause);
    snprintf(remedy, FAILURE_TEXT_SIZE, "%s; then %s", f->remedy,
             automatic ? "start the run again" : "`hexid command reset`, `hexid command engage`");
}

void failure_print(FILE *out) {
    fprintf(out, "| failure | detected by | within | the platform | the operator sees | likely cause | to do |\n"
                 "| --- | --- | --- | --- | --- | --- | --- |\n");
    for (const struct failure *f = failure_table; f->name; f++) {
        const char *quote = f->fault ? "`" : "", *again = f->fault ? ", then `reset`, `engage`" : "";
        fprintf(out, "| %s | %s | %s | %s | %s%s%s | %s | %s%s |\n", f->what, f->detected, f->within, f->platform, quote, f->name, quote,
                f->cause, f->remedy, again);
    }
}
