#include "tumble/reduce/table/axis_record.hpp"

#include <algorithm>
#include <cmath>

#include "tumble/clocks/stamp_slack.hpp"
#include "tumble/math/median.hpp"
#include "tumble/reduce/table/kept_motion.hpp"
#include "tumble/reduce/table/shown_motion.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::table {
namespace {

using Kind = Motion::Kind;
using Severity = Finding::Severity;

constexpr double least_tolerance = 0.01 * degree;  ///< [rad], 0.01 deg: encoders and clocks that are sound show more
constexpr double most_tolerance = 0.5;             ///< [rad]
constexpr double explained = 6.0;                  ///< standard deviations of what a rig does otherwise than its plan
constexpr double same_motion = 0.01;      ///< [1] departures of axes that differ by less have one cause: a clock
constexpr double another_motion = 0.2;    ///< [1] beyond it the encoder shows another motion
constexpr double two_clocks = 100e-6;     ///< [1] by which the plain quartz clocks of rig and recorder differ
constexpr double least_departure = 1e-6;  ///< [1] of an oscillation: less moves no result
constexpr double other_angle = 0.0175;    ///< [rad] 1 deg: beyond it an axis stands in another position
constexpr double finest_stand = 1.0 * arcsecond;  ///< [rad] no rig repeats its angles better
constexpr double most_other_stands = 1.0 / 3.0;   ///< [1] with more the encoder shows another axis
constexpr std::size_t fewest_for_zero = 3;        ///< stands of which the middle one shows the zero of the encoder

/// The readings of a segment whose samples lie in it wholly and on its motion.
Angles readings_in(const Encoder& encoder, const Motion* motion, const PlacedSegment& place) {
  const Channel& channel = *encoder.channel;
  const double step = 1.0 / mean_rate(channel);
  const Kept kept = kept_motion(encoder, motion, place.settled, place.end);
  const double slack = stamp_slack(place.end, step);
  Angles out;
  for (std::size_t i = index_at(channel, kept.from - slack);
       i < channel.values.size() && channel.time(i) + step < kept.until + slack; ++i) {
    if (std::isnan(channel.values[i])) continue;
    out.times.push_back(channel.time(i) + 0.5 * step - place.begin);
    out.values.push_back(channel.values[i]);
  }
  return out;
}

/// What the drive of an axis shows by the plan [rad], or nothing.
std::optional<Angles> planned_angles(const AxisRecord& axis, std::size_t segment, const std::vector<double>& times) {
  const auto& [power_up, number] = axis.test.places[segment];
  if (power_up == Conducted::nowhere) return {};
  const PowerUp& of = axis.test.power_ups[power_up];
  const auto drive = std::ranges::find(of.reference.drives, axis.encoder.axis, &Drive::axis);
  if (drive == of.reference.drives.end()) return {};
  Angles out{times, {}};
  for (const double time : times) out.values.push_back(drive->at(of.begins[number] + time).value);
  return out;
}

double rig_sd(const Plan& plan, const char* name) { return plan.rig.has(name) ? plan.rig.number(name) : 0.0; }

/// By how much the axis may be elsewhere than the plan says [rad], which a rig with the plan's errors explains.
double tolerance_of(const Plan& plan, const std::string& axis, std::size_t segment) {
  double way = 0.0;
  for (std::size_t s = 0; s <= segment; ++s) {
    const Motion* motion = motion_of(plan.schedule[s], axis);
    const bool begins = s > 0 && plan.schedule[s].run != plan.schedule[s - 1].run;
    if (begins || (motion != nullptr && motion->kind != Kind::rate)) way = 0.0;
    if (motion != nullptr && motion->kind == Kind::rate) way += std::abs(motion->value) * plan.schedule[s].duration;
  }
  const double by_rig = explained * (rig_sd(plan, "repeatability_sd") + rig_sd(plan, "rate_error_sd") * way);
  return std::clamp(by_rig, least_tolerance, most_tolerance);
}

bool turns_or_oscillates(const Motion& motion) {
  return !motion.continued &&
         ((motion.kind == Kind::rate && motion.value != 0.0) || (motion.kind == Kind::sine && motion.amplitude != 0.0));
}

/// A segment in which the plan turns the axis or holds it, and its readings.
struct Observed {
  std::size_t segment = 0;
  const Motion* motion = nullptr;
  Angles readings, planned;
  std::optional<RateDeparture> rate = {};  ///< of a rate; of a stand from rest
  std::optional<ShownOscillation> oscillation = {};
  double apart = 0.0, apart_sd = 0.0;  ///< of a stand: recorded minus planned [rad]

