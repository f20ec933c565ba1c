#include "tumble/math/noise/noise_length.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/math/bisection.hpp"
#include "tumble/math/eigen/view.hpp"
#include "tumble/math/noise/noise_filter.hpp"
#include "tumble/units/constants.hpp"

namespace tumble {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double highest_of_long = 0.25;  ///< [1/longest block] where the bands of a longer record begin

constexpr double least_times = 1e-3, most_times = 1e5;
constexpr double step = 1.1;  ///< of the frequencies that a longer record adds

/// Sines of frequency f [cycles a sample], far below that of a unit.
NoiseBand low_band(double frequency, double unit, double shortness) {
  NoiseBand band;
  const double w = 2.0 * pi * frequency * unit;
  band.frequency = frequency;
  band.unit = unit;
  band.shortness = shortness;
  band.expected = {(std::pow(w, 4) + 4.0 * shortness * w * w) / (unit * unit), w * w / unit, w, unit};
  return band;
}

std::vector<NoiseBand> lengthened(const std::vector<NoiseBand>& from, double longest, double times) {
  std::vector<NoiseBand> bands;
  double unit = 1.0;
  const double lowest = 0.25 / (longest * times);  // half a step below the lowest frequency
  for (NoiseBand band : from) {
    if (band.frequency < lowest) continue;
    band.count *= times;
    if (band.radix == 0) unit = band.unit;
    bands.push_back(band);
  }
  for (double high = highest_of_long / longest; high > lowest; high /= step) {
    const double low = std::max(lowest, high / step);
    NoiseBand band = low_band(0.5 * (low + high), unit, unit / (longest * times));
    band.count = (high - low) * 2.0 * longest * times;
    bands.push_back(band);
  }
  return bands;
}

double expected(const NoiseBand& band, const UnitTerm& term) {
  for (std::size_t t = 0; t < power_law_terms.size(); ++t)
    if (power_law_terms[t] == term.term) return band.expected[t];
  return expected_markov(band, term.markov_time);
}

}  // namespace

RecordLength::RecordLength(const NoiseBands& bands, const NoiseFit& fit)
    : bands_(bands.bands), fit_(fit), longest_(1.0) {
  const auto white = expected_filtered(bands_, fit.filter);
  for (std::size_t i = 0; i < bands_.size(); ++i) {
    if (bands_[i].radix == 0) longest_ = std::max(longest_, 0.5 / bands_[i].frequency);
    bands_[i].expected[1] = white[i];
  }
}

double RecordLength::sd_of(std::size_t parameter, double times) const {
  const auto bands = lengthened(bands_, longest_, times);
  const std::size_t terms = fit_.terms.size();
  std::vector<std::size_t> list;
  const std::size_t processes = terms - std::min(terms, power_law_terms.size());
  for (std::size_t t = 0; t < terms + processes; ++t)
    if (t >= terms || fit_.terms[t].kept || t == parameter) list.push_back(t);
  MatrixXd x(at(bands.size()), at(list.size()));
  VectorXd s = VectorXd::Zero(x.rows());
  for (Eigen::Index b = 0; b < x.rows(); ++b) {
    const NoiseBand& band = bands[static_cast<std::size_t>(b)];
    for (std::size_t a = 0; a < list.size(); ++a) {
      if (list[a] >= terms) {
        const FittedTerm& process = fit_.terms[power_law_terms.size() + list[a] - terms];
        const double time = process.unit.markov_time, h = 1e-3 * time;
        x(b, at(a)) = process.squared * (expected_markov(band, time + h) - expected_markov(band, time - h)) / (2.0 * h);
        continue;
      }
      const FittedTerm& term = fit_.terms[list[a]];
      x(b, at(a)) = expected(band, term.unit);
      if (term.kept) s[b] += term.squared * x(b, at(a));
    }
    const double weight = std::sqrt(0.5 * band.count) / s[b];
    x.row(b) *= weight;
  }
  const VectorXd scale = x.colwise().norm().cwiseInverse();
  x = x * scale.asDiagonal();
  const auto place = std::find(list.begin(), list.end(), parameter) - list.begin();
  const VectorXd row = (x.transpose() * x).ldlt().solve(VectorXd::Unit(x.cols(), place));
  return row[place] > 0.0 ? scale[place] * std::sqrt(row[place]) : std::numeric_limits<double>::infinity();
}

double RecordLength::times_for(std::size_t parameter, double sd) const {
  constexpr int halvings = 14;  // of the logarithm of the times: to a thousandth
  if (sd_of(parameter, most_times) > sd) return std::numeric_limits<double>::infinity();
  return std::exp(bisected(std::log(least_times), std::log(most_times), halvings, [&](double logarithm) {
                    return sd_of(parameter, std::exp(logarithm)) > sd;
                  }).middle());
}

}  // namespace tumble
