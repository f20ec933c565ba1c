#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "tumble/clocks/stamp_slack.hpp"
#include "tumble/math/golden_section.hpp"
#include "tumble/reduce/linear/boundaries.hpp"
#include "tumble/reduce/linear/rows.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::linear {

double quickest(const Segment& segment) {
  double quickest = 0.0;
  for (const auto& [name, motion] : segment.axes) {
    quickest = std::max({quickest, motion.frequency, motion.to_frequency});
    if (motion.kind == Motion::Kind::rate || motion.kind == Motion::Kind::slew)
      quickest = std::max(quickest, std::abs(motion.value) / two_pi);
    for (const double f : motion.psd_frequency) quickest = std::max(quickest, f);
  }
  return quickest;
}

namespace {

constexpr double hardly = 1e-4;  ///< [1] of the input of a segment, by which it hardly changes
/// [1] of the quickest motion, that an average takes at most: its mean is off by 1.6 %.
constexpr double part_of_period = 0.1;

/// Whether the segment is one that Problem::whole_moves speaks of, by the kind of motion.
bool moves(const Segment& segment, Motion::Kind kind) {
  return std::ranges::any_of(segment.axes,
                             [&](const auto& axis) { return axis.second.kind == kind && axis.second.value != 0.0; });
}

bool slews(const Segment& segment) { return moves(segment, Motion::Kind::slew); }

/// Blocks of a steady stretch: the least number that shows its noise, and one that is enough to distinguish white noise
/// from the rounding to whole pulses.
constexpr std::size_t least_blocks = 4, counted_blocks = 32;

/// Whether what is felt stays within 1e-4 of its mean while the rig turns: on the arm of a centrifuge.
bool hardly_changes(const PowerUp& power_up, const Stretch& stretch) {
  constexpr std::size_t instants = 16;
  const double length = stretch.duration();
  Felt first;
  for (std::size_t k = 0; k < instants; ++k) {
    Felt felt;
    const double share = golden_fraction(k, 0.5);
    power_up.reference.felt(stretch.first + share * length, stretch.step, std::span(&felt, 1));
    if (k == 0) first = felt;
    if (norm(felt.specific_force - first.specific_force) > hardly * norm(first.specific_force) ||
        norm(felt.rate - first.rate) > hardly * norm(first.rate))
      return false;
  }
  return true;
}

/// How many samples make a block, and whether the rig turns so evenly that they are averaged as at rest.
Blocking blocking_of(const PowerUp& power_up, const Problem& problem, const Stretch& stretch) {
  Blocking out;
  out.even = (problem.even_averages || problem.pulse > 0.0) && !stretch.steady && hardly_changes(power_up, stretch);
  double length = problem.averaging;
  if (!stretch.steady && !out.even)
    if (const double f = quickest(power_up.rig.segments[stretch.segment]); f > 0.0)
      length = std::min(length, part_of_period / f);
  const auto wanted = std::max<std::size_t>(1, static_cast<std::size_t>(std::llround(length / stretch.step)));
  std::size_t blocks = std::max<std::size_t>(1, stretch.samples / wanted);
  if (problem.pulse > 0.0 && (stretch.steady || out.even)) blocks = std::min(blocks, counted_blocks);
  if (stretch.steady) blocks = std::max(blocks, std::min(least_blocks, stretch.samples));
  out.per_block = (stretch.samples + blocks - 1) / blocks;
  return out;
}

/// Where the rate is kept, as many whole turns as the samples hold.
void trim_to_turns(const Segment& segment, Stretch& stretch) {
  const double turn = longest_turn(segment), turns = std::floor(stretch.duration() / turn + 1e-9);
  const auto samples = static_cast<std::size_t>(std::llround(turns * turn / stretch.step));
  stretch.samples = std::min(stretch.samples, samples);
  if (!stretch.values.empty()) stretch.values.shorten(stretch.samples);
}

/// Makes one block of a move that is used as a total. Returned: key in [phrase] of the reason why it cannot; else
/// empty.
std::string make_whole(const PowerUp& power_up, const Problem& problem, Stretch& stretch, Blocking& blocking) {
  const Segment& segment = power_up.rig.segments[stretch.segment];
  const bool slew = slews(segment);
  if (!problem.whole_moves || !(slew || moves(segment, Motion::Kind::rate))) return "";
  if (!slew) trim_to_turns(segment, stretch);
  if (stretch.samples == 0) return "less_than_one_turn";
  const double end = stretch.first + stretch.duration();
  const auto rests_at = [&](double time) {
    const auto& until = power_up.reference.steady_until;
    return time <= 0.0 || !until || until(time) > time;
  };
  const double slack = stamp_slack(std::abs(stretch.begin) + stretch.first, stretch.step);
  if (slew && (!rests_at(stretch.first - slack) || power_up.reference.settled[stretch.segment] > end + slack))
    return "not_from_rest_to_rest";
  if (std::ranges::any_of(stretch.values, [](double v) { return std::isnan(v); })) return "samples_missing_in_move";
  stretch.steady = false;
  blocking = {.per_block = stretch.samples,
              .instants = instants_of(power_up.reference, stretch.first, end, quickest(segment))};
  return "";
}

/// Whether an axis of the segment moves.
bool does_move(const Segment& segment) {
  return std::ranges::any_of(segment.axes, [](const auto& axis) {
    return axis.second.kind != Motion::Kind::hold && axis.second.kind != Motion::Kind::dwell;
  });
}

/// `scale` is one for all recordings: a rate here and a current there would be taken for the same.
void refuse_unlike_units(const Evidence& evidence, const Problem& problem) {
  const Channel& first = require_channel(evidence, evidence.recordings.front(), problem.role);
  Problems problems;
  for (const auto& recording : evidence.recordings) {
    const Channel& channel = require_channel(evidence, recording, problem.role);
    if (channel.unit.dimension() == first.unit.dimension()) continue;
    problems.push_back(
        say("{}: channel '{}' is in {}, but in {} it is in {}: recordings of one fit must hold "
            "the same quantity",
            Name{recording.origin.file}, channel.name, Name{channel.unit.text()},
            Name{evidence.recordings.front().origin.file}, Name{first.unit.text()}));
  }
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
}

/// A unit that is dead, or not connected. A single position may well give the same count in every sample.
void refuse_constant(const Evidence& evidence, const Problem& problem) {
  double some = std::nan("");
  for (const auto& recording : evidence.recordings)
    for (const double v : require_channel(evidence, recording, problem.role).values) {
      if (std::isnan(v) || v == some) continue;
      if (!std::isnan(some)) return;
      some = v;
    }
  if (std::isnan(some)) return;
  const auto& first = evidence.recordings.front();
  const std::string& name = require_channel(evidence, first, problem.role).name;
  throw Error(Error::Kind::bad_data,
              in_file(first.origin.file, say("channel '{}' holds the same value throughout", name)));
}

constexpr double gaps_of_cut = 5.0;    ///< a segment whose values decided which samples are there has so many at least
constexpr double share_of_cut = 10.0;  ///< [1] of the share that the other segments miss

/// Samples that a segment misses.
struct Missing {
  double gaps = 0.0, share = 0.0;
  double most = -INFINITY;  ///< its greatest value, with the sign of the side that is looked at
};

Missing missing_in(const Stretch& stretch, double side) {
  Missing missing;
  double before = 0.0;
  for (const double v : stretch.values) {
    missing.share += std::isnan(v) ? 1.0 / static_cast<double>(stretch.samples) : 0.0;
    missing.gaps += std::isnan(v) && !std::isnan(before) ? 1.0 : 0.0;
    if (!std::isnan(v)) missing.most = std::max(missing.most, side * v);
    before = v;
  }
  return missing;
}

/// Takes a segment out of which a limit has cut the largest values (side: 1) or the smallest ones (-1): it reaches farthest,
/// and misses samples one by one where the others miss few. The mean of the rest is none of the segment.
void take_cut_out(double side, ConductedTest& test) {
  std::vector<Missing> all;
  double shares = 0.0;
  for (const Stretch& stretch : test.stretches) {
    all.push_back(missing_in(stretch, side));
    shares += all.back().share;
  }
  const auto farthest = std::ranges::max_element(all, {}, &Missing::most);
  const double others = (shares - farthest->share) / static_cast<double>(all.size() - 1);
  if (farthest->gaps < gaps_of_cut || farthest->share < share_of_cut * others) return;
  const auto cut = test.stretches.begin() + (farthest - all.begin());
  test.findings.push_back(unused_segment(cut->label, cut->run, {"values_cut_out"}));
  test.stretches.erase(cut);
}

StretchOptions options_of(const Problem& problem) {
  StretchOptions options{.role = problem.role,
                         .scale = problem.scale,
                         .oversampling = problem.oversampling,
                         .settling = problem.settling,
                         .needs_site = problem.needs_site};
  if (problem.rests_only) options.passed_over = does_move;
  if (problem.whole_moves) options.unsettled = slews;
  return options;
}

/// The stretches in blocks; those that cannot be used give way to a finding.
Evidences in_blocks(ConductedTest test, const Problem& problem, Error::Kind kind) {
  Evidences out{std::move(test), {}};
  std::vector<Stretch> all = std::exchange(out.test.stretches, {});
  for (auto& stretch : all) {
    const PowerUp& power_up = out.test.power_ups[stretch.power_up];
    Blocking blocking = blocking_of(power_up, problem, stretch);
    const auto why = make_whole(power_up, problem, stretch, blocking);
    if (!why.empty()) {
      out.test.findings.push_back(unused_segment(stretch.label, stretch.run, {why}));
      continue;
    }
    out.test.stretches.push_back(std::move(stretch));
    out.blocking.push_back(std::move(blocking));
  }
  refuse_unused(out.test, kind);
  return out;
}

}  // namespace

Evidences evidence_of(const Plan& plan, const Problem& problem) {
  return in_blocks(stretches(plan, options_of(problem)), problem, Error::Kind::bad_input);
}

Evidences evidence_of(const Evidence& evidence, const Problem& problem) {
  if (!evidence.recordings.empty()) refuse_unlike_units(evidence, problem);
  refuse_constant(evidence, problem);
  ConductedTest test = stretches(evidence, options_of(problem));
  for (auto& finding : about_boundaries(test, problem.role)) test.findings.push_back(std::move(finding));
  for (const double side : {1.0, -1.0})
    if (test.stretches.size() > 2) take_cut_out(side, test);
  return in_blocks(std::move(test), problem, Error::Kind::bad_data);
}

}  // namespace tumble::linear