  bool stands() const { return motion->kind == Kind::hold; }
  double relative() const { return rate->rate / motion->value; }  ///< of a rate [1]
};

/// The mean of recorded minus planned, and its standard deviation.
void compare_stand(double step, Observed& one) {
  const auto n = static_cast<double>(one.readings.values.size());
  const double first = std::remainder(one.readings.values.front() - one.planned.values.front(), two_pi);
  double squares = 0.0;
  for (std::size_t i = 0; i < one.readings.values.size(); ++i) {
    const double off = std::remainder(one.readings.values[i] - one.planned.values[i] - first, two_pi);
    one.apart += off / n;
    squares += off * off;
  }
  const double variance = std::max(squares / n - one.apart * one.apart, 0.0);
  one.apart_sd = std::sqrt(variance / n + step * step / 12.0);
  one.apart = std::remainder(one.apart + first, two_pi);
}

std::vector<Observed> observed(const AxisRecord& axis) {
  std::vector<Observed> all;
  const double planned_sd = rig_sd(axis.plan, "rate_error_sd");
  for (const auto& place : axis.places) {
    const Motion* motion = motion_of(axis.plan.schedule[place.segment], axis.encoder.axis);
    if (motion == nullptr || !(turns_or_oscillates(*motion) || motion->kind == Kind::hold)) continue;
    Observed one{place.segment, motion, readings_in(axis.encoder, motion, place), {}};
    auto planned = planned_angles(axis, place.segment, one.readings.times);
    if (!planned || one.readings.times.empty()) continue;
    one.planned = std::move(*planned);
    if (one.stands()) compare_stand(axis.encoder.step, one);
    const double rate = one.stands() ? 0.0 : motion->value;
    if (motion->kind != Kind::sine)
      one.rate = departure_of_rate(rate, one.readings, explained * planned_sd * std::abs(rate));
    if (motion->kind == Kind::sine) one.oscillation = oscillation_of(*motion, one.readings);
    all.push_back(std::move(one));
  }
  return all;
}

/// By how much [1] of the rate of the plan the readings differ from another rate [rad/s]. Readings that are far apart show
/// rates only up to whole turns between them.
double off_rate(const Observed& one, double rate) {
  const auto& times = one.readings.times;
  const double step = (times.back() - times.front()) / static_cast<double>(times.size() - 1);
  const double off = std::remainder((one.motion->value + one.rate->rate - rate) * step, two_pi) / step;
  return std::abs(off / one.motion->value);
}
bool shows(const Observed& one, double rate) { return off_rate(one, rate) < another_motion; }

/// Whether the readings cannot distinguish the rate of the plan from that in the other direction.
bool is_alike_mirrored(const Observed& one) { return shows(one, one.motion->value) && shows(one, -one.motion->value); }

/// Whether an encoder shows all that decides it in the other direction: rates, and stands at angles that have one.
const Observed* reversed_by(const std::vector<Observed>& all) {
  const Observed* first = nullptr;
  for (const Observed& one : all) {
    bool mirrored = false;
    if (one.stands()) {
      const double angle = one.planned.values.front();
      if (std::abs(std::remainder(2.0 * angle, two_pi)) < other_angle) continue;  // 0 and 180 deg have no direction
      mirrored = std::abs(std::remainder(one.apart + 2.0 * angle, two_pi)) < other_angle;
    } else if (one.motion->kind == Kind::rate) {
      if (!one.rate || is_alike_mirrored(one)) continue;
      mirrored = one.rate->steady && shows(one, -one.motion->value);
    } else {
      continue;  // a phase may be any
    }
    if (!mirrored) return nullptr;
    if (first == nullptr || first->stands()) first = &one;
  }
  return first;
}

/// The relative departure that all rates have in common [1]: a clock, an encoder, a drive that is off. 0: none is seen.
double common_departure(const AxisRecord& axis, const std::vector<Observed>& all) {
  double weights = 0.0, sum = 0.0;
  for (const Observed& one : all) {
    if (one.motion->kind != Kind::rate || !one.rate || !one.rate->steady) continue;
    if (std::abs(one.relative()) > same_motion) continue;
    const double sd = std::max(one.rate->sd / std::abs(one.motion->value), 1e-12);
    weights += 1.0 / (sd * sd);
    sum += one.relative() / (sd * sd);
  }
  if (weights == 0.0) return 0.0;
  const double beyond = explained * std::hypot(rig_sd(axis.plan, "rate_error_sd"), 1.0 / std::sqrt(weights));
  return std::abs(sum / weights) > beyond ? sum / weights : 0.0;
}

/// What the axis turned faster than the plan says [rad/s], where neither the plan's error of the rate nor the readings
/// explain it; else 0.
double excess_rate(const AxisRecord& axis, const Observed& one, double common) {
  if (one.motion->kind != Kind::rate || !one.rate || !one.rate->steady) return 0.0;
  const double planned = rig_sd(axis.plan, "rate_error_sd") * one.motion->value;
  const double expected = explained * std::hypot(planned, one.rate->sd);
  return std::abs(one.rate->rate) > expected ? one.rate->rate : common * one.motion->value;
}

/// The oscillation as recorded, in place of that of the plan where they differ.
void set_oscillation(const AxisRecord& axis, const Observed& one, Motion& motion, Turned& turned) {
  if (!one.oscillation) return;
  const ShownOscillation& shown = *one.oscillation;
  const double amplitude = shown.amplitude - 1.0, frequency = shown.frequency / motion.frequency - 1.0;
  const double by_rig = explained * std::hypot(rig_sd(axis.plan, "amplitude_sd"), shown.amplitude_sd);
  const double by_readings = explained * shown.frequency_sd / motion.frequency;
  const bool other_amplitude = std::abs(amplitude) > std::max(by_rig, least_departure);
  const bool other_frequency = std::abs(frequency) > std::max(by_readings, least_departure);
  if (other_amplitude) motion.amplitude *= shown.amplitude;
  if (other_frequency) motion.frequency = shown.frequency;
  if (!other_amplitude && !other_frequency) return;
  turned.other = Turned::Other::oscillation;
  turned.departure = other_amplitude && std::abs(amplitude) > std::abs(frequency) ? amplitude : frequency;
  turned.beyond_rig = other_amplitude || std::abs(frequency) > std::hypot(two_clocks, by_readings);
}

/// The motion as recorded, where that is another than the plan's. Given: index [rad] of the encoder beside that of the plan.
Turned recorded_motion(const AxisRecord& axis, const Observed& one, double common, double index) {
  Turned turned{one.segment, axis.encoder.axis};
  const Motion& motion = *one.motion;
  Motion out = motion;
  const double excess = excess_rate(axis, one, common);
  out.value += excess;
  set_oscillation(axis, one, out, turned);
  const auto recorded = phase_of(out, one.readings);
  const auto planned = phase_of(motion, one.planned);
  if (!recorded || !planned) return turned;
  const std::complex<double> wave =
      motion.kind == Kind::sine ? recorded->wave / std::abs(recorded->wave) : recorded->wave;
  const double apart = std::remainder(recorded->from - planned->from - index, two_pi);
  const double off = std::abs(apart) + std::abs(motion.amplitude) * std::abs(wave - planned->wave);
  const bool as_fast = excess == 0.0 && turned.departure == 0.0;
  if (as_fast && !(off > tolerance_of(axis.plan, axis.encoder.axis, one.segment))) return turned;
  // on the turn that the plan has come to
  const double near =
      motion.kind == Kind::sine ? planned->from : one.planned.values.front() - motion.value * one.planned.times.front();
  out.from = near + apart;
  out.lasts = 2.0 * recorded->known_at;
  if (motion.kind == Kind::sine) out.phase = std::arg(wave);
  turned.motion = out;
  if (excess == 0.0) return turned;
  turned.other = Turned::Other::rate;
  turned.departure = excess / motion.value;
  turned.beyond_rig = true;
  return turned;
}

FindingValue shown_as(const char* name, const Motion& motion, double share) {
  if (motion.kind == Kind::rate) return {name, share * motion.value, "deg/s"};
  return {name, share * motion.amplitude, "deg"};
}

/// Whether the axis stood where the plan holds it, and did not turn.
bool is_still(const Observed& stand) {
  return !stand.rate || std::abs(stand.rate->rate) * stand.readings.times.back() < other_angle;
}

/// A motion that the encoder shows otherwise by so much that one of the two is not of this segment.
std::optional<Finding> another_motion_in(const AxisRecord& axis, const Observed& one) {
  const std::string& label = axis.plan.schedule[one.segment].label;
  const auto found = [&](FindingValue recorded, FindingValue planned) {
    return Finding{Severity::error,
                   "another_motion_recorded",
                   {{"segment", label}, {"axis", axis.encoder.axis}, std::move(recorded), std::move(planned)}};
  };
  if (one.stands()) {
    if (is_still(one)) return {};
    return found({"recorded", one.rate->rate, "deg/s"}, {"planned", 0.0, "deg/s"});
  }
  if (one.rate) {
    const double off = std::abs(one.relative());
    if (off < another_motion && (one.rate->steady || off < same_motion)) return {};
    return found(shown_as("recorded", *one.motion, 1.0 + one.relative()), shown_as("planned", *one.motion, 1.0));
  }
  if (!one.oscillation) return {};
  const double amplitude = one.oscillation->amplitude, frequency = one.oscillation->frequency;
  if (std::abs(amplitude - 1.0) > another_motion)
    return found(shown_as("recorded", *one.motion, amplitude), shown_as("planned", *one.motion, 1.0));
  if (std::abs(frequency / one.motion->frequency - 1.0) < another_motion) return {};
  return found({"recorded", frequency, "Hz"}, {"planned", one.motion->frequency, "Hz"});
}

/// Stands of an axis, without those at the place of the one before: it did not move.
struct Stands {
  std::vector<const Observed*> all;
  std::vector<const Observed*> parked;  ///< elsewhere, after the axis turned: many tables stop where they are
  std::vector<double> apart;    ///< of each place [rad]; at the planned angle of the one before it may be another
  double zero = 0.0, sd = 0.0;  ///< of the encoder beside the plan [rad]; of a stand, by the rig

