// Many trajectories: `_core.sweep`.
#include <cstddef>
#include <utility>
#include <vector>

#include "results.hpp"
#include "stickslip/slots.hpp"
#include "stickslip/sweep.hpp"

namespace stickslip::bindings {

namespace {

using namespace stickslip_abi;

py::tuple sweep_members(const Structure& structure, const ConstVector& base, const IndexVector& varied,
                        const ConstMatrix& values, double t_end, double after, double rtol, double atol,
                        std::uint32_t observe, int points, bool lanes, long max_transitions, long max_steps) {
  if (base.size() != parameter_count + state_count) throw py::value_error("base must hold all parameters and states");
  if (values.cols() != varied.size()) throw py::value_error("values must have one column for each varied slot");
  if (points < 0 || points > max_sweep_points) throw py::value_error("points must be within 0 and 64");
  for (Eigen::Index i = 0; i < varied.size(); ++i)
    if (varied[i] < 0 || varied[i] >= parameter_count + state_count) throw py::value_error("a varied slot is unknown");
  SweepRequest request{};
  request.structure = &structure;
  request.base = base.data();
  request.varied = varied.data();
  request.n_varied = static_cast<int>(varied.size());
  request.values = values.data();
  request.t_end = t_end;
  request.after = after;
  request.rtol = rtol;
  request.atol = atol;
  request.observe = observe;
  request.points = points;
  request.lanes = lanes;
  request.max_transitions = max_transitions;
  request.max_steps = max_steps;
  const auto n = static_cast<py::ssize_t>(values.rows());
  SweepResult result = released([&] { return sweep(request, static_cast<long>(n), interrupted); });
  if (result.interrupted) throw py::error_already_set();
  return py::make_tuple(as_array(std::move(result.rows), {n, sweep_row_size}),
                        as_array(std::move(result.points), {n, points, 5}));
}

}  // namespace

void bind_sweep(py::module_& m) {
  py::list row;
  for (const auto& name : state_names) row.append(py::str(name.data(), name.size()));
  for (const char* name : {"t", "stick_time", "transitions", "releases", "slips", "first_release", "last_release",
                           "interval_squares", "x1_min", "x2_min", "y1_min", "y2_min", "x1_max", "x2_max", "y1_max",
                           "y2_max", "dissipated", "steps", "outcome"})
    row.append(name);
  m.attr("SWEEP_ROW") = py::tuple(row);
  m.attr("MAX_SWEEP_POINTS") = max_sweep_points;
  m.def("sweep", &sweep_members, py::kw_only(), py::arg("structure"), py::arg("base").noconvert(),
        py::arg("varied").noconvert(), py::arg("values").noconvert(), py::arg("t_end"), py::arg("after"),
        py::arg("rtol"), py::arg("atol"), py::arg("observe"), py::arg("points"), py::arg("lanes"),
        py::arg("max_transitions"), py::arg("max_steps") = most_steps);
}

}  // namespace stickslip::bindings
