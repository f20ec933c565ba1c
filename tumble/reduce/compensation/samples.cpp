#include "tumble/reduce/compensation/samples.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "tumble/reduce/compensation/solve.hpp"

namespace tumble::compensation {
namespace {

constexpr int passes_with_slopes = 3;  ///< each takes the effect of angular acceleration a factor of a thousand further

/// Lagged inputs follow theirs with a first-order lag, which begins at rest.
void follow(const std::vector<Slot>& slots, std::size_t i, const Channel& clock, Values& values) {
  for (std::size_t k = common_slot_count; k < slots.size(); ++k) {
    if (slots[k].base == SIZE_MAX) continue;
    const double now = values[slots[k].base];
    const double share =
        i == 0 || !(slots[k].lag > 0.0) ? 1.0 : -std::expm1(-(clock.time(i) - clock.time(i - 1)) / slots[k].lag);
    if (std::isnan(values[k]) || share == 1.0) values[k] = now;
    if (!std::isnan(now)) values[k] += share * (now - values[k]);
  }
}

/// All samples, with what is felt and the outputs as they were recorded.
struct Samples {
  const Inputs& known;
  const std::vector<Slot>& slots;
  const Recording& raw;
  std::array<const std::vector<double>*, 3>
      acceleration{};  ///< [rad/s^2] of rates that are compensated; null: not known
  std::array<std::vector<double>, 3> acceleration_sd;
};

/// The inputs of a sample, and where the search for u begins: at `before`, or without it at the output.
void put_inputs(const Samples& samples, Works& works, Values& values, std::size_t i, const Recording* before) {
  samples.known.fill(i, std::span(values));
  for (std::size_t k = 0; k < 3; ++k)
    if (samples.acceleration[k])
      values[static_cast<std::size_t>(Input::angular_acceleration_x) + k] = (*samples.acceleration[k])[i];
  for (Work& work : works) {
    const double value = work.late.empty() ? samples.raw.channels[work.place].values[i] : work.late[i];
    work.y = (value * work.reading - work.offset) / work.scale_factor;
    work.u = before ? before->channels[work.place].values[i] : work.y;
    values[work.shown] = work.u;
  }
  follow(samples.slots, i, works.front().trust.sd, values);
}

/// u of all outputs in place of each, sample by sample.
void solve_all(const Samples& samples, Works& works, Recording& recording, const Recording* before) {
  Values values(samples.slots.size(), 0.0);
  const std::size_t count = samples.raw.channels[works.front().place].values.size();
  for (std::size_t i = 0; i < count; ++i) {
    put_inputs(samples, works, values, i, before);
    solve_together(works, values);
    for (Work& work : works) {
      recording.channels[work.place].values[i] = work.u;
      for (UsedTerm& term : work.terms) advance(term, values);
    }
  }
  for (Work& work : works)
    for (UsedTerm& term : work.terms) begin(term);
}

/// Which outputs have all inputs that their terms need: those with a solution, and those whose terms have a value at
/// what the outputs show.
std::vector<bool> informed_of(const Works& works, const Values& values) {
  std::vector<bool> informed(works.size(), true);
  if (std::ranges::none_of(works, [](const Work& work) { return std::isnan(work.u); })) return informed;
  Values shown = values;
  for (const Work& work : works) shown[work.shown] = work.y;
  for (std::size_t k = 0; k < works.size(); ++k) informed[k] = !std::isnan(errors_at(works[k], shown));
  return informed;
}

/// One sample of all outputs: u in place of each, its uncertainty, and whether the calibration covered it.
void take_sample(const Samples& samples, Works& works, Values& values, std::size_t i, Recording& recording) {
  solve_together(works, values);
  const auto informed = informed_of(works, values);
  Values means;
  if (samples.known.average) samples.known.average(i, means = values);
  const Values& compared = means.empty() ? values : means;
  for (std::size_t k = 0; k < works.size(); ++k)
    take_solution(works[k], values, compared, i, informed[k], recording.channels[works[k].place]);
  Vector3 sd;
  for (std::size_t k = 0; k < 3; ++k)
    if (!samples.acceleration_sd[k].empty()) sd[k] = samples.acceleration_sd[k][i];
  const auto variances = variances_of(works, values, sd);
  for (std::size_t k = 0; k < works.size(); ++k)
    works[k].trust.sd.values[i] = std::isnan(works[k].u) ? works[k].u : std::sqrt(variances[k]);
  for (Work& work : works)
    for (UsedTerm& term : work.terms) advance(term, values);
}

/// Central differences [SI/s]; a sample without both neighbours takes what there is.
std::vector<double> slopes(const Channel& channel) {
  std::vector<double> out(channel.values.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    const std::size_t before = i > 0 ? i - 1 : i, after = i + 1 < out.size() ? i + 1 : i;
    const double time = channel.time(after) - channel.time(before);
    const double slope = (channel.values[after] - channel.values[before]) / time;
    out[i] = time > 0.0 && std::isfinite(slope) ? slope : 0.0;
  }
  return out;
}

/// Standard uncertainty of these differences: where the slope jumps within a sample, they are off by up to half of what
/// the one-sided differences there and beside it are apart, and anything between is as likely: that half over sqrt(3).
std::vector<double> slopes_sd(const Channel& channel) {
  const auto& v = channel.values;
  std::vector<double> apart(v.size()), sd(v.size());
  for (std::size_t i = 1; i + 1 < v.size(); ++i) {
    const double before = channel.time(i) - channel.time(i - 1), after = channel.time(i + 1) - channel.time(i);
    const double change = (v[i + 1] - v[i]) / after - (v[i] - v[i - 1]) / before;
    apart[i] = std::isfinite(change) ? std::abs(change) : 0.0;
  }
  for (std::size_t i = 0; i < v.size(); ++i)
    for (std::size_t near = i > 0 ? i - 1 : i; near < std::min(i + 2, v.size()); ++near)
      sd[i] = std::max(sd[i], 0.5 / std::sqrt(3.0) * apart[near]);
  return sd;
}

/// Rates that are compensated themselves, and whose angular acceleration a term needs that no plan says: axis, output.
std::vector<std::pair<std::size_t, std::size_t>> slopes_needed(const Inputs& known, const Works& works) {
  const auto first = static_cast<std::size_t>(Input::angular_acceleration_x);
  std::vector<std::pair<std::size_t, std::size_t>> needed;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t by = shown_by(works, k);
    const bool asked =
        std::ranges::any_of(works, [&](const Work& work) { return !work.terms_with[first + k].empty(); });
    if (asked && by < works.size() && !known.planned[first + k]) needed.emplace_back(k, by);
  }
  return needed;
}

}  // namespace

std::size_t shown_by(const Works& works, std::size_t slot) {
  return static_cast<std::size_t>(std::ranges::distance(works.begin(), std::ranges::find(works, slot, &Work::shown)));
}

void take_all(const Inputs& known, const std::vector<Slot>& slots, const Recording& raw, Works& works,
              Recording& recording) {
  Samples samples{known, slots, raw, {}, {}};
  const auto needed = slopes_needed(known, works);
  std::array<std::vector<double>, 3> slope;
  for (int pass = 0; !needed.empty() && pass < passes_with_slopes; ++pass) {
    solve_all(samples, works, recording, pass > 0 ? &recording : nullptr);
    for (const auto& [k, by] : needed) {
      const Channel& channel = recording.channels[works[by].place];
      slope[k] = slopes(channel);
      samples.acceleration[k] = &slope[k];
      samples.acceleration_sd[k] = slopes_sd(channel);
    }
  }
  Values values(slots.size(), 0.0);
  const std::size_t count = raw.channels[works.front().place].values.size();
  for (std::size_t i = 0; i < count; ++i) {
    put_inputs(samples, works, values, i, needed.empty() ? nullptr : &recording);
    take_sample(samples, works, values, i, recording);
  }
}

}  // namespace tumble::compensation
