// What `_core.simulate_bodies` returns.
#pragma once

#include <utility>

#include "results.hpp"
#include "stickslip/bodies/record.hpp"

namespace stickslip::bindings {

inline py::dict as_dict(BodiesRecord&& r) {
  const auto n = static_cast<py::ssize_t>(r.t.size()), k = static_cast<py::ssize_t>(r.event_t.size());
  const auto p = static_cast<py::ssize_t>(r.seeds), kinks = static_cast<py::ssize_t>(r.kink_t.size());
  const auto d = static_cast<py::ssize_t>(r.states), m = static_cast<py::ssize_t>(r.contacts);
  const auto s = static_cast<py::ssize_t>(r.senses);
  py::dict out;
  out["t"] = as_array(std::move(r.t), {n});
  out["state"] = as_array(std::move(r.state), {n, d});
  out["mode"] = as_array(std::move(r.mode), {n, m});
  out["sensitivity"] = as_array(std::move(r.sensitivity), {n, d, p});
  out["sensed"] = as_array(std::move(r.sensed), {n, s});
  out["sensed_sensitivity"] = as_array(std::move(r.sensed_sensitivity), {n, s, s > 0 ? p : 0});
  out["transition_t"] = as_array(std::move(r.event_t), {k});
  out["transition_state"] = as_array(std::move(r.event_state), {k, d});
  out["transition_before"] = as_array(std::move(r.event_before), {k, m});
  out["transition_after"] = as_array(std::move(r.event_after), {k, m});
  out["transition_sensitivity"] = as_array(std::move(r.event_sensitivity), {k, d + 1, p});
  out["kink_t"] = as_array(std::move(r.kink_t), {kinks});
  const auto twice = static_cast<py::ssize_t>(r.low.size()), worked = static_cast<py::ssize_t>(r.work.size());
  out["state_min"] = as_array(std::move(r.low), {twice});
  out["state_max"] = as_array(std::move(r.high), {twice});
  out["work"] = as_array(std::move(r.work), {worked});
  out["outcome"] = r.summary.outcome;
  out["t_reached"] = r.summary.t;
  out["steps"] = r.summary.steps;
  return out;
}

}  // namespace stickslip::bindings
