#include "recordings.hpp"

#include <nanobind/ndarray.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <cmath>
#include <optional>
#include <tuple>

#include "bindings.hpp"
#include "tumble/checks/check.hpp"
#include "tumble/clocks/sampling_rate.hpp"
#include "tumble/report/report.hpp"

namespace tumble::python {
namespace {

using View = nb::ndarray<nb::numpy, const double, nb::ndim<1>>;

/// label, begin [s], run, end [s]
using MarkParts = std::tuple<std::string, double, int, double>;

View view(const std::vector<double>& values) { return View(values.data(), {values.size()}, nb::handle()); }

/// Times [s] of the samples: the stamps themselves, or what start and rate give.
View times(nb::handle self) {
  const auto& channel = nb::cast<const Channel&>(self);
  if (!channel.timeline.uniform()) return View(channel.timeline.stamps->data(), {channel.values.size()}, self);
  auto* const values = new std::vector<double>(channel.values.size());
  const nb::capsule owner(values, [](void* it) noexcept { delete static_cast<std::vector<double>*>(it); });
  for (std::size_t i = 0; i < values->size(); ++i) (*values)[i] = channel.time(i);
  return View(values->data(), {values->size()}, owner);
}

std::size_t missing(const Channel& channel) {
  std::size_t count = 0;
  for (const double value : channel.values) count += std::isnan(value) ? 1 : 0;
  return count;
}

std::vector<MarkParts> marks(const Recording& recording) {
  std::vector<MarkParts> parts;
  for (const auto& mark : recording.marks) parts.emplace_back(mark.label, mark.begin, mark.run, mark.end);
  return parts;
}

/// Findings of the reader and of all checks, as the JSON of a result has them.
std::string check(const Recording& recording) {
  auto findings = recording.findings;
  for (auto& finding : run_checks(recording, nullptr)) findings.push_back(std::move(finding));
  return to_json(findings);
}

void bind_channel(nb::module_& module) {
  nb::class_<Channel>(module, "Channel")
      .def_ro("name", &Channel::name)
      .def_prop_ro("kind", [](const Channel& channel) { return std::string(name(channel.kind)); })
      .def_ro("unit", &Channel::unit)
      .def_prop_ro(
          "values", [](const Channel& channel) { return view(channel.values); }, nb::rv_policy::reference_internal)
      .def_prop_ro("times", &times, nb::rv_policy::automatic)
      .def_prop_ro("uniform", [](const Channel& channel) { return channel.timeline.uniform(); })
      .def_prop_ro("start", [](const Channel& channel) { return channel.values.empty() ? NAN : channel.time(0); })
      .def_prop_ro(
          "end",
          [](const Channel& channel) { return channel.values.empty() ? NAN : channel.time(channel.values.size() - 1); })
      .def_prop_ro("rate", [](const Channel& channel) { return sampling_rate(channel); })
      .def_prop_ro("missing", &missing)
      .def("__len__", [](const Channel& channel) { return channel.values.size(); });
}

}  // namespace

void bind_recordings(nb::module_& module) {
  using namespace nb::literals;
  bind_channel(module);
  nb::class_<Recording>(module, "Recording")
      .def_ro("instrument", &Recording::instrument)
      .def_ro("meta", &Recording::meta)
      .def_prop_ro("file", [](const Recording& recording) { return recording.origin.file; })
      .def(
          "sha256", [](const Recording& recording) { return sha256_of(recording.origin); }, nb::call_guard<Unlocked>())
      .def_prop_ro("marks", &marks)
      .def_prop_ro("findings", [](const Recording& recording) { return to_json(recording.findings); })
      .def("check", &check, nb::call_guard<Unlocked>())
      .def("__len__", [](const Recording& recording) { return recording.channels.size(); })
      .def(
          "channel",
          [](const Recording& recording, std::size_t i) -> const Channel& { return recording.channels.at(i); },
          "index"_a, nb::rv_policy::reference_internal)
      .def("between", &between, "begin"_a, "end"_a, nb::call_guard<Unlocked>());
  nb::class_<ChannelParts>(module, "ChannelParts")
      .def(nb::init<std::string, std::string, Samples, double, double, std::optional<Samples>, bool>(), "name"_a,
           "unit"_a, "values"_a.noconvert(), "start"_a, "rate"_a, "stamps"_a.noconvert().none(), "si"_a);
  module.def("make_recording", &make_recording, "channels"_a, "marks"_a, "file"_a, "instrument"_a, "meta"_a,
             "checksum"_a, nb::call_guard<Unlocked>());
}

}  // namespace tumble::python
