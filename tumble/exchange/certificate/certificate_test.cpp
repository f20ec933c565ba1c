#include "tumble/exchange/certificate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/instant.hpp"
#include "tumble/exchange/certificate/testing/example_certificate.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

using testing::day;
using testing::example_details;

/// A measured result with two limits: of bias (uncertain) and of the angle random walk (well known).
Estimate measured_estimate() {
  Estimate estimate = testing::estimate();
  estimate.provenance.seed.reset();
  estimate.findings.clear();
  estimate.verdicts = {{"bias", Verdict::Outcome::undecided, {bound(-0.5, "deg/h"), bound(0.5, "deg/h")}},
                       {"angle_random_walk", Verdict::Outcome::pass, {.upper = bound(0.02, "deg/sqrt(h)")}}};
  return estimate;
}

Refused refused(const Estimate& estimate, const CertificateDetails& details) {
  return refusal_of([&] { certify(estimate, details, {}); });
}

constexpr auto input = Error::Kind::bad_input, data = Error::Kind::bad_data;

TEST(Certificate, AppliesItsRuleToTheLimitsOfThePlan) {
  auto details = example_details();
  details.rule = parse_decision_rule("simple");
  const Certificate certificate = certify(measured_estimate(), details, {});
  ASSERT_EQ(certificate.statements.size(), 2u);
  EXPECT_EQ(certificate.statements[0].outcome, Decision::Outcome::pass);
  EXPECT_NEAR(certificate.statements[0].tolerance.upper, si(0.5, "deg/h"), 1e-20);
  EXPECT_EQ(certificate.statements[1].tolerance.lower, -INFINITY);
  details.rule = parse_decision_rule("guarded:1");
  EXPECT_EQ(certify(measured_estimate(), details, {}).statements[0].outcome, Decision::Outcome::fail);
}

TEST(Certificate, JointProbabilityIsBelowEachSingleOne) {
  const Certificate certificate = certify(measured_estimate(), example_details(), {});
  ASSERT_TRUE(certificate.joint);
  for (const auto& statement : certificate.statements)
    EXPECT_LE(*certificate.joint, statement.decision->conformance + 2e-4);
}

TEST(Certificate, WithoutLimitsNeedsNoRuleAndMakesNoStatement) {
  auto estimate = measured_estimate();
  estimate.verdicts.clear();
  auto details = example_details();
  details.rule.reset();
  const Certificate certificate = certify(estimate, details, {});
  EXPECT_TRUE(certificate.statements.empty());
  EXPECT_NE(certificate_html(certificate).find("makes no statement of conformity"), std::string::npos);
}

TEST(Certificate, NamesAllThatIsMissingAtOnce) {
  auto estimate = measured_estimate();
  estimate.instrument_model.clear(), estimate.instrument_serial.clear();
  const Refused refusal = refused(estimate, {});
  EXPECT_EQ(refusal.problems.size(), 17u);
  for (const char* key :
       {"[laboratory] name", "[laboratory] city", "[laboratory] country", "[customer] name", "[customer] city",
        "[[person]] name", "[[person]] signs = true", "[item] model", "[item] serial", "[[condition]]",
        "[certificate] number", "[certificate] begun", "[certificate] ended", "[certificate] issued",
        "[certificate] place", "[certificate] traceability", "[certificate] rule"})
    EXPECT_TRUE(refuses(input, Asked{.values = {key}, .pattern = "is missing"}, refusal)) << key;
}

TEST(Certificate, ComparesDueDatesWithTheEndOfTheTest) {
  auto details = example_details();
  details.equipment[0].due = details.ended;
  EXPECT_TRUE(refused(measured_estimate(), details).empty());
  details.equipment[0].due = day(2026, 11, 2);
  const Asked due{.values = {details.equipment[0].name, "2026-11-02", "2026-11-03"}};
  EXPECT_TRUE(refuses(input, due, refused(measured_estimate(), details)));
  details.equipment[0].accepted_out_of_date = " \t";
  EXPECT_TRUE(refuses(input, due, refused(measured_estimate(), details)));
  details.equipment[0].accepted_out_of_date = "checked against <C-78>";
  const auto page = certificate_html(certify(measured_estimate(), details, {}));
  EXPECT_NE(page.find("It was accepted: checked against &#60;C-78&#62;"), std::string::npos);
}

