#include "bindings.hpp"
#include "tumble/version.hpp"

NB_MODULE(_tumble, module) {
  using namespace tumble::python;
  module.doc() =
      "The C++ library of Tumble. The package `tumble` is made for people; this module may change at any time.";
  module.attr("version") = tumble::version;
  prepare_for_the_end();
  nb::set_leak_warnings(false);  // threads that are in a call when the interpreter ends keep their objects
  bind_errors(module);
  bind_units(module);
  bind_recordings(module);
  bind_plans(module);
  bind_results(module);
  bind_tasks(module);
  bind_stability(module);
  bind_figures(module);
  bind_archive(module);
  bind_fleet(module);
  bind_fleet_summary(module);
  bind_compat_allantools(module);
  bind_compat_imucal(module);
}
