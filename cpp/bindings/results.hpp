// What the bindings of the kernels share: arrays that own their numbers, and Ctrl-C.
#pragma once

#include <utility>
#include <vector>

#include "pybind.hpp"

namespace stickslip::bindings {

// An array that owns a vector moved out of a result.
template <class V>
py::array_t<V> as_array(std::vector<V>&& values, std::vector<py::ssize_t> shape) {
  auto* owner = new std::vector<V>(std::move(values));
  const py::capsule free(owner, [](void* p) { delete static_cast<std::vector<V>*>(p); });
  return py::array_t<V>(std::move(shape), owner->data(), free);
}

// Asked now and then while the interpreter is released.
inline bool interrupted() {
  const py::gil_scoped_acquire gil;
  return PyErr_CheckSignals() != 0;
}
inline bool interrupted(void*) { return interrupted(); }

// What `work` gives, done while other threads have the interpreter.
template <class Work>
auto released(const Work& work) {
  const py::gil_scoped_release release;
  return work();
}

}  // namespace stickslip::bindings
