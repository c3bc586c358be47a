// The only header that includes pybind11. Names the array types that cross the border; the face
// converts with np.ascontiguousarray, so nothing is copied or cast here.
#pragma once

#include <pybind11/eigen.h>
#include <pybind11/native_enum.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <Eigen/Core>

namespace py = pybind11;

namespace stickslip::bindings {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using ConstMatrix = Eigen::Ref<const RowMatrix>;                                       // (n, d) float64, C-contiguous
using ConstVector = Eigen::Ref<const Eigen::VectorXd>;                                 // (n,) float64
using IndexVector = Eigen::Ref<const Eigen::Matrix<std::int32_t, Eigen::Dynamic, 1>>;  // (n,) int32
using ModeVector = Eigen::Matrix<std::int8_t, Eigen::Dynamic, 1>;                      // (n,) int8: -1, 0, 1

void bind_bodies(py::module_& m);
void bind_config(py::module_& m);
void bind_filter(py::module_& m);
void bind_simulate(py::module_& m);
void bind_structure(py::module_& m);
void bind_sweep(py::module_& m);
void bind_windows(py::module_& m);

}  // namespace stickslip::bindings
