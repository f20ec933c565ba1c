#include <fmt/format.h>

#include <algorithm>

#include "tumble/exchange/certificate.hpp"
#include "tumble/exchange/certificate/countries.hpp"
#include "tumble/units/sentence.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble {
namespace {

/// A detail that a certificate must have, and what it is.
struct Needed {
  const char* key;
  bool given;
  const char* what;
};

/// Two dates in order, if both are given.
void expect_order(const std::optional<Date>& first, const std::optional<Date>& second, const char* names,
                  const CertificateDetails& details, Problems& problems) {
  if (first && second && *second < *first)
    problems.push_back(in_file(details.file, say("[certificate] {}: {} is after {}", Name{names},
                                                 Name{iso_date(*first)}, Name{iso_date(*second)})));
}

/// What a DCC has no place for: dates before the year 1, addresses of pages with characters that none has.
void check_forms(const CertificateDetails& details, Problems& problems) {
  for (const auto& [key, date] : {std::pair{"received", &details.received}, std::pair{"begun", &details.begun},
                                  std::pair{"ended", &details.ended}, std::pair{"issued", &details.issued}})
    if (*date && (*date)->year() < std::chrono::year(1))
      problems.push_back(
          in_file(details.file, say("[certificate] {}: {} is no day of a test", Name{key}, Name{iso_date(**date)})));
  for (const auto& [section, link] :
       {std::pair{"[laboratory]", &details.laboratory.contact.link}, std::pair{"[customer]", &details.customer.link}})
    if (link->find_first_of(" <>\"{}|\\^`") != std::string::npos)
      problems.push_back(in_file(
          details.file,
          say("{} link: '{}': the address of a page is expected, such as https://example.org", Name{section}, *link)));
}

void check_equipment(const CertificateDetails& details, Problems& problems) {
  for (const auto& one : details.equipment) {
    const auto complain = [&](const Sentence& what) {
      problems.push_back(in_file(details.file, say("[[equipment]] '{}': {}", one.name, what)));
    };
    if (!one.certificate.empty() && !one.due) complain("due is missing: the last day on which its certificate counts");
    if (one.due && details.ended && *one.due < *details.ended && is_blank(one.accepted_out_of_date))
      complain(
          say("its calibration was valid to {}, but the test ended on {}; calibrate it, or state why it was "
              "used: accepted_out_of_date = \"...\" or --accept-out-of-date REASON, which is printed",
              Name{iso_date(*one.due)}, Name{iso_date(*details.ended)}));
  }
}

}  // namespace

const std::vector<std::string>& certificate_places() {
  static const std::vector<std::string> places{"laboratory", "customer", "laboratoryBranch", "customerBranch", "other"};
  return places;
}

std::string iso_date(const Date& date) {
  return fmt::format("{:04d}-{:02d}-{:02d}", static_cast<int>(date.year()), static_cast<unsigned>(date.month()),
                     static_cast<unsigned>(date.day()));
}

Problems missing_details(const CertificateDetails& details, const Estimate& estimate) {
  const bool signer = std::ranges::any_of(details.persons, &Person::signs);
  const bool names = std::ranges::none_of(details.persons, [](const Person& p) { return p.name.empty(); });
  Problems problems;
  for (const auto& [key, given, what] : std::initializer_list<Needed>{
           {"[laboratory] name", !details.laboratory.contact.name.empty(), "name of the laboratory"},
           {"[laboratory] city", !details.laboratory.contact.city.empty(), "where it is"},
           {"[laboratory] country", !details.laboratory.contact.country.empty(), "two letters, such as \"DE\""},
           {"[customer] name", !details.customer.name.empty(), "who ordered the calibration"},
           {"[customer] city", !details.customer.city.empty(), "where the customer is"},
           {"[[person]] name", !details.persons.empty() && names, "who is responsible for the certificate"},
           {"[[person]] signs = true", signer, "one person must authorise the certificate"},
           {"[item] model", !details.item.model.empty() || !estimate.instrument_model.empty(),
            "what the instrument is; the plan may say it as [instrument] model"},
           {"[item] serial", !details.item.serial.empty() || !estimate.instrument_serial.empty(),
            "its serial number; the plan may say it as [instrument] serial"},
           {"[[condition]]", !details.conditions.empty(), "the conditions of the test, such as the temperature"},
           {"[certificate] number", !details.number.empty(), "number of this certificate"},
           {"[certificate] begun", details.begun.has_value(),
            "first day of the test, such as 2026-11-02; the recordings do not state it"},
           {"[certificate] ended", details.ended.has_value(), "last day of the test; the recordings do not state it"},
           {"[certificate] issued", details.issued.has_value(), "day of issue"},
           {"[certificate] place", !details.place.empty(),
            "laboratory, customer, laboratoryBranch, customerBranch or other"},
           {"[certificate] traceability", !details.traceability.empty(),
            "a sentence on how the results are traceable to the SI"},
           {"[certificate] rule", details.rule.has_value() || estimate.verdicts.empty(),
            "the plan has limits; the decision rule (or --rule): simple, guarded:1, risk:0.025, method6 or "
            "non-binary"}})
    if (!given) problems.push_back(in_file(details.file, say("{} is missing: {}", Name{key}, what)));
  return problems;
}

Problems wrong_details(const CertificateDetails& details) {
  Problems problems;
  for (const auto& [section, country] : {std::pair{"[laboratory]", &details.laboratory.contact.country},
                                         std::pair{"[customer]", &details.customer.country}})
    if (!country->empty() && !certificate::is_country(*country))
      problems.push_back(in_file(details.file, say("{} country: '{}' is no country code of ISO 3166-1, such as DE, "
                                                   "CN or US",
                                                   Name{section}, *country)));
  if (!details.place.empty() && std::ranges::find(certificate_places(), details.place) == certificate_places().end())
    problems.push_back(in_file(details.file, say("[certificate] place: '{}' is not known: laboratory, customer, "
                                                 "laboratoryBranch, customerBranch or other is expected",
                                                 details.place)));
  expect_order(details.received, details.begun, "received, begun", details, problems);
  expect_order(details.begun, details.ended, "begun, ended", details, problems);
  expect_order(details.ended, details.issued, "ended, issued", details, problems);
  if (!details.replaces.empty() && details.replaces == details.number)
    problems.push_back(in_file(details.file, "[certificate] replaces: an amended certificate has a number of its own"));
  if (details.replaces.empty() && !details.replaces_reason.empty())
    problems.push_back(
        in_file(details.file, "[certificate] replaces_reason is given, but not what is replaced: replaces"));
  check_forms(details, problems);
  check_equipment(details, problems);
  return problems;
}

}  // namespace tumble
