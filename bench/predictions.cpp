// Scatter of simulated and identified tests over what `tumble predict` promises, for every ready plan that has a method.
// Prints bench/results/predict.md. usage: bench_predictions PLANS [TESTS [AGAIN [NAME...]]]
//
// PLANS: the folder of plans. Each is simulated with seeds 1 to TESTS (100); the standard deviation of every parameter over
// the tests is compared with the predicted one. Where one is outside of 0.8 to 1.25, AGAIN tests (400) are made. NAME: only
// these plans.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tumble/math/parallel.hpp"
#include "tumble/tasks/calibration.hpp"
#include "tumble/tasks/prediction/simulated_tests.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/error.hpp"

namespace {

using namespace tumble;

constexpr double low = 0.8, high = 1.25;  // wanted
constexpr std::size_t least_tests = 20;   // that show a parameter
constexpr double known = 200.0;           // degrees of freedom from which most of an uncertainty is known beforehand,
constexpr double far_below = 0.6;         // where values scatter so much less

struct Tests {
  std::map<std::string, std::vector<double>> values, sds;  // [SI] by parameter
  std::size_t made = 0, refused = 0;
};

/// On all processors.
void add_tests(const Plan& plan, std::size_t up_to, Tests& tests) {
  const std::size_t before = tests.made;
  std::vector<std::optional<Estimate>> made(up_to > before ? up_to - before : 0);
  parallel_for(made.size(), [&](std::size_t i) {
    try {
      made[i] = prediction::simulated_test(plan, before + i + 1);
    } catch (const Error&) {
    }
  });
  for (const auto& estimate : made) {
    ++tests.made;
    if (!estimate) ++tests.refused;
    for (std::size_t i = 0; estimate && i < estimate->parameters.size(); ++i) {
      tests.values[estimate->parameters[i].name].push_back(estimate->parameters[i].value);
      tests.sds[estimate->parameters[i].name].push_back(standard_uncertainty(*estimate, i));
    }
  }
}

double mean_of(const std::vector<double>& values) {
  double mean = 0.0;
  for (const double v : values) mean += v / static_cast<double>(values.size());
  return mean;
}

double scatter_of(const std::vector<double>& values) {
  const double mean = mean_of(values);
  double squares = 0.0;
  for (const double v : values) squares += (v - mean) * (v - mean);
  return std::sqrt(squares / static_cast<double>(values.size() - 1));
}

double median_of(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

struct Row {
  std::string name, unit;
  std::size_t tests;
  double scatter, predicted, stated;  // in the unit
  double freedom;                     // degrees of freedom that are predicted

  double ratio() const { return scatter / predicted; }
  /// What a data sheet says is in the promise, and no simulation draws it.
  bool not_drawn() const { return ratio() < far_below && freedom > known; }
  bool outside() const { return !not_drawn() && !(ratio() >= low && ratio() <= high); }
};

std::vector<Row> rows_of(const Estimate& predicted, const Tests& tests) {
  std::vector<Row> rows;
  for (std::size_t i = 0; i < predicted.parameters.size(); ++i) {
    const auto& parameter = predicted.parameters[i];
    const double unit = parameter.unit.factor(), sd = standard_uncertainty(predicted, i);
    const auto found = tests.values.find(parameter.name);
    if (found == tests.values.end() || found->second.size() < least_tests || !(sd > 0.0)) continue;
    const double mean = mean_of(found->second);
    // A scale factor of counts is predicted as that of a rate: both are taken relative to their values.
    const bool relative = parameter.name == "scale_factor" && std::abs(mean / parameter.value - 1.0) > 0.5;
    const double as = relative ? parameter.value / mean / unit : 1.0 / unit;
    rows.push_back({parameter.name, parameter.unit.text(), found->second.size(), scatter_of(found->second) * as,
                    sd / unit, median_of(tests.sds.at(parameter.name)) * as, parameter.degrees_of_freedom});
  }
  return rows;
}

struct Compared {
  std::string summary, outside;
};

Compared compared(const std::string& name, Plan plan, std::size_t first, std::size_t again) {
  Compared out;
  Estimate predicted;
  try {
    predicted = predict(plan);
    read_calibration(plan);
  } catch (const Error& error) {
    out.summary = fmt::format("| `{}` | refused: {} | | | | |\n", name, error.what());
    return out;
  }
  Tests tests;
  add_tests(plan, first, tests);
  auto rows = rows_of(predicted, tests);
  if (std::ranges::any_of(rows, &Row::outside)) add_tests(plan, again, tests), rows = rows_of(predicted, tests);
  double least = INFINITY, most = 0.0;
  std::size_t outside = 0, not_drawn = 0;
  for (const auto& row : rows) {
    if (row.not_drawn()) {
      ++not_drawn;
      continue;
    }
    least = std::min(least, row.ratio()), most = std::max(most, row.ratio());
    if (!row.outside()) continue;
    ++outside;
    out.outside += fmt::format("| `{}` | `{}` [{}] | {} | {:.4g} | {:.4g} | {:.2f} | {:.4g} |\n", name, row.name,
                               row.unit, row.tests, row.scatter, row.predicted, row.ratio(), row.stated);
  }
  out.summary = fmt::format("| `{}` | {} ({} refused) | {} | {:.2f} to {:.2f} | {} | {} |\n", name, tests.made,
                            tests.refused, rows.size() - not_drawn, least, most, outside, not_drawn);
  return out;
}

}  // namespace

int main(int count, char** words) {
  const std::string folder = count > 1 ? words[1] : "plans";
  const std::size_t first = count > 2 ? std::strtoul(words[2], nullptr, 10) : 100;
  const std::size_t again = count > 3 ? std::strtoul(words[3], nullptr, 10) : 400;
  const std::vector<std::string> wanted(words + std::min(count, 4), words + count);
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().extension() == ".toml") files.push_back(entry.path());
  std::ranges::sort(files);
  fmt::print(
      "# What predict promises, and how tests scatter\n\n"
      "Each ready plan that has a method: the scatter of {} simulated and identified tests over the predicted standard "
      "uncertainty, for\n"
      "every parameter. Wanted: {} to {}. With 100 tests a right prediction gives 0.82 to 1.19 (99 %). A plan with a "
      "parameter outside\n"
      "has {} tests. *Not drawn*: parameters whose promise is mostly a data sheet's, which no simulation draws; they "
      "scatter less.\n\n"
      "| plan | tests | parameters | scatter over prediction | outside | not drawn |\n|---|---:|---:|---:|---:|---:|\n",
      first, low, high, again);
  std::string outside;
  for (const auto& file : files) {
    const std::string name = file.stem().string();
    if (!wanted.empty() && std::ranges::find(wanted, name) == wanted.end()) continue;
    Plan plan = load_plan(file.string(), {});
    if (plan.method.empty()) continue;
    const auto found = compared(name, std::move(plan), first, again);
    fmt::print("{}", found.summary);
    std::fflush(stdout);
    outside += found.outside;
  }
  if (!outside.empty())
    fmt::print(
        "\nParameters outside; *stated* is the median of what `identify` states.\n\n"
        "| plan | parameter | tests | scatter | predicted | ratio | stated |\n|---|---|---:|---:|---:|---:|---:|\n{}",
        outside);
}
