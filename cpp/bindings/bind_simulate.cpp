// One trajectory: `_core.simulate` and its record.
#include <optional>
#include <utility>
#include <vector>

#include "results.hpp"
#include "stickslip/record.hpp"

namespace stickslip::bindings {

namespace {

using namespace stickslip_abi;

py::dict record_as_dict(Record&& r) {
  const auto n = static_cast<py::ssize_t>(r.t.size()), k = static_cast<py::ssize_t>(r.event_t.size());
  const auto p = static_cast<py::ssize_t>(r.seeds), kinks = static_cast<py::ssize_t>(r.kink_t.size());
  constexpr py::ssize_t d = state_count;
  py::dict out;
  out["t"] = as_array(std::move(r.t), {n});
  out["state"] = as_array(std::move(r.state), {n, d});
  out["mode"] = as_array(std::move(r.mode), {n});
  out["sensitivity"] = as_array(std::move(r.sensitivity), {n, d, p});
  out["transition_t"] = as_array(std::move(r.event_t), {k});
  out["transition_state"] = as_array(std::move(r.event_state), {k, d});
  out["transition_before"] = as_array(std::move(r.event_before), {k});
  out["transition_after"] = as_array(std::move(r.event_after), {k});
  out["transition_sensitivity"] = as_array(std::move(r.event_sensitivity), {k, d + 1, p});
  out["kink_t"] = as_array(std::move(r.kink_t), {kinks});
  out["outcome"] = r.summary.outcome;
  out["t_reached"] = r.summary.t;
  out["steps"] = r.summary.steps;
  return out;
}

py::dict simulate(const Structure& structure, const ConstVector& parameters, const ConstVector& initial, double t_start,
                  double t_end, int contact, const std::optional<ConstVector>& t_eval, double rtol, double atol,
                  Locator locator, const ConstMatrix& seeds, long max_transitions, int order, double fixed_step,
                  long max_steps) {
  if (parameters.size() != parameter_count || initial.size() != state_count)
    throw py::value_error(
        "parameters must have the length of PARAMETERS plus TABLES times MAX_KNOTS, initial that of STATES");
  if (seeds.rows() > 0 && seeds.cols() != parameter_count + state_count)
    throw py::value_error("seeds must have a column for every parameter, knot and state");
  const Request request{&structure,
                        parameters.data(),
                        initial.data(),
                        t_start,
                        t_end,
                        contact,
                        t_eval ? t_eval->data() : nullptr,
                        t_eval ? static_cast<long>(t_eval->size()) : 0,
                        rtol,
                        atol,
                        locator,
                        static_cast<int>(seeds.rows()),
                        seeds.data(),
                        max_transitions,
                        max_steps,
                        order,
                        fixed_step};
  Record r = released([&] { return record(request, interrupted); });
  if (r.summary.outcome == Outcome::interrupted) throw py::error_already_set();
  return record_as_dict(std::move(r));
}

}  // namespace

void bind_simulate(py::module_& m) {
  py::native_enum<Locator>(m, "Locator", "enum.IntEnum")
      .value("henon", Locator::henon)
      .value("bracket", Locator::bracket)
      .finalize();
  py::native_enum<Outcome>(m, "Outcome", "enum.IntEnum")
      .value("finished", Outcome::finished)
      .value("chatter", Outcome::chatter)
      .value("not_finite", Outcome::not_finite)
      .value("step_too_small", Outcome::step_too_small)
      .value("too_many_transitions", Outcome::too_many_transitions)
      .value("interrupted", Outcome::interrupted)
      .value("too_many_steps", Outcome::too_many_steps)
      .finalize();
  m.def("simulate", &simulate, py::kw_only(), py::arg("structure"), py::arg("parameters").noconvert(),
        py::arg("initial").noconvert(), py::arg("t_start"), py::arg("t_end"), py::arg("contact"),
        py::arg("t_eval").noconvert(), py::arg("rtol"), py::arg("atol"), py::arg("locator"),
        py::arg("seeds").noconvert(), py::arg("max_transitions"), py::arg("order") = 0, py::arg("fixed_step") = 0.0,
        py::arg("max_steps") = most_steps);
}

}  // namespace stickslip::bindings
