#include "tumble/tasks/optimisation/order.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

#include "tumble/math/matrix.hpp"
#include "tumble/math/random.hpp"
#include "tumble/rigs/rig.hpp"

namespace tumble::optimisation {
namespace {

using Order = std::vector<std::size_t>;

constexpr double remounting = 600.0;  ///< [s] by hand: only to keep visits with one mounting together
constexpr int drawn_orders = 64;

bool same_mount(const prediction::Candidate& a, const prediction::Candidate& b) {
  for (const auto& [axis, motion] : a.work)
    if (is_mount_axis(axis) && b.work.at(axis).value != motion.value) return false;
  return true;
}

/// Time [s] from visit i (row) to visit j (column) in its motion.
Matrix moves(const Plan& plan, const std::vector<prediction::Candidate>& all,
             const std::vector<prediction::CandidateVisit>& visits) {
  Matrix out(visits.size(), visits.size());
  for (std::size_t i = 0; i < visits.size(); ++i)
    for (std::size_t j = 0; j < visits.size(); ++j) {
      if (i == j) continue;
      const auto pair = schedule_of(plan, all, {{visits[i].candidate, 0.0}, {visits[j].candidate, 0.0}}, 0.0);
      const bool approached = !all[visits[j].candidate].approach.empty();
      for (std::size_t s = pair.size() - (approached ? 2 : 1); s < pair.size(); ++s) out(i, j) += pair[s].duration;
      if (!same_mount(all[visits[i].candidate], all[visits[j].candidate])) out(i, j) += remounting;
    }
  return out;
}

double length(const Matrix& moves, const Order& order) {
  double sum = 0.0;
  for (std::size_t k = 1; k < order.size(); ++k) sum += moves(order[k - 1], order[k]);
  return sum;
}

Order nearest_neighbours(const Matrix& moves) {
  Order order{0};
  std::vector<bool> used(moves.rows, false);
  used[0] = true;
  while (order.size() < moves.rows) {
    std::size_t next = moves.rows;
    for (std::size_t j = 0; j < moves.rows; ++j)
      if (!used[j] && (next == moves.rows || moves(order.back(), j) < moves(order.back(), next))) next = j;
    used[next] = true;
    order.push_back(next);
  }
  return order;
}

/// Turns parts of the way round as long as that makes it shorter.
void shorten(const Matrix& moves, Order& order) {
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t a = 1; a + 1 < order.size(); ++a)
      for (std::size_t b = a + 1; b < order.size(); ++b) {
        Order trial = order;
        std::reverse(trial.begin() + static_cast<std::ptrdiff_t>(a),
                     trial.begin() + static_cast<std::ptrdiff_t>(b) + 1);
        if (length(moves, trial) > length(moves, order) - 1e-6) continue;
        order = std::move(trial);
        changed = true;
      }
  }
}

Order shuffled(std::size_t count, const RandomStream& random) {
  Order order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (std::size_t k = count; k > 1; --k)
    std::swap(order[k - 1],
              order[std::min(k - 1, static_cast<std::size_t>(random.uniform(k) * static_cast<double>(k)))]);
  return order;
}

/// Mountings in the order in which they come first, the visits of each in the order they have.
Order grouped(const std::vector<prediction::Candidate>& all, const std::vector<prediction::CandidateVisit>& visits,
              const Order& order) {
  Order out, left = order;
  while (!left.empty()) {
    const auto& first = all[visits[left.front()].candidate];
    Order others;
    for (const auto v : left) (same_mount(first, all[visits[v].candidate]) ? out : others).push_back(v);
    left = std::move(others);
  }
  return out;
}

}  // namespace

std::vector<prediction::CandidateVisit> ordered(const Plan& plan, const std::vector<prediction::Candidate>& all,
                                                std::vector<prediction::CandidateVisit> visits, bool randomised,
                                                std::uint64_t seed) {
  if (visits.size() < 3) return visits;
  const Matrix times = moves(plan, all, visits);
  Order best;
  if (randomised) {
    double shortest = std::numeric_limits<double>::infinity();
    for (int i = 0; i < drawn_orders; ++i) {
      const auto draw = RandomStream(seed).split("order").split(static_cast<std::uint64_t>(i));
      const auto order = grouped(all, visits, shuffled(visits.size(), draw));
      if (const double way = length(times, order); way < shortest) shortest = way, best = order;
    }
  } else {
    best = nearest_neighbours(times);
    shorten(times, best);
  }
  std::vector<prediction::CandidateVisit> out;
  for (const auto v : best)
    if (!out.empty() && out.back().candidate == visits[v].candidate)
      out.back().dwell += visits[v].dwell;  // staying is one visit
    else
      out.push_back(visits[v]);
  return out;
}

}  // namespace tumble::optimisation
