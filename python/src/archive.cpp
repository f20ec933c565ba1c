#include "tumble/archive/archive.hpp"

#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <nlohmann/json.hpp>

#include "bindings.hpp"
#include "tumble/archive/archive_json.hpp"
#include "tumble/archive/deposit.hpp"
#include "tumble/archive/history.hpp"
#include "tumble/archive/populations.hpp"
#include "tumble/core/estimate.hpp"

namespace tumble::python {
namespace {

/// JSON, name for messages, model and serial number in place of what it says, where not empty.
using GivenResult = std::tuple<std::string, std::string, std::string, std::string>;

/// How many of what was given were new, by kind.
std::map<std::string, std::size_t> put(Archive& archive, const std::vector<GivenResult>& results,
                                       const std::vector<std::string>& files, const std::string& model,
                                       const std::string& serial, const std::string& who, const std::string& when) {
  Deposit deposit;
  for (const auto& [json, name, of_model, number] : results)
    deposit.results.push_back({.json = json, .file = name, .unit = {of_model, number}});
  for (const auto& path : files)
    deposit.files.push_back({.path = path, .name = path.substr(path.rfind('/') + 1), .unit = {model, serial}});
  const Deposited done = put_in(archive, deposit, {.who = who, .when = when, .why = {}});
  return {{"results", done.results}, {"files", done.files}, {"known", done.known}};
}

}  // namespace

void bind_archive(nb::module_& module) {
  using namespace nb::literals;
  const nb::call_guard<Unlocked> unlocked;
  nb::class_<Archive>(module, "Archive")
      .def(nb::init<const std::string&, const std::string&>(), "address"_a, "when"_a, unlocked)
      .def_prop_ro("address", &Archive::address)
      .def(
          "units_json",
          [](const Archive& archive, const std::string& model) { return units_json(archived_units(archive, model)); },
          "model"_a, unlocked)
      .def(
          "history_json",
          [](const Archive& archive, const std::string& words) {
            return record_json(unit_record(archive, find_unit(archive, words)));
          },
          "unit"_a, unlocked)
      .def(
          "result_text",
          [](const Archive& archive, const std::string& digits) {
            return result_text(archive, find_result(archive, digits));
          },
          "digits"_a, unlocked)
      .def(
          "write_stored",
          [](const Archive& archive, const std::string& sha256, const std::string& path) {
            write_stored(archive, sha256, path);
          },
          "sha256"_a, "path"_a, unlocked)
      .def(
          "population",
          [](const Archive& archive, const std::string& model, const std::string& method, const std::string& without) {
            return population_of(archive, {.model = model, .method = method, .without = without});
          },
          "model"_a, "method"_a, "without"_a, unlocked)
      .def(
          "components",
          [](const Archive& archive, const std::string& model, const std::string& parameter, const std::string& method,
             const std::string& without) {
            return components_of(archive, {.model = model, .method = method, .without = without}, parameter);
          },
          "model"_a, "parameter"_a, "method"_a, "without"_a, unlocked)
      .def("put", &put, "results"_a, "files"_a, "model"_a, "serial"_a, "who"_a, "when"_a, unlocked);
  module.def(
      "make_archive",
      [](const std::string& address, const std::string& folder, const std::string& who, const std::string& when) {
        make_archive(address, folder, {.who = who, .when = when, .why = {}});
      },
      "address"_a, "folder"_a, "who"_a, "when"_a, unlocked);
}

}  // namespace tumble::python
