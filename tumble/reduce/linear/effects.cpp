#include <algorithm>
#include <cmath>

#include "tumble/reduce/linear/rows.hpp"
#include "tumble/reduce/rig_effects.hpp"

namespace tumble::linear {
namespace {

constexpr double ramp_length = 2.0;  ///< [s] after which a response follows a ramp

/// Times that stand for an interval: few enough to be quick, and so spaced that they fall in step with nothing.
std::vector<double> sampled(double begin, double length, std::size_t points) {
  constexpr double golden = 0.6180339887498949;
  std::vector<double> times(points, begin + 0.5 * length);
  for (std::size_t k = 0; k < points && points > 1; ++k)
    times[k] = begin + length * std::fmod(golden * static_cast<double>(k) + 0.5 / static_cast<double>(points), 1.0);
  return times;
}

double indicated(const Problem& problem, const std::vector<double>& coefficients, const Felt& felt) {
  double value = problem.input ? problem.input(felt) : 0.0;
  for (std::size_t j = 0; j < coefficients.size(); ++j)
    if (coefficients[j] != 0.0) value += coefficients[j] * problem.columns[j].regressor(felt);
  return value;
}

/// Mean of what `value` says over an interval of a stretch.
template <class Value>
double mean_over(const Reference& reference, double begin, double length, std::size_t points, const Value& value) {
  const auto& until = reference.steady_until;
  if (!until || until(begin) >= begin + length) points = 1;
  double sum = 0.0;
  for (const double time : sampled(begin, length, points)) {
    Felt felt;
    reference.felt(time, length, std::span(&felt, 1));
    sum += value(felt);
  }
  return sum / static_cast<double>(points);
}

/// Mean of `value` at evenly spaced instants of an interval, as many as `felt` has room for.
template <class Value>
double mean_at(const Reference& reference, double begin, double length, std::span<Felt> felt, const Value& value) {
  const double step = length / static_cast<double>(felt.size());
  reference.felt(begin + 0.5 * step, step, felt);
  double sum = 0.0;
  for (const Felt& sample : felt) sum += value(sample);
  return sum / static_cast<double>(felt.size());
}

constexpr std::size_t points_of_block = 6;      ///< in a short block, of a tenth of a turn at most
constexpr std::size_t points_of_stretch = 192;  ///< in a stretch, or in one turn

/// In a block: a sample that takes longer than a tenth of a turn makes a long one.
std::size_t points_in_block(const Segment& segment, double length) {
  constexpr double of_turn = 16.0;
  const double wanted = std::ceil(of_turn * quickest(segment) * length);
  return static_cast<std::size_t>(
      std::clamp(wanted, static_cast<double>(points_of_block), static_cast<double>(points_of_stretch)));
}

/// Samples of a stretch that are averaged in one row.
struct Block {
  std::size_t begin = 0, size = 0;

  bool is_whole(const Stretch& stretch) const {
    for (std::size_t i = begin; i < begin + size; ++i)
      if (!present(stretch, i)) return false;
    return true;
  }
};

/// Mean of `value` over the samples of a block that are present, as its row is one: an effect over the whole block
/// would differ in its course from the columns that it resembles, and the fit would distinguish them by that.
///
/// Given     points  in the whole block
///           delay   [s] by which what is shown lags behind what is felt
template <class Value>
double mean_of_block(const Reference& reference, const Stretch& stretch, Block block, std::size_t points, double delay,
                     const Value& value) {
  const double begin = stretch.first + static_cast<double>(block.begin) * stretch.step - delay;
  const double length = static_cast<double>(block.size) * stretch.step;
  const bool whole = block.is_whole(stretch);
  const std::size_t each = (points + block.size - 1) / block.size;  // points in a sample
  std::vector<Felt> felt(whole ? points : each * block.size);
  if (whole) return mean_at(reference, begin, length, std::span(felt), value);
  const double step = stretch.step / static_cast<double>(each);
  reference.felt(begin + 0.5 * step, step, felt);
  double sum = 0.0, count = 0.0;
  for (std::size_t k = 0; k < felt.size(); ++k) {
    if (!present(stretch, block.begin + k / each)) continue;
    sum += value(felt[k]);
    count += 1.0;
  }
  return sum / count;
}

/// Mean of `value` over a stretch in which the rig turns evenly: all whole turns are equal, so that one of them
/// represents all, with enough points for ripples of a turn; the remainder of the last turn is added. (Points spread
/// over all turns would retain a ripple of the rate over the root of their number, a hundred times its true mean.)
template <class Value>
double mean_of_turns(const Reference& reference, const Segment& segment, double begin, double length,
                     const Value& value) {
  const double turn = longest_turn(segment);
  std::vector<Felt> felt(points_of_stretch);
  const double turns = turn > 0.0 ? std::floor(length / turn) * turn : 0.0;
  double mean = 0.0;
  if (turns > 0.0) mean += turns / length * mean_at(reference, begin, turn, std::span(felt), value);
  if (length - turns > 1e-9 * length)
    mean += (1.0 - turns / length) * mean_at(reference, begin + turns, length - turns, std::span(felt), value);
  return mean;
}

/// How long the response lags behind a ramp [s].
double delay_of(const Problem& problem, double step) {
  if (!problem.response) return 0.0;
  std::vector<double> ramp(std::max<std::size_t>(64, static_cast<std::size_t>(ramp_length / step)));
  for (std::size_t k = 0; k < ramp.size(); ++k) ramp[k] = static_cast<double>(k) * step;
  const double last = ramp.back();
  problem.response(step)(ramp);
  return last - ramp.back();
}

/// Means over rows.
class Means {
 public:
  Means(const Evidences& evidence, const Problem& problem, const Rows& rows)
      : evidence_(evidence), rows_(rows), first_(evidence.test.stretches.size() + 1, rows.segment.size()) {
    delay_ = delay_of(problem, evidence.test.power_ups.front().step);
    for (std::size_t row = rows.segment.size(); row-- > 0;) first_[rows.segment[row]] = row;
  }

