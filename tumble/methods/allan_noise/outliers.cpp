#include "tumble/methods/allan_noise/outliers.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "tumble/methods/allan_noise/disturbed.hpp"

namespace tumble::allan_noise {
namespace {

constexpr std::size_t fewest_distances = 8;  ///< of which quantiles are taken
/// Two quantiles of the magnitudes [1], and where the normal distribution has them [sd].
constexpr double middle_share = 0.5, middle_size = 0.67449, upper_share = 0.65, upper_size = 0.93459;
constexpr std::size_t means_of_period = 8;  ///< of the means that show a ringing best, in its period at most

constexpr double at_jump = 1.5;  ///< change over departure: 2 of a step, 0 of a single value
constexpr std::size_t measured_on = 65536, per_mean = 4, most_events = 20000;

/// Standard deviation from the middle of the distances, of which some may be outliers; the upper of two quantiles, so
/// that a coarse output whose distances are mostly zero has one. 0: nearly all are zero.
double robust_sd(std::vector<double>& distances) {
  if (distances.size() < fewest_distances) return 0.0;
  const auto quantile = [&](double share) {
    const auto at = distances.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(distances.size() - 1));
    std::nth_element(distances.begin(), at, distances.end());
    return *at;
  };
  return std::max(quantile(middle_share) / middle_size, quantile(upper_share) / upper_size);
}

/// From the mean of the two values beside it.
double departure(const double* y) { return y[0] - 0.5 * (y[-1] + y[1]); }

/// Samples of a value of the scale.
std::size_t samples_of(std::size_t scale) {
  std::size_t samples = 1;
  for (std::size_t k = 0; k < scale; ++k) samples *= per_mean;
  return samples;
}

/// Joins an event with those before it that it touches.
void join(const Outlier& event, std::vector<Outlier>& events) {
  if (!events.empty()) {
    Outlier& last = events.back();
    // Of what rings only crests are far; one may be missed: a period, up to means_of_period of the means that show it
    // best.
    const std::size_t length = event.end - event.begin;
    const std::size_t reach =
        std::max<std::size_t>({2, last.end - last.begin, event.broad ? means_of_period * length : length});
    if (event.begin < last.end + reach) {
      if (std::abs(event.deviations) > std::abs(last.deviations)) {
        last.worst = event.worst;
        last.departure = event.departure;
        last.deviations = event.deviations;
      }
      last.end = std::max(last.end, event.end);
      last.samples += event.samples;
      last.broad = last.broad || event.broad;
      return;
    }
  }
  events.push_back(event);
}

/// What single samples that are far contribute to the departure of a mean.
double share_of(const std::vector<Outlier>& single, const Outlier& mean) {
  const std::size_t length = mean.end - mean.begin, from = mean.begin - std::min(mean.begin, length);
  double sum = 0.0;
  for (auto one = std::ranges::lower_bound(single, from, {}, &Outlier::begin);
       one != single.end() && one->begin < mean.end + length; ++one)
    sum += one->departure * (one->begin >= mean.begin && one->begin < mean.end ? 1.0 : -0.5);
  return sum / static_cast<double>(length);
}

double median_of_four(const double* y) {
  std::array<double, 4> beside{y[-2], y[-1], y[1], y[2]};
  std::ranges::sort(beside);
  return 0.5 * (beside[1] + beside[2]);
}

}  // namespace

void OutlierSearch::push(std::span<const double> values) { take(0, values); }

void OutlierSearch::take(std::size_t number, std::span<const double> values) {
  Scale& scale = scales_[number];
  while (!values.empty()) {
    const auto some = values.first(std::min(values.size(), measured_on));
    scale.waiting.insert(scale.waiting.end(), some.begin(), some.end());
    if (scale.measured || scale.waiting.size() >= measured_on) look(number);
    values = values.subspan(some.size());
    if (number + 1 == scales_.size()) continue;
    std::vector<double> means;
    for (const double value : some) {
      scale.sum += value;
      if (++scale.summed < per_mean) continue;
      means.push_back(scale.sum / static_cast<double>(per_mean));
      scale.sum = 0.0;
      scale.summed = 0;
    }
    take(number + 1, means);
  }
}

void OutlierSearch::measure(std::size_t number) {
  Scale& scale = scales_[number];
  std::vector<double> distances;
  for (std::size_t i = 1; i + 1 < scale.waiting.size(); ++i)
    if (const double distance = std::abs(departure(&scale.waiting[i])); !std::isnan(distance))
      distances.push_back(distance);
  scale.usual = robust_sd(distances);
  scale.measured = true;
}

