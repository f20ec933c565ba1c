#include "tumble/methods/allan_noise/temperature.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/columns.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/stability/allan_fit.hpp"
#include "tumble/methods/allan_noise/slow_courses.hpp"
#include "tumble/methods/allan_noise/words.hpp"

namespace tumble::allan_noise {
namespace {

/// Variance of the temperature, and of its rate of change, over that of the noise in its averages: noise makes the size
/// of a column 3 % too small at 30, and 10 % at 10, where the effect of the rate is small beside the other.
constexpr double least_over_noise = 30.0, least_rate_over_noise = 10.0;

constexpr std::size_t most_temperature_averages = 2048, fewest_temperature_averages = 32;

/// Noise of averages by their second differences, which are six times its variance where it is white, and hardly hold
/// what moves slowly; variance of the averages; mean square of their first differences [K^2].
struct Movement {
  double noise = 0.0, level = 0.0, steps = 0.0, count = 0.0;
};

Movement movement_of(const std::vector<double>& means) {
  Movement of;
  double sum = 0.0, squares = 0.0, measured = 0.0, second = 0.0;
  const double origin = *std::ranges::find_if(means, [](double v) { return !std::isnan(v); });
  for (std::size_t k = 0; k < means.size(); ++k) {
    if (std::isnan(means[k])) continue;
    sum += means[k] - origin;
    squares += std::pow(means[k] - origin, 2);
    ++measured;
    if (k + 2 >= means.size() || std::isnan(means[k + 1] + means[k + 2])) continue;
    second += std::pow(means[k + 2] - 2.0 * means[k + 1] + means[k], 2);
    of.steps += std::pow(means[k + 1] - means[k], 2);
    ++of.count;
  }
  if (!(of.count > 0.0)) return of;
  of.noise = second / of.count / 6.0;
  of.steps /= of.count;
  of.level = std::max(0.0, squares / measured - std::pow(sum / measured, 2));
  return of;
}

/// Averages of a thermometer that are as short as its noise allows, and whether they show its rate of change.
struct Warmth {
  SlowAverages averages;
  std::size_t stride = 1;  ///< [samples]
  bool rate = false;
};

std::optional<Warmth> warmth_of(std::span<const double> temperature, double rate) {
  std::optional<Warmth> of;
  for (std::size_t most = most_temperature_averages; most >= fewest_temperature_averages; most /= 2) {
    const std::size_t stride = slow_stride(temperature.size(), most);
    SlowAverages averages = slow_averages(temperature, rate, stride);
    if (std::ranges::all_of(averages.mean, [](double v) { return std::isnan(v); })) return {};
    const Movement moves = movement_of(averages.mean);
    if (moves.count < fewest_temperature_averages / 2) return of;
    if (!(moves.level > least_over_noise * moves.noise)) continue;
    const bool shows_rate = moves.steps > 2.0 * least_rate_over_noise * moves.noise;
    if (!of || shows_rate) of = Warmth{std::move(averages), stride, shows_rate};
    if (shows_rate) return of;
  }
  return of;
}

/// [K] and [K/s] for each average; share becomes 0 where one of them is not known.
Matrix temperature_columns(const Warmth& warmth, std::vector<double>& share) {
  const std::vector<double>& mean = warmth.averages.mean;
  const std::size_t n = mean.size();
  Matrix columns(n, warmth.rate ? 2 : 1);
  double sum = 0.0, count = 0.0;
  for (const double value : mean)
    if (!std::isnan(value)) sum += value, ++count;
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t before = k > 0 ? k - 1 : k, after = k + 1 < n ? k + 1 : k;
    const double rate = (mean[after] - mean[before]) / (static_cast<double>(after - before) * warmth.averages.interval);
    if (std::isnan(mean[k]) || (warmth.rate && std::isnan(rate))) {
      share[k] = 0.0;
      continue;
    }
    columns(k, 0) = mean[k] - sum / count;
    if (warmth.rate) columns(k, 1) = rate;
  }
  return columns;
}

/// Values of averages over `stride` samples at each of n samples, straight between the middles of neighbours.
std::vector<double> at_samples(const std::vector<double>& of_averages, std::size_t stride, std::size_t n) {
  std::vector<double> values(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double at = std::clamp((static_cast<double>(i) + 0.5) / static_cast<double>(stride) - 0.5, 0.0,
                                 static_cast<double>(of_averages.size() - 1));
    const auto left = static_cast<std::size_t>(at);
    const std::size_t right = std::min(left + 1, of_averages.size() - 1);
    const double part = at - static_cast<double>(left);
    values[i] = (1.0 - part) * of_averages[left] + part * of_averages[right];
  }
  return values;
}

double explained_by(const SlowAverages& averages, const std::vector<double>& course) {
  double n = 0.0, x = 0.0, xx = 0.0, y = 0.0, yy = 0.0;
  for (std::size_t k = 0; k < course.size(); ++k) {
    if (!(averages.share[k] > 0.0)) continue;
    const double value = averages.mean[k] - averages.mean[0], rest = value - course[k];
    ++n;
    x += value;
    xx += value * value;
    y += rest;
    yy += rest * rest;
  }
  const double total = xx - x * x / n;
  return total > 0.0 ? std::max(0.0, 1.0 - (yy - y * y / n) / total) : 0.0;
}

}  // namespace