/// Two recordings of the days from 1 to 3 November 2026.
Estimate dated_estimate() {
  auto estimate = measured_estimate();
  estimate.tables.push_back(table_of({{"2.csv", {"2026-11-02T09:00:00", "2026-11-03T00:00:00"}},
                                      {"1.csv", {"2026-11-01T23:59:59Z", "2026-11-02T00:10:00Z"}}}));
  return estimate;
}

TEST(Certificate, TakesTheDaysOfTheTestFromTheRecordings) {
  auto details = example_details();
  details.begun.reset(), details.ended.reset();
  const auto certificate = certify(dated_estimate(), details, {});
  EXPECT_EQ(certificate.details.begun, day(2026, 11, 1));
  EXPECT_EQ(certificate.details.ended, day(2026, 11, 3));
  EXPECT_TRUE(certificate.notes.empty());
  details.equipment[0].due = day(2026, 11, 2);
  EXPECT_TRUE(refuses(input, Asked{.values = {details.equipment[0].name, "2026-11-02", "2026-11-03"}},
                      refused(dated_estimate(), details)));
}

TEST(Certificate, DoesNotInventDaysOfRecordingsThatDoNotSayThem) {
  auto details = example_details();
  details.begun.reset(), details.ended.reset();
  auto estimate = dated_estimate();
  EXPECT_TRUE(refused(estimate, details).empty());
  estimate.tables.back().rows[0] = {"2.csv", "", ""};
  EXPECT_TRUE(refuses(input,
                      std::vector<Asked>{{.values = {"[certificate] begun"}, .pattern = "is missing"},
                                         {.values = {"[certificate] ended"}, .pattern = "is missing"}},
                      refused(estimate, details)));
}

TEST(Certificate, DoubtsDaysThatTheRecordingsContradict) {
  auto details = example_details();
  details.begun = day(2026, 11, 2), details.ended = day(2026, 11, 2);  // a time zone away
  EXPECT_TRUE(certify(dated_estimate(), details, {}).notes.empty());
  details.begun = day(2026, 11, 4), details.ended = day(2026, 11, 4);
  const auto certificate = certify(dated_estimate(), details, {});
  EXPECT_EQ(certificate.details.begun, day(2026, 11, 4));  // the laboratory decides
  ASSERT_EQ(certificate.notes.size(), 2u);
  EXPECT_EQ(certificate.notes[0].text().find("2.csv was measured from 2026-11-02 to 2026-11-03"), 0u);
}

TEST(Certificate, RefusesDatesOutOfOrderAndUnknownCountries) {
  auto details = example_details();
  details.ended = day(2026, 11, 1);
  details.laboratory.contact.country = "XX";
  details.replaces = details.number;
  const Refused refusal = refused(measured_estimate(), details);
  EXPECT_TRUE(refuses(input,
                      {{.values = {"begun, ended", "2026-11-02", "2026-11-01"}},
                       {.values = {"[laboratory]", "XX"}},
                       {.pattern = "[certificate] replaces: "}},
                      refusal));
  EXPECT_EQ(refusal.problems.size(), 3u);
}

TEST(Certificate, RefusesAPredictionAndAValueWithoutUncertainty) {
  auto estimate = measured_estimate();
  estimate.provenance.inputs.clear();
  EXPECT_TRUE(refuses(data, Asked{.pattern = "needs measured data"}, refused(estimate, example_details())));
  estimate = measured_estimate();
  estimate.covariance(2, 2) = 0.0;
  EXPECT_TRUE(
      refuses(data, Asked{.values = {"A2_0"}, .pattern = "has no uncertainty"}, refused(estimate, example_details())));
  estimate = measured_estimate();
  estimate.covariance(4, 1) = NAN;
  EXPECT_TRUE(refuses(
      data, Asked{.values = {estimate.parameters[1].name, estimate.parameters[4].name}, .pattern = "covariance"},
      refused(estimate, example_details())));
}

