#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "tumble/math/shaped_noise.hpp"
#include "tumble/rigs/chain/carrier.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::rigs::by_hand {
namespace {

using namespace chain;

std::vector<Imperfection> imperfections() {
  return joined({{gravity_imperfection()},
                 lever_imperfections("20 mm"),
                 {{quantity("pose_sd", "deg")
                       .at_least(0)
                       .otherwise("2 deg")
                       .says("error of the orientation in which the instrument is laid down, about each axis"),
                   {error_names::pose_x, error_names::pose_y, error_names::pose_z},
                   true}}});
}

std::vector<Option> options() {
  std::vector<Option> options{
      quantity("move_time", "s")
          .above(0)
          .otherwise("2 s")
          .says("time of the move from one rest to the next, at the beginning of a segment"),
      quantity("tremor_sd", "deg")
          .at_least(0)
          .otherwise("0.3 deg")
          .says("shaking of the hand in the middle of a move, about each axis"),
      quantity("tremor_lowest", "Hz").above(0).otherwise("2 Hz").says("lowest frequency of the shaking"),
      quantity("tremor_highest", "Hz").above(0).otherwise("10 Hz").says("highest frequency of the shaking")};
  for (auto& option : lever_options("0 mm", "0 mm", "100 mm")) {
    option.description += ", from the point about which the hand turns it";
    options.push_back(std::move(option));
  }
  for (auto& option : laboratory_options()) options.push_back(std::move(option));
  for (const auto& imperfection : imperfections()) options.push_back(imperfection.option);
  return options;
}

std::vector<RigError> errors(const Settings& options, const std::optional<Site>& site) {
  return errors_of(imperfections(), options, site);
}

/// A move from the pose before, and a rest, until the next move.
struct Rest {
  double begin = 0.0;
  std::size_t segment = 0;  ///< in which it begins
  Rotation from;            ///< instrument from level, before the move
  Rotation pose;            ///< and after it
  Vector3 axis;             ///< the move turns about it, by
  double angle = 0.0;       ///< [rad]; 0: no move
};

struct Hand {
  std::vector<Rest> rests;
  Kinematics ground;
  Vector3 lever;
  double move_time = 1.0;
  double temperature = 293.15;
  std::vector<ShapedNoise> tremor;  ///< about x, y, z; empty: none
};

/// Angle and axis of a rotation, by its quaternion with the largest part first.
void split(const Rotation& r, Vector3& axis, double& angle) {
  const double trace = r.x.x + r.y.y + r.z.z;
  // 4 times the products of the quaternion's parts (w, x, y, z) of a passive rotation
  const double q[4][4] = {{1.0 + trace, r.y.z - r.z.y, r.z.x - r.x.z, r.x.y - r.y.x},
                          {r.y.z - r.z.y, 1.0 + r.x.x - r.y.y - r.z.z, r.x.y + r.y.x, r.x.z + r.z.x},
                          {r.z.x - r.x.z, r.x.y + r.y.x, 1.0 - r.x.x + r.y.y - r.z.z, r.y.z + r.z.y},
                          {r.x.y - r.y.x, r.x.z + r.z.x, r.y.z + r.z.y, 1.0 - r.x.x - r.y.y + r.z.z}};
  int best = 0;
  for (int i = 1; i < 4; ++i)
    if (q[i][i] > q[best][best]) best = i;
  const double sign = q[best][0] < 0.0 ? -1.0 : 1.0;
  const Vector3 v = sign * Vector3{q[best][1], q[best][2], q[best][3]};
  const double length = norm(v);
  axis = length > 0.0 ? (1.0 / length) * v : Vector3{1.0, 0.0, 0.0};
  angle = 2.0 * std::atan2(length, sign * q[best][0]);
}

std::vector<Rest> rests_of(const Schedule& run, const ErrorValues& error) {
  const auto poses = poses_of(run, error);  // the errors have no mounting: the poses as commanded
  std::vector<Rest> rests;
  double begin = 0.0;
  std::size_t pose = 0;
  for (std::size_t s = 0; s < run.size(); ++s) {
    const bool moved = s == 0 || (pose + 1 < poses.size() && poses[pose + 1].begin <= begin);
    if (moved) {
      if (s > 0) ++pose;
      Rest rest{.begin = begin, .segment = s};
      rest.pose = about_x(error(error_names::pose_x, s)) * about_y(error(error_names::pose_y, s)) *
                  about_z(error(error_names::pose_z, s)) * poses[pose].instrument_from_fixture;
      rest.from = s == 0 ? rest.pose : rests.back().pose;
      if (s > 0) split(rest.pose * inverse(rest.from), rest.axis, rest.angle);
      rests.push_back(rest);
    }
    begin += run[s].duration;
  }
  return rests;
}

Hand hand_of(const RigRun& run) {
  const auto list = errors(run.options, run.site);
  const ErrorValues error(list, run.errors);
  const Settings& options = run.options;
  Hand hand;
  hand.rests = rests_of(run.segments, error);
  hand.ground = ground_of(run.site, error(error_names::gravity), error(error_names::latitude));
  hand.lever = {options.number("lever_x") + error(error_names::lever_x),
                options.number("lever_y") + error(error_names::lever_y),
                options.number("lever_z") + error(error_names::lever_z)};
  hand.move_time = options.number("move_time");
  hand.temperature = options.number("temperature");
  const double sd = options.flag("ideal") ? 0.0 : options.number("tremor_sd");
  const double low = options.number("tremor_lowest"), high = options.number("tremor_highest");
  const double density = sd * sd / (high - low);
  if (sd > 0.0)
    for (const char* axis : {"x", "y", "z"})
      hand.tremor.emplace_back(SpectralDensity{{low, high}, {density, density}},
                               run.random.split("tremor").split(axis));
  return hand;
}

/// The shaking about one axis, (4 s (1 - s))^3 times a stationary process: still where the move begins and ends.
Turn trembling(const ShapedNoise& tremor, double time, double s, double duration) {
  const double b = 4.0 * s * (1.0 - s), b1 = 4.0 * (1.0 - 2.0 * s) / duration, b2 = -8.0 / (duration * duration);
  const double e = b * b * b, e1 = 3.0 * b * b * b1, e2 = 6.0 * b * b1 * b1 + 3.0 * b * b * b2;
  const auto y = tremor.at(time);
  return {e * y.value, e1 * y.value + e * y.first_derivative,
          e2 * y.value + 2.0 * e1 * y.first_derivative + e * y.second_derivative};
}

Kinematics state(const Hand& hand, const Rest& rest, double time) {
  const double s = (time - rest.begin) / hand.move_time;
  if (rest.angle == 0.0 || s >= 1.0) return seen_in(rest.pose, hand.ground);
  Turn turn = smooth_step(std::max(s, 0.0), hand.move_time);
  turn = {rest.angle * turn.angle, rest.angle * turn.rate, rest.angle * turn.acceleration};
  Kinematics k = turned(seen_in(rest.from, hand.ground), rest.axis, turn);
  constexpr Vector3 axes[3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
  for (std::size_t i = 0; i < hand.tremor.size(); ++i)
    k = turned(k, axes[i], trembling(hand.tremor[i], time, std::max(s, 0.0), hand.move_time));
  return moved(k, hand.lever);
}

/// Instrument from level.
Rotation orientation(const Hand& hand, const Rest& rest, double time) {
  const double s = std::max(0.0, (time - rest.begin) / hand.move_time);
  if (rest.angle == 0.0 || s >= 1.0) return rest.pose;
  Rotation turned = about(rest.axis, rest.angle * smooth_step(s, hand.move_time).angle) * rest.from;
  constexpr Vector3 axes[3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
  for (std::size_t i = 0; i < hand.tremor.size(); ++i)
    turned = about(axes[i], trembling(hand.tremor[i], time, s, hand.move_time).angle) * turned;
  return turned;
}

const Rest& rest_at(const Hand& hand, double time) {
  const auto after = std::upper_bound(hand.rests.begin(), hand.rests.end(), time,
                                      [](double t, const Rest& rest) { return t < rest.begin; });
  return after == hand.rests.begin() ? hand.rests.front() : *(after - 1);
}

void felt_in(const Hand& hand, double first, double step, std::span<Felt> out) {
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double time = first + static_cast<double>(i) * step;
    const Kinematics k = state(hand, rest_at(hand, time), time);
    out[i] = {};
    out[i].rate = k.rate;
    out[i].angular_acceleration = k.acceleration;
    out[i].specific_force = k.specific_force;
    out[i].temperature = out[i].start_temperature = hand.temperature;
    out[i].since_power_on = time;
  }
}

double until(const Hand& hand, double time) {
  const Rest* rest = &rest_at(hand, time);
  if (rest->angle != 0.0 && time < rest->begin + hand.move_time) return time;
  const Rest* const end = hand.rests.data() + hand.rests.size();
  while (++rest < end)
    if (rest->angle != 0.0) return rest->begin;
  return std::numeric_limits<double>::infinity();
}

Reference reference(const RigRun& run) {
  const auto hand = std::make_shared<const Hand>(hand_of(run));
  Reference out;
  out.felt = [hand](double first, double step, std::span<Felt> samples) { felt_in(*hand, first, step, samples); };
  out.steady_until = [hand](double time) { return until(*hand, time); };
  auto rest = hand->rests.begin();
  double begin = 0.0;
  for (std::size_t s = 0; s < run.segments.size(); ++s) {
    if (rest + 1 != hand->rests.end() && (rest + 1)->segment == s) ++rest;
    const bool moves = rest->segment == s && rest->angle != 0.0;
    out.settled.push_back(begin + (moves ? std::min(hand->move_time, run.segments[s].duration) : 0.0));
    begin += run.segments[s].duration;
  }
  out.parts.push_back({"instrument", {}, false, [hand](double time) {
                         const Rotation pose = orientation(*hand, rest_at(*hand, time), time);
                         return PartPlacement{pose, inverse(pose) * hand->lever};
                       }});
  for (const char* mount : {"mount_roll", "mount_pitch", "mount_yaw"})
    out.drives.push_back({mount, [hand, last = last_value(run.segments, mount)](double time) {
                            const Rest& now = rest_at(*hand, time);
                            return DriveState{last(time), 0.0, now.angle == 0.0 || time >= now.begin + hand->move_time};
                          }});
  return out;
}

Problems refusals(const Schedule& schedule, const Settings& options) {
  Problems problems;
  check_order(options, "tremor_lowest", "tremor_highest", problems);
  if (!check_axes(mount_axes(), schedule, problems)) return problems;
  const auto list = errors(options, {});
  const Matrix none;
  for (const auto& run : runs_of(schedule)) {
    for (const Rest& rest : rests_of(run, ErrorValues(list, none)))
      if (const Segment& segment = run[rest.segment];
          rest.angle != 0.0 && segment.duration < options.number("move_time"))
        problems.push_back(say("segment '{}' lasts {:.4g} s, but the move of the instrument takes {:.4g} s",
                               segment.label, segment.duration, options.number("move_time")));
  }
  return problems;
}

}  // namespace

extern const Rig by_hand{.name = "by_hand",
                         .summary = "no machine: the instrument is turned by hand from rest to rest",
                         .axes = mount_axes,
                         .options = options,
                         .errors = errors,
                         .reference = reference,
                         .refusals = refusals};

}  // namespace tumble::rigs::by_hand
