#include "tumble/reduce/linear/work.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "tumble/units/error.hpp"

namespace tumble::linear {
namespace {

/// All that several outputs complain of, each sentence once.
class Complaints {
 public:
  /// Whether `attempt` has nothing to complain of.
  template <class Attempt>
  bool none(const Attempt& attempt) try {
    attempt();
    return true;
  } catch (const Error& error) {
    if (!kind_) kind_ = error.kind;
    for (const auto& problem : error.problems)
      if (std::ranges::find(problems_, problem) == problems_.end()) problems_.push_back(problem);
    return false;
  }

  void raise() const {
    if (kind_) throw Error(*kind_, problems_);
  }

 private:
  std::optional<Error::Kind> kind_;
  Problems problems_;
};

/// Given     evident   returns the evidence of output i
///           prepare   takes output i from its rows to its coefficients
///           finish    ends the work of output i
template <class Evident, class Prepare, class Finish>
std::vector<Work> worked_out(std::span<const Problem> problems, const Evident& evident, const Prepare& prepare,
                             const Finish& finish) {
  if (problems.empty()) throw Error(Error::Kind::internal, "identification of no output");
  Complaints complaints;
  std::vector<Work> works;
  std::vector<std::size_t> numbers, sound;
  for (std::size_t i = 0; i < problems.size(); ++i)
    if (complaints.none([&] { works.push_back({.evidence = evident(i)}); })) numbers.push_back(i);
  std::vector<Read> read;
  for (std::size_t k = 0; k < works.size(); ++k) read.push_back({works[k].evidence, problems[numbers[k]]});
  auto rows = rows_of(read);
  std::vector<Shown> shown;
  for (std::size_t k = 0; k < works.size(); ++k) {
    Work& work = works[k];
    work.rows = std::move(rows[k]);
    if (!complaints.none([&] { prepare(numbers[k], work); })) continue;
    sound.push_back(k);
    shown.push_back({work.evidence, problems[numbers[k]], work.rows, work.coefficients});
  }
  auto effects = effects_of(shown);
  for (std::size_t j = 0; j < sound.size(); ++j) {
    works[sound[j]].data.effects = std::move(effects[j]);
    complaints.none([&] { finish(numbers[sound[j]], works[sound[j]]); });
  }
  complaints.raise();
  return works;
}

}  // namespace

std::vector<Work> worked_out(const Evidence& evidence, std::span<const Problem> problems) {
  return worked_out(
      problems, [&](std::size_t i) { return evidence_of(evidence, problems[i]); },
      [&](std::size_t i, Work& work) { prepare(evidence, problems[i], work); },
      [&](std::size_t i, Work& work) { finish(evidence, problems[i], work); });
}

std::vector<Work> worked_out(const Plan& plan, std::span<const Problem> problems, std::span<const Truth> truths) {
  return worked_out(
      problems, [&](std::size_t i) { return evidence_of(plan, problems[i]); },
      [&](std::size_t i, Work& work) { prepare(problems[i], truths[i], work); },
      [&](std::size_t i, Work& work) { finish(problems[i], truths[i], work); });
}

}  // namespace tumble::linear
