#include "tumble/reduce/compensation/before_after.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/clocks/sampling_rate.hpp"
#include "tumble/core/columns.hpp"
#include "tumble/core/evidence.hpp"
#include "tumble/reduce/stretches.hpp"

namespace tumble::compensation {
namespace {

/// Mean of the samples from `at` on, `each` of them or as many as are left; NaN: all are missing.
double mean_at(std::span<const double> values, std::size_t at, std::size_t each) {
  double sum = 0.0, count = 0.0;
  for (const double value : values.subspan(at, std::min(each, values.size() - at)))
    if (!std::isnan(value)) sum += value, count += 1.0;
  return sum / count;
}

/// Standard deviation [as values] of the means over `each` samples about their mean; NaN: fewer than two.
double sd_of_means(std::span<const double> values, std::size_t each) {
  double mean = 0.0, squares = 0.0, count = 0.0;
  for (std::size_t at = 0; at + each <= values.size(); at += each) {
    const double one = mean_at(values, at, each);
    if (std::isnan(one)) continue;
    const double off = one - mean;
    count += 1.0;
    mean += off / count;
    squares += off * (one - mean);
  }
  return count > 1.0 ? std::sqrt(squares / (count - 1.0)) : std::nan("");
}

/// The sd [SI of u] of what the output shows, over the scale factor of the result.
double sd_before(const Work& work, std::span<const double> raw, std::size_t each) {
  return std::abs(work.reading / work.scale_factor) * sd_of_means(raw, each);
}

}  // namespace

namespace {

/// One power-up of an output.
struct RunOfOutput {
  const Channel& channel;
  const Run& run;
  double before, after;  ///< sd [SI of u]
  double outside;        ///< share of samples
};

std::vector<RunOfOutput> runs_of_outputs(const Works& works, const std::vector<Run>& runs, const Recording& raw,
                                         const Recording& done) {
  std::vector<RunOfOutput> rows;
  for (const Work& work : works) {
    const Channel& channel = done.channels[work.place];
    const double averaging = work.model->thermal ? work.model->thermal->averaging : 0.0;
    const auto each = static_cast<std::size_t>(std::max(1.0, std::round(averaging * sampling_rate(channel))));
    for (const Run& run : runs) {
      const auto [first, end] = samples_between(channel, run.begin, run.end);
      if (end <= first) continue;
      const auto part = [&, a = first, n = end - first](const std::vector<double>& values) {
        return std::span(values).subspan(a, n);
      };
      double outside = 0.0;
      for (const double flag : part(work.trust.extrapolated.values)) outside += flag > 0.0;
      rows.push_back({channel, run, sd_before(work, part(raw.channels[work.place].values), each),
                      sd_of_means(part(channel.values), each), outside / static_cast<double>(end - first)});
    }
  }
  return rows;
}

}  // namespace

Table before_and_after(const Works& works, const Recording& raw, const Recording& done) {
  using Row = RunOfOutput;
  const bool means = std::ranges::any_of(
      works, [](const Work& work) { return work.model->thermal && work.model->thermal->averaging > 0.0; });
  const auto runs = runs_of({raw});
  return tabulate(
      "compensation",
      means ? "sd of the averages about their run's mean, before and after" : "sd of the samples before and after",
      runs_of_outputs(works, runs, raw, done),
      {{"channel", [](const Row& r) { return r.channel.name; }},
       {"run", [](const Row& r) { return r.run.number; }},
       {"label", [](const Row& r) { return r.run.label; }},
       {"sd raw", [](const Row& r) { return r.channel.unit.difference_from_si(r.before); }},
       {"sd compensated", [](const Row& r) { return r.channel.unit.difference_from_si(r.after); }},
       {"unit", [](const Row& r) { return r.channel.unit.text(); }},
       {"ratio", [](const Row& r) { return r.after / r.before; }},
       {"outside calibrated range", "%", &Row::outside}});
}

}  // namespace tumble::compensation
