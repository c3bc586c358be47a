#include <stdexcept>

#include "pybind.hpp"
#include "stickslip/filter.hpp"

namespace stickslip::bindings {

namespace {

// y must be a fresh array of x's shape: the face allocates it.
bool first_order_into(const ConstMatrix& x, Eigen::Ref<RowMatrix> y, double a, double k0, double k1) {
  const Recursion constants{a, k0, k1};
  if (!is_stable(constants)) throw std::invalid_argument("first_order: needs |a| < 1 and finite k0, k1");
  if (x.rows() != y.rows() || x.cols() != y.cols()) throw std::invalid_argument("first_order: shapes differ");
  if (x.outerStride() != x.cols() || y.outerStride() != y.cols()) {
    throw std::invalid_argument("first_order: arrays must be C-contiguous");
  }
  return first_order(x.data(), y.data(), static_cast<std::size_t>(x.rows()), static_cast<std::size_t>(x.cols()),
                     constants);
}

}  // namespace

void bind_filter(py::module_& m) {
  m.def("first_order", &first_order_into, py::call_guard<py::gil_scoped_release>(), py::kw_only(),
        py::arg("x").noconvert(), py::arg("y").noconvert(), py::arg("a"), py::arg("k0"), py::arg("k1"),
        "(3.1) on an (n, channels) float64 array into y of the same shape; false if an input is not finite.");
}

}  // namespace stickslip::bindings