std::optional<TemperatureCourse> temperature_course(std::span<const double> values, std::span<const double> temperature,
                                                    const ChannelNoise& channel) {
  if (values.size() != temperature.size() || values.size() < fewest_temperature_averages) return {};
  const auto warmth = warmth_of(temperature, channel.rate);
  if (!warmth) return {};
  SlowAverages averages = slow_averages(values, channel.rate, warmth->stride);
  TemperatureCourse found;
  found.columns = temperature_columns(*warmth, averages.share);
  const auto fits = fit_courses(averages, {found.columns}, channel.fit, channel.rate);
  if (fits.empty() || fits[0].size.empty()) return {};
  const auto count = static_cast<double>(found.columns.columns);
  TemperatureEffect& effect = found.effect;
  effect.average = averages.interval;
  effect.slope = fits[0].size[0];
  effect.slope_sd = std::sqrt(fits[0].covariance(0, 0));
  if (warmth->rate) {
    effect.of_rate = fits[0].size[1];
    effect.of_rate_sd = std::sqrt(fits[0].covariance(1, 1));
  }
  effect.chance = chi_square_tail(fits[0].fall / count, count);
  const auto of_temperature = column(found.columns, 0);
  const auto [low, high] = std::ranges::minmax(of_temperature);
  effect.range = high - low;
  const auto course = found.columns * fits[0].size;
  effect.explained = explained_by(averages, course);
  found.of_bias = at_samples(course, warmth->stride, values.size());
  return found;
}

const Channel* temperature_of(const Recording& recording, const Channel& beside) {
  for (const auto& channel : recording.channels)
    if (channel.kind == QuantityKind::temperature && channel.values.size() == beside.values.size()) return &channel;
  return nullptr;
}

Finding follows_temperature(const ChannelNoise& channel) {
  const TemperatureEffect& effect = *channel.temperature;
  const bool gyro = channel.kind == QuantityKind::angular_rate;
  const Unit slope = Unit::parse(gyro ? "deg/h/K" : "ug/K");
  const Unit of_rate = Unit::parse(gyro ? "deg/h/(K/min)" : "ug/(K/min)");
  return {Finding::Severity::warning,
          "output_follows_temperature",
          {{"temperature", channel.thermometer},
           {"slope", effect.slope, slope},
           {"slope_sd", effect.slope_sd, slope},
           {"of_rate", effect.of_rate, of_rate},
           {"of_rate_sd", effect.of_rate_sd, of_rate},
           {"range", effect.range, "K"},
           {"explained", effect.explained, "%"},
           {"average", effect.average, "s"},
           {"p", std::max(effect.chance, least_shown_p)}},
          channel.label};
}

void describe_temperature(const std::vector<ChannelNoise>& channels, Estimate& estimate) {
  struct Row {
    const ChannelNoise& channel;
    const TemperatureEffect& effect;

    bool gyro() const { return channel.kind == QuantityKind::angular_rate; }
    std::string shown(double value, double sd, const std::string& unit) const {
      const Unit in = Unit::parse(unit);
      return fmt::format("{:.3g} +- {:.2g} {}", in.difference_from_si(value), in.difference_from_si(sd), unit);
    }
  };
  std::vector<Row> rows;
  for (const ChannelNoise& channel : channels)
    if (channel.failure.empty() && channel.temperature) rows.push_back({channel, *channel.temperature});
  const auto slope = [](const Row& r) {
    return r.shown(r.effect.slope, r.effect.slope_sd, r.gyro() ? "deg/h/K" : "ug/K");
  };
  const auto of_rate = [](const Row& r) {
    return r.effect.of_rate_sd > 0.0
               ? r.shown(r.effect.of_rate, r.effect.of_rate_sd, r.gyro() ? "deg/h/(K/min)" : "ug/(K/min)")
               : std::string();
  };
  add_unless_empty(
      estimate.tables,
      tabulate("temperature", "how the channels follow the temperature: maximum likelihood beside the noise", rows,
               {{"channel", [](const Row& r) { return r.channel.label; }},
                {"with", [](const Row& r) { return r.channel.thermometer; }},
                {"range", "K", [](const Row& r) { return r.effect.range; }},
                {"by temperature", slope},
                {"by its rate of change", of_rate},
                {"explains", [](const Row& r) { return fmt::format("{:.0f} %", 100.0 * r.effect.explained); }},
                {"chance", [](const Row& r) { return fmt::format("{:.2g} %", 100.0 * r.effect.chance); }}}));
}

}  // namespace tumble::allan_noise
