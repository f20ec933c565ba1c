#include "tumble/tasks/prediction/candidates.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "tumble/rigs/rig.hpp"
#include "tumble/tasks/prediction/problem.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::prediction {
namespace {

using Kind = Motion::Kind;
using Motions = std::map<std::string, Motion>;

constexpr double right_angle = 0.25 * two_pi;
constexpr std::size_t most_positions = 4096;  ///< held; a finer grid is made coarser
constexpr std::size_t most_beside_motion = 32;
constexpr double long_enough = 7200.0;                        ///< [s] for any move while candidates are looked at
constexpr double highest_amplitude = two_pi / 36.0;           ///< of an oscillation [rad]
constexpr std::array<double, 3> rate_levels{1.0, 0.5, 0.25};  ///< of the highest
constexpr std::array<double, 5> frequencies{0.5, 1.0, 2.0, 5.0, 10.0};  ///< [Hz]
constexpr double samples_in_period = 10.0;
constexpr std::size_t instants_in_motion = 24;

bool can(const Axis& axis, Kind kind) { return std::ranges::find(axis.motions, kind) != axis.motions.end(); }
bool is_angle(const Axis& axis) { return Unit::parse(axis.unit).dimension() == Unit::parse("rad").dimension(); }

Motion held(const Axis& axis, double value) {
  return {.kind = can(axis, Kind::hold) ? Kind::hold : Kind::dwell, .value = value};
}

/// What is felt of candidates, and what the rig refuses.
class Trials {
 public:
  explicit Trials(const Plan& plan) : plan_(plan), rig_(find_rig(plan.rig_kind)) {}

  bool accepted(const Motions& approach, const Motions& work, double duration) const {
    Schedule schedule;
    if (!approach.empty()) schedule.push_back({"approach", long_enough, 1, approach});
    schedule.push_back({"work", duration, 1, work});
    return rig_.refusals(schedule, plan_.rig).empty();
  }

  /// Fills in setup and felt: from the neutral position, each in a segment that is long enough.
  void look(std::vector<Candidate>& all, const Motions& neutral) const {
    for (std::size_t first = 0; first < all.size(); first += 256)
      look_at(std::span(all).subspan(first, std::min<std::size_t>(256, all.size() - first)), neutral);
  }

 private:
  void look_at(std::span<Candidate> some, const Motions& neutral) const {
    RigRun run{{}, plan_.rig, plan_.site, std::max(1.0, plan_.sample_rate), {}, RandomStream{0}};
    for (const auto& one : some) {
      run.segments.push_back({"neutral", long_enough, 1, neutral});
      if (!one.approach.empty()) run.segments.push_back({"approach", long_enough, 1, one.approach});
      run.segments.push_back({"work", long_enough + one.least, 1, one.work});
    }
    const Reference reference = rig_.reference(run);
    double begin = 0.0;
    std::size_t segment = 0;
    const auto next = [&] {
      const double settling = reference.settled[segment] - begin;
      begin += run.segments[segment++].duration;
      return settling;
    };
    for (auto& one : some) {
      next();
      one.setup = one.approach.empty() ? 0.0 : next();
      const double settled = reference.settled[segment];
      one.spin_up = next();
      one.setup += one.spin_up;
      one.felt.resize(one.least > 0.0 ? instants_in_motion : 1);
      const double step = one.least / static_cast<double>(one.felt.size());
      reference.felt(settled + 0.5 * step, std::max(step, 1e-6), one.felt);
    }
  }