  bool differ() const {
    double squares = 0.0;
    bool one = false;
    for (const double angle : apart) {
      const double off = (angle - zero) / sd;
      squares += off * off;
      one = one || std::abs(off) > explained;
    }
    const auto n = static_cast<double>(apart.size());
    return one || squares > n + explained * std::sqrt(2.0 * n);
  }
};

/// Whether the axis stops where it is after it turned: most of its stands after a rate are elsewhere.
bool parks(const std::vector<Observed>& all) {
  std::size_t stops = 0, elsewhere = 0;
  bool turned = false;
  for (const Observed& one : all) {
    if (turned && one.stands()) ++stops, elsewhere += std::abs(one.apart) > other_angle;
    turned = one.motion->kind == Kind::rate;
  }
  return 2 * elsewhere > stops;
}

Stands stands_in(const Plan& plan, const std::vector<Observed>& all) {
  Stands stands;
  const bool parking = parks(all);
  const Observed* before = nullptr;
  bool turned = false;
  for (const Observed& one : all) {
    if (!one.stands() || !is_still(one)) {
      before = nullptr;
      turned = turned || one.motion->kind == Kind::rate;
      continue;
    }
    if (parking && turned && std::abs(one.apart) > other_angle) {
      stands.parked.push_back(&one);
      continue;
    }
    turned = false;
    stands.all.push_back(&one);
    const bool stayed = before != nullptr && one.motion->value == before->motion->value &&
                        std::abs(one.apart - before->apart) < other_angle;
    if (!stayed) stands.apart.push_back(one.apart);
    before = &one;
  }
  const auto n = static_cast<double>(stands.apart.size());
  const double of_each = std::max(rig_sd(plan, "repeatability_sd"), finest_stand);
  constexpr double of_median = 1.57;  // its variance is pi/2 times that of a mean
  if (stands.apart.size() >= fewest_for_zero) stands.zero = median(stands.apart);
  stands.sd = stands.apart.size() >= fewest_for_zero ? of_each * std::sqrt(1.0 + of_median / n)
                                                     : std::hypot(of_each, rig_sd(plan, "index_zero_sd"));
  return stands;
}

Turned stand_of(const AxisRecord& axis, const Observed& one, double zero, bool beyond_rig) {
  Motion motion = *one.motion;
  motion.value += one.apart - zero;
  return {one.segment, axis.encoder.axis, motion, Turned::Other::angle, one.apart - zero, beyond_rig};
}

/// The angles at which the axis stood, in place of the plan's where they differ beyond what the rig explains.
void add_stands(const AxisRecord& axis, const Stands& stands, AxisFound& found) {
  for (const Observed* one : stands.parked) found.turned.push_back(stand_of(axis, *one, stands.zero, false));
  if (stands.apart.empty() || !stands.differ()) return;
  const auto elsewhere =
      std::ranges::count_if(stands.apart, [&](double apart) { return std::abs(apart - stands.zero) > other_angle; });
  if (static_cast<double>(elsewhere) > most_other_stands * static_cast<double>(stands.apart.size())) {
    const auto worst = std::ranges::max(stands.all, {}, [&](const Observed* one) { return std::abs(one->apart); });
    const double planned = worst->planned.values.front();
    found.findings.push_back({Severity::error,
                              "another_motion_recorded",
                              {{"segment", axis.plan.schedule[worst->segment].label},
                               {"axis", axis.encoder.axis},
                               {"recorded", planned + worst->apart, "deg"},
                               {"planned", planned, "deg"}}});
    return;
  }
  for (const Observed* one : stands.all) found.turned.push_back(stand_of(axis, *one, stands.zero, true));
}

/// An encoder whose zero is beside the plan's by little: it was set, and is off. One of any zero was never set. Angles that a
/// hand sets scatter by more than those of a drive.
void judge_zero(const AxisRecord& axis, const Stands& stands, Findings& findings) {
  std::vector<double> off;
  for (const double apart : stands.apart) off.push_back(std::abs(apart - stands.zero));
  const double scatter = 2.0 * median(off) / std::sqrt(static_cast<double>(std::max<std::size_t>(off.size(), 1)));
  const double sd = std::hypot(rig_sd(axis.plan, "index_zero_sd"), std::max(stands.sd, off.empty() ? 0.0 : scatter));
  if (!(std::abs(stands.zero) > explained * sd)) return;
  findings.push_back({std::abs(stands.zero) < other_angle ? Severity::warning : Severity::info,
                      "encoder_zero_off_plan",
                      {{"axis", axis.encoder.axis}, {"offset", stands.zero, "arcsec"}}});
}

}  // namespace

AxisFound found_of(const AxisRecord& axis, bool with_stands) {
  AxisFound found;
  const auto all = observed(axis);
  if (const Observed* one = reversed_by(all)) {
    const bool rate = one->motion->kind == Kind::rate;
    const double planned = rate ? one->motion->value : one->planned.values.front();
    found.findings.push_back(
        {Severity::error,
         "axis_moves_the_other_way",
         {{"axis", axis.encoder.axis},
          {"segment", axis.plan.schedule[one->segment].label},
          {"recorded", rate ? planned + one->rate->rate : planned + one->apart, rate ? "deg/s" : "deg"},
          {"planned", planned, rate ? "deg/s" : "deg"}}});
    return found;
  }
  const Stands stands = stands_in(axis.plan, all);
  const double common = common_departure(axis, all);
  for (const Observed& one : all) {
    if (auto another = another_motion_in(axis, one))
      found.findings.push_back(std::move(*another));
    else if (!one.stands())
      found.turned.push_back(recorded_motion(axis, one, common, with_stands ? stands.zero : 0.0));
  }
  if (with_stands) add_stands(axis, stands, found);
  judge_zero(axis, stands, found.findings);
  return found;
}

}  // namespace tumble::table
