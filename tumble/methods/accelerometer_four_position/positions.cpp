#include "tumble/methods/accelerometer_four_position/positions.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "tumble/methods/accelerometer_four_position/counts.hpp"
#include "tumble/methods/accelerometer_four_position/halves.hpp"
#include "tumble/reduce/accelerometer/samples.hpp"
#include "tumble/reduce/pulses/rounding.hpp"
#include "tumble/units/error.hpp"

namespace tumble::accelerometer_four_position {
namespace {

constexpr double near_axis = 0.05;  ///< [rad] by which an axis may lean and still count as vertical
constexpr double one_row = 1e9;     ///< [s] longer than any segment: one row for each

linear::Problem problem_of(const Settings& settings, const std::string& role) {
  linear::Problem problem;
  problem.role = role;
  problem.input = Input::specific_force_x;
  problem.settling = settings.number("settling");
  problem.averaging = one_row;
  return problem;
}

/// Commanded temperature over a stretch: its mean, and that of the second half minus that of the first.
void set_commanded_temperature(const PowerUp& power_up, const Stretch& stretch, Position& position) {
  constexpr std::size_t points = 16;
  std::vector<Felt> felt(points);
  const double length = stretch.duration(), step = length / points;
  power_up.reference.felt(stretch.first + 0.5 * step, step, felt);
  double halves[2] = {0.0, 0.0};
  for (std::size_t k = 0; k < points; ++k) halves[2 * k / points] += 2.0 / points * felt[k].temperature;
  position.temperature = 0.5 * (halves[0] + halves[1]);
  position.temperature_drift = halves[1] - halves[0];
}

/// Measured temperature over a stretch, likewise. Returned: false where the channel has no samples there.
bool set_measured_temperature(const Channel& channel, const Stretch& stretch, Position& position) {
  const Halves read = halves_of(channel, channel.values, stretch);
  if (!std::isfinite(read.mean)) return false;
  position.temperature = read.mean;
  position.temperature_drift = read.change;
  return true;
}

void set_place(const Felt& felt, Position& position) {
  const Vector3 f = felt.specific_force;
  position.gravity = norm(f);
  const double lean = std::cos(near_axis) * position.gravity;
  if (std::abs(f.x) > lean) position.place = f.x > 0.0 ? Place::up : Place::down;
  for (const bool o : {false, true}) {
    const double along = o ? f.z : f.y;
    if (!(std::abs(along) > lean)) continue;
    position.place = Place::level;
    position.o_level = o;
    position.upwards = along > 0.0;
  }
}

/// Scatter of the averages within a stretch, as a density.
void set_scatter(const Stretch& stretch, double averaging, Position& position) {
  const auto wanted = static_cast<std::size_t>(std::llround(averaging / stretch.step));
  const std::size_t each = std::max<std::size_t>(1, std::min(wanted, stretch.values.size() / 4));
  position.averaging = static_cast<double>(each) * stretch.step;
  std::vector<double> means;
  for (std::size_t first = 0; first + each <= stretch.values.size(); first += each) {
    double sum = 0.0;
    for (std::size_t i = first; i < first + each; ++i) sum += stretch.values[i];
    if (std::isfinite(sum)) means.push_back(sum / static_cast<double>(each));
  }
  if (means.size() < 2) return;
  double mean = 0.0;
  for (const double m : means) mean += m / static_cast<double>(means.size());
  for (const double m : means) position.squares += (m - mean) * (m - mean);
  position.squares *= position.averaging;
  position.freedom = static_cast<double>(means.size() - 1);
}

/// Whether a segment commands the temperature alone, for the instrument to soak.
bool is_soak(const Segment& segment) { return segment.axes.size() == 1 && segment.axes.contains("temperature"); }

void add_positions(const Evidence* measured, double averaging, Bench& bench) {
  std::map<std::size_t, std::size_t> power_ups;
  std::vector<std::string> skipped;
  bench.measured_temperature = measured != nullptr;
  for (std::size_t g = 0; g < bench.evidence.test.stretches.size(); ++g) {
    const auto& stretch = bench.evidence.test.stretches[g];
    const auto& power_up = bench.evidence.test.power_ups[stretch.power_up];
    const auto& segment = power_up.rig.segments[stretch.segment];
    if (is_soak(segment)) continue;
    Position position{.stretch = g, .label = stretch.label, .run = stretch.run};
    position.commands_temperature = segment.axes.contains("temperature");
    position.power_up = power_ups.try_emplace(stretch.start, power_ups.size()).first->second;
    position.output = bench.rows.segments[g].measured;
    position.seconds = bench.rows.segments[g].duration;
    set_place(bench.rows.segments[g].felt, position);
    set_commanded_temperature(power_up, stretch, position);
    const Channel* thermometer =
        measured ? channel_for(*measured, measured->recordings[stretch.recording], "temperature") : nullptr;
    if (!thermometer || !set_measured_temperature(*thermometer, stretch, position)) bench.measured_temperature = false;
    set_scatter(stretch, averaging, position);
    if (position.place == Place::none) {
      skipped.push_back(stretch.label);
      continue;
    }
    bench.positions.push_back(std::move(position));
  }
  if (!skipped.empty())
    bench.findings.push_back({Finding::Severity::warning,
                              "no_axis_vertical",
                              {{"segments", accelerometer::all_quoted(skipped)}},
                              "",
                              {skipped.size(), {}, {}}});
}

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

/// Drops segments that hold angles too while the temperature is reached: the mount, or where the head stands. Such a
/// one commands the temperature, and a later one does not that holds the same position at this temperature.
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

/// Level of the white noise: the scatter of the averages, from which the rounding to pulses, of variance 1/6 pulse^2
/// each, is subtracted (3.14).
void set_white(Bench& bench) {
  double squares = 0.0, rounding = 0.0;
  for (const auto& position : bench.positions) {
    if (!(position.freedom > 0.0)) continue;
    squares += position.squares;
    bench.white_freedom += position.freedom;
    // n roundings correlated by -1/2 with their neighbours: squares about the mean of (n - 1/n) variances
    const double n = position.freedom + 1.0;
    rounding += (n - 1.0 / n) * position.averaging * pulses::rounding_variance(bench.pulse, position.averaging);
  }
  if (bench.white_freedom > 0.0) bench.white = std::max(0.0, (squares - rounding) / bench.white_freedom);
}

/// Whether a finding speaks of a segment in which the instrument soaks: no sample of it is needed.
bool about_soak(const Bench& bench, const Finding& finding) {
  if (finding.code != "segment_not_used") return false;
  const auto* label = std::get_if<std::string>(&finding.values.front().value);
  const auto soaks = [&](const Segment& segment) { return is_soak(segment) && label && segment.label == *label; };
  return std::ranges::any_of(bench.evidence.test.power_ups, [&](const PowerUp& power_up) {
    return std::ranges::any_of(power_up.rig.segments, soaks);
  });
}

/// The positions and cells of a bench whose output, scale factor and `evidence` are set.
void complete(const Settings& settings, const Evidence* measured, Bench& bench) {
  bench.rows = linear::rows_of(bench.evidence, bench.problem);
  for (const auto& finding : bench.evidence.test.findings)
    if (!about_soak(bench, finding)) bench.findings.push_back(finding);
  add_positions(measured, settings.number("averaging"), bench);
  drop_soaks(settings.number("same_temperature"), bench);
  if (measured) refuse_overflow(bench);
  add_cells(settings, bench);
  if (measured) set_white(bench);
}

void set_scale(double reference, const accelerometer::Output& output, Bench& bench) {
  bench.output = output;
  bench.reference_scale_factor = reference;
  if (output.pulses) bench.pulse = 1.0 / std::abs(reference);
}

}  // namespace

std::string in_words(double temperature) {
  return fmt::format("{:.1f} degC", std::round(10.0 * (temperature - 273.15)) / 10.0 + 0.0);
}

Bench bench_of(const Evidence& evidence, const std::string& role) {
  if (evidence.recordings.empty()) throw Error(Error::Kind::bad_data, "there is no recording to identify from");
  const Settings& settings = evidence.plan.settings;
  const Channel& channel = require_channel(evidence, evidence.recordings.front(), role);
  Bench bench;
  set_scale(accelerometer::required_scale_factor(settings, channel), accelerometer::output_of(channel), bench);
  bench.problem = problem_of(settings, role);
  bench.problem.scale = 1.0 / bench.reference_scale_factor;
  bench.problem.pulse = bench.pulse;
  bench.measured = &evidence;
  bench.rates = std::make_shared<const Evidence>(per_second(evidence, role, bench.findings));
  bench.evidence = linear::evidence_of(*bench.rates, bench.problem);
  complete(settings, &evidence, bench);
  return bench;
}

Bench bench_of(const Plan& plan) {
  Bench bench;
  set_scale(accelerometer::scale_factor_of(plan.truth), accelerometer::output_of(plan.truth, plan.sample_rate), bench);
  bench.problem = problem_of(plan.settings, "accelerometer");
  bench.evidence = linear::evidence_of(plan, bench.problem);
  complete(plan.settings, nullptr, bench);
  return bench;
}

}  // namespace tumble::accelerometer_four_position
