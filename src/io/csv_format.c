#include "csv_format.h"

#include <stdlib.h>
#include <string.h>

#define REAL(name, member) {name, CSV_REAL, offsetof(struct cycle, member)}
#define SIX(before, after, member)                                                                                                \
    REAL(before "1" after, member[0]), REAL(before "2" after, member[1]), REAL(before "3" after, member[2]), \
    REAL(before "4" after, member[3]), REAL(before "5" after, member[4]), REAL(before "6" after, member[5])

const struct csv_column csv_columns[CSV_COLUMNS] = {
    REAL("t_s", test_time_s),
    REAL("ref_x_m", ref[DOF_X]),
    REAL("ref_y_m", ref[DOF_Y]),
    REAL("ref_z_m", ref[DOF_Z]),
    REAL("ref_phi_rad", ref[DOF_PHI]),
    REAL("ref_theta_rad", ref[DOF_THETA]),
    REAL("ref_psi_rad", ref[DOF_PSI]),
    SIX("l", "_m", in.length_m),
    SIX("p1_", "_pa", in.p1_pa),
    SIX("p2_", "_pa", in.p2_pa),
    SIX("u", "", out.valve),
    {"flags", CSV_FLAGS, offsetof(struct cycle, in.flags)},
    {"phase", CSV_PHASE, offsetof(struct cycle, phase)},
};

const char *const csv_keys[CSV_KEYS] = {"frequency_hz", "amplitude", "rate_hz", "settle_s", "ramp_s", "duration_s", "ramp_out_s"};

const char *csv_dof_name(enum dof dof) { return dof == DOF_NONE ? "none" : dof_names[dof]; }

bool csv_dof_find(const char *name, enum dof *dof) {
    *dof = DOF_NONE;
    for (int i = 0; i < DOFS; i++)
        if (strcmp(name, dof_names[i]) == 0) *dof = (enum dof)i;
    return *dof != DOF_NONE || strcmp(name, "none") == 0;
}

double *csv_place(struct params *params, enum csv_key key, enum dof dof) {
    struct test_params *t = &params->tests;
    switch (key) {
    case CSV_FREQUENCY: return &t->frequency_hz;
    case CSV_AMPLITUDE: return dof < DOF_PHI ? &t->amplitude_m : &t->amplitude_rad;
    case CSV_SETTLE: return &t->settle_s;
    case CSV_RAMP: return &t->ramp_s;
    case CSV_DURATION: return &t->duration_s;
    case CSV_RAMP_OUT: return &t->ramp_out_s;
    default: return NULL;
    }
}

static int is_csv(const struct dirent *entry) {
    size_t length = strlen(entry->d_name);
    return length > 4 && strcmp(entry->d_name + length - 4, ".csv") == 0;
}

int csv_list(const char *directory, struct dirent ***files) {
    *files = NULL;
    return scandir(directory, files, is_csv, versionsort);
}

void csv_list_free(struct dirent **files, int count) {
    for (int i = 0; i < count; i++) free(files[i]);
    free(files);
}
