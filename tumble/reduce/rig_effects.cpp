#include "tumble/reduce/rig_effects.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <tuple>
#include <utility>

#include "tumble/earth/earth.hpp"
#include "tumble/math/rounding_share.hpp"
#include "tumble/rigs/error_names.hpp"

namespace tumble {

std::optional<double> rig_sd(const Plan& plan, std::string_view name) {
  if (plan.rig_kind.empty()) return {};
  for (const auto& error : find_rig(plan.rig_kind).errors(plan.rig, plan.site))
    if (error.name == name) return error.sd;
  return {};
}

std::vector<PlanError> rig_errors(const std::vector<PowerUp>& power_ups) {
  std::vector<PlanError> all;
  std::set<std::size_t> plans;
  for (const auto& power_up : power_ups) {
    if (power_up.plan->rig_kind.empty() || !plans.insert(power_up.plan_number).second) continue;
    const auto errors = find_rig(power_up.plan->rig_kind).errors(power_up.plan->rig, power_up.plan->site);
    for (std::size_t e = 0; e < errors.size(); ++e)
      if (errors[e].sd > 0.0) all.push_back({power_up.plan_number, e, errors.size(), errors[e]});
  }
  return all;
}

std::string name_of(const PlanError& error) {
  return error.plan == 0 ? error.error.name : fmt::format("{} of plan {}", error.error.name, error.plan + 1);
}

Matrix error_values(const PowerUp& power_up, const PlanError& error, const InSegment& chosen) {
  Matrix values(error.count, power_up.rig.segments.size());
  for (std::size_t s = 0; s < values.columns; ++s) values(error.index, s) = chosen(s) ? error.error.sd : 0.0;
  return values;
}

Reference reference_with(const PowerUp& power_up, const PlanError& error, const InSegment& chosen) {
  RigRun run = power_up.rig;
  run.errors = error_values(power_up, error, chosen);
  return find_rig(power_up.plan->rig_kind).reference(run);
}

std::vector<ErrorDraw> draws_of(const std::vector<const ConductedTest*>& channels) {
  std::vector<ErrorDraw> draws;
  std::set<std::pair<std::size_t, std::size_t>> starts;
  for (const ConductedTest* channel : channels)
    for (const auto& stretch : channel->stretches) starts.insert({stretch.power_up, stretch.start});
  const auto& power_ups = channels.front()->power_ups;
  for (const auto& error : rig_errors(power_ups)) {
    if (!error.error.each_segment) draws.push_back({error});
    for (const auto& [power_up, start] : starts)
      if (error.error.each_segment && power_ups[power_up].plan_number == error.plan)
        for (std::size_t s = 0; s < power_ups[power_up].rig.segments.size(); ++s)
          draws.push_back({error, ErrorDraw::Segment{power_up, s, start}});
  }
  return draws;
}

namespace {

constexpr double effect_rounding = 1e-13;  ///< [1] of an output, below which the effect of an error is rounding
constexpr double whole_share = 0.1;        ///< [1] within which the share of an effect is all, or none

bool everywhere(std::size_t) { return true; }

/// Rows of each output [SI].
using Columns = std::vector<std::vector<double>>;

/// The observation on every row; differences of it are the effects.
class Difference {
 public:
  Difference(const ConductedTest& test, const Observation& observation) : test_(test), observation_(observation) {
    for (std::size_t row = 0; row < observation.stretch.size(); ++row) {
      const std::size_t g = observation.stretch[row];
      if (row == 0 || observation.stretch[row - 1] != g) parts_.push_back({g, row, row});
      parts_.back().end = row + 1;
    }
    find_repeated();
    for (const Detail detail : {Detail::full, Detail::coarse}) {
      auto& without = without_[static_cast<std::size_t>(detail)];
      without = no_rows();
      for (const auto& part : parts_)
        if (!copied(part, without)) add(power_up_of(part).reference, part, detail, without);
    }
    for (const auto& rows : without_[0]) {
      size_.push_back(0.0);
      for (const double v : rows) size_.back() = std::max(size_.back(), std::abs(v));
    }
  }

  /// The shift where the error is at its standard deviation in the segments (of each power-up) chosen.
  Columns of(const PlanError& error, Detail detail, const InSegment& chosen) const {
    std::vector<std::optional<Reference>> references(test_.power_ups.size());
    Columns shift = no_rows();
    for (const auto& part : parts_) {
      if (power_up_of(part).plan_number != error.plan || copied(part, shift)) continue;
      auto& reference = references[test_.stretches[part.stretch].power_up];
      if (!reference) reference = reference_with(power_up_of(part), error, chosen);
      add(*reference, part, detail, shift);
      for (std::size_t k = 0; k < shift.size(); ++k)
        for (std::size_t row = part.begin; row < part.end; ++row)
          shift[k][row] -= without_[static_cast<std::size_t>(detail)][k][row];
    }
    return shift;
  }

