// The public names of the slots of structure.hpp, in their order.
#pragma once

#include <array>
#include <string_view>

#include "stickslip/interface.hpp"

namespace stickslip_abi {

// Parameters of the rig and the laws by their own name, those of effects as effect.parameter; then the values of a
// tabulated term at its knots.
inline constexpr std::array<std::string_view, slot_count> slot_names{"alpha1",
                                                                     "alpha2",
                                                                     "beta3",
                                                                     "eta1",
                                                                     "eta12",
                                                                     "coupling",
                                                                     "stiffness",
                                                                     "belt_speed",
                                                                     "T_s_minus",
                                                                     "A1",
                                                                     "A2",
                                                                     "t1",
                                                                     "t2",
                                                                     "v_w_min",
                                                                     "T_min_minus",
                                                                     "T_s_plus",
                                                                     "T_min_plus",
                                                                     "v_w_max",
                                                                     "static_minus",
                                                                     "kinetic_minus",
                                                                     "static_plus",
                                                                     "kinetic_plus",
                                                                     "scale_minus",
                                                                     "decay_minus",
                                                                     "constant_minus",
                                                                     "quadratic_minus",
                                                                     "scale_plus",
                                                                     "decay_plus",
                                                                     "constant_plus",
                                                                     "quadratic_plus",
                                                                     "block_viscous_damping.c",
                                                                     "block_quadratic_damping.c",
                                                                     "spring_cubic_k1.k",
                                                                     "spring_cubic_k2.k",
                                                                     "spring_cubic_k3.k",
                                                                     "spring_gap_k3.k",
                                                                     "spring_gap_k3.d",
                                                                     "constant_load.f",
                                                                     "harmonic_forcing.a",
                                                                     "harmonic_forcing.w",
                                                                     "harmonic_forcing.phi",
                                                                     "pivot_dry_friction.f",
                                                                     "pivot_dry_friction.v_c",
                                                                     "normal_force_feedback.beta2",
                                                                     "normal_force_feedback.eta2",
                                                                     "stribeck_peak.dT",
                                                                     "stribeck_peak.v_s",
                                                                     "static_aging.dT",
                                                                     "static_aging.tau",
                                                                     "friction_memory.tau",
                                                                     "friction_drift.r",
                                                                     "belt_seam.a",
                                                                     "belt_seam.L",
                                                                     "belt_seam.phi",
                                                                     "contact_compliance.k",
                                                                     "contact_compliance.c",
                                                                     "belt_speed_ripple.a",
                                                                     "belt_speed_ripple.w",
                                                                     "belt_speed_ripple.phi",
                                                                     "belt_load_droop.k",
                                                                     "belt_load_droop.tau",
                                                                     "sensor_lag.tau",
                                                                     "sensor_crosstalk.c",
                                                                     "tabulated.w",
                                                                     "tabulated.phi"};

inline constexpr std::array<std::string_view, state_count> state_names{"x1", "x2", "y1", "y2",   "w",
                                                                       "z",  "b",  "m",  "dwell"};

// Bit k of Structure::effects is entry k.
inline constexpr std::array<std::string_view, 20> effect_names{
    "block_viscous_damping", "block_quadratic_damping", "spring_cubic_k1", "spring_cubic_k2",
    "spring_cubic_k3",       "spring_gap_k3",           "constant_load",   "harmonic_forcing",
    "pivot_dry_friction",    "normal_force_feedback",   "stribeck_peak",   "static_aging",
    "friction_memory",       "friction_drift",          "belt_seam",       "contact_compliance",
    "belt_speed_ripple",     "belt_load_droop",         "sensor_lag",      "tabulated"};

}  // namespace stickslip_abi
