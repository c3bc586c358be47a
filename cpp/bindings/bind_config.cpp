#include <string>
#include <vector>

#include "pybind.hpp"
#include "stickslip/isa.hpp"

namespace stickslip::bindings {

namespace {

std::string dotted(int major, int minor, int patch) {
  return std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(patch);
}

py::dict build_config() {
  std::vector<std::string> compiled;
  for (const IsaFacts& candidate : isa_facts) {
    if (is_compiled(candidate.isa)) compiled.emplace_back(candidate.name);
  }
  const IsaFacts& used = facts(isa_in_use());
  py::dict config;
  config["version"] = STICKSLIP_VERSION;
  config["compiler"] = STICKSLIP_COMPILER;
  config["build_type"] = STICKSLIP_BUILD_TYPE;
  config["flags"] = STICKSLIP_FLAGS;
  config["sanitize"] = STICKSLIP_SANITIZERS;
  config["isa"] = std::string(used.name);
  config["simd_width"] = used.lanes;
  config["isa_compiled"] = compiled;
  config["eigen"] = dotted(EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION);
  config["pybind11"] = dotted(PYBIND11_VERSION_MAJOR, PYBIND11_VERSION_MINOR, PYBIND11_VERSION_PATCH);
  return config;
}

}  // namespace

void bind_config(py::module_& m) {
  m.def("build_config", &build_config,
        R"(How this build was made and which instruction set its kernel uses on this processor.

Returns
-------
dict
    version, compiler, build_type, flags, sanitize, eigen and pybind11 are text; isa is the instruction set in use,
    isa_compiled those that it was chosen from, simd_width how many members of a sweep go side by side.

Examples
--------
>>> import stickslip as ss
>>> config = ss.build_config()
>>> config["isa"] in config["isa_compiled"]
True
)");
}

}  // namespace stickslip::bindings
