#include <algorithm>
#include <tuple>

#include "tumble/reduce/stretches.hpp"

namespace tumble {
namespace {

auto numbers_of(const Motion& m) {
  return std::tie(m.kind, m.value, m.to, m.amplitude, m.frequency, m.to_frequency, m.phase, m.psd_frequency, m.psd,
                  m.lasts, m.continued, m.from);
}

bool same_motions(const Segment& a, const Segment& b) {
  return std::ranges::equal(a.axes, b.axes, [](const auto& x, const auto& y) {
    return x.first == y.first && numbers_of(x.second) == numbers_of(y.second);
  });
}

bool repeats(const PowerUp& a, const PowerUp& b) {
  return a.plan == b.plan && a.step == b.step && a.offset == b.offset && a.begins == b.begins &&
         a.rig.rate == b.rig.rate && a.rig.errors.values == b.rig.errors.values &&
         std::ranges::equal(a.rig.segments, b.rig.segments, same_motions);
}

bool same_samples(const Stretch& a, const Stretch& b) {
  return a.segment == b.segment && a.first == b.first && a.step == b.step && a.samples == b.samples &&
         a.steady == b.steady && a.values.empty() && b.values.empty();
}

}  // namespace

std::vector<std::size_t> first_alike(const ConductedTest& test) {
  std::vector<std::size_t> power_up(test.power_ups.size()), alike(test.stretches.size());
  for (std::size_t u = 0; u < power_up.size(); ++u) {
    power_up[u] = 0;
    while (!repeats(test.power_ups[power_up[u]], test.power_ups[u])) ++power_up[u];  // at the latest it repeats itself
  }
  for (std::size_t g = 0; g < alike.size(); ++g) {
    const Stretch& own = test.stretches[g];
    const auto found = std::find_if(
        test.stretches.begin(), test.stretches.begin() + static_cast<std::ptrdiff_t>(g), [&](const Stretch& other) {
          return power_up[other.power_up] == power_up[own.power_up] && same_samples(other, own);
        });
    alike[g] = static_cast<std::size_t>(found - test.stretches.begin());
  }
  return alike;
}

}  // namespace tumble
