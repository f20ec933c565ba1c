#pragma once

#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "tumble/units/sentence.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble {

/// A request that cannot be carried out. Front ends catch it once and turn `kind` into an exit status (CLI) or a
/// response code. `problems` holds every problem found, not the first; what() joins them with line breaks.
class Error : public std::runtime_error {
 public:
  enum class Kind {
    bad_input,    ///< the request itself is wrong: command line, plan, setting (CLI exit 2)
    bad_data,     ///< the recording cannot carry the method: NaN, too short, constant (CLI exit 3)
    bad_file,     ///< a file cannot be read, understood or written (CLI exit 3)
    unsupported,  ///< asked for something that does not exist here (CLI exit 2)
    internal      ///< a promise of ours was broken (CLI exit 4)
  };

  Error(Kind what, Problem problem) : Error(what, Problems{std::move(problem)}) {}
  Error(Kind what, Problems found)
      : std::runtime_error(joined(texts_of(found), "\n")), kind(what), problems(std::move(found)) {}

  Kind kind;
  Problems problems;
};

/// Why it could not be carried out, for a sentence around it: its problems in a row.
inline Sentence reason_of(const Error& error) {
  std::vector<Sentence> reasons;
  for (const Problem& problem : error.problems) reasons.push_back(sentence_of(problem));
  return reasons.size() == 1 ? std::move(reasons.front()) : in_a_row(reasons, "; ");
}

/// A sentence of the system about a failure, "Permission denied": its Chinese is in [said_by_libraries].
inline Sentence system_reason(const std::string& message) { return Sentence(message.c_str()); }
/// The sentence for a value of errno.
inline Sentence system_reason(int code) { return system_reason(std::generic_category().message(code)); }
/// The sentence for a code of the standard library or of Boost.
template <class Code>
requires requires(const Code& code) { code.message(); }
Sentence system_reason(const Code& code) { return system_reason(std::string(code.message())); }

}  // namespace tumble
