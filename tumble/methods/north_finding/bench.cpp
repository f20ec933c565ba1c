#include "tumble/methods/north_finding/bench.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tumble/clocks/sampling_rate.hpp"
#include "tumble/core/attempt.hpp"
#include "tumble/reduce/linear/linear.hpp"
#include "tumble/reduce/pulses/rounding.hpp"
#include "tumble/sim/power_up.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::north_finding {
namespace {

constexpr double whole_block = 1e-6;  ///< [1] of its length, within which a block has all of its samples

constexpr std::size_t most_revolutions = 40;  ///< of one segment, that have slow noise of their own

/// Four points of Gauss and Legendre: exact to 1e-10 over a tenth of a turn.
constexpr std::array<double, 4> nodes{0.069431844202973712, 0.33000947820757187, 0.66999052179242813,
                                      0.93056815579702629};
constexpr std::array<double, 4> node_weights{0.17392742256872693, 0.32607257743127307, 0.32607257743127307,
                                             0.17392742256872693};

/// To a thousandth of what any encoder shows, so that 0 is 0.
double angle_of(const View& view) { return 1e-12 * std::round(1e12 * std::atan2(view.turn.x.y, view.turn.x.x)); }

linear::Problem problem_of(Channel channel, const Recorded& recorded, const Settings& settings) {
  linear::Problem problem;
  problem.role = role_of(channel);
  problem.scale = recorded.per_second;
  problem.pulse = recorded.pulses ? 1.0 : 0.0;
  problem.settling = settings.number("settling");
  problem.averaging = settings.number("averaging");
  return problem;
}

/// Number of the revolution, among equal parts of the stretch, in which a block lies.
std::size_t revolution_of(const Stretch& stretch, std::size_t per_block, std::size_t block, double rate) {
  const double turns = std::abs(rate) * stretch.duration() / two_pi;
  const auto parts = std::clamp(static_cast<std::size_t>(turns), std::size_t{1}, most_revolutions);
  const std::size_t blocks = (stretch.samples + per_block - 1) / per_block;
  return std::min(parts - 1, block * parts / blocks);
}

/// Rows, positions and which block belongs to which, from the attitudes of the rig without errors.
class Reader {
 public:
  Reader(const Rotation& base, Signal& signal) : base_(base), signal_(signal) {
    for (const auto& power_up : signal.evidence.test.power_ups) attitudes_.emplace_back(power_up, Matrix());
  }

  void read(const std::vector<double>& rounding) {
    const auto& blocks = signal_.blocks;
    signal_.row_of.assign(blocks.weights.size(), npos);
    std::size_t b = 0;
    for (std::size_t g = 0; g < signal_.evidence.test.stretches.size(); ++g) {
      const std::size_t first = b;
      while (b < blocks.segment.size() && blocks.segment[b] == g) ++b;
      const auto& stretch = signal_.evidence.test.stretches[g];
      stretch.steady ? add_stay(g, first, b, rounding) : add_turn(g, first, b);
    }
  }

 private:
  const Attitude& attitude(std::size_t g) const { return attitudes_[signal_.evidence.test.stretches[g].power_up]; }

  void open_position(std::size_t g, double begin, double length) {
    const auto& stretch = signal_.evidence.test.stretches[g];
    const auto& power_up = signal_.evidence.test.power_ups[stretch.power_up];
    const View view = attitude(g).at(begin + (stretch.steady ? 0.5 * length : 0.0), base_);
    signal_.positions.push_back({stretch.label,
                                 stretch.run,
                                 stretch.steady,
                                 angle_of(view),
                                 view.spin.z,
                                 {stretch.start, power_up.offset + begin, length}});
  }

  void set_position(std::size_t g, double middle, Row& row) const {
    row.power_up = signal_.evidence.test.stretches[g].power_up;
    row.run = signal_.evidence.test.stretches[g].run;
    row.start = signal_.evidence.test.stretches[g].start;
    row.at = middle;
  }

  void add_stay(std::size_t g, std::size_t first, std::size_t end, const std::vector<double>& rounding) {
    const auto& blocks = signal_.blocks;
    const auto& stretch = signal_.evidence.test.stretches[g];
    const double length = stretch.duration();
    open_position(g, stretch.first, length);
    Row row{.channel = signal_.channel, .position = signal_.positions.size() - 1};
    for (std::size_t b = first; b < end; ++b) {
      const double w = blocks.weights[b];
      row.seconds += w;
      row.time += w * blocks.time[b];
      row.output += blocks.output.empty() ? NAN : w * blocks.output[b];
      signal_.row_of[b] = signal_.rows.size();
    }
    row.time = row.time / row.seconds + signal_.evidence.test.power_ups[stretch.power_up].offset;
    row.output /= row.seconds;
    row.rounding_sd = rounding.empty() ? 0.0 : rounding[first];
    set_position(g, stretch.first + 0.5 * length, row);
    row.views = {attitude(g).at(row.at, base_)};
    signal_.rows.push_back(std::move(row));
  }

