#include "tumble/methods/allan_noise/settling.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/columns.hpp"
#include "tumble/language/say.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/math/stability/allan_fit.hpp"
#include "tumble/methods/allan_noise/lines.hpp"
#include "tumble/methods/allan_noise/slow_courses.hpp"
#include "tumble/methods/allan_noise/words.hpp"
#include "tumble/reduce/uneven_bias.hpp"

namespace tumble::allan_noise {
namespace {

constexpr std::size_t most_warm_ups = 2;         ///< a case and what is within it: two time constants are usual
constexpr std::size_t settling_averages = 1024;  ///< the shortest time constant is 16 of them
/// Length of the record over the time constants that are tried, by factors of the root of two: a slower exponential is
/// a trend, a faster one moves the slow noise little.
constexpr double longest_settling = 1.5, shortest_settling = 64.0, settling_step = 1.4142135623730951;
constexpr double finer_step = 1.1;
/// Independent tries among these exponentials: those within a factor of two are nearly alike.
constexpr double settling_tries = 6.0;

/// exp(-t/T) of each of n values, and its derivative by ln T.
Matrix exponential(std::size_t n, double time) {
  Matrix columns(n, 2);
  for (std::size_t k = 0; k < n; ++k) {
    const double x = (static_cast<double>(k) + 0.5) / time;
    columns(k, 0) = std::exp(-x);
    columns(k, 1) = x * columns(k, 0);
  }
  return columns;
}

Matrix first_column(const Matrix& columns) { return block(columns, 0, columns.rows, 0, 1); }

/// An exponential of the averages with its fit. time: [averages]
struct TriedSettling {
  double time = 0.0, chance = 1.0;
  CourseFit fit;
};

TriedSettling best_of(const SlowAverages& averages, const std::vector<double>& times, const ChannelNoise& channel) {
  std::vector<Matrix> courses;
  for (const double time : times) courses.push_back(first_column(exponential(averages.mean.size(), time)));
  const auto fits = fit_courses(averages, courses, channel.fit, channel.rate);
  if (fits.empty()) return {};
  const auto best = std::ranges::max_element(fits, {}, &CourseFit::fall);
  const double chance = std::min(1.0, settling_tries * chi_square_tail(best->fall, 1.0));
  return {times[static_cast<std::size_t>(best - fits.begin())], chance, *best};
}

TriedSettling settling_in(const SlowAverages& averages, const ChannelNoise& channel) {
  const auto n = static_cast<double>(averages.mean.size());
  std::vector<double> times;
  for (double share = longest_settling; share <= shortest_settling; share *= settling_step) times.push_back(n / share);
  const TriedSettling coarse = best_of(averages, times, channel);
  if (coarse.chance > course_chance) return coarse;
  times.clear();
  for (int step = -3; step <= 3; ++step) times.push_back(coarse.time * std::pow(finer_step, step));
  return best_of(averages, times, channel);
}

double walk_of(const ChannelNoise& channel) {
  for (std::size_t t = 0; t < channel.fit.terms.size(); ++t)
    if (channel.fit.terms[t].unit.term == NoiseTerm::random_walk && channel.fit.shown[t])
      return coefficient(NoiseTerm::random_walk, channel.fit.value[t] * channel.fit.value[t], channel.rate);
  return 0.0;
}

Finding warm_up_finding(const ChannelNoise& channel, const WarmUp& warm_up) {
  return {Finding::Severity::warning,
          "warm_up_subtracted",
          {{"size", warm_up.size, rate_unit(channel.kind)},
           {"time", warm_up.time, "s"},
           {"p", std::max(warm_up.chance, least_shown_p)}},
          channel.label};
}

bool bias_jumps_in(const NoiseBands& bands, double begin, const ChannelNoise& channel) {
  const Findings uneven = uneven_bias(bands, begin, channel.rate, rate_unit(channel.kind), channel.label);
  return std::ranges::any_of(uneven, [](const Finding& one) { return one.code == "bias_jumps"; });
}

/// Gives back what the exponential took with its size and its time constant, as far as both are determined.
void give_back(const TriedSettling& found, const SlowAverages& averages, const Matrix& shape, NoiseBands& bands,
               const ChannelNoise& channel) {
  const auto both = fit_courses(averages, {exponential(averages.mean.size(), found.time)}, channel.fit, channel.rate);
  if (!both.empty() && both[0].size.size() == shape.columns)
    give_back_course(shape, both[0].covariance, bands);
  else
    give_back_course(first_column(shape), found.fit.covariance, bands);
}

/// Subtracts one exponential and fits the noise of the rest.
void subtract_settling(const TriedSettling& found, const SlowAverages& averages,
                       const std::vector<SpectralLine>& avoided, const NoiseLikelihoodOptions& options,
                       NoiseBands& bands, ChannelNoise& result) {
  const double time = found.time * averages.interval * result.rate / bands.slow_unit;  // [slow values]
  const Matrix shape = exponential(bands.slow.size(), time);
  std::vector<double> rest = bands.slow, course;
  for (std::size_t k = 0; k < rest.size(); ++k) {
    course.push_back(found.fit.size[0] * shape(k, 0));
    rest[k] -= course.back();
  }
  WarmUp warm_up{found.fit.size[0],
                 std::sqrt(found.fit.covariance(0, 0)),
                 time * bands.slow_unit / result.rate,
                 found.chance,
                 walk_of(result),
                 0.0};
  bands = with_slow_part(bands, rest);
  give_back(found, averages, shape, bands, result);
  bands = without_lines(bands, avoided);
  result.fit = fit_noise(bands, options);
  warm_up.walk_without = walk_of(result);
  add_course_variance(course, bands.slow_unit, result);
  result.findings.push_back(warm_up_finding(result, warm_up));
  result.warm_ups.push_back(warm_up);
}

}  // namespace

void take_warm_up(NoiseBands& bands, const std::vector<SpectralLine>& avoided, double begin,
                  const NoiseLikelihoodOptions& options, ChannelNoise& result) {
  if (bias_jumps_in(bands, begin, result)) return;
  for (std::size_t k = 0; k < most_warm_ups; ++k) {
    const SlowAverages averages =
        slow_averages(bands.slow, result.rate / bands.slow_unit, slow_stride(bands.slow.size(), settling_averages));
    const TriedSettling found = settling_in(averages, result);
    if (found.chance > course_chance) return;
    subtract_settling(found, averages, avoided, options, bands, result);
  }
}

void add_course_variance(std::span<const double> course, double unit, ChannelNoise& result) {
  std::vector<double> sums{0.0};
  for (const double value : course) sums.push_back(sums.back() + value);
  result.course_variance.resize(result.curve.size(), 0.0);
  for (std::size_t i = 0; i < result.curve.size(); ++i) {
    const double wanted = static_cast<double>(result.curve[i].factor) / unit;
    const auto width = static_cast<std::size_t>(std::max(1.0, std::round(wanted)));
    const double shorter = std::min(1.0, wanted);  // a course is straight within one of its values
    double squares = 0.0, count = 0.0;
    for (std::size_t k = 0; k + 2 * width < sums.size(); ++k) {
      const double step = (sums[k + 2 * width] - 2.0 * sums[k + width] + sums[k]) / static_cast<double>(width);
      squares += shorter * shorter * step * step;
      ++count;
    }
    if (count > 0.0) result.course_variance[i] += 0.5 * squares / count;
  }
}

void describe_warm_up(const std::vector<ChannelNoise>& channels, Estimate& estimate) {
  struct Row {
    const ChannelNoise& channel;
    const WarmUp& of;

    std::string text(double si, const std::string& unit) const {
      return fmt::format("{:.3g} {}", Unit::parse(unit).difference_from_si(si), unit);
    }
    std::string rate(double si) const { return text(si, rate_unit(channel.kind)); }
    std::string walk(double si) const {
      return si > 0.0 ? text(si, words(NoiseTerm::random_walk, channel.kind).unit) : "not significant";
    }
  };
  std::vector<Row> rows;
  for (const auto& channel : channels)
    for (const auto& one : channel.warm_ups) rows.push_back({channel, one});
  add_unless_empty(
      estimate.tables,
      tabulate("settling",
               "exponentials that die away from the begin of the record, fitted with the noise and subtracted", rows,
               {{"channel", [](const Row& r) { return r.channel.label; }},
                {"size", [](const Row& r) { return r.rate(r.of.size); }},
                {"sd", [](const Row& r) { return r.rate(r.of.size_sd); }},
                {"time constant", [](const Row& r) { return say_seconds(r.of.time); }},
                {"random walk with it", [](const Row& r) { return r.walk(r.of.walk_with); }},
                {"without it", [](const Row& r) { return r.walk(r.of.walk_without); }}}));
}

}  // namespace tumble::allan_noise
