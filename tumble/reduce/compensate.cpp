#include "tumble/reduce/compensate.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tumble/checks/check.hpp"
#include "tumble/clocks/sampling_rate.hpp"
#include "tumble/core/roles.hpp"
#include "tumble/reduce/compensation/before_after.hpp"
#include "tumble/reduce/compensation/inputs.hpp"
#include "tumble/reduce/compensation/outputs.hpp"
#include "tumble/reduce/compensation/samples.hpp"
#include "tumble/reduce/compensation/solve.hpp"
#include "tumble/reduce/compensation/work.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

using compensation::Inputs;
using compensation::shown_by;
using compensation::Slot;
using compensation::UsedTerm;
using compensation::Work;
using compensation::Works;

/// Where the input of a slot comes from; empty: it is missing.
std::string source_of(const Inputs& known, const Recording& recording, const Works& works, const Work& work,
                      const std::vector<Slot>& slots, std::size_t slot) {
  const std::size_t base = slots[slot].base == SIZE_MAX ? slot : slots[slot].base, by = shown_by(works, base);
  if (by == works.size()) return known.from[base];
  return &works[by] == &work ? "the channel itself" : "channel " + recording.channels[works[by].place].name;
}

/// Terms whose inputs are all known, and the others with what they add to the uncertainty.
void sort_terms(const Inputs& known, const Works& works, const Recording& recording, const std::vector<Slot>& slots,
                std::vector<UsedTerm> terms, Work& work) {
  for (std::size_t j = 0; j < terms.size(); ++j) {
    UsedTerm& used = terms[j];
    for (const std::size_t slot : used.slots) {
      const std::string from = source_of(known, recording, works, work, slots, slot);
      (from.empty() ? used.missing : used.from).insert(from.empty() ? name_of(slots[slot]) : from);
      const std::size_t by = shown_by(works, slot);
      if (by < works.size() && &works[by] != &work && std::ranges::find(work.others, by) == work.others.end())
        work.others.push_back(by);
    }
    used.remains = work.model->terms[j].remains;
    const bool stays = !used.missing.empty() || used.remains;
    const double middle = 0.5 * (used.least + used.greatest), width = used.greatest - used.least;
    const double variance =
        used.parameter == SIZE_MAX ? 0.0 : work.estimate->covariance(used.parameter, used.parameter);
    if (stays)
      work.staying_variance += (used.coefficient * used.coefficient + variance) *
                               (middle * middle + width * width / 12.0) /
                               (used.per_output ? work.scale_factor * work.scale_factor : 1.0);
    (stays ? work.staying : work.terms).push_back(std::move(used));
  }
  sort_by_slots(work, slots.size());
}

/// Of an output of whose model nothing is known without inputs that are missing, nothing can be subtracted.
void refuse_without_inputs(const Recording& recording, const Works& works) {
  Problems problems;
  for (const Work& work : works) {
    std::set<std::string> missing;
    for (const UsedTerm& used : work.staying)
      if (!used.remains) missing.insert(used.missing.begin(), used.missing.end());
    if (missing.empty() || !work.terms.empty() || work.model->scale || work.model->offset) continue;
    problems.push_back(
        say("every term of the error model of {} needs what neither a channel nor a plan states, {}: name the "
            "channels in [channels], or give the plan by --plan",
            Name{work.model->role}, fmt::join(missing, ", ")));
  }
  compensation::refuse(recording, problems);
}

/// Value of a parameter that the model cannot do without; `otherwise` where it names none.
double value_of(const Estimate& estimate, const std::optional<std::size_t>& index, double otherwise) {
  if (!index) return otherwise;
  const Parameter& parameter = estimate.parameters.at(*index);
  if (!std::isfinite(parameter.value))
    throw Error(Error::Kind::bad_file, say("the result's parameter '{}' has no value", parameter.name));
  return parameter.value;
}

void set_parameters(Work& work) {
  const OutputModel& model = *work.model;
  work.scale_factor = value_of(*work.estimate, model.scale, 1.0);
  if (work.scale_factor == 0.0)
    throw Error(Error::Kind::bad_file,
                say("the result's parameter '{}' has no value", work.estimate->parameters[*model.scale].name));
  work.offset = value_of(*work.estimate, model.offset, 0.0);
  work.delay = value_of(*work.estimate, model.delay, 0.0);
  work.spread_variance = std::pow(value_of(*work.estimate, model.spread, 0.0), 2) + std::pow(model.misfit, 2);
}

