#pragma once

#include <string>
#include <vector>

namespace tumble {

/// What is odd in the data or weak in the answer. Not an error: the work was carried out.
struct Finding {
  enum class Severity { info, warning, error };  ///< error: do not rely on what it names
  Severity severity = Severity::warning;
  std::string message;  ///< what, and what would mend it
  std::string where;    ///< channel, run, time, file: empty where it concerns the whole
};

using Findings = std::vector<Finding>;

/// The errors among them as the problems of a refusal: "where: message".
std::vector<std::string> errors_among(const Findings& findings);

}  // namespace tumble
