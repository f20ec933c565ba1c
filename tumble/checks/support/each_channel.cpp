#include "tumble/checks/support/each_channel.hpp"

#include "tumble/math/parallel.hpp"

namespace tumble::support {

Findings findings_of_each(const Recording& recording, const std::function<Findings(const Channel&)>& look) {
  std::vector<Findings> found(recording.channels.size());
  parallel_for(found.size(), [&](std::size_t i) { found[i] = look(recording.channels[i]); });
  Findings findings;
  for (const auto& part : found) findings.insert(findings.end(), part.begin(), part.end());
  return findings;
}

}  // namespace tumble::support