/// Factor [1 or Hz] from a channel to its quantity: as it is, or the integral of it over each sample. Nothing where
/// it is neither.
std::optional<double> each_second(const Channel& channel, const Unit& wanted) {
  if (channel.unit.dimension() == wanted.dimension()) return 1.0;
  const auto rate = Unit::parse(fmt::format("({})/s", channel.unit.text())).dimension();
  if (rate == wanted.dimension()) return sampling_rate(channel);
  return std::nullopt;
}

void set_reading(Work& work, const Channel& channel, Problems& problems) {
  const OutputModel& model = *work.model;
  if (const auto recorded = each_second(channel, model.recorded))
    work.reading = *recorded * model.nominal;
  else if (const auto shown = each_second(channel, model.unit); shown && !model.scale)
    work.reading = *shown;
  else
    problems.push_back(say("channel {} is in {}, but was calibrated in {}", Name{channel.name},
                           Name{channel.unit.text()}, Name{model.recorded.text()}));
}

/// The channel of an output. Where a result has one output and no channel plays its role, the only one of its kind.
const Channel* output_channel(const Estimate& estimate, const Recording& recording, const OutputModel& model) {
  if (const Channel* channel = channel_of(estimate, recording, model.role)) return channel;
  if (estimate.models.size() > 1) return nullptr;
  std::vector<const Channel*> all;
  for (const Channel& channel : recording.channels)
    if (channel.kind == kind_of(model.unit) && channel.unit.dimension() == model.unit.dimension() &&
        !channel.name.ends_with(".compensation_sd"))
      all.push_back(&channel);
  return all.size() == 1 ? all.front() : nullptr;
}

bool is_rate(const OutputModel& model) { return static_cast<std::size_t>(model.shows) < 3; }

/// The outputs that the recording holds, and what others of them need. Of several kinds one may be missing: it is said.
std::vector<const OutputModel*> recorded_outputs(const Estimate& estimate, const Recording& recording,
                                                 Findings& findings) {
  const auto present = [&](const OutputModel& model) { return output_channel(estimate, recording, model) != nullptr; };
  std::vector<const OutputModel*> wanted;
  for (const bool rates : {false, true}) {
    std::vector<const OutputModel*> kind;
    for (const OutputModel& model : estimate.models)
      if (is_rate(model) == rates) kind.push_back(&model);
    if (kind.empty()) continue;
    if (std::ranges::any_of(kind, [&](const OutputModel* model) { return present(*model); }))
      wanted.insert(wanted.end(), kind.begin(), kind.end());
    else if (std::ranges::any_of(estimate.models, present))
      findings.push_back({Finding::Severity::info, rates ? "no_gyros_recorded" : "no_accelerometers_recorded", {}});
  }
  if (wanted.empty())
    for (const OutputModel& model : estimate.models) wanted.push_back(&model);
  if (std::ranges::any_of(wanted, [&](const OutputModel* model) { return present(*model); }))
    std::erase_if(wanted, [&](const OutputModel* model) {
      return !present(*model) && std::ranges::none_of(wanted, [&](const OutputModel* other) {
        return other != model && compensation::needs(*other, model->shows);
      });
    });
  return wanted;
}

/// The channels of all outputs, sampled together. Throws Error::bad_data with all that is wrong.
void set_places(const Recording& recording, Works& works) {
  Problems problems;
  for (Work& work : works) {
    const Channel* own = output_channel(*work.estimate, recording, *work.model);
    if (!compensation::usable_output(own, recording, work.model->role, problems)) continue;
    work.place = static_cast<std::size_t>(own - recording.channels.data());
    const Channel& first = recording.channels[works.front().place];
    set_reading(work, *own, problems);
    if (problems.empty() && !sampled_together(first, *own))
      problems.push_back(say("channels {} and {} are not sampled together: bring them to one clock first",
                             Name{first.name}, Name{own->name}));
  }
  compensation::refuse(recording, problems);
}

