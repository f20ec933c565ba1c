#include "tumble/math/noise/noise_likelihood/average.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/math/linear_algebra.hpp"

namespace tumble::noise_likelihood {
namespace {

constexpr double same_time = 4.0;  ///< greatest ratio of correlation times of what counts as one process

/// For each process of a set the one of the chosen set that it stands for; as many as there are: none.
std::vector<std::size_t> counterparts(const std::vector<double>& times, const std::vector<double>& chosen) {
  std::vector<std::size_t> of(times.size(), chosen.size());
  for (std::size_t c = 0; c < chosen.size(); ++c) {
    std::size_t nearest = times.size();
    double least = std::log(same_time);
    for (std::size_t m = 0; m < times.size(); ++m)
      if (const double off = std::abs(std::log(times[m] / chosen[c])); of[m] == chosen.size() && off < least) {
        least = off;
        nearest = m;
      }
    if (nearest < times.size()) of[nearest] = c;
  }
  return of;
}

/// Where each column of a model stands among the values of the chosen set, with value and derivative by the column.
struct Placed {
  std::size_t column, place;
  double value, gain;
};

std::vector<Placed> placed(const TriedTerms& set, const LinearNoise& model, const NoiseSpread& known,
                           const NoiseTerms& chosen) {
  const std::size_t processes = chosen.times.size(), terms = power_laws + processes;
  const auto of = counterparts(set.terms.times, chosen.times);
  std::vector<Placed> all;
  for (std::size_t a = 0; a < model.terms.size(); ++a) {
    const std::size_t t = model.terms[a];
    if (t >= power_laws && of[t - power_laws] == processes) continue;
    std::size_t in_set = set.fit.c.size() - set.terms.times.size() + t - power_laws;
    if (t < power_laws) in_set = std::count(set.terms.used.begin(), set.terms.used.begin() + t, true);
    const double squared = set.fit.c[in_set], root = std::sqrt(squared);
    const double relative = known.covariance(a, a) / (squared * squared);
    all.push_back({a, t < power_laws ? t : power_laws + of[t - power_laws], root * (1.0 + relative / 8.0), 0.5 / root});
  }
  std::size_t column = model.terms.size();
  for (const std::size_t m : model.processes) {
    if (of[m] < processes) all.push_back({column, terms + of[m], set.terms.times[m], set.terms.times[m]});
    ++column;
  }
  const NoiseFilter& filter = set.terms.filter;
  for (int k = 0; k < std::min(model.filter_parameters, chosen.filter_parameters()); ++k, ++column) {
    const double value = k == 0 ? filter.bandwidth : filter.damping;
    all.push_back({column, terms + processes + k, value, value});
  }
  return all;
}

/// Values of a set; what it lacks beside the terms is that of `otherwise`.
NoiseValues values_of(const TriedTerms& set, const LinearNoise& model, const NoiseSpread& known,
                      const NoiseTerms& chosen, const NoiseValues* otherwise) {
  const std::size_t terms = power_laws + chosen.times.size();
  const std::size_t all = terms + chosen.times.size() + chosen.filter_parameters();
  NoiseValues values{std::vector<double>(all), Matrix(all, all), std::vector<double>(all), 1};
  const auto places = placed(set, model, known, chosen);
  for (const Placed& a : places) {
    values.value[a.place] = a.value;
    values.error_variance[a.place] = a.gain * a.gain * known.by_error(a.column, a.column);
    for (const Placed& b : places)
      values.covariance(a.place, b.place) = a.gain * b.gain * known.covariance(a.column, b.column);
  }
  for (std::size_t i = terms; otherwise != nullptr && i < all; ++i) {
    if (values.value[i] > 0.0) continue;
    values.value[i] = otherwise->value[i];
    values.covariance(i, i) = otherwise->covariance(i, i);
    values.error_variance[i] = otherwise->error_variance[i];
  }
  return values;
}

}  // namespace

NoiseValues values_of_chosen(const TermSelection& selection, const LinearNoise& model, const NoiseSpread& known) {
  const TriedTerms& chosen = selection.all[selection.chosen];
  return values_of(chosen, model, known, chosen.terms, nullptr);
}

NoiseValues averaged_values(const BandData& data, const std::vector<double>& statistical_count,
                            const TermSelection& selection, const NoiseValues& chosen) {
  std::vector<NoiseValues> sets;
  std::vector<double> weights;
  double sum = 0.0;
  const NoiseTerms& terms = selection.all[selection.chosen].terms;
  const auto take = [&](const TriedTerms& set, double set_aicc, bool is_chosen) {
    if (set.fit.c.empty() || !(std::ranges::min(set.fit.c) > 0.0)) return;
    const double off = std::max(0.0, set_aicc - selection.aicc[selection.chosen]);
    if (off > near_in_aicc) return;
    if (is_chosen) {
      sets.push_back(chosen);
    } else {
      const LinearNoise model = linear(data, set);
      sets.push_back(values_of(set, model, spread(data, statistical_count, model, set), terms, &chosen));
    }
    weights.push_back(std::exp(-0.5 * off));
    sum += weights.back();
  };
  for (std::size_t i = 0; i < selection.all.size(); ++i)
    take(selection.all[i], selection.aicc[i], i == selection.chosen);
  for (std::size_t i = 0; i < selection.other_filters.size(); ++i)
    take(selection.other_filters[i], selection.other_aicc[i], false);
  const std::size_t all = chosen.value.size();
  NoiseValues mean{std::vector<double>(all), Matrix(all, all), std::vector<double>(all), sets.size()};
  for (std::size_t i = 0; i < sets.size(); ++i) {
    mean.value = scaled_sum(mean.value, weights[i] / sum, sets[i].value);
    mean.error_variance = scaled_sum(mean.error_variance, weights[i] / sum, sets[i].error_variance);
    mean.covariance += (weights[i] / sum) * sets[i].covariance;
  }
  for (std::size_t i = 0; i < sets.size(); ++i)
    add_square(mean.covariance, weights[i] / sum, difference(sets[i].value, mean.value));
  return mean;
}

}  // namespace tumble::noise_likelihood
