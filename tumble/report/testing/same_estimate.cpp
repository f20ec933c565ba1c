#include "tumble/report/testing/same_estimate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/report/result_members.hpp"
#include "tumble/report/testing/member_leaves.hpp"

namespace tumble::testing {
namespace {

constexpr double ulp = std::numeric_limits<double>::epsilon();

/// A value that no double of the displayed unit hits exactly moves by at most the rounding of one division and one
/// product: half an ulp each, 2 ulp with the offset of degC. NaN equals NaN.
void expect_same(double a, double b, double ulps, const std::string& what) {
  if (std::isnan(a) && std::isnan(b)) return;
  if (a == b) return;
  EXPECT_LE(std::abs(a - b), ulps * ulp * std::abs(a)) << what;
}

void expect_same(const std::vector<double>& a, const std::vector<double>& b, const std::string& what) {
  ASSERT_EQ(a.size(), b.size()) << what;
  for (std::size_t i = 0; i < a.size(); ++i) expect_same(a[i], b[i], 2.0, what);
}

/// The ends of limits are written by people: they come back bit by bit.
void expect_same(const std::optional<Bound>& a, const std::optional<Bound>& b, const std::string& what) {
  ASSERT_EQ(a.has_value(), b.has_value()) << what;
  if (!a) return;
  EXPECT_EQ(a->value, b->value) << what;
  EXPECT_EQ(a->unit, b->unit) << what;
}

void expect_same_parameters(const Estimate& a, const Estimate& b) {
  ASSERT_EQ(a.parameters.size(), b.parameters.size());
  for (std::size_t i = 0; i < a.parameters.size(); ++i) {
    const auto &p = a.parameters[i], &q = b.parameters[i];
    EXPECT_EQ(p.name, q.name);
    EXPECT_EQ(p.symbol, q.symbol);
    EXPECT_EQ(p.description, q.description);
    EXPECT_EQ(p.unit, q.unit);
    EXPECT_EQ(p.degrees_of_freedom, q.degrees_of_freedom);
    EXPECT_EQ(std::isnan(p.lower), std::isnan(q.lower));
    if (!std::isnan(p.lower)) expect_same(p.lower, q.lower, 2.0, p.name), expect_same(p.upper, q.upper, 2.0, p.name);
    expect_same(p.value, q.value, 2.0, p.name);
    ASSERT_EQ(p.contains.size(), q.contains.size()) << p.name;
    for (std::size_t k = 0; k < p.contains.size(); ++k) {
      EXPECT_EQ(p.contains[k].name, q.contains[k].name);
      EXPECT_EQ(p.contains[k].unit, q.contains[k].unit);
      expect_same(p.contains[k].weight, q.contains[k].weight, 4.0, p.name);
    }
  }
  ASSERT_EQ(a.covariance.rows, b.covariance.rows);
  expect_same(a.covariance.values, b.covariance.values, "covariance");
  ASSERT_EQ(a.budget.size(), b.budget.size());
  for (std::size_t k = 0; k < a.budget.size(); ++k) {
    EXPECT_EQ(a.budget[k].source, b.budget[k].source);
    EXPECT_EQ(a.budget[k].key, b.budget[k].key);
    expect_same(a.budget[k].factor.values, b.budget[k].factor.values, a.budget[k].source);
    for (std::size_t i = 0; i < a.parameters.size(); ++i) {
      // Each element is written and squared again: twice its relative error, and the rounding of as many sums.
      const double sums = static_cast<double>(a.budget[k].factor.columns);
      expect_same(a.budget[k].variance(i), b.budget[k].variance(i), 4.0 + sums, a.budget[k].source);
    }
  }
}

void expect_same_tables(const Estimate& a, const Estimate& b) {
  ASSERT_EQ(a.tables.size(), b.tables.size());
  for (std::size_t k = 0; k < a.tables.size(); ++k) {
    const auto &p = a.tables[k], &q = b.tables[k];
    EXPECT_EQ(p.for_programs, q.for_programs);
    EXPECT_EQ(p.name, q.name);
    EXPECT_EQ(p.caption, q.caption);
    ASSERT_EQ(p.columns.size(), q.columns.size());
    ASSERT_EQ(p.rows.size(), q.rows.size());
    for (std::size_t j = 0; j < p.columns.size(); ++j) {
      EXPECT_EQ(p.columns[j].name, q.columns[j].name);
      EXPECT_EQ(p.columns[j].unit, q.columns[j].unit);
      for (std::size_t i = 0; i < p.rows.size(); ++i) {
        ASSERT_EQ(p.rows[i][j].index(), q.rows[i][j].index());
        if (p.rows[i][j].index() == 1) {
          EXPECT_EQ(std::get<1>(p.rows[i][j]), std::get<1>(q.rows[i][j]));
        } else {
          expect_same(std::get<0>(p.rows[i][j]), std::get<0>(q.rows[i][j]), 2.0, p.name);
        }
      }
    }
  }
}

/// Members that the JSON has, by their paths.
template <class T>
void expect_same_members(const std::vector<T>& a, const std::vector<T>& b, const std::string& what) {
  ASSERT_EQ(a.size(), b.size()) << what;
  for (std::size_t k = 0; k < a.size(); ++k) {
    const auto before = leaves_of(a[k]), after = leaves_of(b[k]);
    ASSERT_EQ(before.size(), after.size()) << what << " " << k;
    for (const auto& [path, value] : before) {
      ASSERT_TRUE(after.contains(path)) << what << " " << k << " " << path;
      if (const auto* number = std::get_if<double>(&value))
        expect_same(*number, std::get<double>(after.at(path)), 2.0, path);
      else
        EXPECT_EQ(value, after.at(path)) << path;
    }
  }
}

void expect_same_place(const Place& a, const Place& b) {
  EXPECT_EQ(a.label, b.label);
  expect_same(a.time, b.time, 0.0, a.label);
}

void expect_same_finding(const Finding& a, const Finding& b) {
  EXPECT_EQ(a.severity, b.severity);
  EXPECT_EQ(a.code, b.code);
  EXPECT_EQ(a.message, b.message);
  EXPECT_EQ(a.where, b.where);
  EXPECT_EQ(a.occurrences.count, b.occurrences.count);
  expect_same_place(a.occurrences.first, b.occurrences.first);
  expect_same_place(a.occurrences.worst, b.occurrences.worst);
  ASSERT_EQ(a.values.size(), b.values.size());
  for (const FindingValue& p : a.values) {
    const auto same_name = std::ranges::find(b.values, p.name, &FindingValue::name);
    ASSERT_NE(same_name, b.values.end()) << p.name;
    const FindingValue& q = *same_name;
    EXPECT_EQ(p.unit, q.unit);
    ASSERT_EQ(p.value.index(), q.value.index()) << p.name;
    if (const auto* number = std::get_if<double>(&p.value))
      expect_same(*number, std::get<double>(q.value), 2.0, p.name);
    else if (const auto* phrase = std::get_if<Phrase>(&p.value))
      EXPECT_EQ(phrase->key, std::get<Phrase>(q.value).key);
    else if (const auto* text = std::get_if<std::string>(&p.value))
      EXPECT_EQ(*text, std::get<std::string>(q.value));
    else
      EXPECT_EQ(std::get<long long>(p.value), std::get<long long>(q.value));
  }
}

void expect_same_rest(const Estimate& a, const Estimate& b) {
  EXPECT_EQ(a.method, b.method);
  EXPECT_EQ(a.title, b.title);
  EXPECT_EQ(a.instrument_model, b.instrument_model);
  EXPECT_EQ(a.instrument_serial, b.instrument_serial);
  EXPECT_EQ(a.fit.observations, b.fit.observations);
  EXPECT_EQ(a.fit.degrees_of_freedom, b.fit.degrees_of_freedom);
  EXPECT_EQ(a.fit.chi_square, b.fit.chi_square);
  EXPECT_EQ(a.fit.condition, b.fit.condition);
  ASSERT_EQ(a.findings.size(), b.findings.size());
  for (std::size_t i = 0; i < a.findings.size(); ++i) expect_same_finding(a.findings[i], b.findings[i]);
  ASSERT_EQ(a.verdicts.size(), b.verdicts.size());
  for (std::size_t i = 0; i < a.verdicts.size(); ++i) {
    EXPECT_EQ(a.verdicts[i].parameter, b.verdicts[i].parameter);
    EXPECT_EQ(a.verdicts[i].outcome, b.verdicts[i].outcome);
    expect_same(a.verdicts[i].limit.lower, b.verdicts[i].limit.lower, a.verdicts[i].parameter);
    expect_same(a.verdicts[i].limit.upper, b.verdicts[i].limit.upper, a.verdicts[i].parameter);
  }
  ASSERT_EQ(a.provenance.inputs.size(), b.provenance.inputs.size());
  for (std::size_t i = 0; i < a.provenance.inputs.size(); ++i) {
    EXPECT_EQ(a.provenance.inputs[i].file, b.provenance.inputs[i].file);
    EXPECT_EQ(a.provenance.inputs[i].sha256, b.provenance.inputs[i].sha256);
  }
  EXPECT_EQ(a.provenance.settings, b.provenance.settings);
  EXPECT_EQ(a.provenance.seed, b.provenance.seed);
}

}  // namespace

void expect_same(const Estimate& a, const Estimate& b) {
  expect_same_parameters(a, b);
  expect_same_tables(a, b);
  expect_same_members(a.curves, b.curves, "curve");
  expect_same_members(a.models, b.models, "model");
  expect_same_rest(a, b);
}

}  // namespace tumble::testing