TEST(Certificate, RefusesLimitsOfAnotherDimension) {
  auto estimate = measured_estimate();
  estimate.verdicts = {{"bias", Verdict::Outcome::pass, {.upper = bound(1.0, "m")}},
                       {"A1_1", Verdict::Outcome::pass, {.lower = bound(1.0, "g")}}};
  const Refused refusal = refused(estimate, example_details());
  EXPECT_EQ(refusal.problems.size(), 2u);
  EXPECT_TRUE(refuses(input, {{.values = {"bias", "1 m", "m", "deg/h"}}, {.values = {"A1_1", "1 g", "g"}}}, refusal));
}

TEST(Certificate, RefusesLimitsAndIntervalsThatContradictThemselves) {
  auto estimate = measured_estimate();
  estimate.verdicts = {{"bias", Verdict::Outcome::pass, {bound(2.0, "deg/h"), bound(1.0, "deg/h")}}};
  EXPECT_TRUE(refuses(input, Asked{.values = {"bias"}, .pattern = "lower end above its upper end"},
                      refused(estimate, example_details())));
  for (const auto& [below, above] : {std::pair{1.0, 2.0}, {2.0, -2.0}, {0.0, 0.0}}) {
    estimate = measured_estimate();
    Parameter& bias = estimate.parameters[*certify(estimate, example_details(), {}).statements[0].index];
    bias.lower = bias.value + below * 1e-8, bias.upper = bias.value + above * 1e-8;
    EXPECT_TRUE(refuses(data, Asked{.values = {"bias"}, .pattern = "does not hold its value"},
                        refused(estimate, example_details())));
  }
  auto details = example_details();
  details.replaces_reason = "a reason without a certificate";
  details.received = day(0, 1, 1), details.customer.link = "https://example.org/<b>";
  EXPECT_TRUE(refuses(input,
                      {{.values = {"received", "0000-01-01"}},
                       {.values = {"[customer]", "https://example.org/<b>"}},
                       {.pattern = "[certificate] replaces_reason is given"}},
                      refused(measured_estimate(), details)));
}

TEST(Certificate, OfAParameterWithABlankInItsNameIsADcc) {
  auto estimate = measured_estimate();
  estimate.verdicts.clear();
  estimate.parameters[0].name = "Gyro X (1).bias";  // of a channel as people name it
  const auto certificate = certify(estimate, example_details(), {});
  EXPECT_NE(certificate_dcc(certificate, "").find("<si:labelXMLList>Gyro_X_(1).bias "), std::string::npos);
}

TEST(Certificate, ConditionsHaveTheDigitsOfTheirUncertainty) {
  const auto page = certificate_html(certify(measured_estimate(), example_details(), {}));
  EXPECT_NE(page.find("<td>23.0</td><td>0.5 (k = 2)</td>"), std::string::npos);
}

TEST(Certificate, HoldsTheSmallRiskOfAWideGuardBandAsText) {
  auto details = example_details();
  details.rule = parse_decision_rule("guarded:3");
  EXPECT_NE(certificate_html(certify(measured_estimate(), details, {})).find("at most &#60;0.01 %"), std::string::npos);
}

TEST(Certificate, OfSimulatedDataIsASpecimen) {
  auto estimate = measured_estimate();
  EXPECT_EQ(certificate_html(certify(estimate, example_details(), {})).find("Specimen"), std::string::npos);
  estimate.provenance.seed = 7;
  EXPECT_NE(certificate_html(certify(estimate, example_details(), {})).find("Specimen"), std::string::npos);
}