  /// The shift of a total of one output, which is one row, by the draw of one segment.
  double of_total(const PlanError& error, std::size_t output, std::size_t row, std::size_t segment) const {
    const Stretch& stretch = test_.stretches[observation_.stretch[row]];
    const PowerUp& power_up = test_.power_ups[stretch.power_up];
    if (power_up.plan_number != error.plan) return 0.0;
    const Reference reference = reference_with(power_up, error, [=](std::size_t s) { return s == segment; });
    std::vector<double> with(outputs(), 0.0);
    std::vector<std::span<double>> rows;
    for (double& one : with) rows.emplace_back(&one, 1);
    observation_.add(reference, observation_.stretch[row], Detail::full, rows);
    return with[output] - without_[0][output][row];
  }

  std::size_t outputs() const { return observation_.outputs; }
  bool is_total(std::size_t stretch) const { return observation_.is_total && observation_.is_total(stretch); }
  bool any_total() const {
    return std::ranges::any_of(parts_, [this](const Part& part) { return is_total(part.stretch); });
  }
  bool rounding(std::size_t output, double shift) const { return std::abs(shift) <= effect_rounding * size_[output]; }
  bool rounding(std::size_t output, const std::vector<double>& shift) const {
    return std::ranges::all_of(shift, [&](double v) { return rounding(output, v); });
  }

 private:
  /// The rows of one stretch.
  struct Part {
    std::size_t stretch = 0, begin = 0, end = 0;
    std::size_t first = 0;  ///< row of the first part whose rows are the same; `begin` where it is this one
  };

  /// Power-ups that repeat one have its rows, once the rig was asked for the first.
  void find_repeated() {
    const auto alike = first_alike(test_);
    for (auto& part : parts_) {
      part.first = part.begin;
      const auto found = std::ranges::find(parts_, alike[part.stretch], &Part::stretch);
      if (found != parts_.end() && found->end - found->begin == part.end - part.begin) part.first = found->begin;
    }
  }
  /// Whether the rows of a part were those of an earlier one, which they now are.
  static bool copied(const Part& part, Columns& columns) {
    if (part.first == part.begin) return false;
    for (auto& column : columns)
      std::copy_n(column.begin() + static_cast<std::ptrdiff_t>(part.first), part.end - part.begin,
                  column.begin() + static_cast<std::ptrdiff_t>(part.begin));
    return true;
  }

  Columns no_rows() const { return Columns(outputs(), std::vector<double>(observation_.stretch.size(), 0.0)); }
  const PowerUp& power_up_of(const Part& part) const { return test_.power_ups[test_.stretches[part.stretch].power_up]; }
  void add(const Reference& reference, const Part& part, Detail detail, Columns& columns) const {
    std::vector<std::span<double>> rows;
    for (auto& column : columns) rows.push_back(std::span(column).subspan(part.begin, part.end - part.begin));
    observation_.add(reference, part.stretch, detail, rows);
  }

  const ConductedTest& test_;
  const Observation& observation_;
  std::vector<Part> parts_;
  std::vector<double> size_;        ///< of each output
  std::array<Columns, 2> without_;  ///< by Detail
};

/// Which segment's error moves each stretch, as one output shows it.
class Drivers {
 public:
  explicit Drivers(std::size_t stretches) : drivers_(stretches, 0), clear_(stretches, true) {}

  /// Given     all, some  shifts of the rows by the error in all segments, and in those whose number has this bit
  void add(std::size_t bit, const Observation& observation, const std::vector<double>& all,
           const std::vector<double>& some) {
    std::vector<double> product(drivers_.size(), 0.0), square(drivers_.size(), 0.0);
    for (std::size_t i = 0; i < all.size(); ++i) {
      product[observation.stretch[i]] += some[i] * all[i];
      square[observation.stretch[i]] += all[i] * all[i];
    }
    for (std::size_t g = 0; g < drivers_.size(); ++g) {
      const double share = square[g] > 0.0 ? product[g] / square[g] : 0.0;
      if (std::abs(share - 1.0) < whole_share)
        drivers_[g] |= std::size_t{1} << bit;
      else if (std::abs(share) > whole_share)
        clear_[g] = false;
    }
  }

