#include "tumble/methods/imu_ferraris/warming.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "tumble/math/median.hpp"
#include "tumble/math/regression/lack_of_fit.hpp"
#include "tumble/math/square.hpp"

namespace tumble::imu_ferraris {
namespace {

constexpr double settling_times[] = {0.05, 0.1, 0.2, 0.4};  ///< [1] of the session, from its first pose to its last
/// [1] chances below which it is in the budget, and below which it is said: of three accelerometers and four times together.
constexpr double suspected_warming = 0.01, rare_warming = 1e-4;
constexpr double tried_together = 12.0;

/// When the poses of a recording were taken [s].
struct PoseTimes {
  double begin = std::numeric_limits<double>::infinity(), end = -std::numeric_limits<double>::infinity();
};

std::map<std::size_t, PoseTimes> times_of(const Recorded& recorded) {
  std::map<std::size_t, PoseTimes> all;
  for (std::size_t p = 0; p < poses; ++p)
    for (const Part& part : recorded.section[p].pieces) {
      PoseTimes& times = all[part.recording];
      times.begin = std::min(times.begin, part.begin);
      times.end = std::max(times.end, part.begin + part.length);
    }
  return all;
}

/// Mean of exp(-t/T) over a stretch of time that begins `from` [s] after the first pose; T is a part of the session.
double mean_of_settling(const PoseTimes& session, double from, double length, double part) {
  const double time = part * (session.end - session.begin), since = from - session.begin;
  return std::exp(-since / time) * -std::expm1(-length / time) * time / length;
}

/// A bias that settles.
struct Settling {
  double size = 0.0, sd = 0.0;  ///< A and its standard uncertainty [unit of the output]
  double part = 0.0;            ///< T as a part of the session
  double freedom = 1.0;         ///< of the noise
  double ratio() const { return sd > 0.0 ? std::abs(size) / sd : 0.0; }
};

Settling settling_of(const Recorded& recorded, std::size_t output, double part) {
  const auto times = times_of(recorded);
  double squares = 0.0, products = 0.0, freedom = 0.0;
  std::vector<double> densities;  // the pose in which the bias settles most has the greatest
  for (std::size_t p = 0; p < poses; ++p) densities.push_back(recorded.section[p].density[output]);
  const double density = median(densities);
  for (std::size_t p = 0; p < poses; ++p) {
    const Section& section = recorded.section[p];
    freedom += section.freedom[output];
    for (const HalfStep& step : section.halves[output].steps) {
      const Part& piece = section.pieces[step.part];
      const PoseTimes& session = times.at(piece.recording);
      const double half = 0.5 * piece.length;
      const double shape = mean_of_settling(session, piece.begin + half, half, part) -
                           mean_of_settling(session, piece.begin, half, part);
      const double variance = density * step.noise;
      if (!(variance > 0.0)) continue;
      squares += shape * shape / variance;
      products += shape * step.difference / variance;
    }
  }
  if (!(squares > 0.0)) return {};
  return {products / squares, 1.0 / std::sqrt(squares), part, freedom};
}

Settling best_of(const Recorded& recorded, std::size_t output) {
  Settling best;
  for (const double part : settling_times)
    if (const Settling one = settling_of(recorded, output, part); one.ratio() > best.ratio()) best = one;
  return best;
}

/// Mean of the settling over all parts of a pose [1].
double mean_in(const Recorded& recorded, std::size_t pose, double part) {
  const auto times = times_of(recorded);
  double sum = 0.0, length = 0.0;
  for (const Part& piece : recorded.section[pose].pieces) {
    sum += piece.length * mean_of_settling(times.at(piece.recording), piece.begin, piece.length, part);
    length += piece.length;
  }
  return length > 0.0 ? sum / length : 0.0;
}

}  // namespace

void add_warming(const Recorded& recorded, Findings& findings, std::vector<Cause>& all) {
  Cause cause{"bias that settles", {}, std::numeric_limits<double>::infinity(), nullptr};
  std::array<std::array<double, poses>, 3> shapes{};
  for (std::size_t k = 0; k < 3; ++k) {
    const Settling found = best_of(recorded, k);
    const double chance = tried_together * chance_of_ratio(square(found.ratio()), 1.0, found.freedom);
    cause.sd.push_back(chance < suspected_warming ? std::abs(found.size) : 0.0);
    for (std::size_t p = 0; p < poses && cause.sd[k] > 0.0; ++p) shapes[k][p] = mean_in(recorded, p, found.part);
    if (chance < rare_warming)
      findings.push_back({Finding::Severity::warning,
                          "bias_settles_in_poses",
                          {{"change", found.size, recorded.unit[k]}, {"times", found.ratio()}},
                          recorded.channel[k]});
  }
  if (!(*std::ranges::max_element(cause.sd) > 0.0)) return;
  cause.disturb = [shapes](std::span<const double> z, Means& disturbed) {
    for (std::size_t p = 0; p < poses; ++p)
      for (std::size_t k = 0; k < 3; ++k) disturbed.force[p][k] += z[k] * shapes[k][p];
  };
  all.push_back(std::move(cause));
}

}  // namespace tumble::imu_ferraris