TEST(Certificate, OfAnotherUnitThanTheResultIsRefused) {
  auto details = example_details();
  details.item.serial = measured_estimate().instrument_serial;
  EXPECT_FALSE(details.item.serial.empty());
  EXPECT_NO_THROW(certify(measured_estimate(), details, {}));
  details.item.serial = "another";
  EXPECT_TRUE(refuses(input, Asked{.values = {measured_estimate().instrument_serial, "another"}},
                      refused(measured_estimate(), details)));
}

TEST(Certificate, MakesNoStatementOnAParameterThatAnErrorConcerns) {
  const Certificate certificate = certify(measured_estimate(), example_details(), {"bias"});
  EXPECT_EQ(certificate.statements[0].outcome, Decision::Outcome::undecided);
  EXPECT_FALSE(certificate.statements[0].decision);
  EXPECT_NE(certificate_html(certificate).find("concerns bias"), std::string::npos);
}

TEST(Certificate, SaysGlobalRisksWhereTheProductionIsKnown) {
  auto details = example_details();
  details.populations = {{"bias", {0.0, si(0.2, "deg/h")}, Unit::parse("deg/h")}};
  const auto risk = certify(measured_estimate(), details, {}).statements[0].global_risk;
  ASSERT_TRUE(risk);
  EXPECT_GT(risk->producer, risk->consumer);
  details.populations[0].unit = Unit::parse("m/s");
  EXPECT_TRUE(refuses(input, Asked{.values = {"bias", "m/s", "deg/h"}}, refused(measured_estimate(), details)));
  details.populations[0].parameter = "bais";
  EXPECT_TRUE(
      refuses(input, Asked{.values = {"bais"}, .pattern = "[[population]]"}, refused(measured_estimate(), details)));
}

TEST(Certificate, NumberCannotEndTheStyleOrOpenAnElement) {
  auto details = example_details();
  details.number = "1\"; } </style><script>alert(1)</script>\\";
  const auto page = certificate_html(certify(measured_estimate(), details, {}));
  EXPECT_EQ(page.find("<script"), std::string::npos);
  EXPECT_EQ(page.find("</style>"), page.rfind("</style>"));
}

TEST(Certificate, WritesChineseUnitsAsTheNationalStandardDoes) {
  auto details = example_details();
  details.language = Language::chinese;
  const auto page = certificate_html(certify(measured_estimate(), details, {}));
  for (const char* text :
       {"lang=\"zh-CN\"", "校准证书", "2026年11月2日", "(°)/(h·K)", "(°)/h<sup>1/2</sup>", "10<sup>−6</sup>", "″"})
    EXPECT_NE(page.find(text), std::string::npos) << text;
}

TEST(Certificate, SaysWhatGIsWhereAUnitHasIt) {
  const auto says = [](const char* unit) {
    auto estimate = measured_estimate();
    estimate.parameters = {estimate.parameters.front()};
    estimate.covariance = Matrix(1, 1);
    estimate.covariance(0, 0) = 1.0;
    estimate.budget.clear(), estimate.verdicts.clear();
    estimate.parameters.front().unit = Unit::parse(unit);
    return certificate_html(certify(estimate, example_details(), {})).find("standard acceleration") !=
           std::string::npos;
  };
  for (const char* unit : {"g", "mg", "ug/g^2", "deg/h/g"}) EXPECT_TRUE(says(unit)) << unit;
  for (const char* unit : {"deg", "deg/h", "deg/sqrt(h)"}) EXPECT_FALSE(says(unit)) << unit;
}

TEST(Certificate, NamesAndDescriptionsAreInItsLanguage) {
  auto estimate = measured_estimate();
  estimate.method = "static_bias";
  estimate.parameters.front().name = "reference_temperature",
  estimate.parameters.front().description = "mean of the power-ups";
  auto details = example_details();
  details.language = Language::chinese;
  const auto page = certificate_html(certify(estimate, details, {}));
  for (const char* text : {"静态零偏测试 <code>static_bias</code>", "<th scope=\"row\">参考温度<", "各次通电的平均值"})
    EXPECT_NE(page.find(text), std::string::npos) << text;
}

}  // namespace
}  // namespace tumble
