#include "tumble/checks/check.hpp"

#include "tumble/math/parallel.hpp"

namespace tumble {

Findings run_checks(const Recording& recording, const Plan* plan) {
  const auto& all = check_catalogue();
  std::vector<Findings> found(all.size());
  parallel_for(all.size(), [&](std::size_t i) { found[i] = all[i]->run(recording, plan); });
  Findings findings;
  for (const auto& part : found) findings.insert(findings.end(), part.begin(), part.end());
  return findings;
}

}  // namespace tumble
