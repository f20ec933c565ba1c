#pragma once

#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/text.hpp"
#include "tumble/report/figure.hpp"

namespace tumble {

/// A result and the name under which people know it: its file.
struct NamedResult {
  std::string name;
  Estimate estimate;
};

/// A parameter of two results. [SI]
struct Difference {
  std::string parameter;
  Unit unit;                  ///< that people are shown
  double earlier, later;      ///< the two values
  double difference;          ///< later minus earlier
  double sd;                  ///< of the difference, errors that both results share removed
  double shared_covariance;   ///< [SI^2] of the two values
  double degrees_of_freedom;  ///< of sd
  double expanded;            ///< 95 %
  double e_n;                 ///< difference/expanded; without uncertainty NaN, or infinite where the values differ
};

/// Two results, all parameters that both have.
struct ResultPair {
  std::size_t earlier, later;  ///< numbers of the results
  std::vector<Difference> differences;
  double chi_square = 0.0;   ///< [1] of all differences together
  std::size_t rank = 0;      ///< its degrees of freedom
  double probability = 1.0;  ///< [1] of so large a chi-square without a change, by F with the fewest degrees of freedom
};

struct Comparison {
  std::vector<NamedResult> results;
  std::vector<ResultPair>
      pairs;  ///< each result with the one before it; of three or more, also the last with the first
  Findings findings;
};

/// Whether results of one instrument agree, or how it drifted: E_n = (y_2 - y_1)/U, U the expanded uncertainty of the
/// difference. Lines of the two budgets whose source and key agree are errors that both share: their covariance
/// B_1 B_2' is subtracted twice (docs/decisions/034).
///
///   u^2 = u_1^2 + u_2^2 - 2 u_12,   nu = u^4/(u_1^4/nu_1 + u_2^4/nu_2), not below 1
///
/// For a parameter whose interval is not symmetric, the halves that face each other count.
///
/// Given     results  in order of time, two or more
/// Throws    Error::bad_input where a parameter has another dimension in another result, or two results have no
///           parameter in common
/// See       ISO 13528:2022, 9.7; JCGM 100:2008 (GUM), G.4
Comparison compare(std::vector<NamedResult> results);

/// A difference as people read it: earlier, later and difference rounded together by the expanded uncertainty.
struct DifferenceTexts {
  std::string earlier, later, difference, e_n;  ///< difference: "0.12 ± 0.05"; e_n: "2.40", "–": no value
};
DifferenceTexts texts_of(const Difference& difference);
/// "chi-square 12.3 with 9 degrees of freedom, p = 0.2"
std::string chi_square_text(const ResultPair& pair, Language language = Language::english);

/// Terminal text: a table for each pair, E_n beyond 1 marked.
std::string to_text(const Comparison& comparison, std::size_t width = 100, Language language = Language::english);
/// For programs: values in the unit of each parameter.
std::string to_json(const Comparison& comparison);
/// One figure a parameter that all results have: its values with their 95 % intervals.
std::vector<Figure> figures_of(const Comparison& comparison);
/// One figure a parameter of any of the results, over the number of the result: its values with their 95 % intervals. A
/// result that does not have the parameter, or in another dimension, is a gap.
std::vector<Figure> figures_of_units(const std::vector<NamedResult>& results);

}  // namespace tumble
