#include "tumble/departures/judgement.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <ranges>
#include <set>

#include "tumble/checks/check.hpp"
#include "tumble/departures/entries/edits.hpp"
#include "tumble/report/rounding.hpp"

namespace tumble {
namespace {

constexpr double half_width_of_normal = 1.959964;  // of the 95 % interval of a standard normal number

/// Whether a code of `told_by` is said that is not said of the sound test too: what is always said tells nothing.
bool names(const Answer& answer, const Answer& sound, const std::vector<std::string>& told_by) {
  const auto is_one = [&](const std::string& code) {
    return std::ranges::find(told_by, code) != told_by.end() &&
           std::ranges::find(sound.codes, code) == sound.codes.end();
  };
  return std::ranges::any_of(answer.codes, is_one) || is_one(answer.refusal_code);
}

std::size_t count_of(std::span<const Answer> answers, const std::string& code) {
  return static_cast<std::size_t>(std::ranges::count_if(
      answers, [&](const Answer& answer) { return std::ranges::find(answer.codes, code) != answer.codes.end(); }));
}

/// Root mean square of parameter j over the answers that have it; 0 where none has.
double rms_of(std::span<const Answer> answers, std::size_t j) {
  double squares = 0.0, found = 0.0;
  for (const Answer& answer : answers) {
    if (j >= answer.deviations.size() || std::isnan(answer.deviations[j])) continue;
    squares += answer.deviations[j] * answer.deviations[j];
    found += 1.0;
  }
  return found > 0.0 ? std::sqrt(squares / found) : 0.0;
}

std::set<std::string> codes_in(std::span<const Answer> answers) {
  std::set<std::string> codes;
  for (const Answer& answer : answers) codes.insert(answer.codes.begin(), answer.codes.end());
  return codes;
}

/// Each is named, or else the fit is not worse than the worst of the sound ones, nothing is said that is not said of these, and
/// nothing that was recorded beside the outputs has changed.
bool named_or_looks_sound(std::span<const Answer> answers, std::span<const Answer> sound,
                          const std::vector<std::string>& told_by) {
  double worst = 0.0;
  for (const Answer& answer : sound) worst = std::max(worst, answer.reduced_chi_square);
  constexpr double of_few_seeds = 1.2;  // the greatest of ten further sound tests may be somewhat greater
  const std::set<std::string> known = codes_in(sound);
  const auto passes = [&](std::size_t i) {
    const Answer& answer = answers[i];
    return names(answer, sound[i], told_by) ||
           (answer.refusal.empty() && !answer.other_channels_changed &&
            answer.reduced_chi_square <= of_few_seeds * worst &&
            std::ranges::all_of(answer.codes, [&](const std::string& code) { return known.contains(code); }));
  };
  return std::ranges::all_of(std::views::iota(std::size_t{0}, answers.size()), passes);
}

bool same_times(const Channel& a, const Channel& b) {
  if (a.values.size() != b.values.size()) return false;
  for (std::size_t i = 0; i < a.values.size(); ++i)
    if (a.time(i) != b.time(i)) return false;
  return true;
}

bool same_values(const std::vector<double>& a, const std::vector<double>& b) {
  return std::ranges::equal(a, b, [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); });
}

}  // namespace

Answer answer_of(const Estimate& estimate, const std::vector<std::pair<std::string, double>>& truth) {
  Answer answer;
  for (const auto& [parameter, value] : truth) {
    const Parameter* found = find_parameter(estimate, parameter);
    answer.deviations.push_back(std::numeric_limits<double>::quiet_NaN());
    if (found == nullptr) continue;
    const auto [lower, upper] = interval95(estimate, static_cast<std::size_t>(found - estimate.parameters.data()));
    const double error = found->value - value;
    const double half = error > 0.0 ? found->value - lower : upper - found->value;
    answer.deviations.back() = error * half_width_of_normal / half;
  }
  for (const Finding& finding : estimate.findings)
    if (finding.severity != Finding::Severity::info && !is_about_limit(finding)) answer.codes.push_back(finding.code);
  if (estimate.fit.degrees_of_freedom > 0.0 && std::isfinite(estimate.fit.chi_square))
    answer.reduced_chi_square = estimate.fit.chi_square / estimate.fit.degrees_of_freedom;
  return answer;
}

std::string code_of_refusal(const Error& error, const SimulatedTest& test) {
  for (const Recording& recording : test.evidence.recordings)
    for (const Finding& finding : run_checks(recording, &test.evidence.plan))
      for (const Problem& problem : error.problems)
        if (finding.severity == Finding::Severity::error && problem.what.pattern == said_of(finding).pattern)
          return finding.code;
  return {};
}

