#include "tumble/methods/allan_noise/spectrum.hpp"

#include <fmt/format.h>

#include <cmath>

#include "tumble/core/columns.hpp"
#include "tumble/language/say.hpp"
#include "tumble/math/spectrum/spectral_conversion.hpp"
#include "tumble/units/error.hpp"

namespace tumble::allan_noise {
namespace {

constexpr double points_of_spectrum = 10.0;  ///< [1/decade] where the setting asks for octaves of the deviation

NoiseModel model_of(const FittedTerm& term, double rate) {
  const double value = coefficient(term.unit.term, term.squared, rate);
  switch (term.unit.term) {
    case NoiseTerm::quantization:
      return {.quantization_noise = value};
    case NoiseTerm::white:
      return {.angle_random_walk = value};
    case NoiseTerm::flicker:
      return {.bias_instability = value};
    case NoiseTerm::random_walk:
      return {.rate_random_walk = value};
    case NoiseTerm::markov:
      return {.markov_sd = value, .markov_time = term.unit.markov_time / rate};
  }
  return {};
}

Curve curve_of(const ChannelNoise& channel, const std::string& name, std::vector<double> density) {
  const bool rate = channel.kind == QuantityKind::angular_rate;
  const char* unit = channel.kind == QuantityKind::other ? "1/Hz" : rate ? "(deg/h)^2/Hz" : "ug^2/Hz";
  return {.name = channel.label + " " + name,
          .figure = "power spectral density " + channel.label,
          .x = {"frequency", Unit::parse("Hz"), channel.spectrum->frequency},
          .y = {"one-sided density", Unit::parse(unit), std::move(density)},
          .logarithmic = true};
}

void add_spectrum_curves(const ChannelNoise& channel, std::vector<Curve>& curves) {
  const PowerSpectrum& spectrum = *channel.spectrum;
  Curve measured = curve_of(channel, "power_spectrum", spectrum.density);
  measured.points = true;
  measured.lower = spectrum.lower;
  measured.upper = spectrum.upper;
  measured.band = fmt::format("{:g} % confidence", 100.0 * channel.confidence);
  curves.push_back(std::move(measured));
  std::vector<double> sum(spectrum.frequency.size(), 0.0);
  std::vector<Curve> terms;
  for (const FittedTerm& term : channel.fit.terms) {
    if (!term.kept) continue;
    const NoiseModel model = model_of(term, channel.rate);
    const bool filtered = term.unit.term == NoiseTerm::white && channel.fit.filter.given();
    std::vector<double> density;
    for (std::size_t i = 0; i < sum.size(); ++i) {
      const double f = spectrum.frequency[i];
      density.push_back(sampled_density(model, f, channel.rate) *
                        (filtered ? power_gain(channel.fit.filter, f / channel.rate) : 1.0));
      sum[i] += density.back();
    }
    terms.push_back(curve_of(channel, words(term.unit.term, channel.kind).name + "_density", std::move(density)));
  }
  curves.push_back(curve_of(channel, "fitted_density", std::move(sum)));
  for (auto& curve : terms) curves.push_back(std::move(curve));
}

}  // namespace

void add_spectrum(const EvenSignal& signal, const Settings& settings, ChannelNoise& result) {
  const std::string& asked = settings.word("spectrum");
  if (asked == "none") return;
  const auto estimator = asked == "welch" ? SpectrumEstimator::welch : SpectrumEstimator::multitaper;
  const double fine = settings.number("points_per_decade");
  try {
    result.spectrum =
        power_spectrum(estimator, signal.values, signal.rate,
                       {.points_per_decade = fine > 0.0 ? fine : points_of_spectrum, .confidence = result.confidence});
  } catch (const Error& error) {
    if (error.kind != Error::Kind::bad_data) throw;
    result.findings.push_back(
        {Finding::Severity::warning, "no_power_spectrum", {{"reason", reason_of(error)}}, result.label});
  }
}

void describe_spectra(const std::vector<ChannelNoise>& channels, Estimate& estimate) {
  std::vector<const ChannelNoise*> rows;
  for (const auto& channel : channels) {
    if (!channel.spectrum || !channel.failure.empty() || channel.spectrum->edf.empty()) continue;
    add_spectrum_curves(channel, estimate.curves);
    rows.push_back(&channel);
  }
  add_unless_empty(estimate.tables,
                   tabulate("spectra", "one-sided power spectral densities", rows,
                            {{"channel", &ChannelNoise::label},
                             {"segments", [](const auto* c) { return c->spectrum->segments; }},
                             {"samples each", [](const auto* c) { return c->spectrum->length; }},
                             {"bandwidth", "Hz", [](const auto* c) { return c->spectrum->bandwidth; }},
                             {"degrees of freedom of one frequency",
                              [](const auto* c) { return std::round(10.0 * c->spectrum->edf.front()) / 10.0; }},
                             {"left out", [](const auto* c) { return say_count(c->spectrum->left_out, "sample"); }}}));
}

}  // namespace tumble::allan_noise