  const Plan& plan_;
  const Rig& rig_;
};

/// The values that an axis may hold.
struct Places {
  Axis axis;
  std::vector<double> values;
};

std::vector<double> angles(double step, bool corners) {
  const auto half = static_cast<int>(std::floor(0.5 * two_pi / step + 1e-9));
  std::vector<double> out{0.0};
  for (int i = 1; i <= half; ++i) {
    out.push_back(step * i);
    if (step * i < 0.5 * two_pi - 1e-9) out.push_back(-step * i);
  }
  const double corner = std::atan(std::sqrt(0.5));  // with 45 deg of another axis a corner of the cube is up
  if (corners)
    for (const double angle : {corner, right_angle - corner, right_angle + corner, 2.0 * right_angle - corner})
      out.insert(out.end(), {angle, -angle});
  const double millionth = 1e-6 * two_pi / 360.0;  // for people: 75 deg, not 74.99999999999999
  for (double& angle : out) angle = Unit::parse("deg").to_si(std::round(angle / millionth) * 1e-6);
  return out;
}

/// Five levels between the extremes of the plan on an axis that is no angle.
std::vector<double> levels(const Plan& plan, const Axis& axis) {
  double low = 0.0, high = 0.0;
  bool any = false;
  for (const auto& segment : plan.schedule)
    if (const auto found = segment.axes.find(axis.name); found != segment.axes.end()) {
      const Motion& motion = found->second;
      const bool goes = motion.kind == Kind::ramp || motion.kind == Kind::slew;
      if (!goes && motion.kind != Kind::hold && motion.kind != Kind::dwell) continue;
      const double value = goes ? motion.to : motion.value;
      low = any ? std::min(low, value) : value;
      high = any ? std::max(high, value) : value;
      any = true;
    }
  std::vector<double> out{low};
  for (int i = 1; i < 5 && high > low; ++i) out.push_back(low + 0.25 * i * (high - low));
  return out;
}

std::vector<Places> places(const Plan& plan, const CandidateRange& range, double step) {
  std::vector<Places> out;
  for (const auto& axis : find_rig(plan.rig_kind).axes()) {
    if (std::ranges::find(range.axes, axis.name) == range.axes.end()) continue;
    const bool mount = is_mount_axis(axis.name);
    if (!can(axis, Kind::hold) && !can(axis, Kind::dwell))
      out.push_back({axis, {}});
    else
      out.push_back({axis, is_angle(axis) ? angles(mount ? std::max(step, right_angle) : step,
                                                   range.corners && !mount && step < right_angle)
                                          : levels(plan, axis)});
  }
  return out;
}

std::size_t combinations(const std::vector<Places>& places) {
  std::size_t count = 1;
  for (const auto& one : places) count *= std::max<std::size_t>(1, one.values.size());
  return count;
}

/// Grid made coarser until there are at most so many positions.
std::vector<Places> places_up_to(const Plan& plan, const CandidateRange& range, double step, std::size_t most) {
  auto out = places(plan, range, step);
  for (const double coarser : {two_pi / 24.0, two_pi / 12.0, 0.125 * two_pi, right_angle, 0.5 * two_pi})
    if (combinations(out) > most && coarser > step) out = places(plan, range, coarser);
  return out;
}

/// Every combination of values, first axis slowest. `left_out` move and are not held.
std::vector<Motions> all_held(const std::vector<Places>& places, const std::set<std::string>& left_out) {
  std::vector<Motions> out{{}};
  for (const auto& one : places) {
    if (one.values.empty() || left_out.contains(one.axis.name)) continue;
    std::vector<Motions> longer;
    for (const auto& before : out)
      for (const double value : one.values) {
        longer.push_back(before);
        longer.back()[one.axis.name] = held(one.axis, value);
      }
    out = std::move(longer);
  }
  return out;
}

/// The largest x in (0, most] that is accepted, where everything below it is; 0: none.
double largest_accepted(double most, const std::function<bool(double)>& accepted) {
  if (accepted(most)) return most;
  double good = 1e-9 * most, bad = most;
  if (!accepted(good)) return 0.0;
  while (bad > good * (1.0 + 1e-10)) {
    const double middle = std::sqrt(good * bad);
    (accepted(middle) ? good : bad) = middle;
  }
  return good;
}

/// Three digits, not above: limits found by bisection are to be read by people.
double rounded_down(double value, double unit) {
  const double shown = value / unit, digit = std::pow(10.0, std::floor(std::log10(shown)) - 2.0);
  return std::floor(shown / digit * (1.0 + 1e-9)) * digit * unit;
}

/// What the instrument is said to measure of a kind [SI]; +inf where [truth] does not say.
double range_of_instrument(const Plan& plan, QuantityKind kind) {
  double range = std::numeric_limits<double>::infinity();
  for (const auto& output : find_model(plan.instrument_model).outputs(plan.truth))
    for (const auto& name : {output.noise_prefix + "range", std::string("range")})
      if (output.kind == kind && plan.truth.has(name)) range = std::min(range, plan.truth.number(name));
  return range;
}

Motions with(Motions motions, const std::string& axis, const Motion& motion) {
  motions[axis] = motion;
  return motions;
}

/// Rates of one axis, and of two at once, with the others held.
class Rates {
 public:
  Rates(double range, const Trials& trials, const std::vector<Places>& places) : trials_(trials), places_(places) {
    for (const auto& one : places) {
      if (!can(one.axis, Kind::rate) || !is_angle(one.axis)) continue;
      const Motions start = all_held(places, {}).front();
      const double top = largest_accepted(std::min(1e4, range), [&](double rate) {
        return trials.accepted(start, with(start, one.axis.name, {.kind = Kind::rate, .value = rate}),
                               two_pi / rate + long_enough);
      });
      if (top > 0.0) tops_.emplace_back(one.axis, rounded_down(top, degree));
    }
  }

