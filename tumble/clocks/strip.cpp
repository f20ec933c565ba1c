#include "tumble/clocks/strip.hpp"

#include <algorithm>
#include <cmath>

namespace tumble {
namespace {

constexpr double negligible = 1e-9;  ///< of the unit of y: points of one line meet in one corner, which stays one
constexpr double small_cut = 2e-3;   ///< a cut that removes less is not made: one in a few hundred stamps is enough

/// Signed distance: at least zero where the line is on the wanted side.
struct Side {
  double x, bound, sign;
  double operator()(const Strip::Line& line) const { return sign * (line.a + line.r * x - bound); }
};

/// The corners of the polygon on one side.
void cut(const std::vector<Strip::Line>& corners, const Side& side, std::vector<Strip::Line>& out) {
  out.clear();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const auto &p = corners[i], &q = corners[i + 1 == corners.size() ? 0 : i + 1];
    const double at_p = side(p), at_q = side(q);
    if (at_p >= -negligible) out.push_back(p);
    if ((at_p > negligible && at_q < -negligible) || (at_p < -negligible && at_q > negligible)) {
      const double part = at_p / (at_p - at_q);
      out.push_back({p.a + part * (q.a - p.a), p.r + part * (q.r - p.r)});
    }
  }
}

/// log of the number of ways to choose k of n, within a few units of their logarithms.
double ways(double n, double k) {
  const auto part = [](double x) { return x > 0.0 ? x * std::log(x) : 0.0; };
  return part(n) - part(k) - part(n - k);
}

}  // namespace

Strip::Strip(double x, double y, double half, double low, double high)
    : corners_{{y - half - low * x, low},
               {y - half - high * x, high},
               {y + half - high * x, high},
               {y + half - low * x, low}} {}

bool Strip::add(double x, double y, double half) {
  double least = INFINITY, greatest = -INFINITY;
  for (const Line& line : corners_) {
    const double at = line.a + line.r * x;
    least = std::min(least, at), greatest = std::max(greatest, at);
  }
  if (!(least <= y + half && greatest >= y - half)) return false;
  if (least >= y - half - small_cut && greatest <= y + half + small_cut) return true;
  cut(corners_, {x, y - half, 1.0}, spare_);
  cut(spare_, {x, y + half, -1.0}, cut_);
  if (cut_.empty()) return false;
  corners_.swap(cut_);
  return true;
}

double Strip::lowest() const { return std::ranges::min_element(corners_, {}, &Line::r)->r; }
double Strip::highest() const { return std::ranges::max_element(corners_, {}, &Line::r)->r; }

Strip::Line Strip::middle() const {
  Line sum;
  for (const Line& line : corners_) sum.a += line.a, sum.r += line.r;
  const auto count = static_cast<double>(corners_.size());
  return {sum.a / count, sum.r / count};
}

double evidence_for_line(double count, double missing, double repeats, double still_missing) {
  return ways(count + missing, missing) + ways(count, repeats) - ways(count + still_missing, still_missing) -
         3.0 * std::log(count);
}

}  // namespace tumble
