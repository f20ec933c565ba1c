#include <algorithm>
#include <cmath>
#include <utility>

#include "tumble/math/golden_section.hpp"
#include "tumble/math/rounding_share.hpp"
#include "tumble/reduce/linear/rows.hpp"
#include "tumble/reduce/rig_effects.hpp"

namespace tumble::linear {
namespace {

constexpr std::size_t least_ramp = 64;  ///< samples

constexpr double ramp_length = 2.0;             ///< [s] after which a response follows a ramp
constexpr std::size_t points_of_block = 6;      ///< in a short block, of a tenth of a turn at most
constexpr std::size_t points_of_stretch = 192;  ///< in a stretch, or in one turn

/// Times that stand for an interval: few enough to be quick, and so spaced that they fall in step with nothing.
std::vector<double> sampled(double begin, double length, std::size_t points) {
  std::vector<double> times(points, begin + 0.5 * length);
  for (std::size_t k = 0; k < points && points > 1; ++k)
    times[k] = begin + length * golden_fraction(k, 0.5 / static_cast<double>(points));
  return times;
}

/// What the output shows at each of these points [SI]: term by term, so that one regressor is called for all of them.
void indicate(const Problem& problem, const std::vector<double>& coefficients, std::span<const Felt> points,
              std::span<double> values) {
  for (std::size_t i = 0; i < points.size(); ++i) values[i] = problem.input ? problem.input(points[i]) : 0.0;
  for (std::size_t j = 0; j < coefficients.size(); ++j) {
    if (coefficients[j] == 0.0) continue;
    const auto& regressor = problem.columns[j].regressor;
    for (std::size_t i = 0; i < points.size(); ++i) values[i] += coefficients[j] * regressor(points[i]);
  }
}

/// What is felt at some points, and room for what an output shows there; used again from block to block.
struct Points {
  std::vector<Felt> felt;
  std::vector<double> values;
};

/// Adds to the means of each output what it shows on average at the points.
///
/// Given     values_at   called with (number of the output, felt, values), sets the values [SI]
template <class ValuesAt>
void add_mean(Points& points, double share, const ValuesAt& values_at, std::span<double> means) {
  points.values.resize(points.felt.size());
  for (std::size_t k = 0; k < means.size(); ++k) {
    values_at(k, std::span<const Felt>(points.felt), std::span(points.values));
    double sum = 0.0;
    for (const double value : points.values) sum += value;
    means[k] += share * (sum / static_cast<double>(points.felt.size()));
  }
}

/// Adds the means over an interval of a stretch.
template <class ValuesAt>
void add_mean_over(const Reference& reference, double begin, double length, std::size_t points,
                   const ValuesAt& values_at, std::span<double> means) {
  const auto& until = reference.steady_until;
  if (!until || until(begin) >= begin + length) points = 1;
  Points all;
  for (const double time : sampled(begin, length, points)) {
    all.felt.emplace_back();
    reference.felt(time, length, std::span(&all.felt.back(), 1));
  }
  add_mean(all, 1.0, values_at, means);
}

/// What is felt at the middles of equal parts of an interval, as many as `felt` has room for.
void feel(const Reference& reference, double begin, double length, std::span<Felt> felt) {
  const double step = length / static_cast<double>(felt.size());
  reference.felt(begin + 0.5 * step, step, felt);
}

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
  bool whole = true;  ///< all samples are present
};

/// Adds the means over the samples of a block that are present, as its row is one: an effect over the whole block
/// would differ in its course from the columns that it resembles, and the fit would distinguish them by that.
///
/// Given     points  in the whole block
///           delay   [s] by which what is shown lags behind what is felt
///           room    for the points, which are set
template <class ValuesAt>
void add_mean_of_block(const Reference& reference, const Stretch& stretch, Block block, std::size_t points,
                       double delay, const ValuesAt& values_at, Points& room, std::span<double> means) {
  const double begin = stretch.first + static_cast<double>(block.begin) * stretch.step - delay;
  const double length = static_cast<double>(block.size) * stretch.step;
  const std::size_t each = (points + block.size - 1) / block.size;  // points in a sample
  auto& felt = room.felt;
  felt.resize(block.whole ? points : each * block.size);
  feel(reference, begin, length, felt);
  if (!block.whole) {
    std::size_t kept = 0;
    for (std::size_t k = 0; k < felt.size(); ++k)
      if (present(stretch, block.begin + k / each)) felt[kept++] = felt[k];
    felt.resize(kept);
  }
  add_mean(room, 1.0, values_at, means);
}

/// Adds the means over a stretch in which the rig turns evenly: all whole turns are equal, so that one of them
/// represents all, with enough points for ripples of a turn; the remainder of the last turn is added. (Points spread
/// over all turns would retain a ripple of the rate over the root of their number, a hundred times its true mean.)
template <class ValuesAt>
void add_mean_of_turns(const Reference& reference, const Segment& segment, double begin, double length,
                       const ValuesAt& values_at, std::span<double> means) {
  const double turn = longest_turn(segment);
  Points points{std::vector<Felt>(points_of_stretch), {}};
  const double turns = turn > 0.0 ? std::floor(length / turn) * turn : 0.0;
  if (turns > 0.0) {
    feel(reference, begin, turn, points.felt);
    add_mean(points, turns / length, values_at, means);
  }
  if (length - turns > rounding_share * length) {
    feel(reference, begin + turns, length - turns, points.felt);
    add_mean(points, 1.0 - turns / length, values_at, means);
  }
}

/// How long the response lags behind a ramp [s].
double delay_of(const Problem& problem, double step) {
  if (!problem.response) return 0.0;
  std::vector<double> ramp(std::max<std::size_t>(least_ramp, static_cast<std::size_t>(ramp_length / step)));
  for (std::size_t k = 0; k < ramp.size(); ++k) ramp[k] = static_cast<double>(k) * step;
  const double last = ramp.back();
  problem.response(step)(ramp);
  return last - ramp.back();
}

/// Means over rows, of one output or of several with rows at the same samples.
class Means {
 public:
  Means(const Evidences& evidence, const Problem& problem, const Rows& rows)
      : evidence_(evidence), rows_(rows), first_(evidence.test.stretches.size() + 1, rows.segment.size()) {
    delay_ = delay_of(problem, evidence.test.power_ups.front().step);
    for (std::size_t row = rows.segment.size(); row-- > 0;) first_[rows.segment[row]] = row;
    for (std::size_t row = 0; row < rows.segment.size(); ++row) blocks_.push_back(block_of(row));
  }

