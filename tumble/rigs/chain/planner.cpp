#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/rigs/chain/profile.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/unit.hpp"

namespace tumble::chain {
namespace {

using Kind = Motion::Kind;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double slack = 1.0 + 1e-12;  ///< a limit is not exceeded by a rounding of the units

std::string shown(double value, const char* unit) {
  return fmt::format("{:.6g} {}", Unit::parse(unit).from_si(value), unit);
}

/// Lays the pieces of one axis segment after segment.
class Planner {
 public:
  Planner(const AxisLimits& limits, const DriveErrors& errors, Problems* problems)
      : limits_(limits), errors_(errors), problems_(problems) {}

  void start(const Motion* first) {
    if (first && first->kind == Kind::hold) {
      held_ = first->value;
      actual_ = held_ + positioning(0);
    }
    profile_.pieces.push_back({.begin = 0.0, .start = {actual_, 0.0, 0.0}});
  }

  void carry_out(const AxisCommand& command_now, const Schedule& run) {
    const Motion* motion = command_now.motion;
    segment_ = &run[command_now.segment];
    number_ = command_now.segment;
    duration_ = command_now.duration;
    begin_ = now_ = command_now.begin;
    const double begin = begin_, end = begin + duration_;
    std::size_t piece = profile_.pieces.size() - 1;
    at_ = at(profile_, begin, piece);
    const std::size_t before = profile_.pieces.size();
    motion ? command(*motion) : rest();
    if (motion && motion->kind != Kind::slew && now_ > end * slack)
      problem(say("{} needs {:.4g} s to reach the commanded motion, but the segment lasts {:.4g} s", Name{limits_.axis},
                  now_ - begin, duration_));
    auto& pieces = profile_.pieces;
    while (pieces.size() > before && pieces.back().begin >= end) pieces.pop_back();
    check_travel(before, end);
    profile_.settled.push_back(std::min(now_, end));
  }

  /// The motion goes on in a further segment, which begins at this time.
  void continue_at(double begin) { profile_.settled.push_back(std::max(begin, profile_.settled.back())); }

  Profile take() {
    find_rests(profile_);
    return std::move(profile_);
  }

 private:
  double positioning(std::size_t number) const {
    return number < errors_.positioning.size() ? errors_.positioning[number] : 0.0;
  }
  bool endless() const { return limits_.lowest == -infinity && limits_.highest == infinity; }
  void problem(const Sentence& said) {
    if (problems_) problems_->push_back(within(place_of_segment(segment_->label), said));
  }

  void command(const Motion& motion) {
    switch (motion.kind) {
      case Kind::hold:
        return hold(motion.value, limits_.max_rate, true);
      case Kind::slew:
        check_rate(motion.value);
        return hold(motion.to, std::min(motion.value, limits_.max_rate), false);
      case Kind::rate:
        check_rate(motion.value);
        kind_ = Kind::rate;
        if (motion.from)
          return go_on(*motion.from - errors_.rate * motion.value * 0.5 * motion.lasts,
                       motion.value * (1.0 + errors_.rate));
        return change_rate(motion.value * (1.0 + errors_.rate));
      case Kind::sine:
      case Kind::sweep:
        return oscillate(motion);
      default:
        problem(say("{} cannot make this motion", Name{limits_.axis}));
    }
  }

  /// What was to be held stays so; what turned or oscillated comes to rest.
  void rest() {
    if (kind_ == Kind::rate) {
      change_rate(0.0);
      turns_ = endless() ? two_pi * std::round(at_.angle / two_pi) : 0.0;
      held_ = actual_ = at_.angle;
    } else {
      go_to(actual_, speed_);
    }
    kind_ = Kind::hold;
  }

  void hold(double target, double speed, bool nearest) {
    if (kind_ == Kind::rate && endless()) {
      const double stop = at_.angle + at_.rate * std::abs(at_.rate) / (2.0 * limits_.max_acceleration);
      turns_ = two_pi * std::round((nearest ? stop - target : stop) / two_pi);
    }
    if (target + turns_ != held_ || kind_ == Kind::rate) actual_ = target + turns_ + positioning(number_);
    held_ = target + turns_;
    speed_ = speed;
    kind_ = Kind::hold;
    go_to(actual_, speed);
  }

  void oscillate(const Motion& motion) {
    const bool sweep = motion.kind == Kind::sweep;
    const double highest = sweep ? std::max(motion.frequency, motion.to_frequency) : motion.frequency;
    if (!(motion.frequency > 0.0) || (sweep && !(motion.to_frequency > 0.0)))
      return problem(say("{} needs a frequency above zero", Name{limits_.axis}));
    check_oscillation(std::abs(motion.amplitude), two_pi * highest);
    if (motion.from)
      held_ = actual_ = *motion.from;
    else
      rest();
    Piece piece{.begin = now_, .start = {actual_, 0.0, 0.0}};
    piece.amplitude = motion.amplitude * (1.0 + errors_.amplitude);
    piece.origin = begin_;
    piece.phase = motion.phase;
    piece.frequency = two_pi * motion.frequency;
    if (sweep)
      piece.growth = std::log(motion.to_frequency / motion.frequency) / (motion.lasts > 0.0 ? motion.lasts : duration_);
    piece.fade = 2.0 / (motion.frequency * std::exp(piece.growth * (now_ - begin_)));
    now_ += piece.fade;
    if (motion.from) piece.fade = 0.0;
    profile_.pieces.push_back(piece);
    kind_ = motion.kind;
  }

