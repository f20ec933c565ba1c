#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>

#include "tumble/math/parallel.hpp"
#include "tumble/reduce/linear/rows.hpp"

namespace tumble::linear {
namespace {

constexpr double run_in = 2.0;  ///< [s] after which a response follows a ramp

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

/// The same at evenly spaced instants, as many as `felt` has room for.
template <class Value>
double mean_at(const Reference& reference, double begin, double length, std::span<Felt> felt, const Value& value) {
  const double step = length / static_cast<double>(felt.size());
  reference.felt(begin + 0.5 * step, step, felt);
  double sum = 0.0;
  for (const Felt& one : felt) sum += value(one);
  return sum / static_cast<double>(felt.size());
}

constexpr std::size_t points_of_block = 6;      ///< in a short block
constexpr std::size_t points_of_stretch = 192;  ///< in a stretch, or in one turn

/// The same over a stretch in which the rig turns evenly: what goes round with its axis is the same in each whole turn.
/// So one turn stands for all of them, with points enough for what comes round several times in it, and the rest of the
/// last one for itself. (Points strewn over all turns would leave of a ripple of the rate one over the root of their
/// number, a hundred times what the whole stretch does.)
template <class Value>
double mean_of_turns(const Reference& reference, const Segment& segment, double begin, double length,
                     const Value& value) {
  double turn = 0.0;
  for (const auto& [name, motion] : segment.axes)
    if (motion.kind == Motion::Kind::rate && motion.value != 0.0)
      turn = std::max(turn, 2.0 * M_PI / std::abs(motion.value));
  std::vector<Felt> felt(points_of_stretch);
  const double turns = turn > 0.0 ? std::floor(length / turn) * turn : 0.0;
  double mean = 0.0;
  if (turns > 0.0) mean += turns / length * mean_at(reference, begin, turn, std::span(felt), value);
  if (length - turns > 1e-9 * length)
    mean += (1.0 - turns / length) * mean_at(reference, begin + turns, length - turns, std::span(felt), value);
  return mean;
}

/// Adds the mean of `value` over every row that the power-ups of one plan give, `delay` [s] before. Where the rig
/// stands or turns evenly all rows have the mean over the stretch: an error that goes round with the axis averages out.
/// Elsewhere the blocks are short.
template <class Value>
void add_rows(const Evidences& evidence, const Rows& rows, std::size_t plan, const std::vector<Reference>& references,
              double delay, std::size_t points_in_block, const Value& value, std::vector<double>& column) {
  std::size_t row = 0;
  for (std::size_t g = 0; g < evidence.stretches.size(); ++g) {
    const Stretch& stretch = evidence.stretches[g];
    const std::size_t first = row;
    while (row < rows.segment.size() && rows.segment[row] == g) ++row;
    if (evidence.power_ups[stretch.power_up].plan_number != plan) continue;
    const Reference& reference = references[stretch.power_up];
    if (!stretch.whole.empty()) {
      column[first] += mean_over(reference, stretch.whole, value);
      continue;
    }
    const auto length = [&](std::size_t samples) { return static_cast<double>(samples) * stretch.step; };
    if (stretch.steady || stretch.even) {
      const double seconds = length(stretch.samples);
      const Segment& segment = evidence.power_ups[stretch.power_up].rig.segments[stretch.segment];
      const double mean = stretch.even ? mean_of_turns(reference, segment, stretch.first, seconds, value)
                                       : mean_over(reference, stretch.first, seconds,
                                                   std::min(stretch.samples, points_of_stretch), value);
      for (std::size_t i = first; i < row; ++i) column[i] += mean;
      continue;
    }
    std::array<Felt, points_of_block> felt;
    for (std::size_t i = first; i < row; ++i) {
      const std::size_t begin = rows.block[i] * stretch.per_block;
      const std::size_t size = std::min(stretch.per_block, stretch.samples - begin);
      column[i] += mean_at(reference, stretch.first + length(begin) - delay, length(size),
                           std::span(felt).first(std::min(size, points_in_block)), value);
    }
  }
}

/// How long the response lags behind a ramp [s].
double delay_of(const Problem& problem, double step) {
  if (!problem.response) return 0.0;
  std::vector<double> ramp(std::max<std::size_t>(64, static_cast<std::size_t>(run_in / step)));
  for (std::size_t k = 0; k < ramp.size(); ++k) ramp[k] = static_cast<double>(k) * step;
  const double last = ramp.back();
  problem.response(step)(ramp);
  return last - ramp.back();
}

/// One error of one plan's rig.
struct Job {
  std::size_t plan = 0, index = 0, count = 0;  ///< `count` errors in all
  RigError error;
};

std::vector<Job> jobs_of(const Evidences& evidence) {
  std::vector<Job> jobs;
  std::size_t next = 0;
  for (const auto& power_up : evidence.power_ups) {
    if (power_up.plan_number != next) continue;
    ++next;
    const auto errors = find_rig(power_up.plan->rig_kind).errors(power_up.plan->rig);
    for (std::size_t e = 0; e < errors.size(); ++e)
      if (errors[e].sd > 0.0) jobs.push_back({power_up.plan_number, e, errors.size(), errors[e]});
  }
  return jobs;
}

/// Unique among the plans.
std::string name_of(const Job& job) {
  return job.plan == 0 ? job.error.name : fmt::format("{} of plan {}", job.error.name, job.plan + 1);
}

/// How many instants stand for a short block: several, or its middle.
enum Look : std::size_t { close, glance };

/// What the instrument would show on every row; differences of it are the effects.
class Difference {
 public:
  Difference(const Evidences& evidence, const Problem& problem, const Rows& rows,
             const std::vector<double>& coefficients)
      : evidence_(evidence), problem_(problem), rows_(rows), coefficients_(coefficients) {
    delay_ = delay_of(problem, evidence.power_ups.front().step);
    for (const auto& power_up : evidence.power_ups) nominal_.push_back(power_up.reference);
    const auto value = [this](const Felt& felt) { return shown(felt); };
    for (const Look look : {close, glance}) {
      without_[look].assign(rows.weights.size(), 0.0);
      for (std::size_t p = 0; p < evidence.plans; ++p) add(p, nominal_, look, value, without_[look]);
    }
    for (const double one : without_[close]) size_ = std::max(size_, std::abs(one));
  }