  /// Adds the mean of each output over every row of one stretch. Where the rig stands or turns evenly all
  /// rows have the mean over the stretch: an error that goes round with the axis averages out. Elsewhere each row has
  /// the mean over its own samples, of what is felt `delay_` before.
  template <class ValuesAt>
  void add(const Reference& reference, std::size_t g, Detail detail, const ValuesAt& values_at, OutputRows rows) const {
    const Stretch& stretch = evidence_.test.stretches[g];
    const Blocking& blocking = evidence_.blocking[g];
    const Segment& segment = evidence_.test.power_ups[stretch.power_up].rig.segments[stretch.segment];
    std::vector<double> means(rows.size(), 0.0);
    if (!blocking.instants.empty()) {
      const auto shown = [&](std::size_t k, const Felt& felt) {
        double value = 0.0;
        values_at(k, std::span(&felt, 1), std::span(&value, 1));
        return value;
      };
      for (std::size_t k = 0; k < rows.size(); ++k)
        rows[k][0] += mean_over(reference, blocking.instants, [&](const Felt& felt) { return shown(k, felt); });
      return;
    }
    if (evidence_.uniform(g)) {
      if (blocking.even)
        add_mean_of_turns(reference, segment, stretch.first, stretch.duration(), values_at, means);
      else
        add_mean_over(reference, stretch.first, stretch.duration(), std::min(stretch.samples, points_of_stretch),
                      values_at, means);
      for (std::size_t k = 0; k < rows.size(); ++k)
        for (double& row : rows[k]) row += means[k];
      return;
    }
    const double longest = static_cast<double>(blocking.per_block) * stretch.step;
    const std::size_t points = detail == Detail::full ? points_in_block(segment, longest) : 1;
    Points room;
    for (std::size_t i = 0; i < rows[0].size(); ++i) {
      std::ranges::fill(means, 0.0);
      add_mean_of_block(reference, stretch, blocks_[first_[g] + i], points, delay_, values_at, room, means);
      for (std::size_t k = 0; k < rows.size(); ++k) rows[k][i] += means[k];
    }
  }

  /// The means of one output over all rows, where the rigs have no errors.
  template <class ValuesAt>
  std::vector<double> nominal(const ValuesAt& values_at) const {
    std::vector<double> column(rows_.segment.size(), 0.0);
    for (std::size_t row = 0, end = 0; row < column.size(); row = end) {
      const std::size_t g = rows_.segment[row];
      while (end < column.size() && rows_.segment[end] == g) ++end;
      const auto part = std::span(column).subspan(row, end - row);
      add(
          evidence_.test.power_ups[evidence_.test.stretches[g].power_up].reference, g, Detail::full,
          [&](std::size_t, std::span<const Felt> points, std::span<double> values) { values_at(points, values); },
          OutputRows(&part, 1));
    }
    return column;
  }

