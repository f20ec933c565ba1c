// A Digital Calibration Certificate on the trial of every method: valid by the schema of the PTB, which xmllint applies
// without a network; every number reads back as it is in the result.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <pugixml.hpp>
#include <sstream>

#include "tumble/exchange/certificate.hpp"
#include "tumble/exchange/certificate/testing/example_certificate.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/methods/testing/trials.hpp"
#include "tumble/report/report.hpp"

namespace tumble {
namespace {

/// What xmllint says of a document; empty: it is valid.
std::string fault_by_schema(const std::string& xml) {
  const std::string folder = std::string(TUMBLE_SOURCE_DIR) + "/tests/reference/dcc";
  const auto test = ::testing::UnitTest::GetInstance()->current_test_info();
  std::string name = std::string(test->test_suite_name()) + "_" + test->name();
  std::ranges::replace(name, '/', '_');
  const auto file = std::filesystem::temp_directory_path() / ("tumble_" + name + ".xml");
  std::ofstream(file) << xml;
  const std::string command = "XML_CATALOG_FILES='" + folder + "/catalog.xml' xmllint --nonet --noout --schema '" +
                              folder + "/dcc.xsd' '" + file.string() + "' > '" + file.string() + ".log' 2>&1";
  const int status = std::system(command.c_str());
  std::ifstream log(file.string() + ".log");
  std::ostringstream said;
  said << log.rdbuf();
  std::filesystem::remove(file), std::filesystem::remove(file.string() + ".log");
  return status == 0 ? "" : "xmllint: " + said.str();
}

std::vector<double> numbers_of(const char* text) {
  std::istringstream stream(text);
  std::vector<double> numbers;
  for (std::string word; stream >> word;) numbers.push_back(std::strtod(word.c_str(), nullptr));
  return numbers;
}

std::string dcc_of(const Certificate& certificate) {
  return certificate_dcc(certificate, certificate_html(certificate));
}

/// The result as it is after a file: what a certificate is written from.
Estimate read_back(const Estimate& estimate) { return estimate_from_json(to_json(estimate), "result.json"); }

/// The list of all parameters that a DCC ends with.
pugi::xml_node list_of(const pugi::xml_document& document) {
  return document.select_node("//dcc:quantity[contains(@refType,'tumble_allParameters')]/si:realListXMLList").node();
}

class CertificateOfMethod : public ::testing::TestWithParam<const Method*> {};

TEST_P(CertificateOfMethod, ValidatesAndReadsBack) {
  Estimate estimate = GetParam()->identify(trial_of(*GetParam(), 1).evidence, {});
  estimate.method = GetParam()->name;
  estimate.provenance.inputs = {{"trial.h5", std::string(64, '0')}};
  for (std::size_t i = 0; i < estimate.parameters.size() && estimate.verdicts.size() < 3; ++i)
    if (std::isfinite(estimate.parameters[i].value) && estimate.parameters[i].unit.offset() == 0.0)
      estimate.verdicts.push_back({estimate.parameters[i].name,
                                   Verdict::Outcome::undecided,
                                   {.upper = Bound{estimate.parameters[i].value, estimate.parameters[i].unit}}});
  estimate = read_back(estimate);
  auto details = testing::example_details();
  details.item.model = "model", details.item.serial = "1";
  for (const auto language : {Language::english, Language::chinese}) {
    details.language = language;
    const Certificate certificate = certify(estimate, details, {});
    const std::string xml = dcc_of(certificate);
    ASSERT_EQ(fault_by_schema(xml), "");
    pugi::xml_document document;
    ASSERT_TRUE(document.load_string(xml.c_str()));
    const auto list = list_of(document);
    if (!list) continue;  // of a single parameter
    const auto values = numbers_of(list.child_value("si:valueXMLList"));
    std::vector<std::size_t> indices;
    for (std::size_t i = 0; i < estimate.parameters.size(); ++i)
      if (std::isfinite(estimate.parameters[i].value)) indices.push_back(i);
    ASSERT_EQ(values.size(), indices.size());
    const auto columns = list.select_nodes(".//si:covarianceXMLList/si:valueXMLList");
    ASSERT_EQ(columns.size(), indices.size());
    Eigen::MatrixXd correlation(indices.size(), indices.size());
    for (std::size_t j = 0; j < indices.size(); ++j) {
      EXPECT_EQ(values[j], estimate.parameters[indices[j]].value);
      const auto column = numbers_of(columns[j].node().child_value());
      ASSERT_EQ(column.size(), indices.size());
      for (std::size_t i = 0; i < indices.size(); ++i) {
        const double variances =
            estimate.covariance(indices[i], indices[i]) * estimate.covariance(indices[j], indices[j]);
        EXPECT_NEAR(column[i], estimate.covariance(indices[i], indices[j]), 1e-15 * std::sqrt(variances));
        correlation(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = column[i] / std::sqrt(variances);
      }
    }
    // The budget is a sum of squares; what the JSON rounds is 1e-16 of each element.
    const Eigen::VectorXd values_of_matrix = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(correlation).eigenvalues();
    EXPECT_GT(values_of_matrix.minCoeff(), -1e-12 * static_cast<double>(indices.size()));
  }
}

INSTANTIATE_TEST_SUITE_P(, CertificateOfMethod, ::testing::ValuesIn(method_catalogue()),
                         [](const auto& test) { return test.param->name; });

/// A certificate of the example result, in English, without the page inside.
std::string example_dcc() {
  Estimate estimate = testing::estimate();
  estimate.findings.clear();
  return certificate_dcc(certify(read_back(estimate), testing::example_details(), {}), "");
}

std::string with(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

TEST(CertificateSchema, RefusesWhatItMust) {
  const std::string sound = example_dcc();
  ASSERT_EQ(fault_by_schema(sound), "");
  for (const auto& [from, to] : {std::pair{"<dcc:performanceLocation>laboratory</dcc:performanceLocation>", ""},
                                 {"<si:coverageFactor>", "<si:coverageFactor>0."},
                                 {"<si:coverageProbability>0.95", "<si:coverageProbability>9.5e-1"},
                                 {"<dcc:uniqueIdentifier>", "<dcc:uniqueIdentifier> "},
                                 {"<dcc:conformity>fail", "<dcc:conformity>failed"}})
    EXPECT_NE(fault_by_schema(with(sound, from, to)), "") << from;
}

TEST(CertificateRules, RefuseWhatTheSchemaLets) {
  const std::string sound = example_dcc();
  ASSERT_TRUE(dcc_problems(sound).empty());
  for (const auto& [from, to] : {std::pair{"\\kelvin\\tothe{-1}", "K^-1"},
                                 {"\\radian", "\\radians"},
                                 {"<dcc:release>v", "<dcc:release>"},
                                 {"<si:labelXMLList>A1_0 ", "<si:labelXMLList>"},
                                 {"<si:valueStandardMUXMLList>", "<si:valueStandardMUXMLList>1 "},
                                 {"<dcc:endPerformanceDate>2026", "<dcc:endPerformanceDate>2025"},
                                 {"<dcc:countryCodeISO3166_1>DE", "<dcc:countryCodeISO3166_1>XX"},
                                 {"lang=\"en\"", "lang=\"fr\""},
                                 {"<dcc:mainSigner>true", "<dcc:mainSigner>false"},
                                 {"<dcc:item>", "<dcc:item refId=\"nobody\">"},
                                 {"<dcc:usedMethods>", "<dcc:usedMethods2>"},
                                 {"<si:columnXMLList>", "<si:columnXMLList/><si:columnXMLList>"}})
    EXPECT_FALSE(dcc_problems(with(sound, from, to)).empty()) << from;
}

TEST(CertificateRules, RefuseACovarianceThatIsNone) {
  const std::string sound = example_dcc();
  pugi::xml_document document;
  ASSERT_TRUE(document.load_string(sound.c_str()));
  const std::string first =
      list_of(document).select_node(".//si:covarianceXMLList/si:valueXMLList").node().child_value();
  const auto blank = first.find(' ');
  EXPECT_FALSE(dcc_problems(with(sound, first, "1" + first.substr(blank))).empty()) << "diagonal";
  const auto second = first.find(' ', blank + 1);
  EXPECT_FALSE(dcc_problems(with(sound, first, first.substr(0, blank) + " 1" + first.substr(second))).empty())
      << "symmetry";
}

TEST(CertificateRules, RefuseWhatIsNoCertificate) {
  EXPECT_FALSE(dcc_problems("").empty());
  EXPECT_FALSE(dcc_problems("<a>").empty());
  EXPECT_FALSE(dcc_problems("<a/>").empty());
}

TEST(CertificateSchema, HoldsHostileNamesAsText) {
  Estimate estimate = testing::estimate();
  estimate.findings.clear();
  auto details = testing::example_details();
  details.item.name = "]]><x a='\"&amp;\x01\xff\xe2\x80\xae\xef\xbf\xbf";
  details.customer.name = "\t";
  details.remarks = {"<!DOCTYPE a [<!ENTITY b SYSTEM \"file:///etc/passwd\">]>&b;"};
  const Certificate certificate = certify(estimate, details, {});
  EXPECT_EQ(fault_by_schema(dcc_of(certificate)), "");
}

TEST(CertificateSchema, HoldsUnknownValuesAndHiddenParameters) {
  Estimate estimate = testing::estimate();
  estimate.findings.clear();
  estimate.parameters[2].value = NAN;
  estimate.verdicts = {{estimate.parameters[2].name, Verdict::Outcome::undecided, {.upper = bound(1.0, "deg/h/K^2")}},
                       {"nothing", Verdict::Outcome::undecided, {.lower = bound(1.0, "m")}}};
  estimate.parameters[0].degrees_of_freedom = 0.3;  // k is about 40 000
  estimate.parameters[1].lower = estimate.parameters[1].value, estimate.parameters[1].upper = 1.0;
  const Certificate certificate = certify(estimate, testing::example_details(), {});
  EXPECT_EQ(fault_by_schema(dcc_of(certificate)), "");
}

}  // namespace
}  // namespace tumble
