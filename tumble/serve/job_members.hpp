#pragma once

#include <type_traits>
#include <utility>

#include "tumble/report/members.hpp"
#include "tumble/serve/jobs.hpp"

/// Members of a job; see report/members.hpp.
namespace tumble {

/// The words of the states, in their order.
const EnumerationWords& job_state_words();

/// Members that everybody may know.
template <class Visitor, PossiblyConst<Job> X>
void members(Visitor& visit, X& x) {
  EnumerationWords texts = texts_of(x.problems);
  visit("id", x.id)("kind", x.kind)("title", x.title)("state", x.state, job_state_words())("doing", x.doing);
  visit("progress", x.progress)("begun", x.begun)("problems", texts);
  CodedProblems errors{x.code.empty() ? "failed" : x.code, x.problems};
  visit.optional("errors", errors, true);
  if constexpr (!std::is_const_v<X>) {
    x.code = errors.problems.empty() ? "" : errors.code;
    x.problems = std::move(errors.problems);
    if (x.problems.empty())  // a job of an earlier version
      for (const std::string& text : texts) x.problems.emplace_back(Sentence(text));
  }
  visit("files", x.files);
}

/// All members, as the folder of the state keeps them.
template <class Visitor, PossiblyConst<Job> X>
void kept_members(Visitor& visit, X& x) {
  members(visit, x);
  visit("steps", x.steps)("scratch", x.scratch)("owner", x.owner)("folder", x.folder);
}

}  // namespace tumble