  void add(std::vector<Candidate>& out) const {
    for (const auto& [axis, top] : tops_)
      for (const auto& beside : all_held(places_, {axis.name}))
        for (const double level : rate_levels)
          for (const double sense : {1.0, -1.0}) add_one(out, beside, {{axis, sense * level * top}});
    for (std::size_t a = 0; a < tops_.size(); ++a)
      for (std::size_t b = a + 1; b < tops_.size(); ++b)
        for (const auto& beside : all_held(places_, {tops_[a].first.name, tops_[b].first.name}))
          for (const double level : {1.0, 0.5})
            for (const auto& [first, second] : {std::pair{1.0, 1.0}, {1.0, -1.0}, {-1.0, 1.0}, {-1.0, -1.0}})
              add_one(out, beside,
                      {{tops_[a].first, first * level * tops_[a].second}, {tops_[b].first, second * tops_[b].second}});
  }

 private:
  void add_one(std::vector<Candidate>& out, const Motions& beside,
               const std::vector<std::pair<Axis, double>>& rates) const {
    Candidate one{beside, beside};
    for (const auto& [axis, rate] : rates) {
      one.approach[axis.name] = held(axis, 0.0);
      one.work[axis.name] = {.kind = Kind::rate, .value = rate};
      one.least = std::max(one.least, two_pi / std::abs(rate));
      one.fastest = std::max(one.fastest, std::abs(rate) / two_pi);
    }
    if (trials_.accepted(one.approach, one.work, one.least + long_enough)) out.push_back(std::move(one));
  }

  const Trials& trials_;
  const std::vector<Places>& places_;
  std::vector<std::pair<Axis, double>> tops_;  ///< highest rate [rad/s]
};

double largest_amplitude_of_plan(const Plan& plan, const std::string& axis) {
  double most = 0.0;
  for (const auto& segment : plan.schedule)
    if (const auto found = segment.axes.find(axis); found != segment.axes.end())
      most = std::max(most, std::abs(found->second.amplitude));
  return most;
}

/// Oscillations about zero at the largest amplitude that the rig can do at each frequency.
void add_oscillations(const Plan& plan, double range, const Trials& trials, const std::vector<Places>& places,
                      std::vector<Candidate>& out) {
  for (const auto& one : places) {
    if (!can(one.axis, Kind::sine)) continue;
    const double most = is_angle(one.axis) ? highest_amplitude : largest_amplitude_of_plan(plan, one.axis.name);
    const Unit unit = Unit::parse(one.axis.unit);
    for (const auto& beside : all_held(places, {one.axis.name}))
      for (const double frequency : frequencies) {
        if (!(most > 0.0) || samples_in_period * frequency > plan.sample_rate) continue;
        Motions approach = beside;
        if (!one.values.empty()) approach[one.axis.name] = held(one.axis, 0.0);
        const auto motion = [&](double amplitude) {
          return with(beside, one.axis.name, {.kind = Kind::sine, .amplitude = amplitude, .frequency = frequency});
        };
        const double felt = is_angle(one.axis) ? std::min(most, range / (two_pi * frequency)) : most;
        const double top = largest_accepted(
            felt, [&](double amplitude) { return trials.accepted(approach, motion(amplitude), long_enough); });
        if (top > 0.0)
          out.push_back({.approach = approach,
                         .work = motion(rounded_down(top, unit.factor())),
                         .least = 1.0 / frequency,
                         .fastest = frequency});
      }
  }
}

/// Positions in which everything felt is the same are one.
std::vector<Candidate> felt_once(std::vector<Candidate> all) {
  std::set<std::array<long, 7>> seen;
  std::vector<Candidate> out;
  for (auto& one : all) {
    const auto& f = one.felt.front();
    const auto rounded = [](double value, double unit) { return std::lround(value / unit); };
    if (one.approach.empty() &&
        !seen.insert({rounded(f.rate.x, 1e-10), rounded(f.rate.y, 1e-10), rounded(f.rate.z, 1e-10),
                      rounded(f.specific_force.x, 1e-6), rounded(f.specific_force.y, 1e-6),
                      rounded(f.specific_force.z, 1e-6), rounded(f.temperature, 1e-3)})
             .second)
      continue;
    out.push_back(std::move(one));
  }
  return out;
}

bool still(Kind kind) { return kind == Kind::hold || kind == Kind::dwell; }

}  // namespace

CandidateRange range_of(const Plan& plan, double step) {
  CandidateRange range{{}, false, false, step};
  std::set<std::string> moved;
  for (const auto& segment : plan.schedule)
    for (const auto& [axis, motion] : segment.axes) {
      moved.insert(axis);
      range.rates = range.rates || motion.kind == Kind::rate;
      range.sines = range.sines || motion.kind == Kind::sine || motion.kind == Kind::sweep;
    }
  range.axes.assign(moved.begin(), moved.end());
  return range;
}