  void check_oscillation(double amplitude, double w) {
    if (amplitude * w > limits_.max_rate * slack)
      problem(say("{} would oscillate at up to {}, above its max_rate of {}", Name{limits_.axis},
                  Name{shown(amplitude * w, "deg/s")}, Name{shown(limits_.max_rate, "deg/s")}));
    if (amplitude * w * w > limits_.max_acceleration * slack)
      problem(say("{} would need {}, above its max_acceleration of {}", Name{limits_.axis},
                  Name{shown(amplitude * w * w, "deg/s^2")}, Name{shown(limits_.max_acceleration, "deg/s^2")}));
  }

  void check_rate(double rate) {
    if (std::abs(rate) > limits_.max_rate * slack)
      problem(say("{} at {} is above its max_rate of {}", Name{limits_.axis}, Name{shown(std::abs(rate), "deg/s")},
                  Name{shown(limits_.max_rate, "deg/s")}));
  }

  void lay(double acceleration, double duration) {
    if (!(duration > 0.0)) return;
    profile_.pieces.push_back({.begin = now_, .start = {at_.angle, at_.rate, acceleration}});
    at_.angle += duration * (at_.rate + 0.5 * duration * acceleration);
    at_.rate += duration * acceleration;
    now_ += duration;
  }

  void keep(double angle, double rate) {
    at_ = {angle, rate, 0.0};
    profile_.pieces.push_back({.begin = now_, .start = at_});
  }

  void change_rate(double rate) {
    const double by = rate - at_.rate;
    lay(std::copysign(limits_.max_acceleration, by), std::abs(by) / limits_.max_acceleration);
    keep(at_.angle, rate);
  }

  /// At this rate already, from this angle on.
  void go_on(double angle, double rate) {
    const double change = std::abs(rate - at_.rate) / limits_.max_acceleration;
    keep(angle, rate);
    now_ += change;
  }

  /// The fastest move to rest at `target`: speed up (or slow down), run on at `speed`, brake.
  void go_to(double target, double speed) {
    const double a = limits_.max_acceleration;
    const double beyond_stop = target - at_.angle - at_.rate * std::abs(at_.rate) / (2.0 * a);
    const double sense = beyond_stop < 0.0 ? -1.0 : 1.0;
    const double way = sense * (target - at_.angle), initial = sense * at_.rate;
    const double peak = std::min(speed, std::sqrt(std::max(0.0, a * way + 0.5 * initial * initial)));
    const double change = std::abs(peak - initial) / a, brake = peak / a;
    const double cruise = way - 0.5 * (initial + peak) * change - 0.5 * peak * brake;
    lay(sense * std::copysign(a, peak - initial), change);
    at_.rate = sense * peak;
    if (peak > 0.0) lay(0.0, cruise / peak);
    lay(-sense * a, brake);
    keep(target, 0.0);
  }

  /// Least and greatest angle from the segment's beginning to its end.
  void check_travel(std::size_t first, double end) {
    if (endless() || !problems_) return;
    std::size_t hint = first;
    const double before = begin_ > 0.0 ? at(profile_, begin_, hint).angle : 0.0;
    if (begin_ > 0.0 && (before < limits_.lowest || before > limits_.highest)) return;  // it has been said
    double low = infinity, high = -infinity;
    const auto& pieces = profile_.pieces;
    for (std::size_t p = first > 0 ? first - 1 : 0; p < pieces.size(); ++p) {
      const Turn& start = pieces[p].start;
      const double from = std::max(begin_, pieces[p].begin), to = p + 1 < pieces.size() ? pieces[p + 1].begin : end;
      const double swing = p < first ? 0.0 : std::abs(pieces[p].amplitude);
      const double vertex = start.acceleration == 0.0 ? from : pieces[p].begin - start.rate / start.acceleration;
      for (const double time : {from, std::max(from, to), std::clamp(vertex, from, std::max(from, to))}) {
        const double s = time - pieces[p].begin, angle = start.angle + s * (start.rate + 0.5 * s * start.acceleration);
        low = std::min(low, angle - swing);
        high = std::max(high, angle + swing);
      }
    }
    const auto beyond = [&](double angle, double stop) {
      problem(say("{} would reach {}, beyond its stop at {}", Name{limits_.axis}, Name{shown(angle, "deg")},
                  Name{shown(stop, "deg")}));
    };
    const double tolerance = 1e-9;  // [rad], rounding of the units
    if (low < limits_.lowest - tolerance) beyond(low, limits_.lowest);
    if (high > limits_.highest + tolerance) beyond(high, limits_.highest);
  }

  const AxisLimits& limits_;
  const DriveErrors& errors_;
  Problems* problems_;
  Profile profile_;
  const Segment* segment_ = nullptr;
  std::size_t number_ = 0;
  double begin_ = 0.0, duration_ = 0.0;  ///< of the segment and those that continue it [s]
  double now_ = 0.0;                     ///< until where the pieces are laid [s]
  Turn at_{};                            ///< state at now_
  Kind kind_ = Kind::hold;
  double turns_ = 0.0;                ///< whole turns made by rate motions [rad]
  double held_ = 0.0, actual_ = 0.0;  ///< angle to be held, and with its positioning error [rad]
  double speed_ = infinity;           ///< at which it goes there
};

}  // namespace

Profile profile_of(const Schedule& run, const AxisLimits& limits, const DriveErrors& errors, Problems* problems) {
  const auto commands = commands_to(run, limits.axis);
  Planner planner(limits, errors, problems);
  planner.start(commands.empty() ? nullptr : commands.front().motion);
  double begin = 0.0;
  for (std::size_t s = 0, c = 0; s < run.size(); ++s) {
    if (c < commands.size() && commands[c].segment == s)
      planner.carry_out(commands[c++], run);
    else
      planner.continue_at(begin);
    begin += run[s].duration;
  }
  return planner.take();
}

}  // namespace tumble::chain
