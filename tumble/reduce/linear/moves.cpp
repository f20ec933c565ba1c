#include "tumble/reduce/linear/moves.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tumble::linear {
namespace {

constexpr double fewest_parts = 8.0, most_parts = 1e5;  ///< of a move

constexpr double parts_of_period = 12.0;
constexpr double tolerance = 1e-11;
constexpr int deepest = 30;  ///< halvings: 1e-9 of a part

/// Nodes on [-1, 1] and weights of the Gauss-Legendre rule of five points, as shares of the interval.
constexpr std::array<double, 5> nodes{-0.9061798459386640, -0.5384693101056831, 0.0, 0.5384693101056831,
                                      0.9061798459386640};
constexpr std::array<double, 5> shares{0.5 * 0.2369268850561891, 0.5 * 0.4786286704993665, 0.5 * 0.5688888888888889,
                                       0.5 * 0.4786286704993665, 0.5 * 0.2369268850561891};

/// Part of the interval with the integrals over it.
struct Part {
  double begin = 0.0, end = 0.0;
  Vector3 rate, force;
};

class Refinement {
 public:
  Refinement(const Reference& reference, double begin, double end)
      : reference_(reference), length_(end - begin), begin_(begin) {}

  Instants take(std::size_t parts) {
    std::vector<Part> coarse;
    for (std::size_t k = 0; k < parts; ++k) coarse.push_back(part(edge(k, parts), edge(k + 1, parts)));
    for (const auto& interval : coarse) halve(interval, 0);
    double sum = 0.0;
    for (const double share : out_.share) sum += share;
    for (double& share : out_.share) share /= sum;
    return std::move(out_);
  }

 private:
  double edge(std::size_t k, std::size_t parts) const {
    return begin_ + length_ * static_cast<double>(k) / static_cast<double>(parts);
  }

  Part part(double begin, double end) {
    Part part{begin, end, {}, {}};
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      Felt felt;
      reference_.felt(0.5 * (begin + end) + 0.5 * (end - begin) * nodes[k], 1.0, std::span(&felt, 1));
      part.rate = part.rate + (end - begin) * shares[k] * felt.rate;
      part.force = part.force + (end - begin) * shares[k] * felt.specific_force;
      rate_ = std::max(rate_, norm(felt.rate));
      force_ = std::max(force_, norm(felt.specific_force));
    }
    return part;
  }

  void halve(const Part& interval, int depth) {
    const double middle = 0.5 * (interval.begin + interval.end);
    const Part first = part(interval.begin, middle), second = part(middle, interval.end);
    const auto off = [](Vector3 a, Vector3 b, Vector3 sum) { return norm(a + b - sum); };
    const bool good = off(first.rate, second.rate, interval.rate) <= tolerance * rate_ * length_ &&
                      off(first.force, second.force, interval.force) <= tolerance * force_ * length_;
    if (!good && depth < deepest) {
      halve(first, depth + 1);
      halve(second, depth + 1);
      return;
    }
    for (const Part* half : {&first, &second})
      for (std::size_t k = 0; k < nodes.size(); ++k) {
        out_.time.push_back(0.5 * (half->begin + half->end) + 0.5 * (half->end - half->begin) * nodes[k]);
        out_.share.push_back((half->end - half->begin) / length_ * shares[k]);
      }
  }

  const Reference& reference_;
  double length_, begin_;
  double rate_ = 0.0, force_ = 0.0;  ///< the greatest so far
  Instants out_;
};

}  // namespace

Instants instants_of(const Reference& reference, double begin, double end, double frequency) {
  const double parts = std::clamp(parts_of_period * frequency * (end - begin), fewest_parts, most_parts);
  return Refinement(reference, begin, end).take(static_cast<std::size_t>(std::ceil(parts)));
}

}  // namespace tumble::linear
