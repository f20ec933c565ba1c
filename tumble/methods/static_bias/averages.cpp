#include "tumble/methods/static_bias/averages.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/checks/grain.hpp"
#include "tumble/math/noise_model.hpp"
#include "tumble/reduce/coarse_output.hpp"

namespace tumble::static_bias {
namespace {

/// Covariance of a mean over `first` samples and one over `second`, by the lag of their beginnings.
double mean_covariance(const std::vector<UnitTerm>& terms, const std::vector<double>& squared, double lag, double first,
                       double second) {
  double sum = 0.0;
  for (std::size_t t = 0; t < terms.size(); ++t) {
    if (squared[t] == 0.0) continue;
    const auto r = [&](double by) { return generalised_autocovariance(terms[t], by); };
    sum += squared[t] * (r(lag + first - second) - r(lag + first) - r(lag - second) + r(lag));
  }
  return sum / (first * second);
}

struct Centred {
  double trace = 0.0, squares = 0.0;
};

/// P_1 V_12 P_2 for averages of `size` and of `ratio * size` samples.
Centred centred(const std::vector<UnitTerm>& terms, const std::vector<double>& squared, std::size_t size,
                std::size_t ratio, std::size_t rows, std::size_t columns) {
  const auto first = static_cast<double>(size), second = static_cast<double>(size * ratio);
  const std::size_t origin = ratio * (columns - 1);  // lag i - ratio j from -origin to rows - 1
  std::vector<double> by_lag(origin + rows);
  for (std::size_t l = 0; l < by_lag.size(); ++l)
    by_lag[l] =
        mean_covariance(terms, squared, (static_cast<double>(l) - static_cast<double>(origin)) * first, first, second);
  const auto v = [&](std::size_t i, std::size_t j) { return by_lag[origin + i - ratio * j]; };
  std::vector<double> row_mean(rows, 0.0), column_mean(columns, 0.0);
  double mean = 0.0;
  for (std::size_t j = 0; j < columns; ++j)
    for (std::size_t i = 0; i < rows; ++i) {
      row_mean[i] += v(i, j) / static_cast<double>(columns);
      column_mean[j] += v(i, j) / static_cast<double>(rows);
    }
  for (const double average : row_mean) mean += average / static_cast<double>(rows);
  Centred result;
  for (std::size_t j = 0; j < columns; ++j)
    for (std::size_t i = 0; i < rows; ++i) {
      const double x = v(i, j) - row_mean[i] - column_mean[j] + mean;
      result.squares += x * x;
      if (i == j) result.trace += x;
    }
  return result;
}

}  // namespace

constexpr double least_measured = 0.9;  ///< of the samples of an average

AverageScatter scatter_of_averages(std::span<const double> values, std::size_t size) {
  std::vector<double> averages;
  for (std::size_t first = 0; size > 0 && first + size <= values.size(); first += size) {
    double sum = 0.0, count = 0.0;
    for (const double value : values.subspan(first, size))
      if (!std::isnan(value)) sum += value, count += 1.0;
    if (count >= least_measured * static_cast<double>(size)) averages.push_back(sum / count);
  }
  AverageScatter scatter{averages.size(), 0.0};
  if (averages.size() < 2) return scatter;
  const auto count = static_cast<double>(averages.size());
  double mean = 0.0;
  for (const double average : averages) mean += average / count;
  for (const double average : averages) scatter.variance += (average - mean) * (average - mean) / (count - 1.0);
  return scatter;
}

ExpectedScatter expected_scatter(const std::vector<UnitTerm>& terms, const std::vector<double>& squared,
                                 std::size_t samples, std::size_t shorter, std::size_t ratio) {
  constexpr std::size_t most = 4000;
  ExpectedScatter result;
  const std::size_t averages = samples / shorter, rows = std::min(most, averages), columns = rows / ratio;
  if (rows < 2) return result;
  const double thinned = static_cast<double>(rows) / static_cast<double>(averages);
  const double n1 = static_cast<double>(rows) - 1.0, n2 = static_cast<double>(columns) - 1.0;
  const Centred of_shorter = centred(terms, squared, shorter, 1, rows, rows);
  result.shorter = of_shorter.trace / n1;
  result.shorter_variance = thinned * 2.0 * of_shorter.squares / (n1 * n1);
  if (columns < 2) return result;
  const Centred of_longer = centred(terms, squared, shorter * ratio, 1, columns, columns);
  result.longer = of_longer.trace / n2;
  result.longer_variance = thinned * 2.0 * of_longer.squares / (n2 * n2);
  result.covariance = thinned * 2.0 * centred(terms, squared, shorter, ratio, rows, columns).squares / (n1 * n2);
  return result;
}

double mean_variance(const UnitTerm& term, std::size_t samples) {
  const auto n = static_cast<double>(samples);
  switch (term.term) {
    case NoiseTerm::quantization:
      return 2.0 / (n * n);
    case NoiseTerm::white:
      return 1.0 / n;
    case NoiseTerm::random_walk:
      return n / 3.0;
    case NoiseTerm::flicker: {
      double sum = 0.0;
      for (const auto& [sd, time] : flicker_bank(1.0, 0.25, 4.0 * n)) {
        sum += sd * sd * markov_mean_variance(n / time);
      }
      return sum;
    }
    case NoiseTerm::markov:
      return markov_mean_variance(n / term.markov_time);
  }
  return 0.0;
}

double steps_move_mean(std::span<const double> values) {
  const Grain grain = grain_of(values);
  if (!(grain.step > 0.0)) return 0.0;
  const double cut_off = is_coarse(grain) ? 0.5 * grain.step / std::sqrt(3.0) : 0.0;
  return std::hypot(rounding_sd(grain.step, grain.scatter), cut_off);
}

}  // namespace tumble::static_bias
