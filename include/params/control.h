/* Section `control` of the configuration (params.h). */
#ifndef HEXID_PARAMS_CONTROL_H
#define HEXID_PARAMS_CONTROL_H

enum control_law { CONTROL_PID, CONTROL_MODEL };

struct control_params {           /* gains of the controller; src/core/pid.h has the exact law */
    enum control_law law;
    double delay_s;               /* time from the latching of a sample to the instant at which its
                                   * command reaches the valve; for the law `model` */
    double kp, ki, kd;            /* gains of the proportional, the integral and the derivative
                                   * part: 1/m, 1/(m s), s/m */
    double modal;                 /* exponent, 0 to 1, by which kp, ki and kd grow with a mode's
                                   * frequency (src/core/modal.h) */
    double kff;                   /* feed-forward gain of the leg's reference rate, s/m */
    double kpf;                   /* feedback gain of the high-passed leg force, 1/N */
    double tf, tp;                /* time constants of the filters of derivative and force, s */
    double integral_limit;        /* largest integral part, as a share of full opening */
    double output_limit;          /* largest output, as a share of full opening */
};

#endif
