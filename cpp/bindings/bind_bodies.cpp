// One trajectory of a rig of bodies: `_core.simulate_bodies`, laws and speeds as tapes.
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bodies_results.hpp"
#include "bodies_tapes.hpp"

namespace stickslip::bindings {

namespace {

py::dict simulate_bodies(int n, const std::vector<std::pair<Formulas, Formulas>>& laws,
                         const IndexVector& contact_speed, const std::vector<Speed>& speeds,
                         const std::vector<Formulas>& pushes, int parameters, const ConstVector& values,
                         const std::vector<int>& modes, double t_start, double t_end,
                         const std::optional<ConstVector>& t_eval, double rtol, double atol, Locator locator,
                         const ConstMatrix& seeds, long max_transitions, long max_steps, bool sensed, double after,
                         bool extremes, bool work) {
  check(contact_speed.size() == static_cast<Eigen::Index>(laws.size()) && modes.size() == laws.size(),
        "a speed and a mode for every contact");
  const Model model = model_of(n, laws, contact_speed, speeds, pushes, parameters);
  const int size = layout_of(model.bodies).size;
  check(parameters >= 0 && values.size() == size, "values must hold every number of bodies_layout");
  check(seeds.rows() == 0 || seeds.cols() == size, "seeds must have a column for every value");
  check(seeds.rows() == 0 || !(extremes || work), "extremes and work are summed up without seeds");
  std::vector<signed char> start;
  for (const int one : modes) {
    check(one >= -1 && one <= 2, "a mode is -1, 0, 1, or 2 for what the state says");
    start.push_back(static_cast<signed char>(one));
  }
  const BodiesRequest request{&model.bodies,
                              values.data(),
                              start.data(),
                              t_start,
                              t_end,
                              t_eval ? t_eval->data() : nullptr,
                              t_eval ? static_cast<long>(t_eval->size()) : 0,
                              rtol,
                              atol,
                              locator,
                              static_cast<int>(seeds.rows()),
                              seeds.data(),
                              max_transitions,
                              max_steps,
                              sensed};
  BodiesRecord r = released([&] { return record_bodies(request, {after, extremes, work}, interrupted); });
  if (r.summary.outcome == Outcome::interrupted) throw py::error_already_set();
  return as_dict(std::move(r));
}

}  // namespace

void bind_bodies(py::module_& m) {
  py::class_<Formulas>(
      m, "Formulas",
      "Formulas of a law in one direction, or of a speed: rows (operation, a, b); of the rows, which is the "
      "force (in slip, or of a contact without stick), the static limit (-1: none), each state's rate.")
      .def(py::init<const Rows&, int, int, std::vector<int>>(), py::kw_only(), py::arg("nodes"), py::arg("force"),
           py::arg("limit") = -1, py::arg("rates") = std::vector<int>{})
      .def(py::pickle(
          [](const Formulas& f) {
            Rows rows;
            for (const Node& one : f.nodes) rows.push_back({static_cast<int>(one.op), one.a, one.b});
            return py::make_tuple(rows, f.force, f.limit, f.rates);
          },
          [](const py::tuple& t) {
            return Formulas(t[0].cast<Rows>(), t[1].cast<int>(), t[2].cast<int>(), t[3].cast<std::vector<int>>());
          }));
  py::class_<Speed>(m, "PrescribedSpeed",
                    "A speed over time: a formula of t from each time on, the first before it too.")
      .def(py::init([](std::vector<double> begins, std::vector<Formulas> pieces) {
             check(!begins.empty() && begins.size() == pieces.size(), "a piece for every time");
             for (std::size_t i = 1; i < begins.size(); ++i) check(begins[i] > begins[i - 1], "times must increase");
             return Speed{std::move(begins), std::move(pieces)};
           }),
           py::kw_only(), py::arg("begins"), py::arg("pieces"))
      .def(py::pickle([](const Speed& s) { return py::make_tuple(s.begins, s.pieces); },
                      [](const py::tuple& t) {
                        return Speed{t[0].cast<std::vector<double>>(), t[1].cast<std::vector<Formulas>>()};
                      }));
  py::list names;
  for (const auto& name : op_names) names.append(py::str(name.data(), name.size()));
  m.attr("OPERATIONS") = py::tuple(names);
  m.def(
      "bodies_layout",
      [](int n, int contacts, int speeds, int pushes, int parameters, int states) {
        const BodiesLayout l =
            layout_of(Bodies{n, contacts, speeds, parameters, states, nullptr, nullptr, nullptr, pushes, nullptr});
        return std::map<std::string, int>{{"M", l.M},
                                          {"C", l.C},
                                          {"K", l.K},
                                          {"force", l.force},
                                          {"D", l.D},
                                          {"G", l.G},
                                          {"pull_x", l.pull_x},
                                          {"pull_v", l.pull_v},
                                          {"parameters", l.parameters},
                                          {"initial", l.initial},
                                          {"dwell", l.dwell},
                                          {"size", l.size}};
      },
      "Where each array begins among the values, row by row, and how many values there are.", py::kw_only(),
      py::arg("n"), py::arg("contacts"), py::arg("speeds"), py::arg("pushes") = 0, py::arg("parameters"),
      py::arg("states"));
  m.def("simulate_bodies", &simulate_bodies, py::kw_only(), py::arg("n"), py::arg("laws"),
        py::arg("contact_speed").noconvert(), py::arg("speeds"), py::arg("pushes") = std::vector<Formulas>{},
        py::arg("parameters"), py::arg("values").noconvert(), py::arg("modes"), py::arg("t_start"), py::arg("t_end"),
        py::arg("t_eval").noconvert(), py::arg("rtol"), py::arg("atol"), py::arg("locator"),
        py::arg("seeds").noconvert(), py::arg("max_transitions"), py::arg("max_steps") = most_steps,
        py::arg("sensed") = false, py::arg("after") = 0.0, py::arg("extremes") = false, py::arg("work") = false);
}

}  // namespace stickslip::bindings
