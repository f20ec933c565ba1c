#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tumble/exchange/certificate.hpp"

namespace tumble::certificate {

/// Value, standard uncertainty and interval of a parameter [SI].
Measured measured_of(const Estimate& estimate, std::size_t index);
/// Parameters that have a value, in their order.
std::vector<std::size_t> determined(const Estimate& estimate);

/// The details with the days of the test as the recordings say them, where the laboratory does not.
CertificateDetails with_days_of_test(CertificateDetails details, const Estimate& estimate);

/// Recordings whose own days are not among those that the laboratory states, a sentence each.
std::vector<Sentence> doubts_about_days(const CertificateDetails& stated, const Estimate& estimate);

/// The decision rule in words of a language.
std::string rule_in_words(const DecisionRule& rule, Language language);
/// "Pass" and the like.
std::string outcome_in_words(Decision::Outcome outcome, Language language);
/// A probability [1] in percent for people: "97.5", ">99.99", "<0.01".
std::string percent(double probability);

}  // namespace tumble::certificate
