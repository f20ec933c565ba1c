// How fast an archive of many units is: putting in, the history of a unit, a chart over all units; prints a page. It is
// run in the root of the repository, for its plans.
//
//   archive ADDRESS FOLDER [UNITS, 10000] [RESULTS of each, 20]
//
// ADDRESS is a file that is not there, or an empty database of a server; with 0 results an archive of an earlier run.
// Times are those within the program: each question is asked 20 times, and the median and the longest of the last 19
// are printed.
#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "tumble/archive/history.hpp"
#include "tumble/archive/statistics.hpp"
#include "tumble/archive/verify.hpp"
#include "tumble/core/instant.hpp"
#include "tumble/math/random.hpp"
#include "tumble/report/report.hpp"
#include "tumble/sim/simulate.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/error.hpp"

namespace {

using namespace tumble;
namespace fs = std::filesystem;

double steady() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// [s] of this process.
double processor() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) { return double(time.tv_sec) + 1e-6 * double(time.tv_usec); };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// A result of accelerometer_tumble as a laboratory makes it: measured on a dividing head with a certificate.
Estimate tumble_result() {
  Plan plan = load_plan("plans/accelerometer_tumble.toml", {});
  plan.rig_equipment = "head 7, certificate 12";
  Evidence evidence{plan, {simulate(plan, 1, {})}};
  Estimate estimate = identify(evidence, {});
  estimate.provenance.seed = std::nullopt;
  return estimate;
}

/// Result number `result` of unit number `unit`: ten days of two results, a month apart, with a spread of its own.
ResultDeposit deposit_of(const Estimate& base, std::uint64_t unit, std::uint64_t result, const RandomStream& random) {
  Estimate estimate = base;
  estimate.instrument_serial = fmt::format("A{:05}", unit);
  const RandomStream of_unit = random.split(unit);
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i) {
    const double sd = std::sqrt(base.covariance(i, i));
    estimate.parameters[i].value += sd * (3.0 * of_unit.normal(i) + of_unit.split(result).normal(i));
  }
  constexpr std::int64_t second = 1'000'000'000, day = 86'400;
  const auto begin = parse_iso_time("2024-01-01T08:00:00Z").value_or(0);
  const std::int64_t time = static_cast<std::int64_t>(result / 2) * 30 * day +
                            static_cast<std::int64_t>(result % 2) * 7200 + static_cast<std::int64_t>(unit % 28) * day;
  return {
      .json = to_json(estimate), .file = "result.json", .ended = iso_time(begin + time * second).substr(0, 19) + "Z"};
}

/// Puts in, a hundred results in a transaction. Returns [s] of wall time and of the processor, without the making of
/// the texts.
std::pair<double, double> put_all(Archive& archive, const Estimate& base, std::uint64_t units, std::uint64_t results) {
  const RandomStream random(7);
  double wall = 0.0, processed = 0.0;
  Deposit deposit;
  const auto flush = [&] {
    const double begin = steady(), before = processor();
    put_in(archive, deposit, {"bench", "2026-01-01T00:00:00Z", {}});
    wall += steady() - begin, processed += processor() - before;
    deposit = {};
  };
  for (std::uint64_t result = 0; result < results; ++result)
    for (std::uint64_t unit = 0; unit < units; ++unit) {
      deposit.results.push_back(deposit_of(base, unit, result, random));
      if (deposit.results.size() == 100) flush();
    }
  if (!deposit.results.empty()) flush();
  return {wall, processed};
}

void measure(const std::string& what, const std::function<void()>& work) {
  std::vector<double> times, processed;
  for (int i = 0; i < 20; ++i) {
    const double begin = steady(), before = processor();
    work();
    times.push_back(1e3 * (steady() - begin));
    processed.push_back(1e3 * (processor() - before));
  }
  times.erase(times.begin()), processed.erase(processed.begin());  // the first one is not warm
  std::ranges::sort(times), std::ranges::sort(processed);
  fmt::print("| {} | {:.1f} ms | {:.1f} ms | {:.1f} ms |\n", what, times[9], times.back(), processed[9]);
}

void measure_all(const std::string& address, const std::string& folder, std::uint64_t units, std::uint64_t results) {
  const Estimate base = tumble_result();
  if (results > 0) make_archive(address, folder, {"bench", "2026-01-01T00:00:00Z", {}});
  Archive archive(address);
  const double count = double(units) * double(results);
  fmt::print("{} units x {} results of {} parameters, {} kB each as JSON\n\n", units, results, base.parameters.size(),
             to_json(base).size() / 1000);
  if (results > 0) {
    const auto [wall, processed] = put_all(archive, base, units, results);
    fmt::print(
        "Put in, 100 in a transaction: {:.0f} results/s by the clock, {:.0f} results in a second of this process.\n\n",
        count / wall, count / processed);
  }
  fmt::print("| question | median | longest | processor, median |\n|---|---:|---:|---:|\n");
  const UnitName unit{base.instrument_model, "A00042"};
  const std::string parameter = base.parameters[0].name;
  measure("history of a unit", [&] { unit_record(archive, unit); });
  measure("history and drift of a parameter of a unit", [&] {
    drift_of_unit(archive, {.what = {parameter, {}, unit}, .limits = {-1.0, 1.0}});
  });
  if (unit_record(archive, unit).results.size() >= 8)  // four days
    measure("chart of a parameter of a unit", [&] { chart_of_archive(archive, {.what = {parameter, {}, unit}}); });
  measure("values of a parameter over all units", [&] { parameter_over_units(archive, parameter, ""); });
  measure("chart of a parameter over all units", [&] {
    chart_of_archive(archive, {.what = {parameter, base.instrument_model, {}}});
  });
  const double begin = steady();
  summary_of_model(archive, {.what = {parameter, base.instrument_model, {}}});
  const double summed = steady();
  const auto check = verify_archive(archive);
  fmt::print("\nSummary of a model (components of variance of all results): {:.1f} s. Verify: {:.1f} s, {} problems.\n",
             summed - begin, steady() - summed, check.problems.size());
  if (fs::exists(address)) fmt::print("The database has {:.0f} MB.\n", 1e-6 * double(fs::file_size(address)));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    fmt::print(stderr, "archive ADDRESS FOLDER [UNITS] [RESULTS]\n");
    return 2;
  }
  const auto number = [&](int place, double usual) { return argc > place ? std::atof(argv[place]) : usual; };
  try {
    measure_all(argv[1], argv[2], static_cast<std::uint64_t>(number(3, 10'000.0)),
                static_cast<std::uint64_t>(number(4, 20.0)));
  } catch (const Error& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 3;
  }
  return 0;
}
