#include "pybind.hpp"

PYBIND11_MODULE(_core, m, py::mod_gil_not_used()) {
  using namespace stickslip::bindings;
  m.doc() = "The compiled core. Cranky: float64, C-contiguous, exact shapes, keywords only.";
  bind_config(m);
  bind_filter(m);
  bind_structure(m);
  bind_simulate(m);
  bind_sweep(m);
  bind_windows(m);
  bind_bodies(m);
}
