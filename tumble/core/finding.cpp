#include "tumble/core/finding.hpp"

namespace tumble {

std::vector<std::string> errors_among(const Findings& findings) {
  std::vector<std::string> problems;
  for (const Finding& finding : findings)
    if (finding.severity == Finding::Severity::error)
      problems.push_back(finding.where.empty() ? finding.message : finding.where + ": " + finding.message);
  return problems;
}

}  // namespace tumble
