// Many windows at once: `_core.simulate_windows`.
#include <algorithm>
#include <cstdint>
#include <vector>

#include "results.hpp"
#include "stickslip/windows.hpp"

namespace stickslip::bindings {

namespace {

using namespace stickslip_abi;
using Offsets = Eigen::Ref<const Eigen::Matrix<std::int64_t, Eigen::Dynamic, 1>>;  // (n,) int64

static_assert(sizeof(long) == sizeof(std::int64_t) && sizeof(int) == sizeof(std::int32_t) && sizeof(Outcome) == 4);

bool all_within(const IndexVector& values, Eigen::Index below) {
  return (values.array() >= 0).all() && (values.array() < static_cast<std::int32_t>(below)).all();
}

void check_shapes(const ConstMatrix& parameters, const IndexVector& set, const ConstMatrix& initial,
                  const IndexVector& contact, const ConstVector& t, const Offsets& offset, const ConstMatrix& seeds,
                  const IndexVector& column, int columns, const IndexVector& kept) {
  const Eigen::Index windows = set.size();
  if (parameters.cols() != parameter_count || initial.cols() != state_count || initial.rows() != windows ||
      contact.size() != windows || offset.size() != windows + 1 || !all_within(set, parameters.rows()))
    throw py::value_error("parameters, set, initial, contact and offset must belong to the same windows");
  if (offset[0] != 0 || offset[windows] != t.size() ||
      (offset.tail(windows).array() <= offset.head(windows).array()).any())
    throw py::value_error("offset must rise from 0 to the number of times");
  if ((seeds.rows() > 0 && seeds.cols() != parameter_count + state_count) || column.size() != seeds.rows() ||
      !all_within(column, columns) || !all_within(kept, state_count))
    throw py::value_error("seeds, column, columns and kept must belong together");
}

py::dict simulate_windows(const std::vector<const Structure*>& structures, const ConstMatrix& parameters,
                          const IndexVector& set, const ConstMatrix& initial, const IndexVector& contact,
                          const ConstVector& t, const Offsets& offset, double rtol, double atol,
                          const ConstMatrix& seeds, const IndexVector& column, int columns, const IndexVector& kept,
                          long max_transitions, long max_steps, int order, int threads) {
  check_shapes(parameters, set, initial, contact, t, offset, seeds, column, columns, kept);
  const auto alike = [&](const Structure* one) {
    return one && one->rig == structures[0]->rig && one->law == structures[0]->law &&
           one->effects == structures[0]->effects;
  };
  if (static_cast<Eigen::Index>(structures.size()) != parameters.rows() ||
      !std::all_of(structures.begin(), structures.end(), alike))
    throw py::value_error("structures must be one for each row of parameters, of one rig, law and effects");
  const py::ssize_t n = t.size(), windows = set.size();
  py::array_t<double> state({n, static_cast<py::ssize_t>(state_count)});
  py::array_t<double> slopes({static_cast<py::ssize_t>(kept.size()), n, static_cast<py::ssize_t>(columns)});
  py::array_t<signed char> mode(n);
  py::array_t<std::int32_t> outcome(windows);
  const WindowsRequest request{structures.data(),
                               parameters.data(),
                               set.data(),
                               initial.data(),
                               contact.data(),
                               t.data(),
                               reinterpret_cast<const long*>(offset.data()),
                               windows,
                               rtol,
                               atol,
                               static_cast<int>(seeds.rows()),
                               seeds.data(),
                               column.data(),
                               columns,
                               kept.data(),
                               static_cast<int>(kept.size()),
                               max_transitions,
                               max_steps,
                               order};
  const WindowsResult result{state.mutable_data(), slopes.mutable_data(), mode.mutable_data(),
                             reinterpret_cast<Outcome*>(outcome.mutable_data())};
  const bool done = released([&] { return stickslip::simulate_windows(request, result, threads, interrupted); });
  if (!done) throw py::error_already_set();
  py::dict out;
  out["state"] = state;
  out["slopes"] = slopes;
  out["mode"] = mode;
  out["outcome"] = outcome;
  return out;
}

}  // namespace

void bind_windows(py::module_& m) {
  m.def("simulate_windows", &simulate_windows, py::kw_only(), py::arg("structures"), py::arg("parameters").noconvert(),
        py::arg("set").noconvert(), py::arg("initial").noconvert(), py::arg("contact").noconvert(),
        py::arg("t").noconvert(), py::arg("offset").noconvert(), py::arg("rtol"), py::arg("atol"),
        py::arg("seeds").noconvert(), py::arg("column").noconvert(), py::arg("columns"), py::arg("kept").noconvert(),
        py::arg("max_transitions"), py::arg("max_steps"), py::arg("order") = 0, py::arg("threads") = 1,
        "Windows, each from its own start through its own times: state (n, states), slopes (kept, n, columns), mode "
        "(n,)\n"
        "and the outcome (windows,) as numbers of Outcome.");
}

}  // namespace stickslip::bindings