  double shown(const Felt& felt) const { return indicated(problem_, coefficients_, felt); }

  template <class Value>
  void add(std::size_t plan, const std::vector<Reference>& references, Look look, const Value& value,
           std::vector<double>& column) const {
    add_rows(evidence_, rows_, plan, references, delay_, look == close ? points_of_block : 1, value, column);
  }

  /// The shift where the error is at its standard deviation in the segments (of each power-up) chosen.
  std::vector<double> of(const Job& job, Look look, const std::function<bool(std::size_t segment)>& chosen) const {
    std::vector<Reference> references(evidence_.power_ups.size());
    for (std::size_t u = 0; u < references.size(); ++u) {
      const PowerUp& power_up = evidence_.power_ups[u];
      if (power_up.plan_number != job.plan) continue;
      RigRun run = power_up.rig;
      run.errors = Matrix(job.count, run.segments.size());
      for (std::size_t s = 0; s < run.segments.size(); ++s) run.errors(job.index, s) = chosen(s) ? job.error.sd : 0.0;
      references[u] = find_rig(power_up.plan->rig_kind).reference(run);
    }
    std::vector<double> shift(rows_.weights.size(), 0.0);
    const auto value = [this](const Felt& felt) { return shown(felt); };
    add(job.plan, references, look, value, shift);
    for (std::size_t i = 0; i < shift.size(); ++i) {
      const auto& stretch = evidence_.stretches[rows_.segment[i]];
      shift[i] = evidence_.power_ups[stretch.power_up].plan_number == job.plan ? shift[i] - without_[look][i] : 0.0;
    }
    return shift;
  }

