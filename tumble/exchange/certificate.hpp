#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/exchange/decision.hpp"
#include "tumble/language/text.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble {

using Date = std::chrono::year_month_day;

/// Where somebody is, and how to reach them. Empty: not stated.
struct Contact {
  std::string name, street, post_code, city, state;
  std::string country;  ///< two letters of ISO 3166-1
  std::string email, phone, link;
};

struct Laboratory {
  Contact contact;
  std::string code;  ///< of its accreditation
  std::string logo;  ///< image as a data: address; empty: none
};

struct Person {
  std::string name, role;
  bool signs = false;
};

/// A measuring instrument or standard that the test was made with.
struct Equipment {
  std::string name, manufacturer, model, serial;
  std::string certificate;           ///< number of its own calibration certificate
  std::optional<Date> due;           ///< the last day on which that calibration counts
  std::string traceable_to;          ///< who calibrated it
  std::string certificate_sha256;    ///< of the file of that certificate
  std::string accepted_out_of_date;  ///< why it was used although it was due; printed
};

/// Names of the instrument that the result does not have.
struct CertifiedItem {
  std::string name, manufacturer, model, serial, customer_number;
};

/// A condition of the test. Value [SI] and its expanded uncertainty [SI] (k = 2), shown in the unit.
struct Condition {
  std::string name;
  double value = 0.0;
  std::optional<double> uncertainty;
  Unit unit;
};

/// Mean and spread of the production of a parameter, for global risks. [SI]
struct KnownPopulation {
  std::string parameter;
  Population population;
  Unit unit;  ///< as written
};

/// All that a certificate says and no result knows.
struct CertificateDetails {
  std::string file;  ///< where they stand, for messages
  Laboratory laboratory;
  std::vector<Person> persons;
  std::vector<Equipment> equipment;
  Contact customer;
  CertifiedItem item;
  std::vector<Condition> conditions;
  std::vector<KnownPopulation> populations;
  std::string number;
  std::optional<Date> received, begun, ended, issued;
  std::string place;  ///< a word of certificate_places()
  std::string traceability;
  std::string norm;                       ///< the standard that the test follows, if any
  std::string replaces, replaces_reason;  ///< number of the certificate that this one replaces
  std::optional<DecisionRule> rule;       ///< absent: no statement of conformity
  std::string rule_agreed_with;           ///< who asked for the rule
  bool signed_in_archive = false;         ///< people sign it in the archive, which the page says
  std::vector<std::string> remarks;
  Language language = Language::english;
};

/// "laboratory", "customer", "laboratoryBranch", "customerBranch", "other": words of the DCC.
const std::vector<std::string>& certificate_places();

/// A statement of conformity on one limit of the plan.
struct Statement {
  std::string parameter;
  Limit limit;                       ///< of the plan's verdict
  std::optional<std::size_t> index;  ///< of the parameter; absent: the data do not show it
  Tolerance tolerance;               ///< [SI]
  std::optional<Decision> decision;  ///< [SI]; absent where the result has no value of it
  Decision::Outcome outcome = Decision::Outcome::undecided;
  bool undermined = false;  ///< an error finding says not to rely on the value
  std::optional<GlobalRisk> global_risk;
};

/// The validation of the plan of a result (tasks/validate.hpp), as an annex.
struct CertifiedValidation {
  Estimate estimate;
  std::string file, sha256;
};

/// A result, what the laboratory says of it, and the statements that follow.
struct Certificate {
  Estimate estimate;
  CertificateDetails details;
  std::vector<Statement> statements;
  std::optional<double> joint;  ///< [1] probability that all parameters with a statement are within their limits
  std::string result_file, result_sha256;
  std::optional<CertifiedValidation> validation = {};  ///< absent: the certificate has no annex
  std::vector<Sentence> notes = {};                    ///< what its author should look at; not printed
};

/// "2026-11-02".
std::string iso_date(const Date& date);

/// Details that a certificate must have and that are missing: "lab.toml: [certificate] number is missing: ...", all of
/// them.
Problems missing_details(const CertificateDetails& details, const Estimate& estimate);

/// Errors in details that are given: dates out of order, equipment out of date at the end of the test without a reason,
/// a country that ISO 3166-1 does not have.
Problems wrong_details(const CertificateDetails& details);

/// Applies the rule to the limits of the plan. `undermined` are parameters that an error finding names.
///
/// Throws Error::bad_data for a simulated or predicted result, or a parameter without uncertainty;
///        Error::bad_input with all that is missing and wrong in the details
Certificate certify(const Estimate& estimate, const CertificateDetails& details,
                    const std::vector<std::string>& undermined);

/// A page for people: prints to A4 with a running head. It needs no network.
std::string certificate_html(const Certificate& certificate);

/// A Digital Calibration Certificate, schema 3.3.0 with D-SI 2.2.1, not signed: values in SI, and beside them in the
/// unit of the result where D-SI has it; the full covariance; `page` of certificate_html() as embedded document.
///
/// Throws Error::internal when the document breaks a rule of dcc_problems()
std::string certificate_dcc(const Certificate& certificate, const std::string& page);

/// Rules of a DCC that its schema does not check: units of D-SI, lengths of lists, references, languages, order of
/// dates, releases of software, country codes. Empty: none is broken.
///
/// See Schematron of the PTB for DCC 3.3.0
Problems dcc_problems(const std::string& xml);

/// `unit` in D-SI: "\degree\hour\tothe{-1}"; absent where D-SI has no such unit (parts of g).
std::optional<std::string> dsi_unit(const Unit& unit);
/// The coherent SI unit of a dimension in D-SI: "\metre\second\tothe{-2}". A count is \one.
std::string dsi_unit(const Dimension& dimension);

}  // namespace tumble
