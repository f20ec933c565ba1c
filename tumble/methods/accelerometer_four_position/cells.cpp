#include "tumble/methods/accelerometer_four_position/cells.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "tumble/units/error.hpp"

namespace tumble::accelerometer_four_position {
namespace {

const char* words_of(const Position& position) {
  if (position.place == Place::up) return "1 (input axis up)";
  if (position.place == Place::down) return "3 (input axis down)";
  if (position.o_level) return position.upwards ? "2 (output axis up)" : "4 (output axis down)";
  return position.upwards ? "2 (pendulum axis up)" : "4 (pendulum axis down)";
}

/// A cell to which positions are added.
struct Open {
  std::optional<std::size_t> slots[4];  ///< positions 1 to 4
  double first_temperature = 0.0;
  bool empty = true;
};

std::size_t slot_of(const Position& position) {
  if (position.place == Place::up) return 0;
  if (position.place == Place::down) return 2;
  return position.upwards ? 1 : 3;
}

/// A cell that lacks positions.
struct Lack {
  int run = 1;
  double temperature = 0.0;                           ///< [K]
  std::vector<std::size_t> missing;                   ///< positions 1 to 4
  const Position *twice = nullptr, *again = nullptr;  ///< two of its segments that hold the same position; null: none
};

Sentence problem_of(const Lack& lack) {
  const char* names[4] = {"1 (input axis up)", "2 (level)", "3 (input axis down)", "4 (level, turned over against 2)"};
  std::vector<Sentence> missing;
  for (const std::size_t number : lack.missing) missing.emplace_back(names[number - 1]);
  const Sentence twice = lack.twice ? say("; segments '{}' and '{}' both hold position {}", lack.twice->label,
                                          lack.again->label, Sentence(std::string(words_of(*lack.again)).c_str()))
                                    : Sentence();
  return say("run {}, {}: position {} missing{}", lack.run, Name{in_words(lack.temperature)},
             in_a_row(missing, " and "), twice);
}

Finding finding_of(const Lack& lack) {
  std::vector<FindingValue> values{{"run", lack.run},
                                   {"temperature", lack.temperature, "degC"},
                                   {"missing", fmt::format("{}", fmt::join(lack.missing, ", "))}};
  if (lack.twice) {
    values.emplace_back("segment", lack.twice->label);
    values.emplace_back("other", lack.again->label);
    values.emplace_back("position", slot_of(*lack.again) + 1);
  }
  return {Finding::Severity::warning, lack.twice ? "position_missing_other_twice" : "position_missing", values};
}

class Cells {
 public:
  Cells(Bench& bench, bool all_four, double same) : bench_(bench), all_four_(all_four), same_(same) {}

  void add(std::size_t index) {
    const Position& position = bench_.positions[index];
    const std::size_t slot = slot_of(position);
    const bool elsewhere =
        !open_.empty && (position.power_up != bench_.positions[last_].power_up ||
                         std::abs(position.temperature - open_.first_temperature) > same_ || other_axis(position));
    if (elsewhere) close();
    if (open_.slots[slot]) close(&bench_.positions[*open_.slots[slot]], &position);
    if (open_.empty) open_.first_temperature = position.temperature;
    open_.empty = false;
    open_.slots[slot] = last_ = index;
  }

  /// Ends the cell. Given: two segments that hold the same position, where that is why it ends.
  void close(const Position* twice = nullptr, const Position* again = nullptr) {
    if (open_.empty) return;
    const Position& position = bench_.positions[last_];
    Lack lack{position.run, position.temperature, {}, twice, again};
    for (std::size_t k = 0; k < 4; ++k)
      if (!open_.slots[k] && (all_four_ || k % 2 == 0)) lack.missing.push_back(k + 1);
    if (lack.missing.empty())
      push();
    else
      lacks_.push_back(std::move(lack));
    open_ = {};
  }

  const std::vector<Lack>& lacks() const { return lacks_; }

 private:
  bool other_axis(const Position& position) const {
    return position.place == Place::level && std::ranges::any_of(open_.slots, [&](const auto& slot) {
             return slot && bench_.positions[*slot].place == Place::level &&
                    bench_.positions[*slot].o_level != position.o_level;
           });
  }

