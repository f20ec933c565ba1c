#pragma once

#include <string>

#include "tumble/exchange/certificate.hpp"
#include "tumble/report/testing/example_estimate.hpp"

namespace tumble::testing {

inline Date day(int year, unsigned month, unsigned of_month) {
  return {std::chrono::year(year), std::chrono::month(month), std::chrono::day(of_month)};
}

/// All that a certificate needs, of a laboratory that does not exist.
inline CertificateDetails example_details() {
  CertificateDetails details;
  details.laboratory.contact = {"Example Laboratory", "", "38116", "Braunschweig", "", "DE", "lab@example.org", "", ""};
  details.customer = {"Example Customer", "", "", "Cambridge", "", "GB", "", "", ""};
  details.persons = {{"A. Example", "head", true}, {"B. Example", "", false}};
  details.equipment = {{"rate table", "", "RT-2", "C-77", "2031", day(2027, 1, 31), "PTB", std::string(64, 'a'), ""}};
  details.item = {"gyro", "Example Instruments", "", "", "NAV-42"};
  details.conditions = {{"temperature", 296.15, 0.5, Unit::parse("degC")}};
  details.number = "2026-000123";
  details.received = day(2026, 10, 28), details.begun = day(2026, 11, 2);
  details.ended = day(2026, 11, 3), details.issued = day(2026, 11, 5);
  details.place = "laboratory";
  details.traceability = "Traceable to the SI through the equipment above.";
  details.rule = DecisionRule{DecisionRule::Kind::guarded, 1.0};
  return details;
}

}  // namespace tumble::testing
