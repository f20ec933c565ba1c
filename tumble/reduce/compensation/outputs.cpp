#include "tumble/reduce/compensation/outputs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/math/linear_algebra.hpp"
#include "tumble/reduce/compensate.hpp"
#include "tumble/units/error.hpp"

namespace tumble::compensation {

std::optional<std::size_t> output_of(const Estimate& estimate, const Recording& recording, const std::string& role,
                                     Problems& problems) {
  const Channel* channel = channel_of(estimate, recording, role);
  if (!channel) {
    problems.push_back(say("the recording has no channel for the role {}", role));
    return std::nullopt;
  }
  if (find_channel(recording, channel->name + ".compensation_sd")) {
    problems.push_back(say("channel {} is compensated already: it would be subtracted twice", channel->name));
    return std::nullopt;
  }
  return static_cast<std::size_t>(channel - recording.channels.data());
}

void require_dimension(const Channel* channel, const std::string& unit, Problems& problems) {
  if (channel && channel->unit.dimension() != Unit::parse(unit).dimension())
    problems.push_back(
        say("channel {} is in {}, but must be in {} or the like", channel->name, channel->unit.text(), unit));
}

double number_in(const Table& table, const Table::Cell& cell) {
  if (const auto* number = std::get_if<double>(&cell)) return *number;
  throw Error(Error::Kind::bad_file,
              say("the result's table {} holds '{}' where a number belongs", table.name, std::get<std::string>(cell)));
}

void refuse(const Recording& recording, std::vector<std::string> problems) {
  if (problems.empty()) return;
  if (!recording.origin.file.empty())
    for (auto& problem : problems)
      problem = within(Where{.file = recording.origin.file, .place = say("{}", Name{recording.origin.file})}, problem);
  throw Error(Error::Kind::bad_data, problems);
}

KnownTerms known_terms(const Estimate& estimate, const std::vector<Term>& candidates) {
  KnownTerms known;
  std::vector<std::size_t> used;
  for (const Term& term : candidates) {
    const auto match = std::ranges::find(estimate.parameters, term.name, &Parameter::name);
    if (match == estimate.parameters.end()) continue;
    if (!std::isfinite(match->value) || match->unit.dimension() != Unit::parse(term.unit).dimension())
      throw Error(Error::Kind::bad_file, say("the result's parameter '{}' has no value in {}", match->name, term.unit));
    known.terms.push_back(term);
    known.coefficients.push_back(match->value);
    used.push_back(static_cast<std::size_t>(match - estimate.parameters.begin()));
  }
  known.covariance = Matrix(used.size(), used.size());
  for (std::size_t r = 0; r < used.size(); ++r)
    for (std::size_t c = 0; c < used.size(); ++c) known.covariance(r, c) = estimate.covariance(used[r], used[c]);
  return known;
}

Predicted predicted(const KnownTerms& known, const Felt& felt, std::vector<double>& regressors) {
  const std::size_t n = known.terms.size();
  regressors.resize(n);
  Predicted out;
  for (std::size_t t = 0; t < n; ++t)
    out.value += known.coefficients[t] * (regressors[t] = known.terms[t].regressor(felt));
  const double variance = quadratic_form(regressors, known.covariance);
  out.sd = std::isnan(variance) ? variance : std::sqrt(std::max(0.0, variance));
  return out;
}

Trust trust_in(const Channel& output) {
  Trust out{output, output};
  out.sd.name += ".compensation_sd";
  out.extrapolated.name += ".extrapolated";
  out.extrapolated.kind = QuantityKind::other;
  out.extrapolated.unit = Unit();
  return out;
}

}  // namespace tumble::compensation
