#include "tumble/checks/grain.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tumble/math/median.hpp"

namespace tumble {
namespace support {

namespace {

/// Samples of a block: few, so that most lie within one segment of a test.
constexpr std::size_t block = 64, most_blocks = 256;
/// [1] of the step squared: the scatter of noise of 0.4 steps, and of their rounding.
constexpr double coarse = 0.4 * 0.4 + 1.0 / 12.0;
constexpr std::size_t least_changes = 16;  ///< whose common step is no chance
/// [1] of the changes that are smaller than the step: of a coarse output none is, and of noise of that many parts of its
/// sd. Chosen: one in 50 forgives single samples that were interpolated.
constexpr double smaller = 1.0 / 50.0;
/// [steps] a change may be off a whole number of them, by the digits of a file. Chosen: changes of every size do so in
/// 2 % of cases, and 95 % must.
constexpr double whole = 0.01, least_whole = 0.95;
/// [1] of the changes that are the one before again: nearly all of a ramp without noise, which has no steps, and few of a
/// signal that crosses steps. Half of both.
constexpr double most_again = 0.5;
constexpr double rounding = 1e-12;  ///< [1] of the values: two sums of the same terms may differ by this

/// Sums for weights of u = x[i-1] + x[i+1] and v = x[i-2] + x[i+2], about the mean of the block.
struct Normal {
  double uu = 0.0, uv = 0.0, vv = 0.0, ux = 0.0, vx = 0.0, xx = 0.0, count = 0.0;
};

/// Variance [u^2] of white noise that the neighbours leave; NaN where too few samples are there.
double unpredicted(std::span<const double> x) {
  double mean = 0.0, present = 0.0;
  for (const double value : x)
    if (!std::isnan(value)) mean += value, ++present;
  if (present < least_changes) return NAN;
  mean /= present;
  Normal n;
  for (std::size_t i = 2; i + 2 < x.size(); ++i) {
    const double u = x[i - 1] + x[i + 1] - 2.0 * mean, v = x[i - 2] + x[i + 2] - 2.0 * mean, y = x[i] - mean;
    if (std::isnan(u + v + y)) continue;
    n.uu += u * u, n.uv += u * v, n.vv += v * v, n.ux += u * y, n.vx += v * y, n.xx += y * y, ++n.count;
  }
  if (n.count < least_changes) return NAN;
  const double determinant = n.uu * n.vv - n.uv * n.uv;
  double a = 0.0, b = 0.0;
  if (determinant > rounding * n.uu * n.vv) {
    a = (n.ux * n.vv - n.vx * n.uv) / determinant;
    b = (n.vx * n.uu - n.ux * n.uv) / determinant;
  } else if (n.uu > 0.0) {
    a = n.ux / n.uu;
  }
  const double rest = std::max(0.0, n.xx - a * n.ux - b * n.vx) / n.count;
  return rest / (1.0 + 2.0 * a * a + 2.0 * b * b);
}

/// Changes from sample to sample.
struct Changes {
  std::vector<double> sizes;             ///< [u] of those that are not zero
  std::size_t unchanged = 0, again = 0;  ///< samples without one, and with the very one of the sample before
};

void add_changes(std::span<const double> x, Changes& changes) {
  double last = 0.0;
  for (std::size_t i = 1; i < x.size(); ++i) {
    const double change = x[i] - x[i - 1], least = rounding * std::abs(x[i]);
    if (std::isnan(change)) continue;
    if (std::abs(change) > least) {
      changes.sizes.push_back(std::abs(change));
      changes.again += std::abs(change - last) <= least;
    } else {
      ++changes.unchanged;
    }
    last = change;
  }
}

/// Whether nearly all changes are whole multiples of the step, and seldom the one before again.
bool is_common(double step, const Changes& changes) {
  const auto multiples = static_cast<double>(std::ranges::count_if(
      changes.sizes, [&](double change) { return std::abs(std::remainder(change, step)) < whole * step; }));
  const auto all = static_cast<double>(changes.sizes.size());
  return multiples > least_whole * all && static_cast<double>(changes.again) < most_again * all;
}

}  // namespace
}  // namespace support

Grain grain_of(std::span<const double> values) {
  using namespace support;
  Changes changes;
  std::vector<double> variances;
  const std::size_t blocks = std::clamp<std::size_t>(values.size() / block, 1, most_blocks);
  for (std::size_t k = 0; k < blocks; ++k) {
    const std::size_t room = values.size() - std::min(values.size(), block);
    const auto part = values.subspan(blocks == 1 ? 0 : k * room / (blocks - 1), std::min(values.size(), block));
    add_changes(part, changes);
    if (const double variance = unpredicted(part); !std::isnan(variance)) variances.push_back(variance);
  }
  Grain grain;
  if (!variances.empty()) grain.scatter = std::sqrt(median(std::move(variances)));
  auto& sizes = changes.sizes;
  if (sizes.size() < least_changes) return grain;
  const auto small = sizes.begin() + static_cast<std::ptrdiff_t>(smaller * static_cast<double>(sizes.size()));
  std::nth_element(sizes.begin(), small, sizes.end());
  grain.smallest = *small;
  if (is_common(grain.smallest, changes)) grain.step = grain.smallest;
  return grain;
}

bool is_coarse(const Grain& grain) {
  using namespace support;
  return grain.step > 0.0 && grain.scatter * grain.scatter < coarse * grain.step * grain.step;
}

}  // namespace tumble
