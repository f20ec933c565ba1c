#include <nanobind/stl/string.h>

#include "bindings.hpp"
#include "tumble/units/unit.hpp"

namespace tumble::python {

void bind_units(nb::module_& module) {
  using namespace nb::literals;
  nb::class_<Unit>(module, "Unit")
      .def_static(
          "parse", [](const std::string& text) { return Unit::parse(text); }, "text"_a)
      .def_prop_ro("text", &Unit::text)
      .def_prop_ro("dimension", [](const Unit& unit) { return name(unit.dimension()); })
      .def_prop_ro("factor", &Unit::factor)
      .def_prop_ro("offset", &Unit::offset)
      .def("to_si", &Unit::to_si, "value"_a)
      .def("from_si", &Unit::from_si, "value"_a)
      .def("difference_to_si", &Unit::difference_to_si, "value"_a)
      .def("difference_from_si", &Unit::difference_from_si, "value"_a);
  module.def(
      "parse_si", [](const std::string& text, const std::string& unit) { return parse_si(text, Unit::parse(unit)); },
      "text"_a, "unit"_a);
}

}  // namespace tumble::python
