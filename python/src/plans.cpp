#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bindings.hpp"
#include "tumble/core/plan.hpp"
#include "tumble/tasks/tasks.hpp"

namespace tumble::python {

void bind_plans(nb::module_& module) {
  using namespace nb::literals;
  nb::class_<Plan>(module, "Plan")
      .def_ro("file", &Plan::file)
      .def_ro("sha256", &Plan::sha256)
      .def_ro("text", &Plan::text)
      .def_prop_ro("calibration_sha256", [](const Plan& plan) { return plan.calibration.sha256; })
      .def_ro("title", &Plan::title)
      .def_ro("method", &Plan::method)
      .def_ro("instrument_model", &Plan::instrument_model)
      .def_ro("instrument_serial", &Plan::instrument_serial)
      .def_ro("rig", &Plan::rig_kind)
      .def_ro("sample_rate", &Plan::sample_rate)
      .def_prop_ro("settings", [](const Plan& plan) { return plan.settings.texts(); })
      .def_prop_ro("rig_settings", [](const Plan& plan) { return plan.rig.texts(); })
      .def_prop_ro("truth", [](const Plan& plan) { return plan.truth.texts(); })
      .def_prop_ro("recordings", [](const Plan& plan) {
        std::vector<std::string> files;
        for (const auto& entry : plan.recordings) files.push_back(entry.file);
        return files;
      });
  module.def("load_plan", &load_plan, "path"_a, "sets"_a);
  module.def("plan_for_method", &plan_for_method, "method"_a, "sets"_a);
}

}  // namespace tumble::python