  void add_turn(std::size_t g, std::size_t first, std::size_t end) {
    const auto& blocks = signal_.blocks;
    const auto& stretch = signal_.evidence.test.stretches[g];
    const std::size_t per_block = signal_.evidence.blocking[g].per_block;
    const double rate = attitude(g).at(stretch.first, base_).spin.z;
    std::size_t last = npos, next = npos;
    for (std::size_t b = first; b < end; ++b) {
      const std::size_t begin = blocks.block[b] * per_block;
      const std::size_t size = std::min(per_block, stretch.samples - begin);
      const double length = static_cast<double>(size) * stretch.step;
      if (std::abs(blocks.weights[b] - length) > whole_block * length)
        continue;  // where samples are missing it is no mean
      const double from = stretch.first + static_cast<double>(begin) * stretch.step;
      if (const std::size_t part = revolution_of(stretch, per_block, blocks.block[b], rate); part != last) {
        open_position(g, from, 0.0);
        last = part;
      }
      auto& position = signal_.positions.back();
      position.interval.length =
          signal_.evidence.test.power_ups[stretch.power_up].offset + from + length - position.interval.begin;
      Row row{.channel = signal_.channel, .position = signal_.positions.size() - 1, .seconds = length};
      row.time = blocks.time[b] + signal_.evidence.test.power_ups[stretch.power_up].offset;
      row.output = blocks.output.empty() ? NAN : blocks.output[b];
      row.reading_sd = signal_.problem.pulse * std::sqrt(pulses::reading_variance) / length;
      row.follows = b == next;
      next = b + 1;
      set_position(g, from + 0.5 * length, row);
      for (std::size_t k = 0; k < nodes.size(); ++k) {
        row.views.push_back(attitude(g).at(from + nodes[k] * length, base_));
        row.views.back().weight = node_weights[k];
      }
      signal_.row_of[b] = signal_.rows.size();
      signal_.rows.push_back(std::move(row));
    }
  }

  Rotation base_;
  Signal& signal_;
  std::vector<Attitude> attitudes_;
};

void read_rows(const Rotation& base, Signal& signal) {
  signal.blocks = linear::rows_of(signal.evidence, signal.problem);
  std::vector<double> rounding;
  if (signal.problem.pulse > 0.0)
    rounding = linear::take_out_counting(signal.evidence, signal.problem, signal.blocks).column;
  Reader(base, signal).read(rounding);
}

void set_middle(Bench& bench) {
  double first = 0.0, last = 0.0;
  bool any = false;
  for (const auto& position : bench.signals.front().positions) {
    const double begin = position.interval.begin, end = begin + position.interval.length;
    first = any ? std::min(first, begin) : begin;
    last = any ? std::max(last, end) : end;
    any = true;
  }
  bench.middle = 0.5 * (first + last);
  for (auto& signal : bench.signals)
    for (auto& row : signal.rows) row.time -= bench.middle;
}

std::vector<Channel> channels_in(const Records& records) {
  std::vector<Channel> out;
  for (const Channel channel : {gyro, accelerometer_x, accelerometer_y})
    if (records[channel].present) out.push_back(channel);
  return out;
}

template <class From>
Bench assembled(const From& from, const Plan& plan, const Records& records) {
  Problems problems;
  Bench bench;
  bench.plan = &plan;
  bench.records = records;
  auto kind = Error::Kind::bad_input;
  for (const Channel channel : channels_in(records)) try {
      Signal signal{.channel = channel, .problem = problem_of(channel, records[channel], plan.settings)};
      signal.evidence = linear::evidence_of(from, signal.problem);
      for (const auto& finding : signal.evidence.test.findings)
        if (channel == gyro) bench.findings.push_back(finding);
      bench.signals.push_back(std::move(signal));
    } catch (const Error& error) {
      kind = error.kind;
      for (const auto& problem : error.problems)
        if (std::ranges::find(problems, problem) == problems.end()) problems.push_back(problem);
    }
  if (!problems.empty()) throw Error(kind, problems);
  bench.index = index_of(plan);
  for (auto& signal : bench.signals) read_rows(bench.index.base_from_level, signal);
  set_middle(bench);
  return bench;
}

/// Output that the model of a channel of the plan records, in the simulation.
Recorded recorded_by(const Plan& plan, Channel channel) {
  const auto choice = plan.channels.find(role_of(channel));
  const std::string name = choice == plan.channels.end() ? role_of(channel) : choice->second.front().channel;
  for (const auto& instrument : participants_of(plan)) {
    const auto outputs = instrument.model.outputs(instrument.truth);
    for (std::size_t k = 0; k < outputs.size(); ++k) {
      if (instrument.prefix + outputs[k].channel != name) continue;
      if (!instrument.model.record) return recorded_as(channel, Unit::parse(outputs[k].unit), plan.sample_rate);
      const auto recorded = instrument.model.record(instrument.truth, k, 1.0 / plan.sample_rate, RandomStream(0));
      return recorded_as(channel, Unit::parse(recorded.unit), plan.sample_rate);
    }
  }
  return {};
}

}  // namespace

Bench bench_of(const Evidence& evidence) {
  if (evidence.recordings.empty()) throw Error(Error::Kind::bad_data, "north_finding needs at least one recording");
  Records records;
  for (const Channel channel : {gyro, accelerometer_x, accelerometer_y}) {
    const auto& first = evidence.recordings.front();
    const auto* source = channel == gyro ? &require_channel(evidence, first, role_of(channel))
                                         : channel_for(evidence, first, role_of(channel));
    if (source) records[channel] = recorded_as(channel, source->unit, sampling_rate(*source));
  }
  return assembled(evidence, evidence.plan, records);
}

Bench bench_of(const Plan& plan) {
  Records records;
  for (const Channel channel : {gyro, accelerometer_x, accelerometer_y}) records[channel] = recorded_by(plan, channel);
  if (!records[gyro].present)
    throw Error(Error::Kind::bad_input,
                say("to predict, the model {} must have an output that plays the role gyro: [channels] gyro = "
                    "\"...\"",
                    Name{plan.instrument_model}));
  return assembled(plan, plan, records);
}

const Signal* signal_of(const Bench& bench, Channel channel) {
  for (const auto& signal : bench.signals)
    if (signal.channel == channel) return &signal;
  return nullptr;
}

std::vector<double> outputs_of(const Signal& signal) {
  std::vector<double> outputs;
  for (const auto& row : signal.rows) outputs.push_back(row.output);
  return outputs;
}

}  // namespace tumble::north_finding
