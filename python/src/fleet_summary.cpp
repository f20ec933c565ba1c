#include "tumble/tasks/fleet_summary.hpp"

#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bindings.hpp"

namespace tumble::python {

void bind_fleet_summary(nb::module_& module) {
  using namespace nb::literals;
  module.def("fleet_summary", &summarise_fleet, "folder"_a, "parameters"_a, "limits"_a, nb::call_guard<Unlocked>());
}

}  // namespace tumble::python
