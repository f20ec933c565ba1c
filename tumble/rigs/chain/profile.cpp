#include "tumble/rigs/chain/profile.hpp"

#include <algorithm>
#include <cmath>

namespace tumble::chain {
namespace {

Turn oscillation(const Piece& piece, double time) {
  const double u = time - piece.origin, k = piece.growth;
  const double grown = k == 0.0 ? u : std::expm1(k * u) / k;
  const double w = piece.frequency * (k == 0.0 ? 1.0 : std::exp(k * u));
  const double s = std::sin(piece.phase + piece.frequency * grown), c = std::cos(piece.phase + piece.frequency * grown);
  const double a = piece.amplitude;
  const Turn y{a * s, a * w * c, a * (k * w * c - w * w * s)};
  const double since = time - piece.begin;
  if (since >= piece.fade) return y;
  const Turn e = smooth_step(std::max(since, 0.0) / piece.fade, piece.fade);
  return {e.angle * y.angle, e.rate * y.angle + e.angle * y.rate,
          e.acceleration * y.angle + 2.0 * e.rate * y.rate + e.angle * y.acceleration};
}

Turn state(const Piece& piece, double time) {
  const double s = time - piece.begin;
  Turn now{piece.start.angle + s * (piece.start.rate + 0.5 * s * piece.start.acceleration),
           piece.start.rate + s * piece.start.acceleration, piece.start.acceleration};
  if (piece.amplitude == 0.0) return now;
  const Turn y = oscillation(piece, time);
  return {now.angle + y.angle, now.rate + y.rate, now.acceleration + y.acceleration};
}

bool stands(const Piece& piece) {
  return piece.start.rate == 0.0 && piece.start.acceleration == 0.0 && piece.amplitude == 0.0;
}

/// The piece in force at `time`, looked for from `piece` on.
std::size_t found(const Profile& profile, double time, std::size_t piece) {
  const auto& pieces = profile.pieces;
  piece = std::min(piece, pieces.size() - 1);
  const auto covers = [&](std::size_t p) {
    return pieces[p].begin <= time && (p + 1 == pieces.size() || time < pieces[p + 1].begin);
  };
  if (covers(piece)) return piece;
  if (piece + 1 < pieces.size() && covers(piece + 1)) return piece + 1;
  const auto after =
      std::upper_bound(pieces.begin(), pieces.end(), time, [](double t, const Piece& p) { return t < p.begin; });
  return after == pieces.begin() ? 0 : static_cast<std::size_t>(after - pieces.begin()) - 1;
}

}  // namespace

Turn smooth_step(double s, double duration) {
  const double r = 1.0 - s;
  return {s * s * s * (10.0 - 15.0 * s + 6.0 * s * s), 30.0 * s * s * r * r / duration,
          60.0 * s * r * (1.0 - 2.0 * s) / (duration * duration)};
}

Turn at(const Profile& profile, double time, std::size_t& piece) {
  piece = found(profile, time, piece);
  return state(profile.pieces[piece], time);
}

void find_rests(Profile& profile) {
  const auto& pieces = profile.pieces;
  profile.rests_until.assign(pieces.size(), std::numeric_limits<double>::infinity());
  for (std::size_t p = pieces.size(); p-- > 0;) {
    if (!stands(pieces[p])) {
      profile.rests_until[p] = pieces[p].begin;
    } else if (p + 1 < pieces.size()) {
      const bool goes_on = stands(pieces[p + 1]) && pieces[p + 1].start.angle == pieces[p].start.angle;
      profile.rests_until[p] = goes_on ? profile.rests_until[p + 1] : pieces[p + 1].begin;
    }
  }
}

double steady_until(const Profile& profile, double time) {
  return std::max(time, profile.rests_until[found(profile, time, 0)]);
}

}  // namespace tumble::chain
