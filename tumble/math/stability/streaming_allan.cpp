#include "tumble/math/stability/streaming_allan.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "tumble/math/stability/allan_differences.hpp"
#include "tumble/math/stability/allan_edf.hpp"
#include "tumble/math/stability/allan_phase.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

/// Growth of white phase noise; its type; ratio of times.
constexpr double steepest = -1.5, type_of_steepest = 1.5, slope_over = 1.4;

constexpr std::size_t memory = 2 * StreamingAllan::exact_to;  // increments that the longest term of a stage spans
constexpr std::size_t increments_at_once = 2 * memory;        // increments worked through at a time

/// Samples from one point of a stage to the next.
std::size_t step_of(std::size_t stage) {
  std::size_t step = 1;
  for (std::size_t k = 0; k < stage; ++k) step *= StreamingAllan::decimation;
  return step;
}

std::size_t next_multiple(std::size_t value, std::size_t unit) { return (value + unit - 1) / unit * unit; }

/// Increments of a stage from its first point at or after a sample to the first point of the next stage.
std::size_t steps_to_next_stage(std::size_t sample, std::size_t stage) {
  const std::size_t step = step_of(stage);
  return (next_multiple(sample, step * StreamingAllan::decimation) - next_multiple(sample, step)) / step;
}

/// Noise type from the growth of the variance, S_y ~ f^alpha -> sigma^2 ~ tau^(-1-alpha); 1.5 stands for phase noise.
double noise_type(const DeviationPoint& before, const DeviationPoint& after) {
  if (!(before.deviation > 0.0 && after.deviation > 0.0) || before.factor == after.factor) return 0.0;
  const double growth = 2.0 * std::log(after.deviation / before.deviation) / std::log(after.tau / before.tau);
  return growth < steepest ? type_of_steepest : std::clamp(std::round(-1.0 - growth), -4.0, 0.0);
}

}  // namespace

StreamingAllan::StreamingAllan(std::size_t longest, double points_per_decade, std::size_t start) : start_(start) {
  if (!(points_per_decade >= 0.0 && std::isfinite(points_per_decade)))
    throw Error(Error::Kind::bad_input, "points per decade must be 0 (octaves) or more");
  const auto factors = averaging_factors(exact_to, points_per_decade);
  for (std::size_t step = 1; step == 1 || exact_to * (step / decimation) < longest; step *= decimation) {
    Stage stage;
    for (const std::size_t factor : factors) {
      if ((step == 1 || factor > exact_to / decimation) && factor * step <= longest) stage.factors.push_back(factor);
    }
    stage.sums.resize(stage.factors.size(), 0.0L);
    stage.terms.resize(stage.factors.size(), 0);
    stages_.push_back(std::move(stage));
  }
  for (std::size_t k = 0; k < stages_.size(); ++k) stages_[k].skip = steps_to_next_stage(start, k);
}

/// Adds the terms that end in the last `fresh` of the increments, of which the `old` first were worked through before.
void StreamingAllan::add_terms(Stage& stage, std::span<const double> increments, std::size_t old, std::size_t fresh) {
  double mean = 0.0;
  for (const double increment : increments) mean += increment;
  mean /= static_cast<double>(increments.size());
  std::vector<double> x(increments.size() + 1, 0.0);
  for (std::size_t n = 0; n < increments.size(); ++n) x[n + 1] = x[n] + (increments[n] - mean);
  for (std::size_t i = 0; i < stage.factors.size(); ++i) {
    const std::size_t reach = 2 * stage.factors[i];
    const std::size_t first = old + 1 > reach ? old + 1 - reach : 0;
    // Terms that start beyond `old` lie within the fresh part: of a junction they are not counted (fresh = 0).
    const std::size_t last =
        fresh > 0 ? x.size() - std::min(x.size(), reach) : std::min(x.size() - std::min(x.size(), reach), old);
    if (last <= first) continue;
    stage.sums[i] += second_difference_squares(x.data() + first, stage.factors[i], last - first);
    stage.terms[i] += last - first;
  }
}

