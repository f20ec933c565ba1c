// What every method promises of its answers: deterministic, a covariance that is one, a budget that sums to it, and an
// Error, nothing else, for evidence that cannot carry it.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <set>
#include <string>

#include "tumble/core/budget.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/methods/testing/trials.hpp"
#include "tumble/reduce/compensate.hpp"
#include "tumble/report/figure.hpp"
#include "tumble/report/report.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

bool same_bytes(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0);
}

class Methods : public ::testing::TestWithParam<const Method*> {
 protected:
  const Method& method() const { return *GetParam(); }

  /// identify on trial(1), once for all tests of a process.
  const Estimate& estimate() const {
    static std::map<std::string, Estimate> known;
    auto found = known.find(method().name);
    if (found == known.end()) {
      found = known.emplace(method().name, method().identify(trial_of(method(), 1).evidence, {})).first;
    }
    return found->second;
  }
};

TEST_P(Methods, SaysWhatItNeedsAndWhereItComesFrom) {
  EXPECT_NE(std::string(method().source), "");
  EXPECT_EQ(&find_method(method().name), &method());
  EXPECT_FALSE(method().roles().empty());
  for (const auto& role : method().roles()) {
    EXPECT_FALSE(role.description.empty()) << role.name;
    if (role.unit.empty()) continue;  // any unit that the description allows
    EXPECT_NO_THROW(Unit::parse(role.unit)) << role.name;
  }
}

TEST_P(Methods, TrialIsDrawnFromOneTruth) {
  const Trial one = trial_of(method(), 1), again = trial_of(method(), 1), other = trial_of(method(), 2);
  EXPECT_FALSE(one.truth.empty());
  EXPECT_EQ(one.truth, other.truth);
  ASSERT_FALSE(one.evidence.recordings.empty());
  const auto& first = one.evidence.recordings[0].channels;
  ASSERT_FALSE(first.empty());
  bool differs = false;
  for (std::size_t c = 0; c < first.size(); ++c) {
    EXPECT_TRUE(same_bytes(first[c].values, again.evidence.recordings[0].channels[c].values)) << first[c].name;
    differs = differs || !same_bytes(first[c].values, other.evidence.recordings[0].channels[c].values);
  }
  EXPECT_TRUE(differs) << "two seeds give the same data";
}

TEST_P(Methods, IsDeterministic) {
  const Estimate again = method().identify(trial_of(method(), 1).evidence, {});
  ASSERT_EQ(again.parameters.size(), estimate().parameters.size());
  for (std::size_t i = 0; i < again.parameters.size(); ++i) {
    EXPECT_TRUE(same_bytes({again.parameters[i].value}, {estimate().parameters[i].value})) << again.parameters[i].name;
  }
  EXPECT_TRUE(same_bytes(again.covariance.values, estimate().covariance.values));
  EXPECT_EQ(to_json(again), to_json(estimate()));
}

TEST_P(Methods, ParametersAreWhole) {
  ASSERT_FALSE(estimate().parameters.empty());
  std::set<std::string> seen;
  for (const auto& parameter : estimate().parameters) {
    EXPECT_TRUE(seen.insert(parameter.name).second) << parameter.name << " twice";
    EXPECT_FALSE(parameter.symbol.empty() || parameter.description.empty()) << parameter.name;
    EXPECT_EQ(Unit::parse(parameter.unit.text()), parameter.unit) << parameter.name;
    EXPECT_TRUE(std::isfinite(parameter.value)) << parameter.name;
    EXPECT_GT(parameter.degrees_of_freedom, 0.0) << parameter.name;
  }
}

TEST_P(Methods, CovarianceIsSymmetricAndPositive) {
  const Matrix& c = estimate().covariance;
  const std::size_t n = estimate().parameters.size();
  ASSERT_EQ(c.rows, n);
  ASSERT_EQ(c.columns, n);
  Eigen::MatrixXd correlation(n, n);
  for (std::size_t i = 0; i < n; ++i) {
    ASSERT_GT(c(i, i), 0.0) << estimate().parameters[i].name;
    ASSERT_TRUE(std::isfinite(c(i, i))) << estimate().parameters[i].name;
  }
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      correlation(i, j) = c(i, j) / std::sqrt(c(i, i) * c(j, j));
      EXPECT_NEAR(correlation(i, j), c(j, i) / std::sqrt(c(i, i) * c(j, j)), 1e-12);
    }
  }
  // Rounding in n products of size one moves an eigenvalue of zero by about n epsilon; 1e-9 is far beyond.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(correlation, Eigen::EigenvaluesOnly);
  EXPECT_GT(eigen.eigenvalues().minCoeff(), -1e-9);
}