  void push() {
    Cell cell{.up = *open_.slots[0], .down = *open_.slots[2], .power_up = bench_.positions[last_].power_up};
    cell.run = bench_.positions[last_].run;
    if (all_four_) {
      cell.second = open_.slots[1];
      cell.fourth = open_.slots[3];
      cell.o_level = bench_.positions[*cell.second].o_level;
    }
    double low = INFINITY, high = -INFINITY, count = 0.0;
    for (std::size_t k = 0; k < 4; ++k) {
      if (!open_.slots[k] || (!all_four_ && k % 2 == 1)) continue;
      const double t = bench_.positions[*open_.slots[k]].temperature;
      cell.temperature += t;
      low = std::min(low, t);
      high = std::max(high, t);
      count += 1.0;
    }
    cell.temperature /= count;
    cell.spread = high - low;
    bench_.cells.push_back(cell);
  }

  Bench& bench_;
  bool all_four_;
  double same_;
  Open open_;
  std::size_t last_ = 0;
  std::vector<Lack> lacks_;
};

[[noreturn]] void refuse_without_cells(const std::vector<Lack>& lacks) {
  Problems problems;
  for (const auto& lack : lacks) problems.push_back(problem_of(lack));
  if (problems.empty()) problems.push_back("no segment holds the instrument with an axis up or down");
  problems.push_back(
      "the method needs four positions at each temperature: input axis up, level, down, and level turned over; the "
      "axes of the rig show which is which");
  throw Error(Error::Kind::bad_data, problems);
}

/// Sets in which the scale factor has the other sign than in most: they would spoil those that are sound.
void drop_turned_sets(Bench& bench) {
  const auto falls = [&](const Cell& cell) {
    return bench.positions[cell.up].output < bench.positions[cell.down].output;
  };
  const auto turned = std::ranges::count_if(bench.cells, falls);
  if (turned == 0 || 2 * turned >= static_cast<std::ptrdiff_t>(bench.cells.size())) return;
  std::vector<std::string> names;
  double ratio = 0.0;
  for (const Cell& cell : bench.cells) {
    if (!falls(cell)) continue;
    names.push_back(fmt::format("run {}: {}", cell.run, in_words(cell.temperature)));
    const auto &up = bench.positions[cell.up], &down = bench.positions[cell.down];
    ratio = std::min(ratio, (up.output - down.output) / (2.0 * up.gravity));
  }
  bench.findings.push_back({Finding::Severity::error,
                            "turned_set_not_used",
                            {{"sets", fmt::format("{}", fmt::join(names, ", "))}, {"ratio", ratio, "1"}},
                            "",
                            {names.size(), names.front(), {}}});
  std::erase_if(bench.cells, falls);
}

/// Groups of cells whose temperatures are closer than `same` [K] to that of the next.
void set_groups(double same, Bench& bench) {
  std::vector<std::size_t> order(bench.cells.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](std::size_t c) { return bench.cells[c].temperature; });
  std::vector<double> counts;
  double before = -INFINITY;
  for (const std::size_t c : order) {
    Cell& cell = bench.cells[c];
    if (cell.temperature - before > same) {
      bench.group_temperature.push_back(0.0);
      counts.push_back(0.0);
    }
    before = cell.temperature;
    cell.group = counts.size() - 1;
    bench.group_temperature.back() += cell.temperature;
    counts.back() += 1.0;
  }
  for (std::size_t k = 0; k < counts.size(); ++k) bench.group_temperature[k] /= counts[k];
}

}  // namespace

void drop_soaks(double same, Bench& bench) {
  const auto& all = bench.positions;
  std::vector<Position> kept;
  for (std::size_t i = 0; i < all.size(); ++i) {
    bool again = false;
    for (std::size_t k = i + 1; k < all.size() && !again && all[i].commands_temperature; ++k) {
      if (all[k].commands_temperature || all[k].power_up != all[i].power_up ||
          std::abs(all[k].temperature - all[i].temperature) > same)
        break;
      again = slot_of(all[k]) == slot_of(all[i]);
    }
    if (!again) kept.push_back(all[i]);
  }
  bench.positions = std::move(kept);
}

void add_cells(const Settings& settings, Bench& bench) {
  const double same = settings.number("same_temperature");
  Cells cells(bench, settings.word("estimator") == "four_positions", same);
  for (std::size_t i = 0; i < bench.positions.size(); ++i) cells.add(i);
  cells.close();
  if (bench.cells.empty()) refuse_without_cells(cells.lacks());
  for (const auto& lack : cells.lacks()) bench.findings.push_back(finding_of(lack));
  drop_turned_sets(bench);
  set_groups(same, bench);
}

}  // namespace tumble::accelerometer_four_position
