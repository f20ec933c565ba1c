#include "tumble/methods/allan_noise/temperature.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>

#include "tumble/core/columns.hpp"
#include "tumble/language/say.hpp"
#include "tumble/math/noise/whitening.hpp"
#include "tumble/methods/allan_noise/disturbed.hpp"
#include "tumble/methods/allan_noise/input.hpp"
#include "tumble/methods/allan_noise/words.hpp"
#include "tumble/units/error.hpp"

namespace tumble::allan_noise {
namespace {

/// Mean square of the temperature over that of its steps. Below it the temperature scatters from average to average,
/// and an effect of it would be found in noise.
constexpr double least_smoothness = 30.0;

constexpr std::size_t most_averages = 64, fewest_averages = 16;

struct Averages {
  std::vector<double> mean, share;
};

Averages averages_of(std::span<const double> values, std::size_t stride) {
  const std::size_t count = values.size() / stride;
  Averages result{std::vector<double>(count, 0.0), std::vector<double>(count, 0.0)};
  for (std::size_t k = 0; k < count; ++k) {
    double sum = 0.0, there = 0.0;
    for (const double value : values.subspan(k * stride, stride)) {
      if (std::isnan(value)) continue;
      sum += value;
      ++there;
    }
    result.mean[k] = there > 0.0 ? sum / there : std::nan("");
    result.share[k] = there / static_cast<double>(stride);
  }
  return result;
}

/// The noise of averages, and the degrees of freedom with which its slow part is known.
struct Noise {
  NoiseModel model;
  double freedom = 1e6;
};

Noise noise_of(const ChannelNoise& channel, double interval) {
  Noise noise;
  for (const FittedTerm& term : channel.fit.terms) {
    const NoiseTerm kind = term.unit.term;
    const bool limit = !term.kept && kind == NoiseTerm::random_walk;
    if (!term.kept && !limit) continue;
    const double value = coefficient(kind, limit ? term.upper_limit : term.squared, channel.rate);
    if (kind == NoiseTerm::white) noise.model.angle_random_walk = value;
    if (kind == NoiseTerm::flicker) noise.model.bias_instability = value;
    if (kind == NoiseTerm::random_walk) noise.model.rate_random_walk = value;
    if (kind == NoiseTerm::markov && value > noise.model.markov_sd) {
      noise.model.markov_sd = value;
      noise.model.markov_time = term.unit.markov_time / channel.rate;
    }
    if (kind != NoiseTerm::white && kind != NoiseTerm::quantization && term.kept)
      noise.freedom = std::min(noise.freedom, term.degrees_of_freedom);
    // Quantization in an average, as if independent from one to the next.
    if (kind == NoiseTerm::quantization)
      noise.model.angle_random_walk = std::max(noise.model.angle_random_walk, value * std::sqrt(2.0 / interval));
  }
  return noise;
}

/// Constant, temperature, rate of change, signal: a row for each average that has all.
Matrix design_of(const Averages& signal, const Averages& temperature, double interval, std::vector<double>& share) {
  const std::size_t count = signal.mean.size();
  Matrix design(count, 4);
  share.assign(count, 0.0);
  double origin = 0.0, warm = 0.0, rows = 0.0;
  for (std::size_t k = 1; k + 1 < count; ++k) {
    const double rate = (temperature.mean[k + 1] - temperature.mean[k - 1]) / (2.0 * interval);
    if (std::isnan(rate) || std::isnan(temperature.mean[k]) || std::isnan(signal.mean[k])) continue;
    share[k] = signal.share[k];
    design(k, 2) = rate;
    origin += signal.mean[k];
    warm += temperature.mean[k];
    ++rows;
  }
  for (std::size_t k = 0; k < count; ++k) {
    if (share[k] == 0.0) continue;
    design(k, 0) = 1.0;
    design(k, 1) = temperature.mean[k] - warm / rows;
    design(k, 3) = signal.mean[k] - origin / rows;
  }
  return design;
}

/// Whether the temperature moves by more than its averages scatter from one to the next.
bool moves(const Matrix& design, const std::vector<double>& share) {
  double level = 0.0, steps = 0.0, rows = 0.0;
  for (std::size_t k = 1; k < design.rows; ++k) {
    if (share[k] == 0.0 || share[k - 1] == 0.0) continue;
    level += design(k, 1) * design(k, 1);
    steps += 0.5 * std::pow(design(k, 1) - design(k - 1, 1), 2);
    ++rows;
  }
  return rows >= fewest_averages && level > least_smoothness * steps;
}

/// Slopes and their covariance from whitened columns, without the constant.
void regress(const Matrix& design, const std::vector<double>& share, const Noise& noise, TemperatureEffect& effect) {
  Matrix block = design;
  Whitening(noise.model, effect.average, effect.average * static_cast<double>(block.rows))(block, share);
  double s[4][4] = {};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j)
      for (std::size_t k = 0; k < block.rows; ++k) s[i][j] += block(k, i) * block(k, j);
  const auto centred = [&](std::size_t i, std::size_t j) { return s[i][j] - s[0][i] * s[0][j] / s[0][0]; };
  const double determinant = centred(1, 1) * centred(2, 2) - centred(1, 2) * centred(1, 2);
  effect.slope = (centred(2, 2) * centred(1, 3) - centred(1, 2) * centred(2, 3)) / determinant;
  effect.of_rate = (centred(1, 1) * centred(2, 3) - centred(1, 2) * centred(1, 3)) / determinant;
  effect.slope_sd = std::sqrt(centred(2, 2) / determinant);
  effect.of_rate_sd = std::sqrt(centred(1, 1) / determinant);
  const double statistic = 0.5 * (effect.slope * centred(1, 3) + effect.of_rate * centred(2, 3));
  const boost::math::fisher_f_distribution<double> f(2.0, noise.freedom);
  effect.chance = boost::math::cdf(boost::math::complement(f, std::max(0.0, statistic)));
}

double share_explained(const Matrix& design, const std::vector<double>& share, const TemperatureEffect& effect) {
  double total = 0.0, squares = 0.0, sum = 0.0, rows = 0.0;
  for (std::size_t k = 0; k < design.rows; ++k) {
    if (share[k] == 0.0) continue;
    const double residual = design(k, 3) - effect.slope * design(k, 1) - effect.of_rate * design(k, 2);
    total += design(k, 3) * design(k, 3);
    squares += residual * residual;
    sum += residual;
    ++rows;
  }
  return total > 0.0 ? std::max(0.0, 1.0 - (squares - sum * sum / rows) / total) : 0.0;
}

std::string shown(double value, double sd, const std::string& unit) {
  const Unit in = Unit::parse(unit);
  return fmt::format("{:.3g} +- {:.2g} {}", in.difference_from_si(value), in.difference_from_si(sd), unit);
}

Finding follows(const TemperatureEffect& effect, const ChannelNoise& channel, const Channel& temperature) {
  const bool gyro = channel.kind == QuantityKind::angular_rate;
  const Unit slope = Unit::parse(gyro ? "deg/h/K" : "ug/K");
  const Unit of_rate = Unit::parse(gyro ? "deg/h/(K/min)" : "ug/(K/min)");
  return {Finding::Severity::warning,
          "output_follows_temperature",
          {{"temperature", temperature.name},
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

const Channel* temperature_of(const Recording& recording, const Channel& beside) {
  for (const auto& channel : recording.channels)
    if (channel.kind == QuantityKind::temperature && channel.values.size() == beside.values.size()) return &channel;
  return nullptr;
}

}  // namespace

std::optional<TemperatureEffect> temperature_effect(std::span<const double> values, std::span<const double> temperature,
                                                    const ChannelNoise& channel) {
  if (values.size() != temperature.size() || values.size() < fewest_averages) return {};
  const std::size_t stride = (values.size() + most_averages - 1) / most_averages;
  TemperatureEffect effect;
  effect.average = static_cast<double>(stride) / channel.rate;
  std::vector<double> share;
  const Matrix design = design_of(averages_of(values, stride), averages_of(temperature, stride), effect.average, share);
  if (!moves(design, share)) return {};
  double low = 0.0, high = 0.0;
  for (std::size_t k = 0; k < design.rows; ++k) {
    low = std::min(low, design(k, 1));
    high = std::max(high, design(k, 1));
  }
  effect.range = high - low;
  const Noise noise = noise_of(channel, effect.average);
  if (!(noise.model.angle_random_walk > 0.0)) return {};
  regress(design, share, noise, effect);
  if (!std::isfinite(effect.slope_sd) || !std::isfinite(effect.of_rate_sd)) return {};
  effect.explained = share_explained(design, share, effect);
  return effect;
}

namespace {

/// A channel and the temperature that it follows.
struct FollowedTemperature {
  const ChannelNoise& channel;
  const Channel& temperature;
  TemperatureEffect effect;

  bool gyro() const { return channel.kind == QuantityKind::angular_rate; }
};

Table temperature_table(const std::vector<FollowedTemperature>& rows) {
  using Row = FollowedTemperature;
  const auto slope = [](const Row& r) {
    return shown(r.effect.slope, r.effect.slope_sd, r.gyro() ? "deg/h/K" : "ug/K");
  };
  const auto of_rate = [](const Row& r) {
    return shown(r.effect.of_rate, r.effect.of_rate_sd, r.gyro() ? "deg/h/(K/min)" : "ug/(K/min)");
  };
  return tabulate("temperature",
                  "how the channels follow the temperature: generalised least squares under the identified noise", rows,
                  {{"channel", [](const Row& r) { return r.channel.label; }},
                   {"with", [](const Row& r) { return r.temperature.name; }},
                   {"range", "K", [](const Row& r) { return r.effect.range; }},
                   {"by temperature", slope},
                   {"by its rate of change", of_rate},
                   {"explains", [](const Row& r) { return fmt::format("{:.0f} %", 100.0 * r.effect.explained); }},
                   {"chance", [](const Row& r) { return fmt::format("{:.2g} %", 100.0 * r.effect.chance); }}});
}

}  // namespace

void describe_temperature(const Evidence& evidence, const std::vector<ChannelRun>& stretches,
                          const std::vector<ChannelNoise>& channels, Estimate& estimate) {
  const Settings& settings = evidence.plan.settings;
  std::vector<FollowedTemperature> rows;
  for (std::size_t i = 0; i < stretches.size(); ++i) {
    const ChannelRun& stretch = stretches[i];
    if (!channels[i].failure.empty()) continue;
    const Channel* temperature = temperature_of(evidence.recordings[stretch.recording], *stretch.channel);
    if (temperature == nullptr) continue;
    ChannelRun beside = stretch;
    beside.channel = temperature;
    EvenSignal signal = rate_signal(stretch, settings);
    const EvenSignal warmth =
        even_signal(beside, settings.has("rate") ? settings.number("rate") : 0.0, settings.word("timing"));
    set_missing(channels[i].set_aside, signal);
    const auto effect = temperature_effect(signal.values, warmth.values, channels[i]);
    if (!effect) continue;
    rows.push_back({channels[i], *temperature, *effect});
    if (effect->chance < settings.number("significance"))
      estimate.findings.push_back(follows(*effect, channels[i], *temperature));
  }
  add_unless_empty(estimate.tables, temperature_table(rows));
}

}  // namespace tumble::allan_noise
