// What a flat vector of parameters describes: `_core.Structure`, and the names of all that a model may have.
#include <algorithm>
#include <array>
#include <string>
#include <tuple>
#include <vector>

#include "pybind.hpp"
#include "stickslip/slots.hpp"

namespace stickslip::bindings {

namespace {

using namespace stickslip_abi;

template <std::size_t N>
py::tuple names(const std::array<std::string_view, N>& all) {
  py::list out;
  for (const auto& name : all) out.append(py::str(name.data(), name.size()));
  return out;
}

// Every slot by its name: "belt_speed", "paper.A1", "belt_seam.a".
py::tuple parameter_names() {
  py::list out;
  for (const SlotName& name : slot_names)
    out.append(std::string(name.owner) + (name.owner.empty() ? "" : ".") + std::string(name.own));
  return out;
}

// A tabulated term: place, variable, period, knots.
using TableTuple = std::tuple<int, int, double, std::vector<double>>;

Table table(const TableTuple& from) {
  const auto& [place, variable, period, knots] = from;
  if (knots.size() > max_knots) throw py::value_error("a tabulated term has at most 24 knots");
  Table out;
  out.place = static_cast<TablePlace>(place);
  out.variable = static_cast<TableVariable>(variable);
  out.period = period;
  out.knots = static_cast<int>(knots.size());
  std::copy(knots.begin(), knots.end(), out.knot);
  return out;
}

}  // namespace

void bind_structure(py::module_& m) {
  py::native_enum<RigKind>(m, "RigKind", "enum.IntEnum")
      .value("two_degree", RigKind::two_degree)
      .value("block_on_belt", RigKind::block_on_belt)
      .finalize();
  py::class_<Structure>(m, "Structure", "Which rig, law and effects a parameter vector describes.")
      .def(py::init([](RigKind rig, int law, std::uint32_t effects, const std::vector<TableTuple>& tables) {
             if (law < 0 || law >= Laws::size) throw py::value_error("law must be a place in LAWS");
             Structure s;
             s.rig = rig;
             s.law = law;
             s.effects = effects;
             if (tables.size() > table_count) throw py::value_error("a model has two tabulated terms at most");
             for (std::size_t i = 0; i < tables.size(); ++i) s.table[i] = table(tables[i]);
             return s;
           }),
           py::kw_only(), py::arg("rig"), py::arg("law"), py::arg("effects") = 0,
           py::arg("tables") = std::vector<TableTuple>{});
  m.attr("PARAMETERS") = parameter_names();
  m.attr("MAX_KNOTS") = max_knots;
  m.attr("TABLES") = table_count;
  m.attr("STATES") = names(state_names);
  m.attr("EFFECTS") = names(effect_names);
  m.attr("LAWS") = names(law_names);
  m.attr("TABLE_PLACES") = names(table_places);
  m.attr("TABLE_VARIABLES") = names(table_variables);
}

}  // namespace stickslip::bindings