 private:
  Block block_of(std::size_t row) const {
    const std::size_t g = rows_.segment[row];
    const Stretch& stretch = evidence_.test.stretches[g];
    const std::size_t per_block = evidence_.blocking[g].per_block, begin = rows_.block[row] * per_block;
    Block block{begin, std::min(per_block, stretch.samples - begin)};
    for (std::size_t i = 0; i < block.size; ++i) block.whole = block.whole && present(stretch, begin + i);
    return block;
  }

  const Evidences& evidence_;
  const Rows& rows_;
  std::vector<std::size_t> first_;  ///< row of each stretch
  std::vector<Block> blocks_;       ///< of each row
  double delay_ = 0.0;
};

/// The errors of the reading and of the response of one output.
void add_own_effects(const Shown& one, const Means& means, std::vector<KnownEffect>& effects) {
  for (const auto& error : one.problem.reading_errors) {
    if (!(error.sd > 0.0)) continue;
    const auto changes = [&](std::span<const Felt> points, std::span<double> values) {
      indicate(one.problem, one.coefficients, points, values);
      for (std::size_t i = 0; i < points.size(); ++i) values[i] = error.sd * error.change(points[i], values[i]);
    };
    effects.push_back({error.source, means.nominal(changes), false});
  }
  for (const auto& error : one.problem.response_errors) {
    Problem varied = one.problem;
    varied.columns.clear();
    varied.response = error.response;
    KnownEffect effect{error.source, rows_of(one.evidence, varied).input, false};
    for (std::size_t i = 0; i < one.rows.input.size(); ++i) effect.column[i] -= one.rows.input[i];
    effects.push_back(std::move(effect));
  }
}

bool same_samples(const Stretch& a, const Stretch& b) {
  for (std::size_t i = 0; i < a.samples; ++i)
    if (present(a, i) != present(b, i)) return false;
  return true;
}

/// Whether two outputs have rows at the same samples, and no delay.
bool observed_together(const Shown& a, const Shown& b) {
  return read_together({a.evidence, a.problem}, {b.evidence, b.problem}) &&
         std::ranges::equal(a.evidence.test.stretches, b.evidence.test.stretches, same_samples);
}

/// Effects of outputs that are observed together.
std::vector<std::vector<KnownEffect>> effects_together(const std::vector<const Shown*>& outputs) {
  const Evidences& evidence = outputs.front()->evidence;
  const Means means(evidence, outputs.front()->problem, outputs.front()->rows);
  const auto shown = [&](std::size_t k, std::span<const Felt> points, std::span<double> values) {
    indicate(outputs[k]->problem, outputs[k]->coefficients, points, values);
  };
  auto effects =
      rig_effects(evidence.test, {.stretch = outputs.front()->rows.segment,
                                  .outputs = outputs.size(),
                                  .add = [&](const Reference& reference, std::size_t g, Detail detail,
                                             OutputRows rows) { means.add(reference, g, detail, shown, rows); },
                                  .is_total = [&](std::size_t g) { return !evidence.blocking[g].instants.empty(); }});
  for (std::size_t k = 0; k < outputs.size(); ++k) add_own_effects(*outputs[k], means, effects[k]);
  return effects;
}

}  // namespace

std::vector<std::vector<KnownEffect>> effects_of(std::span<const Shown> outputs) {
  std::vector<std::vector<KnownEffect>> effects(outputs.size());
  const auto together = [&](std::size_t a, std::size_t b) { return observed_together(outputs[a], outputs[b]); };
  for (const auto& group : groups_of(outputs.size(), together)) {
    std::vector<const Shown*> observed;
    for (const std::size_t k : group) observed.push_back(&outputs[k]);
    auto found = effects_together(observed);
    for (std::size_t i = 0; i < group.size(); ++i) effects[group[i]] = std::move(found[i]);
  }
  return effects;
}

std::vector<KnownEffect> effects_of(const Evidences& evidence, const Problem& problem, const Rows& rows,
                                    const std::vector<double>& coefficients) {
  const Shown shown{evidence, problem, rows, coefficients};
  return std::move(effects_of(std::span(&shown, 1)).front());
}

}  // namespace tumble::linear
