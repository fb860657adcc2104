#include "cycle_columns.h"

#define REAL(name, unit, member) {name, unit, COLUMN_REAL, offsetof(struct cycle, member)}
#define TIME_NS(name, member) {name, "ns", COLUMN_INT64, offsetof(struct cycle, member)}
#define COUNT(name, member) {name, "", COLUMN_INT64, offsetof(struct cycle, member)}
#define BITS(name, member) {name, "", COLUMN_UINT32, offsetof(struct cycle, member)}
#define CODE(name, member) {name, "", COLUMN_CODE, offsetof(struct cycle, member)}
#define LEGS_OF(before, after, unit, member)                                                                     \
    REAL(before "1" after, unit, member[0]), REAL(before "2" after, unit, member[1]), REAL(before "3" after, unit, member[2]), \
    REAL(before "4" after, unit, member[3]), REAL(before "5" after, unit, member[4]), REAL(before "6" after, unit, member[5])
#define POSE(before, member)                                                                                                   \
    REAL(before "_x_m", "m", member[DOF_X]), REAL(before "_y_m", "m", member[DOF_Y]), REAL(before "_z_m", "m", member[DOF_Z]),   \
    REAL(before "_phi_rad", "rad", member[DOF_PHI]), REAL(before "_theta_rad", "rad", member[DOF_THETA]),                       \
    REAL(before "_psi_rad", "rad", member[DOF_PSI])

const struct cycle_column cycle_columns[CYCLE_COLUMNS] = {
    COUNT("seq", seq),
    TIME_NS("time_ns", in.time_ns),
    CODE("state", state),
    CODE("test", test),
    CODE("dof", dof),
    CODE("phase", phase),
    REAL("test_time_s", "s", test_time_s),
    BITS("flags", in.flags),
    BITS("faults", faults),
    BITS("first_fault", first_fault),
    {"enable", "", COLUMN_BOOL, offsetof(struct cycle, out.enable)},
    POSE("ref", ref),
    POSE("pose", pose),
    LEGS_OF("l", "_m", "m", in.length_m),
    LEGS_OF("p1_", "_pa", "Pa", in.p1_pa),
    LEGS_OF("p2_", "_pa", "Pa", in.p2_pa),
    LEGS_OF("force_", "_n", "N", force_n),
    LEGS_OF("u", "", "", out.valve),
    COUNT("device_seq", in.device_seq),
    TIME_NS("age_ns", in.age_ns),
    TIME_NS("wake_late_ns", wake_late_ns),
    TIME_NS("exec_ns", exec_ns),
};

static const void *place(const struct cycle *c, int column) { return (const char *)c + cycle_columns[column].offset; }

double column_real(const struct cycle *c, int column) { return *(const double *)place(c, column); }

int64_t column_integer(const struct cycle *c, int column) {
    switch (cycle_columns[column].kind) {
    case COLUMN_UINT32: return *(const uint32_t *)place(c, column);
    case COLUMN_CODE: return *(const int *)place(c, column);
    case COLUMN_BOOL: return *(const bool *)place(c, column);
    default: return *(const int64_t *)place(c, column);
    }
}
