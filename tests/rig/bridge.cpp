#include "bridge.h"
#include "rig.hpp"

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <stdexcept>

struct bridge {
    Rig rig;
};

/* Gives every parameter but the named one its configured value. */
static Base keep_only(const Base &drawn, const Base &configured, const std::string &name)
{
    Base b = configured;
    const struct {
        const char *name;
        double Base::*member;
    } common[] = {{"payload", &Base::payload}, {"upper", &Base::upper}, {"lower", &Base::lower}};
    const struct {
        const char *name;
        Vec6 Base::*member;
    } legs[] = {{"viscous", &Base::viscous},    {"bulk", &Base::bulk},
                {"leakage", &Base::leakage},    {"gain", &Base::gain},
                {"dead1", &Base::dead1},        {"dead2", &Base::dead2},
                {"null_bias", &Base::null_bias}};
    bool known = false;
    for (const auto &c : common)
        if (name == c.name) {
            b.*c.member = drawn.*c.member;
            known = true;
        }
    for (const auto &l : legs)
        if (name == l.name) {
            b.*l.member = drawn.*l.member;
            known = true;
        }
    if (!known)
        throw std::runtime_error("no such parameter of the base: '" + name + "'");
    return b;
}

static void tell(const Base &from, bridge_base *to)
{
    to->payload = from.payload;
    to->upper = from.upper;
    to->lower = from.lower;
    const std::pair<const Vec6 *, double *> legs[] = {
        {&from.viscous, to->viscous},    {&from.bulk, to->bulk},   {&from.leakage, to->leakage},
        {&from.gain, to->gain},          {&from.dead1, to->dead1}, {&from.dead2, to->dead2},
        {&from.null_bias, to->null_bias}};
    for (const auto &[values, out] : legs)
        for (int i = 0; i < kLegs; i++)
            out[i] = (*values)[i];
}

static bridge *create(const bridge_setup &given, bridge_base *base)
{
    Setup setup;
    setup.settings.load("config/tian2015.yaml");
    const Base configured = draw_base(setup);
    setup.tolerance_seed = given.tolerance_seed;
    setup.noise_seed = given.noise_seed;
    setup.step_s = given.step_s;
    for (const char *way : {"extend", "retract"})
        set_effect(setup.effects, std::string("cylinder_coulomb_friction.force_") + way +
                                      "_n=" + std::to_string(given.dry_n));
    Base drawn = draw_base(setup);
    if (given.only)
        drawn = keep_only(drawn, configured, given.only);
    tell(drawn, base);
    Vec6 parked = Vec6::Zero();
    parked[2] = setup.settings.at("motion.park_z_m");
    return new bridge{Rig(setup, drawn, parked)};
}

bridge *bridge_create(const bridge_setup *setup, bridge_base *base)
{
    try {
        return create(*setup, base);
    } catch (const std::exception &error) {
        std::fprintf(stderr, "rig: %s\n", error.what());
        return nullptr;
    }
}

void bridge_destroy(bridge *b)
{
    delete b;
}

void bridge_measure(bridge *b, double length_m[BRIDGE_LEGS], double p1_pa[BRIDGE_LEGS],
                    double p2_pa[BRIDGE_LEGS])
{
    Sample sample;
    b->rig.measure(sample);
    for (int i = 0; i < kLegs; i++) {
        length_m[i] = sample.length[i];
        p1_pa[i] = sample.p1[i];
        p2_pa[i] = sample.p2[i];
    }
}

void bridge_pose(const bridge *b, double pose[6])
{
    for (int i = 0; i < 6; i++)
        pose[i] = b->rig.machine().pose(i);
}

void bridge_step(bridge *b, const double valve[BRIDGE_LEGS])
{
    try {
        b->rig.step(Eigen::Map<const Vec6>(valve));
    } catch (const std::exception &error) {
        std::fprintf(stderr, "rig: %s\n", error.what());
        std::exit(1);
    }
}