void StreamingAllan::work_through(std::size_t index) {
  Stage& stage = stages_[index];
  if (stage.pending.empty()) return;
  const std::vector<double> fresh = std::move(stage.pending);
  stage.pending.clear();
  const std::size_t old = stage.tail.size();
  stage.tail.insert(stage.tail.end(), fresh.begin(), fresh.end());
  add_terms(stage, stage.tail, old, fresh.size());
  if (stage.tail.size() > memory) stage.tail.erase(stage.tail.begin(), stage.tail.end() - memory);
  if (stage.head_open) {
    const std::size_t room = memory - stage.head.size();
    stage.head.insert(stage.head.end(), fresh.begin(), fresh.begin() + std::min(room, fresh.size()));
    stage.head_open = fresh.size() <= room;
  }
  if (index + 1 == stages_.size()) return;
  for (const double increment : fresh) {
    if (stage.skip > 0) {
      --stage.skip;
      stage.lead += stage.lead_open ? increment : 0.0;
      stage.leading += stage.lead_open ? 1 : 0;
      continue;
    }
    stage.lead_open = false;
    stage.carry += increment;
    if (++stage.carried < decimation) continue;
    feed(index + 1, stage.carry);
    stage.carry = 0.0;
    stage.carried = 0;
  }
}

void StreamingAllan::feed(std::size_t index, double increment) {
  stages_[index].pending.push_back(increment);
  if (stages_[index].pending.size() == increments_at_once) work_through(index);
}

void StreamingAllan::flush() {
  for (std::size_t k = 0; k < stages_.size(); ++k) work_through(k);
}

/// After a missing sample each stage begins anew at its next point.
void StreamingAllan::break_off() {
  flush();
  for (std::size_t k = 0; k < stages_.size(); ++k) {
    Stage& stage = stages_[k];
    stage.tail.clear();
    stage.head_open = false;
    stage.carry = 0.0;
    stage.carried = 0;
    if (stage.lead_open && stage.skip > 0) stage.lead = 0.0, stage.leading = 0;  // it was not complete
    stage.lead_open = false;
    stage.skip = steps_to_next_stage(start_ + samples_, k);
  }
}

void StreamingAllan::push(std::span<const double> rate) {
  while (!rate.empty()) {
    auto& pending = stages_[0].pending;
    const auto some = rate.first(std::min(rate.size(), increments_at_once - pending.size()));
    const auto end = std::find_if(some.begin(), some.end(), [](double value) { return !std::isfinite(value); });
    const auto good = static_cast<std::size_t>(end - some.begin());
    pending.insert(pending.end(), some.begin(), end);
    samples_ += good;
    if (pending.size() == increments_at_once) work_through(0);
    if (good < some.size()) {
      if (std::isinf(*end)) throw Error(Error::Kind::bad_data, say("infinite value at sample {}", start_ + samples_));
      ++samples_;
      break_off();
    }
    rate = rate.subspan(good < some.size() ? good + 1 : good);
  }
}

/// Sums, first and last increments of one stage, whose part before the joint has been worked through.
void StreamingAllan::join(Stage& stage, const Stage& other) {
  std::vector<double> both = stage.tail;
  both.insert(both.end(), other.head.begin(), other.head.end());
  if (!stage.tail.empty() && !other.head.empty()) add_terms(stage, both, stage.tail.size(), 0);
  for (std::size_t i = 0; i < stage.factors.size(); ++i) {
    stage.sums[i] += other.sums[i];
    stage.terms[i] += other.terms[i];
  }
  if (stage.head_open) {
    const std::size_t room = memory - stage.head.size();
    stage.head.insert(stage.head.end(), other.head.begin(), other.head.begin() + std::min(room, other.head.size()));
    stage.head_open = other.head_open && other.head.size() <= room;
  }
  if (other.head_open) {  // it holds all of the part
    stage.tail = std::move(both);
    if (stage.tail.size() > memory) stage.tail.erase(stage.tail.begin(), stage.tail.end() - memory);
  } else {
    stage.tail = other.tail;
  }
}

