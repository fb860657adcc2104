/* Section `loop` of the configuration (params.h). */
#ifndef HEXID_PARAMS_LOOP_H
#define HEXID_PARAMS_LOOP_H

struct loop_params {
    double period_s;
    int priority;                 /* priority of the loop's thread under SCHED_FIFO */
    int cpu;                      /* processor for the loop's thread; -1: any */
    int overrun_limit;            /* number of missed deadlines in a row that is a fault */
};

#endif