void limit_to_instrument(const Plan& plan, CandidateRange& range) {
  constexpr double used_of_range = 0.9, rounding = 1.001;
  double rate = 0.0, force = 0.0;
  for (const auto& felt : felt_over(plan)) {
    rate = std::max(rate, norm(felt.rate));
    force = std::max(force, norm(felt.specific_force));
  }
  const auto most = [&](QuantityKind kind, double of_plan) {
    const double stated = used_of_range * range_of_instrument(plan, kind);
    return std::isfinite(stated) ? stated : rounding * of_plan;
  };
  range.most_rate = most(QuantityKind::angular_rate, rate);
  range.most_force = most(QuantityKind::specific_force, force);
}

std::vector<Candidate> candidates(const Plan& plan, const CandidateRange& range) {
  const Trials trials(plan);
  const auto grid = places_up_to(plan, range, range.step, most_positions);
  std::vector<Candidate> out;
  for (auto& motions : all_held(grid, {}))
    if (trials.accepted({}, motions, long_enough)) out.push_back({.work = std::move(motions)});
  if (out.empty()) return out;
  const Motions neutral = out.front().work;
  trials.look(out, neutral);
  out = felt_once(std::move(out));
  const auto beside = places_up_to(plan, range, right_angle, most_beside_motion);
  std::vector<Candidate> moving;
  const double most_rate = std::min(range.most_rate, 0.9 * range_of_instrument(plan, QuantityKind::angular_rate));
  if (range.rates) Rates(most_rate, trials, beside).add(moving);
  if (range.sines) add_oscillations(plan, range.most_rate, trials, beside, moving);
  trials.look(moving, neutral);
  out.insert(out.end(), moving.begin(), moving.end());
  std::erase_if(out, [&](const Candidate& one) {
    return std::ranges::any_of(one.felt, [&](const Felt& felt) {
      return norm(felt.rate) > range.most_rate || norm(felt.specific_force) > range.most_force;
    });
  });
  return out;
}

std::vector<Felt> felt_of(const std::vector<Candidate>& all) {
  std::vector<Felt> out;
  for (const auto& one : all) out.insert(out.end(), one.felt.begin(), one.felt.end());
  return out;
}

Schedule schedule_of(const Plan& plan, const std::vector<Candidate>& all, const std::vector<CandidateVisit>& visits,
                     double settling) {
  RigRun run{{}, plan.rig, plan.site, std::max(1.0, plan.sample_rate), {}, RandomStream{0}};
  const double interval = plan.sample_rate > 0.0 ? 1.0 / plan.sample_rate : 0.0;
  double begin = 0.0;
  // How long a move takes depends on where the one before ended: segment after segment, the last one long.
  const auto add = [&](const std::string& label, const Motions& axes, double after_move, bool approach) {
    run.segments.push_back({label, long_enough + after_move, 1, axes, approach});
    double duration = find_rig(plan.rig_kind).reference(run).settled.back() - begin + after_move;
    if (interval > 0.0) duration = std::max(1.0, std::ceil(duration / interval - 1e-6)) * interval;
    run.segments.back().duration = duration;
    begin += duration;
  };
  for (std::size_t v = 0; v < visits.size(); ++v) {
    const auto& one = all[visits[v].candidate];
    if (!one.approach.empty()) add(fmt::format("{:02d} approach", v + 1), one.approach, 0.0, true);
    add(fmt::format("{:02d} {}", v + 1, in_words(one.work, plan)), one.work, settling + visits[v].dwell, false);
  }
  return run.segments;
}

std::string in_words(const std::map<std::string, Motion>& axes, const Plan& plan) {
  std::string text;
  for (const auto& axis : find_rig(plan.rig_kind).axes()) {
    const auto found = axes.find(axis.name);
    if (found == axes.end()) continue;
    const Motion& motion = found->second;
    const Unit unit = Unit::parse(axis.unit);
    if (still(motion.kind) && motion.value == 0.0 && unit.offset() == 0.0) continue;
    if (!text.empty()) text += ", ";
    if (still(motion.kind)) text += fmt::format("{} {:.6g} {}", axis.name, unit.from_si(motion.value), axis.unit);
    if (motion.kind == Kind::rate)
      text += fmt::format("{} {:+.6g} {}/s", axis.name, unit.difference_from_si(motion.value), axis.unit);
    if (motion.kind == Kind::sine)
      text += fmt::format("{} +-{:.6g} {} at {:.6g} Hz", axis.name, unit.difference_from_si(motion.amplitude),
                          axis.unit, motion.frequency);
  }
  return text.empty() ? "all axes at zero" : text;
}

}  // namespace tumble::prediction