  /// Adds the mean of `value` over every row of one stretch. Where the rig stands or turns evenly all rows have the
  /// mean over the stretch: an error that goes round with the axis averages out. Elsewhere each row has the mean over
  /// its own samples, of what is felt `delay_` before.
  template <class Value>
  void add(const Reference& reference, std::size_t g, Detail detail, const Value& value,
           std::span<double> column) const {
    const Stretch& stretch = evidence_.test.stretches[g];
    const Blocking& blocking = evidence_.blocking[g];
    if (!blocking.instants.empty()) {
      column[0] += mean_over(reference, blocking.instants, value);
      return;
    }
    if (evidence_.uniform(g)) {
      const Segment& segment = evidence_.test.power_ups[stretch.power_up].rig.segments[stretch.segment];
      const double mean = blocking.even ? mean_of_turns(reference, segment, stretch.first, stretch.duration(), value)
                                        : mean_over(reference, stretch.first, stretch.duration(),
                                                    std::min(stretch.samples, points_of_stretch), value);
      for (double& row : column) row += mean;
      return;
    }
    const Segment& segment = evidence_.test.power_ups[stretch.power_up].rig.segments[stretch.segment];
    const double longest = static_cast<double>(blocking.per_block) * stretch.step;
    const std::size_t points = detail == Detail::full ? points_in_block(segment, longest) : 1;
    for (std::size_t i = 0; i < column.size(); ++i) {
      const std::size_t begin = rows_.block[first_[g] + i] * blocking.per_block;
      const std::size_t size = std::min(blocking.per_block, stretch.samples - begin);
      column[i] += mean_of_block(reference, stretch, {begin, size}, points, delay_, value);
    }
  }

  /// The means over all rows, where the rigs have no errors.
  template <class Value>
  std::vector<double> nominal(const Value& value) const {
    std::vector<double> column(rows_.segment.size(), 0.0);
    for (std::size_t row = 0, end = 0; row < column.size(); row = end) {
      const std::size_t g = rows_.segment[row];
      while (end < column.size() && rows_.segment[end] == g) ++end;
      add(evidence_.test.power_ups[evidence_.test.stretches[g].power_up].reference, g, Detail::full, value,
          std::span(column).subspan(row, end - row));
    }
    return column;
  }

 private:
  const Evidences& evidence_;
  const Rows& rows_;
  std::vector<std::size_t> first_;  ///< row of each stretch
  double delay_ = 0.0;
};

}  // namespace

std::vector<KnownEffect> effects_of(const Evidences& evidence, const Problem& problem, const Rows& rows,
                                    const std::vector<double>& coefficients) {
  const Means means(evidence, problem, rows);
  const auto shown = [&](const Felt& felt) { return indicated(problem, coefficients, felt); };
  auto effects = rig_effects(evidence.test,
                             {.stretch = rows.segment,
                              .add = [&](const Reference& reference, std::size_t g, Detail detail,
                                         std::span<double> column) { means.add(reference, g, detail, shown, column); },
                              .is_total = [&](std::size_t g) { return !evidence.blocking[g].instants.empty(); }});
  for (const auto& error : problem.reading_errors) {
    if (!(error.sd > 0.0)) continue;
    const auto value = [&](const Felt& felt) { return error.sd * error.change(felt, shown(felt)); };
    effects.push_back({error.source, means.nominal(value), false});
  }
  for (const auto& error : problem.response_errors) {
    Problem varied = problem;
    varied.columns.clear();
    varied.response = error.response;
    KnownEffect effect{error.source, rows_of(evidence, varied).input, false};
    for (std::size_t i = 0; i < rows.input.size(); ++i) effect.column[i] -= rows.input[i];
    effects.push_back(std::move(effect));
  }
  return effects;
}

}  // namespace tumble::linear
