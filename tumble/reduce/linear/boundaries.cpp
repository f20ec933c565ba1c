#include "tumble/reduce/linear/boundaries.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tumble/math/median.hpp"
#include "tumble/math/regression/lack_of_fit.hpp"
#include "tumble/math/square.hpp"

namespace tumble::linear {
namespace {

/// Of the samples from one index to another that are present.
struct Level {
  double mean = 0.0, sd = 0.0;  ///< [SI of the output]
  double count = 0.0;
};

Level level_of(const EvenValues& values, std::size_t begin, std::size_t end) {
  Level level;
  double squares = 0.0;
  for (std::size_t i = begin; i < end; ++i) {
    if (std::isnan(values[i])) continue;
    const double d = values[i] - level.mean;
    level.mean += d / ++level.count;
    squares += d * (values[i] - level.mean);
  }
  if (level.count > 1.0) level.sd = std::sqrt(squares / (level.count - 1.0));
  return level;
}

/// The middle half of a segment.
Level middle_of(const Stretch& stretch) {
  const std::size_t quarter = stretch.samples / 4;
  return level_of(stretch.values, quarter, stretch.samples - quarter);
}

/// Two segments of which one follows the other without a pause.
struct Pair {
  const Stretch *before = nullptr, *after = nullptr;
  Level level_before, level_after;
};

bool adjoin(const ConductedTest& test, const Stretch& a, const Stretch& b) {
  if (a.recording != b.recording || a.power_up != b.power_up || a.segment + 1 != b.segment) return false;
  const double begin = b.power_on + test.power_ups[b.power_up].begins[b.segment];
  return std::abs(a.end - begin) < a.step;
}

std::vector<Pair> pairs_of(const ConductedTest& test) {
  constexpr std::size_t least = 8;  // samples, so that a middle and two ends remain
  std::vector<Pair> pairs;
  const auto& all = test.stretches;
  for (std::size_t k = 0; k + 1 < all.size(); ++k) {
    if (!adjoin(test, all[k], all[k + 1]) || std::min(all[k].values.size(), all[k + 1].values.size()) < least) continue;
    pairs.push_back({&all[k], &all[k + 1], middle_of(all[k]), middle_of(all[k + 1])});
    if (!(std::min(pairs.back().level_before.count, pairs.back().level_after.count) >= 4.0)) pairs.pop_back();
  }
  return pairs;
}

/// The outermost samples of one segment that lie towards the level of its neighbour.
struct Strays {
  double samples = 0.0, whole = 0.0;  ///< how many, and how many of the neighbour's they make
};

/// Given: step [SI of the output] from the segment's own level to that of the neighbour, last: at the end of the
/// segment.
Strays strays_of(const Stretch& stretch, const Level& own, double step, bool last) {
  Strays strays;
  const double least = std::max(6.0 * own.sd / std::abs(step), 1e-3);
  const std::size_t n = stretch.samples;
  for (std::size_t j = 0; j < n / 4; ++j) {
    const double v = stretch.values[last ? n - 1 - j : j];
    if (std::isnan(v)) continue;
    const double share = (v - own.mean) / step;
    if (!(share > least && share < 1.5)) break;
    ++strays.samples;
    strays.whole += std::min(share, 1.0);
  }
  return strays;
}

/// One finding for the ends of the segments, or for their begins.
Findings about_strays(const std::vector<Pair>& pairs, bool last, const std::string& role) {
  std::vector<double> shifts;
  std::size_t able = 0;
  const Stretch* first = nullptr;
  for (const Pair& pair : pairs) {
    const Stretch& stretch = last ? *pair.before : *pair.after;
    const Level &own = last ? pair.level_before : pair.level_after, &other = last ? pair.level_after : pair.level_before;
    const double step = other.mean - own.mean;
    if (!(std::abs(step) > 20.0 * own.sd)) continue;
    ++able;
    const Strays strays = strays_of(stretch, own, step, last);
    const bool slow = strays.samples - strays.whole >= 1.0;
    if (strays.samples < 1.0 || (slow && !last)) continue;
    if (first == nullptr) first = &stretch;
    shifts.push_back(strays.whole * stretch.step);
  }
  if (shifts.size() < 3 || 3 * shifts.size() < 2 * able) return {};
  return {{Finding::Severity::error,
           last ? "segments_end_in_next" : "segments_begin_in_last",
           {{"shift", median(shifts), "s"}, {"shown", shifts.size()}, {"segments", able}, {"first", first->label}},
           role}};
}

/// How the segments change from their first to their last third, for one unit of the step that led to them.
Findings about_settling(const std::vector<Pair>& pairs, const std::string& role) {
  constexpr double rare = 1e-5, negligible = 1e-9;
  double squares = 0.0, product = 0.0, total = 0.0;
  for (const Pair& pair : pairs) {
    const EvenValues& values = pair.after->values;
    const std::size_t third = pair.after->samples / 3, end = pair.after->samples;
    const Level first = level_of(values, 0, third), last = level_of(values, end - third, end);
    if (!(first.count > 0.0 && last.count > 0.0)) continue;
    const double step = pair.level_after.mean - pair.level_before.mean, change = last.mean - first.mean;
    squares += square(step);
    product += step * change;
    total += square(change);
  }
  const double freedom = static_cast<double>(pairs.size()) - 1.0, share = product / squares;
  if (!(freedom >= 3.0 && std::abs(share) > negligible)) return {};
  const double rest = std::max(total - share * product, 0.0) / freedom, ratio = share * product / rest;
  if (chance_of_ratio(ratio, 1.0, freedom) > rare) return {};
  return {{Finding::Severity::warning,
           "segments_settle",
           {{"share", std::abs(share), "%"}, {"times", std::sqrt(ratio)}, {"segments", pairs.size()}},
           role}};
}

}  // namespace

Findings about_boundaries(const ConductedTest& test, const std::string& role) {
  const auto pairs = pairs_of(test);
  if (Findings late = about_strays(pairs, true, role); !late.empty()) return late;
  if (Findings early = about_strays(pairs, false, role); !early.empty()) return early;
  return about_settling(pairs, role);
}

}  // namespace tumble::linear
