#pragma once

#include <stdexcept>
#include <string>
#include <vector>

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

  Error(Kind what, std::string problem) : Error(what, std::vector<std::string>{std::move(problem)}) {}
  Error(Kind what, std::vector<std::string> found)
      : std::runtime_error(joined(found)), kind(what), problems(std::move(found)) {}

  Kind kind;
  std::vector<std::string> problems;

 private:
  static std::string joined(const std::vector<std::string>& lines) {
    std::string text;
    for (const auto& problem : lines) text += (text.empty() ? "" : "\n") + problem;
    return text;
  }
};

}  // namespace tumble