/// The output in the unit of u, and with a delay what it shows at each time instead of what it showed then.
void set_channels(Recording& recording, Work& work) {
  Channel& channel = recording.channels[work.place];
  if (work.delay != 0.0 && !channel.values.empty()) {
    const double first = channel.time(0), last = channel.time(channel.values.size() - 1);
    for (std::size_t i = 0; i < channel.values.size(); ++i) {
      const double time = channel.time(i) + work.delay;
      work.late.push_back(time < first || time > last ? std::nan("") : compensation::value_at(channel, time));
    }
  }
  const Unit& unit = work.model->unit;
  channel.unit = channel.unit.dimension() == unit.dimension() && !work.model->scale ? channel.unit : unit;
  channel.kind = kind_of(channel.unit);
  work.trust = compensation::trust_in(channel);
}

Works works_of(const Estimate& estimate, const std::vector<const OutputModel*>& models) {
  Works works;
  for (const OutputModel* model : models) {
    Work& work = works.emplace_back();
    work.model = model;
    work.estimate = &estimate;
    work.shown = static_cast<std::size_t>(model->shows);
    set_parameters(work);
  }
  return works;
}

/// The first output whose temperatures are read as a thermal model wants, else the first.
const Work& thermal_first(const Works& works) {
  const auto match = std::ranges::find_if(works, [](const Work& work) { return work.model->thermal.has_value(); });
  return match == works.end() ? works.front() : *match;
}

void finish(Works& works, const Recording& raw, Compensation& out) {
  out.tables.push_back(compensation::before_and_after(works, raw, out.recording));
  for (Work& work : works) {
    const Channel& channel = out.recording.channels[work.place];
    for (const auto& code : work.model->caveats)
      out.findings.push_back({Finding::Severity::warning, code, {{"channel", channel.name}}, channel.name});
    say_staying(work, channel.name, out.findings);
    tell(work.counts, channel.name, out.findings);
    out.tables.push_back(
        subtracted(work, works.size() > 1 ? "subtracted_" + work.model->role : "subtracted", channel.unit));
    out.recording.channels.push_back(std::move(work.trust.sd));
    out.recording.channels.push_back(std::move(work.trust.extrapolated));
  }
}

/// What is wrong with samples as such. That a flight has gusts and stops is no fault of it.
constexpr std::array<std::string_view, 5> checks_of_samples{"backward_stamps", "duplicate_stamps", "gaps",
                                                            "missing_samples", "saturation"};

void add_faults_of_samples(const Recording& recording, const Plan* plan, Findings& findings) {
  for (const Check* check : check_catalogue())
    if (std::ranges::find(checks_of_samples, std::string_view(check->name)) != checks_of_samples.end())
      for (auto& finding : check->run(recording, plan)) findings.push_back(std::move(finding));
}

}  // namespace

const Channel* channel_of(const Estimate& estimate, const Recording& recording, const std::string& role) {
  const auto given = estimate.provenance.settings.find("channels." + role);
  const auto names = names_of_role(role);
  const bool by_role =
      given == estimate.provenance.settings.end() || std::ranges::find(names, given->second) != names.end();
  return by_role ? find_role(recording, role) : find_channel(recording, given->second);
}

Compensation compensate(const Estimate& estimate, const Recording& recording, const Plan* plan) {
  if (estimate.models.empty())
    throw Error(Error::Kind::unsupported,
                say("{} identifies no error model that could be subtracted from a recording", Name{estimate.method}));
  if (estimate.covariance.rows != estimate.parameters.size())
    throw Error(Error::Kind::bad_file, "the result's covariance does not belong to its parameters");
  Compensation out{recording, {}, {}};
  Works works = works_of(estimate, recorded_outputs(estimate, recording, out.findings));
  set_places(recording, works);
  std::vector<Slot> slots = compensation::common_slots();
  std::vector<std::vector<UsedTerm>> terms;
  for (const Work& work : works) terms.push_back(used_terms(*work.model, estimate, slots));
  const OutputModel& warm = *thermal_first(works).model;
  compensation::require_sensors(estimate, recording, warm);
  const Inputs known =
      compensation::inputs_of(estimate, recording, recording.channels[works.front().place], plan, slots, warm.thermal);
  for (std::size_t k = 0; k < works.size(); ++k)
    sort_terms(known, works, recording, slots, std::move(terms[k]), works[k]);
  refuse_without_inputs(recording, works);
  for (Work& work : works) set_channels(out.recording, work);
  for (Work& work : works) set_cover(slots, known, works, work);
  compensation::take_all(known, slots, recording, works, out.recording);
  finish(works, recording, out);
  add_faults_of_samples(recording, plan, out.findings);
  return out;
}

}  // namespace tumble
