#include "frequency_stability.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "clock_intervals.hpp"
#include "tumble/math/interruption.hpp"
#include "tumble/math/parallel.hpp"
#include "tumble/math/square.hpp"
#include "tumble/math/stability/allan_differences.hpp"
#include "tumble/math/stability/allan_phase.hpp"
#include "tumble/math/stability/allan_sums.hpp"
#include "tumble/math/stability/every_tau.hpp"
#include "tumble/units/error.hpp"

namespace tumble::python {
namespace {

constexpr double missing = std::numeric_limits<double>::quiet_NaN();

/// Averaging times of a word, in samples.
std::vector<double> times_of(const std::string& word, std::size_t points) {
  const double size = static_cast<double>(points);
  std::vector<double> times;
  if (word == "all") {
    for (std::size_t m = 1; m <= points; ++m) times.push_back(static_cast<double>(m));
  } else if (word == "octave") {
    for (double m = 1.0; m <= size; m *= 2.0) times.push_back(m);
  } else if (word == "decade") {
    for (double m = 1.0; m <= size; m *= 10.0) times.insert(times.end(), {m, 2.0 * m, 4.0 * m});
  } else if (word == "log10") {
    const double decades = std::log10(size);
    const int count = static_cast<int>(10.0 * decades);
    for (int k = 0; k < count; ++k) times.push_back(std::pow(10.0, count > 1 ? decades * k / (count - 1) : 0.0));
  } else {
    throw Error(
        Error::Kind::bad_input,
        say("argument taus: '{}' was given; accepted are 'octave', 'decade', 'all', 'log10', and averaging times [s]",
            word));
  }
  return times;
}

/// Phase in samples, and what makes a difference of it a phase again [s].
struct Series {
  std::vector<double> kept;
  Phase integral;
  std::span<const double> phase;
  double unit = 1.0;
};

std::span<const double> trimmed(std::span<const double> values) {
  const auto there = [](double value) { return !std::isnan(value); };
  const auto first = std::find_if(values.begin(), values.end(), there);
  const auto last = std::find_if(values.rbegin(), values.rend(), there);
  if (first == values.end()) return {};
  return {first, last.base()};
}

void require_finite(std::span<const double> values) {
  double sum = 0.0;
  for (const double value : values) sum += value - value;
  if (sum == 0.0) return;
  const auto bad = std::find_if(values.begin(), values.end(), [](double value) { return !std::isfinite(value); });
  throw Error(Error::Kind::bad_data,
              say("argument data: value {} is not a finite number; accepted are finite numbers (gradev accepts NaN in "
                  "phase, and tumble.allan_deviation NaN for missing samples with missing='nan')",
                  bad - values.begin()));
}

void require_rate(double rate) {
  if (!(rate > 0.0 && std::isfinite(rate)))
    throw Error(Error::Kind::bad_input,
                say("argument rate: {} was given; accepted are rates above 0 Hz", Name{std::to_string(rate)}));
}

Series series_of(std::span<const double> values, double rate, bool of_phase, bool exact_mean) {
  require_rate(rate);
  Series series;
  if (of_phase) {
    require_finite(values);
    series.phase = values;
    return series;
  }
  const auto inner = trimmed(values);
  require_finite(inner);
  series.integral = exact_mean ? integrate_rate(inner, 1) : integrate_rate_once(inner, 1);
  series.phase = series.integral.values;
  series.unit = 1.0 / rate;
  return series;
}

/// Theo1 below the stride of 10, from which on it is published.
MeanSquare short_theo1(std::span<const double> x, std::size_t m) {
  const std::size_t half = m / 2, outer = x.size() - m;
  double sum = 0.0;
  for (std::size_t k = 0; k < half; ++k) {
    double part = 0.0;
    for (std::size_t i = 0; i < outer; ++i) part += square((x[i] - x[i + half - k]) + (x[i + m] - x[i + half + k]));
    sum += part / static_cast<double>(half - k);
  }
  return {sum / (0.75 * square(static_cast<double>(m)) * static_cast<double>(outer)), outer * half};
}

/// Mean square of the measure at factor m, in samples.
MeanSquare measured(Stability measure, std::span<const double> x, std::span<const double> frequency, std::size_t m) {
  const double area = square(static_cast<double>(m));
  switch (measure) {
    case Stability::allan:
      return difference_variance(x, m, 2, m);
    case Stability::modified_allan:
    case Stability::time:
      return modified_allan_variance(x, m);
    case Stability::hadamard:
      return difference_variance(x, m, 3, m);
    case Stability::overlapping_hadamard:
      return difference_variance(x, m, 3, 1);
    case Stability::total:
      return total_variance(x, m);
    case Stability::parabolic:
      return parabolic_variance(x, m);
    case Stability::modified_total:
    case Stability::time_total: {
      const auto found = reflected_segments(x, m);
      return {found.value / (2.0 * area), found.count};
    }
    case Stability::hadamard_total: {
      if (m == 1) return difference_variance(x, 1, 3, 1);
      const auto found = reflected_segments(frequency, m);
      return {found.value / 6.0, found.count};
    }
    case Stability::theo1:
      return m < 10 ? short_theo1(x, m) : theo1_variance(x, m);
    case Stability::peak_interval_error: {
      const auto found = peak_interval_error(x, m);
      return {square(found.value), found.count};
    }
    case Stability::rms_interval_error:
      return interval_error_variance(x, m);
    default:
      break;
  }
  throw Error(Error::Kind::unsupported, "allantools does not have this measure");
}

bool of_time(Stability measure) { return measure == Stability::time || measure == Stability::time_total; }

bool of_interval_errors(Stability measure) {
  return measure == Stability::peak_interval_error || measure == Stability::rms_interval_error;
}

/// Measures whose sums use all threads by themselves.
bool shares_work(Stability measure) {
  using enum Stability;
  return measure == modified_total || measure == time_total || measure == hadamard_total || measure == theo1 ||
         measure == parabolic;
}

/// Every factor by the sums of docs/decisions/026 where there are many, the overlapping Allan and Hadamard deviations.
std::optional<std::vector<MeanSquare>> many(Stability measure, std::span<const double> x,
                                            std::span<const std::size_t> factors) {
  const std::size_t order = measure == Stability::overlapping_allan      ? 2
                            : measure == Stability::overlapping_hadamard ? 3
                                                                         : 0;
  const bool worth = factors.size() > 400 && factors.back() - factors.front() < 4 * factors.size();
  if (order == 0 || (!worth && order == 3)) return std::nullopt;
  std::vector<double> sums(factors.size(), 0.0);
  if (worth) {
    std::vector<double> rounding;
    const auto every = every_difference_sum(x, order, rounding);
    for (std::size_t i = 0; i < factors.size(); ++i)
      if (factors[i] <= every.size()) sums[i] = every[factors[i] - 1];
  } else {
    add_second_differences(x, factors, sums);
  }
  std::vector<MeanSquare> found(factors.size());
  for (std::size_t i = 0; i < factors.size(); ++i) {
    if (x.size() <= order * factors[i]) continue;
    const std::size_t terms = x.size() - order * factors[i];
    const double weight = (order == 2 ? 2.0 : 6.0) * square(static_cast<double>(factors[i]));
    found[i] = {sums[i] / (weight * static_cast<double>(terms)), terms};
  }
  return found;
}

std::vector<MeanSquare> all(Stability measure, std::span<const double> x, std::span<const double> frequency,
                            std::span<const std::size_t> factors) {
  if (auto found = many(measure, x, factors)) return *std::move(found);
  std::vector<MeanSquare> found(factors.size());
  const auto one = [&](std::size_t i) { found[i] = measured(measure, x, frequency, factors[i]); };
  if (shares_work(measure) || factors.size() * x.size() < 200'000)
    for (std::size_t i = 0; i < factors.size(); ++i) {
      stop_if_asked();
      one(i);
    }
  else
    parallel_for(factors.size(), one);
  return found;
}

/// `errs` as allantools gives it.
double error_of(Stability measure, double deviation, double terms, double points, double factor) {
  if (measure == Stability::rms_interval_error) return 0.0;
  return deviation / std::sqrt(measure == Stability::theo1 ? points - factor : terms);
}

void add(Deviations& to, double tau, double deviation, double error, std::size_t terms) {
  if (terms < 2) return;
  to.taus.push_back(tau);
  to.devs.push_back(deviation);
  to.errs.push_back(error);
  to.ns.push_back(static_cast<double>(terms));
}

}  // namespace

std::vector<std::size_t> factors_of(const Taus& taus, double rate, std::size_t points, double longest, bool even) {
  require_rate(rate);
  const bool named = std::holds_alternative<std::string>(taus);
  const auto times = named ? times_of(std::get<std::string>(taus), points) : std::get<std::vector<double>>(taus);
  std::vector<std::size_t> factors;
  for (const double time : times) {
    const double m = std::nearbyint(named ? 1.0 / rate * time * rate : time * rate);
    if (!(m > 0.0 && m < static_cast<double>(points) && m <= longest)) continue;
    const auto factor = static_cast<std::size_t>(m);
    if (!even || factor % 2 == 0) factors.push_back(factor);
  }
  std::sort(factors.begin(), factors.end());
  factors.erase(std::unique(factors.begin(), factors.end()), factors.end());
  return factors;
}

Deviations deviations(Stability measure, std::span<const double> values, double rate, bool of_phase, const Taus& taus) {
  const auto series = series_of(values, rate, of_phase, of_interval_errors(measure));
  const auto x = series.phase;
  std::vector<double> frequency;
  std::size_t points = x.size();
  double longest = static_cast<double>(points);
  if (measure == Stability::hadamard_total) {
    for (std::size_t n = 0; n + 1 < x.size(); ++n) frequency.push_back(x[n + 1] - x[n]);
    points = frequency.size();
  }
  if (measure == Stability::hadamard_total || measure == Stability::modified_total || measure == Stability::time_total)
    longest = static_cast<double>(points) / 3.0;
  const auto factors = factors_of(taus, rate, points, longest, measure == Stability::theo1);
  const auto found = all(measure, x, frequency, factors);
  // from differences of phase in samples to the unit: [u s] times rate, or of phase in samples of [u] nothing
  const double scale = series.unit * (of_interval_errors(measure) ? 1.0 : rate);
  Deviations out;
  for (std::size_t i = 0; i < factors.size(); ++i) {
    const double m = static_cast<double>(factors[i]), tau = m / rate, terms = static_cast<double>(found[i].count);
    double deviation = std::sqrt(found[i].value) * scale;
    if (of_time(measure)) deviation *= tau / std::sqrt(3.0);
    add(out, tau, deviation, error_of(measure, deviation, terms, static_cast<double>(points), m), found[i].count);
  }
  return out;
}

Deviations gap_robust(std::span<const double> values, double rate, bool of_phase, const Taus& taus, double ci,
                      int alpha) {
  require_rate(rate);
  std::vector<double> x(values.begin(), values.end());
  double unit = 1.0;
  if (!of_phase) {
    const auto inner = trimmed(values);
    const auto gap = std::find_if(inner.begin(), inner.end(), [](double value) { return std::isnan(value); });
    // less the mean of all; a sum with a missing value is missing, and so is what follows
    x = gap == inner.end() ? phase_from_rate(inner, 1.0) : std::vector<double>{0.0};
    if (gap != inner.end()) {
      const Phase phase = integrate_rate(inner, 1);
      const auto whole = static_cast<std::size_t>(gap - inner.begin());
      x.assign(phase.values.begin(), phase.values.begin() + static_cast<std::ptrdiff_t>(whole + 1));
      x.resize(inner.size() + 1, missing);
    }
    unit = 1.0 / rate;
  }
  const auto factors = factors_of(taus, rate, x.size(), static_cast<double>(x.size()), false);
  const auto absent = std::count_if(x.begin(), x.end(), [](double value) { return std::isnan(value); });
  const double present = static_cast<double>(x.size()) - static_cast<double>(absent);
  Deviations out;
  for (const std::size_t m : factors) {
    stop_if_asked();
    double sum = 0.0;
    std::size_t terms = 0;
    for (std::size_t n = 0; n + 2 * m < x.size(); ++n) {
      const double term = (x[n + 2 * m] - x[n + m]) - (x[n + m] - x[n]);
      if (!std::isnan(term)) sum += term * term, ++terms;
    }
    if (terms < 2) continue;
    const double factor = static_cast<double>(m);
    const double deviation = std::sqrt(sum / (2.0 * static_cast<double>(terms))) / factor * rate * unit;
    const auto limits = chi_square_limits(deviation, ci, simple_edf(present, factor, alpha));
    add(out, factor / rate, deviation, limits.first, terms);
    out.upper.push_back(limits.second);
  }
  return out;
}

Deviations codeviation(std::span<const double> one, std::span<const double> two, double rate, bool of_phase,
                       const Taus& taus) {
  const auto first = series_of(one, rate, of_phase, false), second = series_of(two, rate, of_phase, false);
  const auto x = first.phase, y = second.phase;
  if (x.size() != y.size())
    throw Error(
        Error::Kind::bad_input,
        say("argument data_2: {} phase points were given; accepted are as many as data_1 has, {}", y.size(), x.size()));
  Deviations out;
  for (const std::size_t m : factors_of(taus, rate, x.size(), static_cast<double>(x.size()), false)) {
    if (x.size() <= 2 * m) continue;
    stop_if_asked();
    const std::size_t terms = x.size() - 2 * m;
    double sum = 0.0;
    for (std::size_t n = 0; n < terms; ++n)
      sum += ((x[n + 2 * m] - x[n + m]) - (x[n + m] - x[n])) * ((y[n + 2 * m] - y[n + m]) - (y[n + m] - y[n]));
    const double count = static_cast<double>(terms), factor = static_cast<double>(m);
    const double deviation = std::sqrt(std::abs(sum) / (2.0 * count)) / factor * rate * first.unit;
    add(out, factor / rate, deviation, deviation / std::sqrt(count), terms);
  }
  return out;
}

}  // namespace tumble::python