std::string_view name(Handling handling) {
  switch (handling) {
    case Handling::held:
      return "held";
    case Handling::named:
      return "named";
    case Handling::refused:
      return "refused";
    case Handling::cannot_be_seen:
      return "cannot be seen";
    case Handling::silent:
      break;
  }
  return "silent";
}

namespace {

/// Whether the answer is that of the sound test of the same seed.
bool as_without_it(const Answer& answer, const Answer& sound) {
  const auto close = [](double a, double b) {
    return (std::isnan(a) && std::isnan(b)) || std::abs(a - b) < least_moved;
  };
  return answer.refusal.empty() && std::ranges::equal(answer.deviations, sound.deviations, close) &&
         std::ranges::all_of(answer.codes, [&](const std::string& code) {
           return std::ranges::find(sound.codes, code) != sound.codes.end();
         });
}

/// Given: the answers that are not as without the departure.
CellVerdict judge_moved(std::span<const Answer> answers, std::span<const Answer> sound,
                        const std::vector<std::string>& told_by, bool listed) {
  CellVerdict verdict;
  std::size_t parameters = 0, named_or_refused = 0;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    parameters = std::max(parameters, answers[i].deviations.size());
    verdict.refused += answers[i].refusal.empty() ? 0 : 1;
    verdict.named += names(answers[i], sound[i], told_by) ? 1 : 0;
    named_or_refused += !answers[i].refusal.empty() || names(answers[i], sound[i], told_by) ? 1 : 0;
  }
  for (std::size_t j = 0; j < parameters; ++j)
    if (const double rms = rms_of(answers, j); rms > verdict.worst_rms || std::isnan(rms)) {
      verdict.worst_rms = std::isnan(rms) ? std::numeric_limits<double>::infinity() : rms;
      verdict.worst = j;
    }
  for (const std::string& code : codes_in(answers))
    if (std::ranges::find(told_by, code) == told_by.end() && 2 * count_of(answers, code) > answers.size() &&
        count_of(sound, code) < count_of(answers, code))
      verdict.other_codes.push_back(code);
  const auto enough = [&](std::size_t seeds) {
    return static_cast<double>(seeds) >= least_named * static_cast<double>(answers.size()) - 1e-9;
  };
  if (enough(verdict.named))
    verdict.handling = Handling::named;
  else if (enough(named_or_refused))
    verdict.handling = Handling::refused;
  else if (verdict.worst_rms < most_rms)
    verdict.handling = Handling::held;
  else if (listed && named_or_looks_sound(answers, sound, told_by))
    verdict.handling = Handling::cannot_be_seen;
  if (verdict.handling == Handling::named && verdict.refused == 0 && verdict.worst_rms < most_rms)
    verdict.handling = Handling::held;
  return verdict;
}

}  // namespace

CellVerdict judge_cell(std::span<const Answer> answers, std::span<const Answer> sound,
                       const std::vector<std::string>& told_by, bool listed) {
  const CellVerdict of_all = judge_moved(answers, sound, told_by, listed);
  if (of_all.handling != Handling::silent) return of_all;
  std::vector<Answer> moved, sound_of_moved;
  for (std::size_t i = 0; i < answers.size(); ++i)
    if (!as_without_it(answers[i], sound[i])) moved.push_back(answers[i]), sound_of_moved.push_back(sound[i]);
  return moved.empty() ? of_all : judge_moved(moved, sound_of_moved, told_by, listed);
}

Accusations accusations_in(std::span<const Answer> sound) {
  Accusations accusations{.tests = sound.size()};
  for (const Answer& answer : sound) {
    accusations.refused += answer.refusal.empty() ? 0 : 1;
    accusations.warned += answer.codes.empty() ? 0 : 1;
  }
  for (const std::string& code : codes_in(sound)) accusations.codes.push_back(code);
  return accusations;
}

bool other_channels_differ(const SimulatedTest& sound, const SimulatedTest& departed) {
  const Plan& plan = sound.evidence.plan;
  const Recordings &before = sound.evidence.recordings, &after = departed.evidence.recordings;
  if (before.size() != after.size()) return true;
  const auto outputs = entries::all_outputs(plan, before);
  for (std::size_t r = 0; r < before.size(); ++r) {
    if (before[r].channels.size() != after[r].channels.size()) return true;
    for (std::size_t c = 0; c < before[r].channels.size(); ++c) {
      const Channel &a = before[r].channels[c], &b = after[r].channels[c];
      const bool output = std::ranges::find(outputs, a.name) != outputs.end();
      if (!same_times(a, b) || (!output && !same_values(a.values, b.values))) return true;
    }
    const auto same_mark = [](const Mark& a, const Mark& b) {
      return a.label == b.label && a.begin == b.begin && a.run == b.run && a.end == b.end;
    };
    if (!std::ranges::equal(before[r].marks, after[r].marks, same_mark)) return true;
  }
  return false;
}

}  // namespace tumble