TEST_P(Methods, BudgetSumsToTheCovariance) {
  ASSERT_FALSE(estimate().budget.empty());
  for (const auto& contribution : estimate().budget) {
    EXPECT_FALSE(contribution.source.empty());
    ASSERT_EQ(contribution.factor.rows, estimate().parameters.size()) << contribution.source;
  }
  const Matrix& c = estimate().covariance;
  const Matrix whole = covariance_of(estimate().budget, c.rows);
  for (std::size_t i = 0; i < c.rows; ++i)
    for (std::size_t j = 0; j < c.rows; ++j)
      EXPECT_NEAR(whole(i, j) / std::sqrt(c(i, i) * c(j, j)), c(i, j) / std::sqrt(c(i, i) * c(j, j)), 1e-9)
          << estimate().parameters[i].name << ", " << estimate().parameters[j].name;
  for (std::size_t i = 0; i < estimate().parameters.size(); ++i) {
    double sum = 0.0;
    for (const auto& contribution : estimate().budget) {
      EXPECT_GE(contribution.variance(i), 0.0) << contribution.source << ", " << estimate().parameters[i].name;
      sum += contribution.variance(i);
    }
    EXPECT_NEAR(sum / estimate().covariance(i, i), 1.0, 1e-9) << estimate().parameters[i].name;
  }
}

TEST_P(Methods, TablesAndCurvesAreWhole) {
  for (const auto& table : estimate().tables) {
    EXPECT_FALSE(table.name.empty() || table.columns.empty());
    for (const auto& row : table.rows) EXPECT_EQ(row.size(), table.columns.size()) << table.name;
  }
  for (const auto& curve : estimate().curves) {
    EXPECT_FALSE(curve.name.empty() || curve.x.name.empty() || curve.y.name.empty());
    EXPECT_EQ(curve.x.values.size(), curve.y.values.size()) << curve.name;
    EXPECT_EQ(curve.lower.size(), curve.upper.size()) << curve.name;
    EXPECT_TRUE(curve.lower.empty() || curve.lower.size() == curve.x.values.size()) << curve.name;
    EXPECT_EQ(curve.lower.empty(), curve.band.empty()) << curve.name << ": a band says what it is";
  }
}

/// Noise and spectra: their figures show the data beside the model, over the time or the frequency.
TEST_P(Methods, ShowsItsResiduals) {
  static const std::set<std::string> shows_the_data{"allan_noise", "random_vibration"};
  const bool shown = std::ranges::any_of(figures_of(estimate()), [](const Figure& figure) {
    return (figure.name + figure.y.name).find("residual") != std::string::npos;
  });
  EXPECT_TRUE(shown || shows_the_data.contains(method().name));
}

/// The report, the workbench and `report --figure` have something to show of each method.
TEST_P(Methods, HasAFigure) {
  const auto figures = figures_of(estimate());
  ASSERT_FALSE(figures.empty());
  for (const auto& series : figures.front().series) EXPECT_GT(series.x.size(), 1u) << series.name;
}

TEST_P(Methods, TruthNamesParameters) {
  std::size_t found = 0;
  for (const auto& [name, value] : trial_of(method(), 1).truth) found += find_parameter(estimate(), name) != nullptr;
  EXPECT_GT(found, 0u);
}

// Poor evidence: trial(1) with one thing done to it.

struct Poor {
  std::string name;
  std::function<void(Evidence&)> mutate;
};

void each_channel(Evidence& evidence, const std::function<void(Channel&)>& mutate) {
  for (auto& recording : evidence.recordings) {
    for (auto& channel : recording.channels) mutate(channel);
  }
}

void keep(Channel& channel, std::size_t samples) {
  channel.values.resize(samples);
  if (channel.timeline.uniform()) return;
  auto stamps = *channel.timeline.stamps;
  stamps.resize(samples);
  channel.timeline.stamps = std::make_shared<const std::vector<double>>(std::move(stamps));
}