/// The increment of the next stage that both parts share: what the first has of it, and the lead of the second.
void StreamingAllan::join_lead(std::size_t index, const Stage& other) {
  Stage& stage = stages_[index];
  if (stage.skip > 0) {
    stage.skip -= std::min(stage.skip, other.leading);
    if (stage.lead_open) {
      stage.lead += other.lead;
      stage.leading += other.leading;
    }
  } else if (other.leading > 0) {
    stage.lead_open = false;
    stage.carry += other.lead;
    stage.carried += other.leading;
    if (stage.carried == decimation) {
      if (index + 1 < stages_.size()) feed(index + 1, stage.carry);
      stage.carry = 0.0;
      stage.carried = 0;
    }
  }
  if (other.lead_open) return;  // the second part ends within its lead
  if (stage.skip > 0 && stage.lead_open) stage.lead = 0.0, stage.leading = 0;
  stage.lead_open = false;
  stage.carry = other.carry;
  stage.carried = other.carried;
  stage.skip = other.skip;
}

void StreamingAllan::append(const StreamingAllan& given) {
  if (given.start_ != start_ + samples_ || given.stages_.size() != stages_.size() ||
      given.stages_.back().factors != stages_.back().factors) {
    throw Error(
        Error::Kind::bad_input,
        say("the part that starts at sample {} does not follow one that ends at {}, or has other averaging factors",
            Name{std::to_string(given.start_)}, Name{std::to_string(start_ + samples_)}));
  }
  StreamingAllan next = given;
  next.flush();
  flush();
  for (std::size_t k = 0; k < stages_.size(); ++k) {
    work_through(k);
    join(stages_[k], next.stages_[k]);
    join_lead(k, next.stages_[k]);
  }
  samples_ += next.samples_;
}

std::vector<DeviationPoint> StreamingAllan::points(double sample_rate, double confidence) const {
  StreamingAllan all = *this;
  all.flush();
  std::vector<DeviationPoint> points;
  std::vector<std::size_t> steps;
  for (std::size_t k = 0; k < all.stages_.size(); ++k) {
    const Stage& stage = all.stages_[k];
    for (std::size_t i = 0; i < stage.factors.size(); ++i) {
      if (stage.terms[i] == 0) continue;
      const std::size_t factor = stage.factors[i] * step_of(k);
      DeviationPoint point{.factor = factor, .tau = static_cast<double>(factor) / sample_rate};
      point.count = stage.terms[i];
      const long double mean = stage.sums[i] / (2.0L * static_cast<long double>(stage.terms[i]));
      point.deviation = std::sqrt(static_cast<double>(mean)) / static_cast<double>(factor);
      points.push_back(point);
      steps.push_back(step_of(k));
    }
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::size_t before = i, after = i;
    while (before > 0 && points[before].tau > points[i].tau / slope_over) --before;
    while (after + 1 < points.size() && points[after].tau < points[i].tau * slope_over) ++after;
    const double type = noise_type(points[before], points[after]);
    const auto edf = [&](double alpha) {
      return phase_difference_edf(static_cast<int>(alpha), PhaseDifference{}, points[i].factor / steps[i],
                                  points[i].count);
    };
    points[i].edf = type > 0.0 ? std::min(edf(1.0), edf(2.0)) : edf(type);
    points[i].alpha = type > 0.0 ? (edf(1.0) < edf(2.0) ? 1 : 2) : static_cast<int>(type);
    const auto limits = deviation_limits(points[i].deviation, points[i].edf, confidence);
    points[i].lower = limits.lower;
    points[i].upper = limits.upper;
  }
  return points;
}

}  // namespace tumble
