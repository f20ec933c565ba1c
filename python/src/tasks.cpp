#include "tumble/tasks/tasks.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <nlohmann/json.hpp>

#include "bindings.hpp"
#include "tumble/report/report.hpp"
#include "tumble/tasks/catalogue.hpp"
#include "tumble/tasks/departed.hpp"
#include "tumble/tasks/export.hpp"
#include "tumble/tasks/optimise.hpp"
#include "tumble/tasks/validate.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"

namespace tumble::python {
namespace {

using Call = nb::object;

/// Format of that name; null for none.
const Format* format_named(const std::optional<std::string>& wanted) {
  if (!wanted) return nullptr;
  std::vector<std::string> names;
  for (const auto* format : format_catalogue()) {
    if (format->name == *wanted) return format;
    names.emplace_back(format->name);
  }
  throw Error(Error::Kind::unsupported, say("there is no format '{}'{}", *wanted, did_you_mean(*wanted, names)));
}

Recording read(const std::string& path, const Sets& sets, const std::vector<std::string>& only,
               const std::optional<std::string>& format, const Call& call) {
  Listener listener(call);
  Unlocked unlocked;
  ReadOptions options = read_options(sets);
  options.only = only;
  const FormatList formats = format ? FormatList{format_named(format)} : format_catalogue();
  return read_recording(path, options, listener.progress(), formats);
}

Estimate identify_from(const Plan& plan, const std::vector<std::string>& files,
                       const std::vector<const Recording*>& in_memory, std::uintmax_t memory, const Call& call) {
  Listener listener(call);
  Unlocked unlocked;
  if (in_memory.empty()) return identify(plan, files, memory, listener.progress());
  std::vector<Recording> copies;
  for (const auto* recording : in_memory) copies.push_back(*recording);
  return identify(gather(plan, files, std::move(copies), listener.progress()), listener.progress());
}

Recording simulate_plan(const Plan& plan, std::uint64_t seed, const Call& call) {
  Listener listener(call);
  Unlocked unlocked;
  return simulate(plan, seed, listener.progress());
}

void simulate_file(const std::string& path, const Plan& plan, std::uint64_t seed, std::size_t memory,
                   const Call& call) {
  Listener listener(call);
  Unlocked unlocked;
  simulate_to(path, plan, seed, memory, listener.progress());
}

void convert_file(const std::string& from, const std::string& to, const Sets& sets, const Call& call) {
  Listener listener(call);
  Unlocked unlocked;
  convert(from, to, read_options(sets), listener.progress());
}

/// The compensated recording; and a result without parameters that holds
/// what the method says of its work, as `tumble compensate` prints it.
std::pair<Recording, Estimate> compensate_recording(const Estimate& estimate, const Recording& recording,
                                                    const Plan* plan) {
  auto done = compensate(estimate, recording, plan);
  Estimate account;
  account.method = estimate.method;
  account.title = recording.origin.file + " compensated";
  account.findings = std::move(done.findings);
  account.tables = std::move(done.tables);
  return {std::move(done.recording), std::move(account)};
}

/// Criterion "A" or "D", total time [s] and step [rad]. Returned: what was predicted, and the text of the plan.
std::pair<Estimate, std::string> optimise_plan(const Plan& plan, const std::string& criterion,
                                               std::optional<double> time, std::optional<double> step,
                                               const std::vector<std::string>& terms, const Call& call) {
  Listener listener(call);
  Unlocked unlocked;
  OptimiseOptions options;
  options.criterion = criterion == "D" ? DesignCriterion::D : DesignCriterion::A;
  options.total_time = time;
  options.terms = terms;
  if (step) options.step = *step;
  const auto found = optimise(plan, options, listener.progress());
  return {found.estimate, plan_with_schedule(plan, found.schedule)};
}

Estimate predict_terms(const Plan& plan, const std::vector<std::string>& terms) {
  return terms.empty() ? predict(plan) : predict_model(plan, terms);
}

/// Given: the departure, its target and its size as people write it; each may be empty.
Estimate validate_plan(const Plan& plan, std::size_t trials, std::uint64_t seed, const std::string& departure,
                       const std::string& target, const std::string& size, const Call& call) {
  Listener listener(call);
  Unlocked unlocked;
  ValidateOptions options{.trials = trials, .seed = seed, .departure = departure, .target = target};
  if (!size.empty()) options.size = parse_quantity(size);
  return report_of(validate(plan, options, listener.progress()));
}

/// The recordings of a test with departures as people write them.
std::vector<Recording> simulate_with_departures(const Plan& plan, std::uint64_t seed,
                                                const std::vector<std::string>& departures) {
  return simulate_departed(plan, wanted_departures(departures), seed);
}

/// Given: sources, each as name, JSON and axis. Returned: the file for a consumer.
std::string export_sources(const std::vector<std::tuple<std::string, std::string, std::string>>& sources,
                           const std::string& to, const Sets& sets, const std::vector<std::string>& drop,
                           double inflate) {
  std::vector<ExportSource> all;
  for (const auto& [name, text, axis] : sources) all.push_back({name, text, axis});
  return export_results(all, {to, sets, drop, inflate});
}

}  // namespace

void bind_tasks(nb::module_& module) {
  using namespace nb::literals;
  const nb::call_guard<Unlocked> unlocked;
  module.def("read", &read, "path"_a, "sets"_a, "only"_a, "format"_a.none(), "progress"_a.none());
  module.def(
      "write", [](const Recording& recording, const std::string& path) { write_recording(recording, path); },
      "recording"_a, "path"_a, unlocked);
  module.def("convert", &convert_file, "from_path"_a, "to_path"_a, "sets"_a, "progress"_a.none());
  module.def("identify", &identify_from, "plan"_a, "files"_a, "recordings"_a, "memory"_a, "progress"_a.none());
  module.def("simulate", &simulate_plan, "plan"_a, "seed"_a, "progress"_a.none());
  module.def("simulate_to", &simulate_file, "path"_a, "plan"_a, "seed"_a, "memory"_a, "progress"_a.none());
  module.def("predict", &predict_terms, "plan"_a, "terms"_a, unlocked);
  module.def("optimise", &optimise_plan, "plan"_a, "criterion"_a, "total_time"_a.none(), "step"_a.none(), "terms"_a,
             "progress"_a.none());
  module.def("validate", &validate_plan, "plan"_a, "trials"_a, "seed"_a, "departure"_a, "target"_a, "size"_a,
             "progress"_a.none());
  module.def("simulate_departed", &simulate_with_departures, "plan"_a, "seed"_a, "departures"_a, unlocked);
  module.def("compensate", &compensate_recording, "estimate"_a, "recording"_a, "plan"_a.none(), unlocked);
  module.def("export_results", &export_sources, "sources"_a, "to"_a, "sets"_a, "drop"_a, "inflate"_a, unlocked);
  module.def(
      "catalogue", [](const std::string& kind) { return catalogue_json(kind); }, "kind"_a);
}

}  // namespace tumble::python
