// Does every method hold, or say what happened, where a test is not carried out as planned? Its first trial, every departure
// that the channels allow, three sizes, ten seeds (decision 117). script/departures runs all of it and writes the matrix.

#include <fmt/format.h>
#include <fmt/ranges.h>
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

/// Sound tests of a method, with all cells and with some, and how many of them may get a warning: more have p < 1e-3 where one
/// in a hundred does. The seeds are not those of the cells.
struct SoundTests {
  std::size_t count, most_warned;
};
constexpr SoundTests sound_of_all{100, 5}, sound_of_some{10, 2};
constexpr std::uint64_t first_sound = 1001;

/// The share of the cells [%] that TUMBLE_DEPARTURES asks for.
double share() {
  const char* text = std::getenv("TUMBLE_DEPARTURES");
  return text == nullptr ? 0.0 : std::strtod(text, nullptr);
}

Drawn drawn() {
  const char* departure = std::getenv("TUMBLE_DEPARTURES_OF");
  return {share(), departure == nullptr ? "" : departure};
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
  const Matrix matrix = matrix_of(*GetParam(), drawn(), seeds);
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

TEST_P(Departures, AccuseNoSoundTest) {
  if (!(share() > 0.0)) GTEST_SKIP() << "TUMBLE_DEPARTURES says how many per cent of the cells are run";
  const SoundTests asked = share() < 100.0 ? sound_of_some : sound_of_all;
  const Accusations found = accusations_of(*GetParam(), first_sound, asked.count);
  if (const char* folder = std::getenv("TUMBLE_DEPARTURES_TO"))
    std::ofstream(fmt::format("{}/{}.sound.txt", folder, GetParam()->name))
        << fmt::format("accused\t{}\t{}\t{}\t{}\t{}\n", GetParam()->name, found.tests, found.warned, found.refused,
                       fmt::join(found.codes, " "));
  EXPECT_EQ(found.refused, 0u) << fmt::format("{}", fmt::join(found.codes, " "));
  EXPECT_LE(found.warned, asked.most_warned) << fmt::format("{}", fmt::join(found.codes, " "));
}

INSTANTIATE_TEST_SUITE_P(FirstTrials, Departures, ::testing::ValuesIn(method_catalogue()),
                         [](const auto& entry) { return std::string(entry.param->name); });

}  // namespace
}  // namespace tumble::departures