std::vector<Poor> poor_evidence() {
  const auto fill = [](double value) {
    return [value](Evidence& e) { each_channel(e, [value](Channel& c) { c.values.assign(c.values.size(), value); }); };
  };
  return {
      {"no recording", [](Evidence& e) { e.recordings.clear(); }},
      {"no channels",
       [](Evidence& e) {
         for (auto& r : e.recordings) r.channels.clear();
       }},
      {"no samples", [](Evidence& e) { each_channel(e, [](Channel& c) { keep(c, 0); }); }},
      {"one sample", [](Evidence& e) { each_channel(e, [](Channel& c) { keep(c, 1); }); }},
      {"two samples", [](Evidence& e) { each_channel(e, [](Channel& c) { keep(c, 2); }); }},
      {"constant", fill(1.0)},
      {"zero", fill(0.0)},
      {"all NaN", fill(std::nan(""))},
      {"all infinite", fill(std::numeric_limits<double>::infinity())},
  };
}

TEST_P(Methods, PoorEvidenceIsAnErrorAndNothingElse) {
  for (const auto& poor : poor_evidence()) {
    Evidence evidence = trial_of(method(), 1).evidence;
    poor.mutate(evidence);
    try {
      method().identify(evidence, {});
      ADD_FAILURE() << poor.name << ": no error";
    } catch (const Error& error) {
      EXPECT_TRUE(error.kind == Error::Kind::bad_data || error.kind == Error::Kind::bad_input)
          << poor.name << ": " << error.what();
      EXPECT_FALSE(error.problems.empty()) << poor.name;
      EXPECT_NE(std::string(error.what()), "") << poor.name;
    } catch (const std::exception& other) {
      ADD_FAILURE() << poor.name << ": not an Error: " << other.what();
    }
  }
}

TEST_P(Methods, HasModelsWhoseTermsAreItsParameters) {
  const Estimate result = estimate();
  EXPECT_EQ(method().compensates, !result.models.empty());
  for (const OutputModel& model : result.models) {
    EXPECT_TRUE(!model.terms.empty() || model.scale) << model.role;
    for (const ModelTerm& term : model.terms) {
      EXPECT_FALSE(term.regressor.empty()) << term.term;
      if (!term.parameter) continue;
      ASSERT_LT(*term.parameter, result.parameters.size());
      EXPECT_EQ(result.parameters[*term.parameter].name, term.term);
      EXPECT_LE(term.least, term.greatest) << term.term;
    }
  }
}

TEST_P(Methods, CompensatesWithoutLosingSamples) {
  if (!method().compensates) return;
  const Trial trial = trial_of(method(), 2);
  const Recording& recording = trial.evidence.recordings[0];
  Estimate result = estimate();
  result.provenance.settings = trial.evidence.plan.settings.texts();
  for (const auto& [role, choices] : trial.evidence.plan.channels)  // as `identify` of tasks/ notes them
    result.provenance.settings["channels." + role] = choices.front().channel;
  const Compensation done = compensate(result, recording, nullptr);
  for (const auto& channel : recording.channels) {
    const Channel* kept = find_channel(done.recording, channel.name);
    ASSERT_NE(kept, nullptr) << channel.name;
    EXPECT_EQ(kept->values.size(), channel.values.size()) << channel.name;
  }
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.pattern = "no channel for the role"},
                      [&] { compensate(result, Recording{}, nullptr); }));
}

TEST_P(Methods, PredictsUncertaintiesOfItsOwnTrial) {
  if (method().predict == nullptr) return;
  const Estimate predicted = method().predict(trial_of(method(), 1).evidence.plan);
  ASSERT_FALSE(predicted.parameters.empty());
  ASSERT_EQ(predicted.covariance.rows, predicted.parameters.size());
  for (std::size_t i = 0; i < predicted.parameters.size(); ++i) {
    EXPECT_GT(standard_uncertainty(predicted, i), 0.0) << predicted.parameters[i].name;
  }
}

INSTANTIATE_TEST_SUITE_P(All, Methods, ::testing::ValuesIn(method_catalogue()),
                         [](const auto& entry) { return std::string(entry.param->name); });

TEST(FindMethod, SuggestsTheNearestName) {
  const std::string name = method_catalogue().front()->name;
  try {
    find_method(name + "x");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind, Error::Kind::unsupported);
    EXPECT_NE(std::string(error.what()).find("'" + name + "'"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace tumble
