// Does every method hold, or say what happened, where a test is not carried out as planned? Its first trial, every departure
// that the channels allow, three sizes, ten seeds (decision 117). script/departures runs all of it and writes the matrix.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <set>
#include <string>

#include "matrix.hpp"

namespace tumble::departures {

namespace {

constexpr std::size_t seeds = 10;  // most_rms and least_named are derived for them
/// Of the limit: processors round unlike one another, and a cell this near to it is silent on one and held on the other.
constexpr double near_limit = 0.1;

/// The share of the cells [%] that TUMBLE_DEPARTURES asks for.
double share() {
  const char* text = std::getenv("TUMBLE_DEPARTURES");
  return text == nullptr ? 0.0 : std::strtod(text, nullptr);
}

/// Cells that were silent when the matrix was last written, one a line. What is mended is removed.
std::set<std::string> known_silent() {
  std::set<std::string> cells;
  std::ifstream file(std::string(TUMBLE_SOURCE_DIR) + "/tests/departures/silent.txt");
  for (std::string line; std::getline(file, line);)
    if (!line.empty() && line.front() != '#') cells.insert(line);
  return cells;
}

/// Into the folder of TUMBLE_DEPARTURES_TO, for the script.
void write(const Method& method, const Matrix& matrix) {
  if (const char* folder = std::getenv("TUMBLE_DEPARTURES_TO"))
    std::ofstream(fmt::format("{}/{}.txt", folder, method.name)) << text_of(method, matrix);
}

class Departures : public ::testing::TestWithParam<const Method*> {};

TEST_P(Departures, AreHeldOrNamed) {
  if (!(share() > 0.0)) GTEST_SKIP() << "TUMBLE_DEPARTURES says how many per cent of the cells are run";
  const Matrix matrix = matrix_of(*GetParam(), share(), seeds);
  write(*GetParam(), matrix);
  EXPECT_GT(matrix.judged, 0u) << "the result has no parameter of the truth: nothing is judged";
  const std::set<std::string> known = known_silent();
  for (const Row& row : matrix.rows) {
    const bool silent = row.verdict.handling == Handling::silent;
    if (silent == known.contains(row.cell)) continue;
    if (std::abs(row.verdict.worst_rms / most_rms - 1.0) < near_limit) continue;
    ADD_FAILURE() << row.cell << " is " << (silent ? "silent: " : "no longer silent; remove it from silent.txt: ")
                  << fmt::format("{} is off by {:.1f} sd (rms)", row.parameter, row.verdict.worst_rms);
  }
}

INSTANTIATE_TEST_SUITE_P(FirstTrials, Departures, ::testing::ValuesIn(method_catalogue()),
                         [](const auto& entry) { return std::string(entry.param->name); });

}  // namespace
}  // namespace tumble::departures