  /// The shift of a move used whole, in this row, by the draw of one segment.
  double of_move(const Job& job, const Stretch& stretch, std::size_t row, std::size_t segment) const {
    const PowerUp& power_up = evidence_.power_ups[stretch.power_up];
    if (power_up.plan_number != job.plan) return 0.0;
    RigRun run = power_up.rig;
    run.errors = Matrix(job.count, run.segments.size());
    run.errors(job.index, segment) = job.error.sd;
    const auto value = [this](const Felt& felt) { return shown(felt); };
    return mean_over(find_rig(power_up.plan->rig_kind).reference(run), stretch.whole, value) - without_[close][row];
  }

  bool rounding(double shift) const { return std::abs(shift) <= 1e-13 * size_; }
  bool rounding(const std::vector<double>& shift) const {
    return std::ranges::all_of(shift, [&](double one) { return rounding(one); });
  }

  const std::vector<Reference>& nominal() const { return nominal_; }

 private:
  const Evidences& evidence_;
  const Problem& problem_;
  const Rows& rows_;
  const std::vector<double>& coefficients_;
  double delay_ = 0.0, size_ = 0.0;
  std::vector<Reference> nominal_;
  std::array<std::vector<double>, 2> without_;
};

/// Which segment's error moves each stretch: an angle that is gone to once stays wrong until the next. The segments are
/// told apart by the bits of their number, one look at the rig a bit.
std::vector<std::size_t> drivers_of(const Evidences& evidence, const Rows& rows, const Difference& difference,
                                    const Job& job) {
  const auto all = difference.of(job, glance, [](std::size_t) { return true; });
  std::size_t most = 0;
  for (const auto& stretch : evidence.stretches) most = std::max(most, stretch.segment);
  for (const auto& power_up : evidence.power_ups) most = std::max(most, power_up.rig.segments.size());
  std::vector<std::size_t> drivers(evidence.stretches.size(), 0);
  std::vector<bool> clear(drivers.size(), true);
  for (std::size_t bit = 0; (most >> bit) > 0; ++bit) {
    const auto some = difference.of(job, glance, [bit](std::size_t segment) { return ((segment >> bit) & 1) != 0; });
    std::vector<double> product(drivers.size(), 0.0), square(drivers.size(), 0.0);
    for (std::size_t i = 0; i < all.size(); ++i) {
      product[rows.segment[i]] += some[i] * all[i];
      square[rows.segment[i]] += all[i] * all[i];
    }
    for (std::size_t g = 0; g < drivers.size(); ++g) {
      const double share = square[g] > 0.0 ? product[g] / square[g] : 0.0;
      if (std::abs(share - 1.0) < 0.1)
        drivers[g] |= std::size_t{1} << bit;
      else if (std::abs(share) > 0.1)
        clear[g] = false;
    }
  }
  for (std::size_t g = 0; g < drivers.size(); ++g)
    if (!clear[g]) drivers[g] = evidence.stretches[g].segment;
  return drivers;
}

/// One draw of an error that is drawn anew for each segment: the rows it shifts.
struct Draw {
  std::vector<std::size_t> stretches;                  ///< at rest or in blocks: shifted as by all draws together
  std::vector<std::pair<std::size_t, double>> totals;  ///< rows of moves used whole, and the shift
};

/// A move from rest to rest is shifted by the draw of its own angle and by that of the angle it begins at.
void add_totals(const Evidences& evidence, const Rows& rows, const Difference& difference, const Job& job,
                std::map<std::tuple<std::size_t, int, std::size_t>, Draw>& draws) {
  for (std::size_t row = 0; row < rows.segment.size(); ++row) {
    const Stretch& stretch = evidence.stretches[rows.segment[row]];
    if (stretch.whole.empty()) continue;
    for (std::size_t segment = stretch.segment + 1, earlier = 0; segment-- > 0 && earlier == 0;) {
      const double shift = difference.of_move(job, stretch, row, segment);
      if (difference.rounding(shift)) continue;
      draws[{stretch.power_up, stretch.run, segment}].totals.emplace_back(row, shift);
      if (segment < stretch.segment) ++earlier;
    }
  }
}

/// The shift by an error drawn anew for each segment. Stretches moved by one and the same draw share a column; the
/// others have draws of their own.
void add_each_segment(const Evidences& evidence, const Rows& rows, const Difference& difference, const Job& job,
                      const std::vector<double>& all, std::vector<KnownEffect>& effects) {
  const auto drivers = drivers_of(evidence, rows, difference, job);
  const auto name = [&](std::size_t power_up, int run, std::size_t driver) {
    const auto& segments = evidence.power_ups[power_up].rig.segments;
    return fmt::format("{}, segment '{}' ({} of power-up {}, run {})", name_of(job), segments[driver].label, driver + 1,
                       power_up + 1, run);
  };
  std::map<std::tuple<std::size_t, int, std::size_t>, Draw> draws;
  KnownEffect own{job.error.name, all, true};
  for (std::size_t g = 0; g < drivers.size(); ++g) {
    const auto& stretch = evidence.stretches[g];
    if (stretch.whole.empty()) draws[{stretch.power_up, stretch.run, drivers[g]}].stretches.push_back(g);
    own.draws.push_back(name(stretch.power_up, stretch.run, stretch.whole.empty() ? drivers[g] : stretch.segment));
  }
  for (std::size_t i = 0; i < all.size(); ++i)
    if (!evidence.stretches[rows.segment[i]].whole.empty()) own.column[i] = 0.0;
  add_totals(evidence, rows, difference, job, draws);
  for (const auto& [key, draw] : draws) {
    if (draw.stretches.size() < 2 && draw.totals.empty()) continue;
    const auto& [power_up, run, driver] = key;
    KnownEffect shared{job.error.name, std::vector<double>(all.size(), 0.0), false, {name(power_up, run, driver)}};
    for (std::size_t i = 0; i < all.size(); ++i)
      if (std::ranges::find(draw.stretches, rows.segment[i]) != draw.stretches.end())
        std::swap(shared.column[i], own.column[i]);
    for (const auto& [row, shift] : draw.totals) shared.column[row] = shift;
    if (!difference.rounding(shared.column)) effects.push_back(std::move(shared));
  }
  if (!difference.rounding(own.column)) effects.push_back(std::move(own));
}

}  // namespace

std::vector<KnownEffect> effects_of(const Evidences& evidence, const Problem& problem, const Rows& rows,
                                    const std::vector<double>& coefficients) {
  const Difference difference(evidence, problem, rows, coefficients);
  const auto jobs = jobs_of(evidence);
  const bool moved_whole = std::ranges::any_of(evidence.stretches, [](const auto& s) { return !s.whole.empty(); });
  std::vector<std::vector<KnownEffect>> found(jobs.size());
  parallel_for(jobs.size(), [&](std::size_t k) {
    auto all = difference.of(jobs[k], close, [](std::size_t) { return true; });
    if (difference.rounding(all) && !(jobs[k].error.each_segment && moved_whole)) return;
    if (jobs[k].error.each_segment)
      add_each_segment(evidence, rows, difference, jobs[k], all, found[k]);
    else
      found[k].push_back({jobs[k].error.name, std::move(all), false, {name_of(jobs[k])}});
  });
  std::vector<KnownEffect> effects;
  for (auto& some : found) std::ranges::move(some, std::back_inserter(effects));
  for (const auto& error : problem.reading_errors) {
    if (!(error.sd > 0.0)) continue;
    KnownEffect effect{error.source, std::vector<double>(rows.weights.size(), 0.0), false};
    const auto value = [&](const Felt& felt) { return error.sd * error.change(felt, difference.shown(felt)); };
    for (std::size_t p = 0; p < evidence.plans; ++p)
      difference.add(p, difference.nominal(), close, value, effect.column);
    effects.push_back(std::move(effect));
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