  /// Of each stretch: the segment; its own where several move it.
  std::vector<std::size_t> of(const ConductedTest& test) const {
    std::vector<std::size_t> drivers = drivers_;
    for (std::size_t g = 0; g < drivers.size(); ++g)
      if (!clear_[g]) drivers[g] = test.stretches[g].segment;
    return drivers;
  }

 private:
  std::vector<std::size_t> drivers_;
  std::vector<bool> clear_;
};

/// Which segment's error moves each stretch, for each output: an angle that is gone to once stays wrong until the next.
/// The bits of their numbers distinguish the segments, one look at the rig a bit.
std::vector<Drivers> drivers_of(const ConductedTest& test, const Observation& observation, const Difference& difference,
                                const PlanError& error) {
  const auto all = difference.of(error, Detail::coarse, everywhere);
  std::size_t most = 0;
  for (const auto& power_up : test.power_ups) most = std::max(most, power_up.rig.segments.size());
  std::vector<Drivers> drivers(difference.outputs(), Drivers(test.stretches.size()));
  for (std::size_t bit = 0; (most >> bit) > 0; ++bit) {
    const auto some =
        difference.of(error, Detail::coarse, [bit](std::size_t segment) { return ((segment >> bit) & 1) != 0; });
    for (std::size_t k = 0; k < drivers.size(); ++k) drivers[k].add(bit, observation, all[k], some[k]);
  }
  return drivers;
}

/// One draw of an error that is drawn anew for each segment: the rows it shifts.
struct Shifted {
  std::vector<std::size_t> stretches;                  ///< shifted as by all draws together
  std::vector<std::pair<std::size_t, double>> totals;  ///< rows that are totals, and the shift
};

/// By power-up, start and segment.
using DrawKey = std::tuple<std::size_t, std::size_t, std::size_t>;

/// A move from rest to rest is shifted by the draw of its own angle and by that of the angle it begins at.
void add_totals(const ConductedTest& test, const Observation& observation, const Difference& difference,
                const PlanError& error, std::size_t output, std::map<DrawKey, Shifted>& draws) {
  for (std::size_t row = 0; row < observation.stretch.size(); ++row) {
    if (!difference.is_total(observation.stretch[row])) continue;
    const Stretch& stretch = test.stretches[observation.stretch[row]];
    for (std::size_t segment = stretch.segment + 1, earlier = 0; segment-- > 0 && earlier == 0;) {
      const double shift = difference.of_total(error, output, row, segment);
      if (difference.rounding(output, shift)) continue;
      draws[{stretch.power_up, stretch.start, segment}].totals.emplace_back(row, shift);
      if (segment < stretch.segment) ++earlier;
    }
  }
}

std::string draw_name(const ConductedTest& test, const PlanError& error, const Stretch& stretch, std::size_t segment) {
  const auto& segments = test.power_ups[stretch.power_up].rig.segments;
  const std::string again = stretch.repetition == 0 ? "" : fmt::format(", repetition {}", stretch.repetition);
  return fmt::format("{}, segment '{}' ({} of power-up {}, run {}{})", name_of(error), segments[segment].label,
                     segment + 1, stretch.power_up + 1, stretch.run, again);
}

/// The shift of one output by an error drawn anew for each segment. Stretches moved by one and the same draw share a
/// column; the others have draws of their own.
void add_each_segment(const ConductedTest& test, const Observation& observation, const Difference& difference,
                      const PlanError& error, std::size_t output, const std::vector<std::size_t>& drivers,
                      const std::vector<double>& all, std::vector<KnownEffect>& effects) {
  std::map<DrawKey, Shifted> draws;
  std::map<std::pair<std::size_t, std::size_t>, const Stretch*> starts;
  KnownEffect own{error.error.name, all, true};
  for (std::size_t g = 0; g < drivers.size(); ++g) {
    const auto& stretch = test.stretches[g];
    starts.try_emplace({stretch.power_up, stretch.start}, &stretch);
    if (!difference.is_total(g)) draws[{stretch.power_up, stretch.start, drivers[g]}].stretches.push_back(g);
    own.draws.push_back(draw_name(test, error, stretch, difference.is_total(g) ? stretch.segment : drivers[g]));
  }
  for (std::size_t i = 0; i < all.size(); ++i)
    if (difference.is_total(observation.stretch[i])) own.column[i] = 0.0;
  add_totals(test, observation, difference, error, output, draws);
  for (const auto& [key, draw] : draws) {
    if (draw.stretches.size() < 2 && draw.totals.empty()) continue;
    const auto& [power_up, start, driver] = key;
    KnownEffect shared{error.error.name,
                       std::vector<double>(all.size(), 0.0),
                       false,
                       {draw_name(test, error, *starts.at({power_up, start}), driver)}};
    for (std::size_t i = 0; i < all.size(); ++i)
      if (std::ranges::find(draw.stretches, observation.stretch[i]) != draw.stretches.end())
        std::swap(shared.column[i], own.column[i]);
    for (const auto& [row, shift] : draw.totals) shared.column[row] = shift;
    if (!difference.rounding(output, shared.column)) effects.push_back(std::move(shared));
  }
  if (!difference.rounding(output, own.column)) effects.push_back(std::move(own));
}

/// How the instrument was mounted is an error of this test alone, gravity and latitude are errors of the site.
bool belongs_to_rig(const std::string& name) {
  namespace names = error_names;
  constexpr std::array<std::string_view, 11> others{
      names::lever_x, names::lever_y, names::lever_z, names::mounting_x, names::mounting_y, names::mounting_z,
      names::pose_x,  names::pose_y,  names::pose_z,  names::gravity,    names::latitude};
  return std::ranges::find(others, name) == others.end();
}

}  // namespace

std::string gravity_key(double gravity) { return fmt::format("gravity {:.12g} m/s^2", gravity); }

std::string latitude_key(double latitude) { return fmt::format("latitude {:.12g} rad", latitude); }

std::string key_of(const ConductedTest& test, const PlanError& error) {
  const auto with_plan = [&](const PowerUp& power_up) { return power_up.plan_number == error.plan; };
  const Plan& plan = *std::ranges::find_if(test.power_ups, with_plan)->plan;
  if (error.error.name == error_names::gravity) return plan.site ? gravity_key(gravity(*plan.site)) : "";
  if (error.error.name == error_names::latitude) return plan.site ? latitude_key(plan.site->latitude) : "";
  return belongs_to_rig(error.error.name) ? plan.rig_equipment : "";
}

namespace {

/// An error of one plan, with its standard deviation.
struct Keyed {
  KnownEffect effect;
  double sd = 0.0;
};

/// Plans that share a key share the error: its shifts in the one and in the other are by one draw. Where they state
/// different standard deviations for it, they do not speak of the same error, and each is independent.
void add(Keyed one, std::vector<Keyed>& all) {
  const auto shared = std::ranges::find_if(all, [&](const Keyed& other) {
    return !one.effect.key.empty() && other.effect.key == one.effect.key && other.effect.source == one.effect.source;
  });
  if (shared != all.end() && std::abs(shared->sd - one.sd) <= rounding_share * shared->sd) {
    for (std::size_t i = 0; i < one.effect.column.size(); ++i) shared->effect.column[i] += one.effect.column[i];
    return;
  }
  if (shared != all.end()) one.effect.key.clear();
  all.push_back(std::move(one));
}

}  // namespace

std::vector<std::vector<KnownEffect>> rig_effects(const ConductedTest& test, const Observation& observation) {
  const Difference difference(test, observation);
  const auto errors = rig_errors(test.power_ups);
  const bool totals = difference.any_total();
  using Effects = std::vector<KnownEffect>;
  std::vector<std::vector<Effects>> by_error(errors.size(), std::vector<Effects>(observation.outputs));
  parallel_for(errors.size(), [&](std::size_t e) {
    const bool each_segment = errors[e].error.each_segment;
    auto all = difference.of(errors[e], Detail::full, everywhere);
    std::optional<std::vector<Drivers>> drivers;
    for (std::size_t k = 0; k < observation.outputs; ++k) {
      if (difference.rounding(k, all[k]) && !(each_segment && totals)) continue;
      if (each_segment) {
        if (!drivers) drivers = drivers_of(test, observation, difference, errors[e]);
        add_each_segment(test, observation, difference, errors[e], k, (*drivers)[k].of(test), all[k], by_error[e][k]);
      } else {
        by_error[e][k].push_back(
            {errors[e].error.name, std::move(all[k]), false, {name_of(errors[e])}, key_of(test, errors[e])});
      }
    }
  });
  std::vector<Effects> effects(observation.outputs);
  for (std::size_t k = 0; k < observation.outputs; ++k) {
    std::vector<Keyed> all_errors;
    for (std::size_t e = 0; e < errors.size(); ++e)
      for (auto& effect : by_error[e][k]) add({std::move(effect), errors[e].error.sd}, all_errors);
    for (auto& one : all_errors) effects[k].push_back(std::move(one.effect));
  }
  return effects;
}

}  // namespace tumble
