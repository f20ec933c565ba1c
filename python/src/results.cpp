#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>

#include "bindings.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/report/report.hpp"

namespace tumble::python {

void bind_results(nb::module_& module) {
  using namespace nb::literals;
  nb::class_<Estimate>(module, "Estimate")
      .def(
          "to_json", [](const Estimate& estimate) { return to_json(estimate); }, nb::call_guard<Unlocked>())
      .def(
          "to_html", [](const Estimate& e) { return to_html(e); }, nb::call_guard<Unlocked>())
      .def(
          "to_text", [](const Estimate& e) { return to_text(e); }, nb::call_guard<Unlocked>())
      .def_static("from_json", &estimate_from_json, "text"_a, "file"_a, nb::call_guard<Unlocked>());
  module.def("with_uncertainty", &with_uncertainty, "value"_a, "sd"_a);
  module.def("write_whole", &write_file_atomically, "path"_a, "text"_a, nb::call_guard<Unlocked>());
}

}  // namespace tumble::python
