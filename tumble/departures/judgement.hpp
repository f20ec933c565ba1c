#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/departures/departure.hpp"
#include "tumble/units/error.hpp"

/// Judges whether a result holds in spite of a departure, names it, or is wrong in silence (decision 117).
namespace tumble {

/// The answer to one simulated test.
struct Answer {
  /// (estimate - truth)/sd of each parameter of the truth, NaN where the result has no value of it. The sd is half of the
  /// 95 % interval divided by 1.96, so that a few degrees of freedom do not look like errors.
  std::vector<double> deviations;
  std::vector<std::string> codes;       ///< of the warnings and errors
  std::string refusal;                  ///< why there is no result; empty: there is one
  std::string refusal_code;             ///< of the finding that refused it; empty: another reason
  double reduced_chi_square = 1.0;      ///< of the fit; 1 where it has none
  bool other_channels_changed = false;  ///< a reference, a stamp or a mark differs from that of the sound test
};

/// The answer of a result to a test of known truth [SI].
Answer answer_of(const Estimate& estimate, const std::vector<std::pair<std::string, double>>& truth);

/// The code of the finding of a check whose sentence a refusal is; empty: of none.
std::string code_of_refusal(const Error& error, const SimulatedTest& test);

enum class Handling {
  held,            ///< the values are right
  named,           ///< a finding or a refusal names the departure
  refused,         ///< there is no result, for another reason than the departure
  cannot_be_seen,  ///< the list of unseen departures has it, and the data show nothing
  silent           ///< the values are wrong, and nothing names why: a failure
};
std::string_view name(Handling handling);

/// The judgement of one cell: a method, a departure, its target and its size.
struct CellVerdict {
  Handling handling = Handling::silent;
  double worst_rms = 0.0;                     ///< of the deviations of a parameter over the seeds, the greatest [1]
  std::size_t worst = 0;                      ///< index of this parameter
  std::size_t named = 0;                      ///< seeds in which it is named
  std::size_t refused = 0;                    ///< seeds without a result
  std::vector<std::string> other_codes = {};  ///< of most seeds, and of fewer sound tests: what is said in its place
};

/// The root mean square of ten deviations [1] above which a parameter is wrong: of ten standard normal numbers it is above
/// 2.2 with p = 5e-7, since the sum of their squares is chi-square of 10 degrees of freedom, and 10 x 2.2^2 = 48.4.
inline constexpr double most_rms = 2.2;
/// The share of seeds in which a departure must be named.
inline constexpr double least_named = 0.9;

/// A departure that moves a parameter by less than this share of its sd [1] moves nothing: the test is no case of it, as a dead band is
/// nothing to an output that is never within it.
inline constexpr double least_moved = 0.1;

/// Judges the answers to one departure, a seed each; deviations in standard uncertainties [1]. Seeds in which it moves no parameter
/// and nothing more is said than without it are passed over: they hold, and need not be named.
///
/// Given     answers  of the tests with the departure
///           sound    of the same seeds without it
///           told_by  codes that name the departure, where they are not said of the sound test of the same seed
///           listed   whether the list of unseen departures has it
CellVerdict judge_cell(std::span<const Answer> answers, std::span<const Answer> sound,
                       const std::vector<std::string>& told_by, bool listed);

/// Warnings and errors in sound tests, in numbers of tests [1].
struct Accusations {
  std::size_t tests = 0, warned = 0, refused = 0;
  std::vector<std::string> codes;  ///< each once
};
/// Number [1] of sound tests that a method accuses.
Accusations accusations_in(std::span<const Answer> sound);

/// A departure that no data of a method can show.
struct Unseen {
  const char* departure;
  const char* method;  ///< empty: of any method
  const char* reason;
  /// Also where a reference or a stamp is what departs: nothing else was recorded that it could be compared with.
  bool of_references = false;
};
/// The list, which the tests confirm: an entry counts only where the fit is not worse than in sound tests and no recorded
/// channel contradicts.
const std::vector<Unseen>& unseen_departures();
/// The entry for the departure and the method, or null.
const Unseen* find_unseen(std::string_view departure, std::string_view method);
/// Names of those that can happen to the test of the plan: its method has an entry, and something of the test is a target.
std::vector<std::string> unseen_in(const Plan& plan, const Recordings& recordings);

/// Whether a channel that is no output, a stamp or a mark differs between the two tests.
bool other_channels_differ(const SimulatedTest& sound, const SimulatedTest& departed);

}  // namespace tumble