/// Pieces in which nothing is far are passed in one loop without branches.
void OutlierSearch::look(std::size_t number) {
  Scale& scale = scales_[number];
  if (!scale.measured) measure(number);
  constexpr std::size_t piece = 256;
  const std::size_t size = samples_of(number), count = scale.waiting.size();
  const double most = far * scale.usual;
  const double* const y = scale.waiting.data();
  for (std::size_t first = 1; scale.usual > 0.0 && first + 1 < count; first += piece) {
    const std::size_t last = std::min(first + piece, count - 1);
    bool any = false;
    for (std::size_t i = first; i < last; ++i) any |= std::abs(departure(y + i)) > most;
    if (!any) continue;
    for (std::size_t i = first; i < last; ++i) {
      const double off = departure(y + i);
      if (!(std::abs(off) > most)) continue;
      // A single value throws its neighbours off by half as much: they are not far themselves.
      const bool beside = (i > 1 && std::abs(departure(y + i - 1)) > std::abs(off)) ||
                          (i + 2 < count && std::abs(departure(y + i + 1)) > std::abs(off));
      // Where the level changes and stays, as of a jump of the bias, the value lies at one end of the change.
      if (beside || std::abs(y[i + 1] - y[i - 1]) > at_jump * std::abs(off)) continue;
      const std::size_t begin = (scale.first + i) * size;
      if (events_.size() < most_events)
        events_.push_back({begin, begin + size, begin + size / 2, 1, off, off / scale.usual, number > 0});
    }
  }
  const std::size_t passed = count - std::min<std::size_t>(count, 2);
  scale.waiting.erase(scale.waiting.begin(), scale.waiting.begin() + static_cast<std::ptrdiff_t>(passed));
  scale.first += passed;
}

std::vector<Outlier> OutlierSearch::events() {
  for (std::size_t scale = 0; scale < scales_.size(); ++scale) look(scale);
  std::ranges::stable_sort(events_, {}, &Outlier::begin);
  std::vector<Outlier> single, joined;
  std::ranges::copy_if(events_, std::back_inserter(single), [](const Outlier& event) { return !event.broad; });
  for (const Outlier& event : events_) {
    // The share that single samples have in a mean and in those beside it: a mean that is not far without is theirs.
    const double rest = event.departure - share_of(single, event);
    if (event.broad && std::abs(rest) <= far * event.departure / event.deviations) continue;
    join(event, joined);
  }
  return joined;
}

bool are_rare(const std::vector<Outlier>& events, std::size_t samples) {
  constexpr double most_share = 0.01;
  double all = 0.0;
  for (const Outlier& event : events) all += static_cast<double>(event.end - event.begin);
  return all <= most_share * static_cast<double>(samples);
}

bool is_knock(const Outlier& event) { return event.broad || event.end - event.begin >= 4; }

std::vector<double> without_outliers(std::span<const double> values, std::size_t& removed) {
  constexpr double most = 4.0;
  std::vector<double> rest(values.begin(), values.end()), distances;
  const std::size_t stride = 1 + values.size() / measured_on;
  for (std::size_t i = 2; i + 2 < values.size(); i += stride)
    if (const double distance = std::abs(values[i] - median_of_four(&values[i])); !std::isnan(distance))
      distances.push_back(distance);
  const double limit = most * robust_sd(distances);
  removed = 0;
  if (!(limit > 0.0)) return rest;
  for (std::size_t i = 2; i + 2 < values.size(); ++i)
    if (std::abs(values[i] - median_of_four(&values[i])) > limit) {
      rest[i] = std::nan("");
      ++removed;
    }
  return rest;
}

void find_outliers(const Settings& settings, EvenSignal& signal, ChannelNoise& result) {
  OutlierSearch search;
  search.push(signal.values);
  result.outliers = search.events();
  if (result.outliers.empty() || settings.word("disturbed") != "cut" ||
      !are_rare(result.outliers, signal.values.size()))
    return;
  const std::size_t longest = block_scatter(signal.values).size;
  std::vector<RecordPart> parts;
  for (const Outlier& event : result.outliers) {
    const std::size_t length = event.end - event.begin, margin = std::max(longest / 2, length);
    if (!is_knock(event) || length > longest) continue;
    const std::size_t begin = event.begin - std::min(event.begin, margin);
    if (!parts.empty() && begin <= parts.back().end)
      parts.back().end = event.end + margin;
    else
      parts.push_back({begin, event.end + margin});
  }
  if (parts.empty()) return;
  parts.back().end = std::min(parts.back().end, signal.values.size());
  set_missing(parts, signal);
  result.knocks_set_aside = parts;
}

void settle_outliers(ChannelNoise& result) {
  std::erase_if(result.outliers, [&](const Outlier& event) {
    return std::ranges::any_of(
               result.set_aside,
               [&](const RecordPart& part) { return part.begin < event.end && event.begin < part.end; }) &&
           std::ranges::none_of(result.knocks_set_aside, [&](const RecordPart& part) {
             return part.begin < event.end && event.begin < part.end;
           });
  });
  auto& all = result.set_aside;
  all.insert(all.end(), result.knocks_set_aside.begin(), result.knocks_set_aside.end());
  std::ranges::stable_sort(all, {}, &RecordPart::begin);
}

}  // namespace tumble::allan_noise
