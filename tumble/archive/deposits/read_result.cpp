#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "tumble/archive/deposits/parts.hpp"
#include "tumble/core/instant.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/report/report.hpp"
#include "tumble/units/error.hpp"

namespace tumble::deposits {

namespace {

/// The version that wrote a result; the text was read as a result before.
std::string program_of(const std::string& json) {
  const auto parsed = nlohmann::json::parse(json, nullptr, false);
  const auto version = parsed.is_object() ? parsed.find("tumble") : parsed.end();
  return version != parsed.end() && version->is_string() ? version->get<std::string>() : std::string();
}

/// From the first sample to the last one of all recordings that say it.
void times_of(const Estimate& estimate, std::string& begun, std::string& ended) {
  for (const auto& [file, times] : recording_times(estimate)) {
    if (!times.begun.empty() && (begun.empty() || times.begun < begun)) begun = times.begun;
    if (!times.ended.empty() && times.ended > ended) ended = times.ended;
  }
}

}  // namespace

std::vector<ReadInput> inputs_of(const Estimate& estimate) {
  const Provenance& provenance = estimate.provenance;
  const auto calibration = provenance.settings.find("calibration");
  std::vector<ReadInput> inputs;
  for (const auto& plan : provenance.plans) inputs.push_back({"plan", plan.sha256, plan.file});
  for (const auto& input : provenance.inputs) {
    const bool calibrates = calibration != provenance.settings.end() && calibration->second == input.file;
    if (!input.sha256.empty()) inputs.push_back({calibrates ? "calibration" : "recording", input.sha256, input.file});
  }
  return inputs;
}

Problems problems_of_name(const UnitName& unit) {
  constexpr std::size_t longest = 1000;  // indexes of PostgreSQL hold no more than 2704 bytes
  Problems problems;
  for (const auto& [what, text] :
       {std::pair<const char*, const std::string&>{"model", unit.model}, {"serial number", unit.serial}}) {
    if (text.size() > longest)
      problems.push_back(say("the {} has {} bytes: up to {} are accepted", what, text.size(), longest));
    if (text.find('\0') != std::string::npos) problems.push_back(say("the {} has a character of value 0", what));
  }
  return problems;
}

ReadResult read_result(const ResultDeposit& deposit, Problems& problems) {
  ReadResult result;
  result.deposit = &deposit;
  try {
    result.estimate = estimate_from_json(deposit.json, deposit.file);
  } catch (const Error& error) {
    problems.insert(problems.end(), error.problems.begin(), error.problems.end());
    return result;
  }
  result.sha256 = sha256_of(deposit.json);
  result.program_version = program_of(deposit.json);
  result.unit = {deposit.unit.model.empty() ? result.estimate.instrument_model : deposit.unit.model,
                 deposit.unit.serial.empty() ? result.estimate.instrument_serial : deposit.unit.serial};
  if (result.unit.serial.empty() || result.unit.model.empty())
    problems.push_back(
        say("{}: the result does not say which unit it is of: give --unit MODEL/SERIAL, or [instrument] model "
            "and serial in the plan",
            Name{deposit.file}));
  for (auto& problem : problems_of_name(result.unit)) problems.push_back(say("{}: {}", Name{deposit.file}, problem));
  result.begun = deposit.begun;
  result.ended = deposit.ended;
  if (result.begun.empty() && result.ended.empty()) times_of(result.estimate, result.begun, result.ended);
  if (result.ended.empty()) result.ended = result.begun;
  for (const auto& time : std::set{result.begun, result.ended})
    if (!time.empty() && !parse_iso_time(time))
      problems.push_back(say("{}: '{}' is no time of a test: write it in UTC, such as 2026-11-20T09:00:00Z",
                             Name{deposit.file}, time));
  return result;
}

}  // namespace tumble::deposits
