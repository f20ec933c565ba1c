// A long run: memory and file handles at its end are those of its first hour. TUMBLE_SOAK_HOURS says how long, 2 h by
// default, 72 h in script/test --full.
#include <gtest/gtest.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/rehearsal/rehearse.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/constants.hpp"

namespace tumble {
namespace {

double soak_hours() {
  const char* const text = std::getenv("TUMBLE_SOAK_HOURS");
  if (text == nullptr) return 2.0;
  double hours = 0.0;
  const std::string_view word = text;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), hours);
  if (error == std::errc() && end == word.data() + word.size() && hours >= 1.0) return hours;
  throw std::invalid_argument("TUMBLE_SOAK_HOURS: a number from 1 is accepted");
}

/// What this process holds.
struct Holding {
  std::size_t handles = 0;
  double memory = 0.0;  ///< [byte] resident
};

Holding holding() {
  Holding now;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) ++now.handles;
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmRSS:")) now.memory = 1024.0 * std::strtod(line.c_str() + 6, nullptr);
  return now;
}

TEST(RehearsedSoak, HoldsNoMoreAtTheEndThanAfterTheFirstPart) {
  const double hours = soak_hours();
  const ScratchFolder scratch;
  Rehearsal rehearsal;
  rehearsal.plan = load_plan(TUMBLE_SOURCE_DIR "/plans/gyro_scale_factor.toml", {});
  Schedule schedule;
  for (double planned = 0.0; planned < hours * hour; planned += 600.0) {  // segment after segment, ten minutes each
    schedule.push_back(rehearsal.plan.schedule[schedule.size() % rehearsal.plan.schedule.size()]);
    schedule.back().label += " " + std::to_string(schedule.size());
    schedule.back().duration = 600.0;
  }
  rehearsal.plan.schedule = schedule;
  rehearsal.plan.text.reset();
  rehearsal.plan.file.clear();
  rehearsal.folder = scratch.file("run");
  Holding first, last;
  rehearsal.company.show_every = 60.0;
  rehearsal.company.show = [&](const RunView& view) {
    last = holding();
    if (view.time < std::min(1.0, 0.5 * hours) * hour) first = last;
  };
  const Rehearsed rehearsed = rehearse(rehearsal);
  EXPECT_EQ(rehearsed.end.ending, RunEnding::complete) << rehearsed.end.text.text();
  EXPECT_GT(rehearsed.simulated, hours * hour);
  EXPECT_EQ(last.handles, first.handles);
  // What waits for the disk is 16 MiB at most (rehearse), and its copy in the writer; an item that was never given
  // back, 100 bytes a sample at 10 Hz, would be 250 MB in 72 h.
  EXPECT_LT(last.memory - first.memory, 64.0 * 1024 * 1024) << first.memory << " " << last.memory;
  RecordProperty("handles", static_cast<int>(last.handles));
  RecordProperty("megabytes", static_cast<int>(last.memory / 1e6));
  std::printf("%.0f h: %zu handles and %.0f MB in the first part, %zu and %.0f MB at the end\n", hours, first.handles,
              first.memory / 1e6, last.handles, last.memory / 1e6);
}

}  // namespace
}  // namespace tumble
