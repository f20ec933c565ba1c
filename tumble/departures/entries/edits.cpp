#include "tumble/departures/entries/edits.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/math/median.hpp"
#include "tumble/sim/power_up.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::entries {
namespace {

/// A plan that was made to identify alone has no truth: its outputs are those of the usual instrument.
std::vector<std::string> outputs_of_models(const Plan& plan) {
  std::vector<std::string> names;
  for (const auto& participant : participants_of(plan))
    for (const auto& output : participant.model.outputs(
             participant.truth.texts().empty() ? defaults(participant.model.constants()) : participant.truth))
      names.push_back(participant.prefix + output.channel);
  return names;
}

bool measures_motion(QuantityKind kind) {
  return kind == QuantityKind::angular_rate || kind == QuantityKind::specific_force || kind == QuantityKind::velocity ||
         kind == QuantityKind::count;
}

/// The channels of all recordings, each name once.
std::vector<const Channel*> all_channels(const Recordings& recordings) {
  std::vector<const Channel*> all;
  for (const Recording& recording : recordings)
    for (const Channel& channel : recording.channels)
      if (std::ranges::find(all, channel.name, &Channel::name) == all.end()) all.push_back(&channel);
  return all;
}

bool is_output(const Plan& plan, const Channel& channel) {
  if (!plan.instrument_model.empty()) {
    const auto names = outputs_of_models(plan);
    return std::ranges::find(names, channel.name) != names.end();
  }
  const auto reference = plan.channels.find("reference");
  const bool called = reference != plan.channels.end() && reference->second.front().channel == channel.name;
  return measures_motion(channel.kind) && !called && channel.name != "reference";
}

/// Whether the plan names the channel for a role of the method.
bool is_chosen(const Plan& plan, const std::string& channel) {
  return std::ranges::any_of(plan.channels, [&](const auto& role) {
    return std::ranges::find(role.second, channel, &ChannelChoice::channel) != role.second.end();
  });
}

std::vector<std::string> references_where(const Plan& plan, const Recordings& recordings,
                                          const std::function<bool(QuantityKind)>& wanted) {
  std::vector<std::string> names;
  for (const Channel* channel : all_channels(recordings))
    if (!is_output(plan, *channel) && wanted(channel->kind)) names.push_back(channel->name);
  return names;
}

}  // namespace

std::vector<std::string> whole_test(const Plan&, const Recordings& recordings) {
  const bool samples =
      std::ranges::any_of(all_channels(recordings), [](const Channel* c) { return c->values.size() > 1; });
  return samples ? std::vector<std::string>{""} : std::vector<std::string>{};
}

std::vector<std::string> all_outputs(const Plan& plan, const Recordings& recordings) {
  std::vector<std::string> names;
  for (const Channel* channel : all_channels(recordings))
    if (is_output(plan, *channel)) names.push_back(channel->name);
  return names;
}

std::vector<std::string> outputs(const Plan& plan, const Recordings& recordings) {
  std::vector<std::string> names;
  std::vector<std::pair<QuantityKind, bool>> found;
  for (const Channel* channel : all_channels(recordings)) {
    if (!is_output(plan, *channel)) continue;
    const std::pair kind{channel->kind, is_chosen(plan, channel->name)};
    if (std::ranges::find(found, kind) != found.end()) continue;
    found.push_back(kind);
    names.push_back(channel->name);
  }
  return names;
}

std::vector<std::string> references(const Plan& plan, const Recordings& recordings) {
  return references_where(plan, recordings, [](QuantityKind) { return true; });
}

std::vector<std::string> encoders(const Plan& plan, const Recordings& recordings) {
  return references_where(plan, recordings, [](QuantityKind kind) { return kind == QuantityKind::angle; });
}

std::vector<std::string> thermometers(const Plan& plan, const Recordings& recordings) {
  return references_where(plan, recordings, [](QuantityKind kind) { return kind == QuantityKind::temperature; });
}

std::vector<std::string> reference_sensors(const Plan& plan, const Recordings& recordings) {
  return references_where(plan, recordings, [](QuantityKind kind) {
    return kind != QuantityKind::angle && kind != QuantityKind::temperature && kind != QuantityKind::time;
  });
}

bool is_count(const Recordings& recordings, const std::string& name) {
  return std::ranges::any_of(recordings, [&](const Recording& recording) {
    const Channel* channel = find_channel(recording, name);
    return channel != nullptr && channel->kind == QuantityKind::count;
  });
}

std::vector<std::string> first_of(std::vector<std::string> names) {
  if (names.size() > 1) names.resize(1);
  return names;
}

void edit_channels(Recordings& recordings, const std::vector<std::string>& names,
                   const std::function<void(Channel&)>& edit) {
  for (Recording& recording : recordings)
    for (Channel& channel : recording.channels)
      if (std::ranges::find(names, channel.name) != names.end()) edit(channel);
}

void edit_channel(Recordings& recordings, const std::string& name, const std::function<void(Channel&)>& edit) {
  edit_channels(recordings, {name}, edit);
}

void edit_values(Recordings& recordings, const std::string& name, const std::function<double(double)>& edit) {
  edit_channel(recordings, name, [&](Channel& channel) {
    for (double& value : channel.values)
      if (!std::isnan(value)) value = edit(value);
  });
}

Counted::Counted(const Channel& channel, double step) : step_(channel.kind == QuantityKind::count ? step : 0.0) {}

double Counted::operator()(double value) {
  if (!(step_ > 0.0) || std::isnan(value)) return value;
  const double all = value + rest_, counted = step_ * std::round(all / step_);
  rest_ = all - counted;
  return counted;
}

void edit_measured(Recordings& recordings, const std::string& name, const std::function<double(double)>& edit) {
  edit_channel(recordings, name, [&](Channel& channel) {
    Counted counted(channel);
    for (double& value : channel.values)
      if (!std::isnan(value)) value = counted(edit(value));
  });
}

void divide_counts(Recordings& recordings, const std::string& name, double n) {
  edit_channel(recordings, name, [&](Channel& channel) {
    Counted counted(channel, n);
    for (double& value : channel.values) value = counted(value);
  });
}

void add_along(Recordings& recordings, const std::string& name, const std::function<double(double)>& added) {
  edit_channel(recordings, name, [&](Channel& channel) {
    Counted counted(channel);
    const auto last = static_cast<double>(std::max<std::size_t>(channel.values.size(), 2) - 1);
    for (std::size_t i = 0; i < channel.values.size(); ++i)
      channel.values[i] = counted(channel.values[i] + added(static_cast<double>(i) / last));
  });
}

void pass_through(Recordings& recordings, const std::string& name,
                  const std::function<Response(double step)>& response) {
  edit_channel(recordings, name, [&](Channel& channel) {
    const double rate = mean_rate(channel);
    if (!(rate > 0.0)) return;
    std::vector<double> samples = channel.values;
    double before = 0.0;
    for (double& sample : samples) before = sample = std::isnan(sample) ? before : sample;
    response(1.0 / rate)(samples);
    for (std::size_t i = 0; i < samples.size(); ++i)
      if (!std::isnan(channel.values[i])) channel.values[i] = samples[i];
  });
}

void restamp(Channel& channel, const std::function<double(double time, std::size_t sample)>& stamp) {
  auto stamps = std::make_shared<std::vector<double>>(channel.values.size());
  for (std::size_t i = 0; i < stamps->size(); ++i) (*stamps)[i] = stamp(channel.time(i), i);
  if (!stamps->empty()) channel.timeline = {stamps->front(), 0.0, std::move(stamps)};
}

void remove_samples(Channel& channel, const std::function<bool(std::size_t sample)>& lost) {
  auto stamps = std::make_shared<std::vector<double>>();
  std::vector<double> values;
  for (std::size_t i = 0; i < channel.values.size(); ++i)
    if (!lost(i)) {
      stamps->push_back(channel.time(i));
      values.push_back(channel.values[i]);
    }
  if (values.empty()) return;
  channel.values = std::move(values);
  channel.timeline = {stamps->front(), 0.0, std::move(stamps)};
}

double sample_interval(const Recordings& recordings, const std::string& name) {
  for (const Channel* channel : all_channels(recordings))
    if (name.empty() || channel->name == name) {
      const double rate = mean_rate(*channel);
      if (rate > 0.0) return 1.0 / rate;
    }
  return 1.0;
}

double half_a_sample(const Plan&, const Recordings& recordings, const std::string& name) {
  return 0.5 * sample_interval(recordings, name);
}

double covered_index(const Plan& plan, const Recordings&, const std::string&) {
  return std::max(rig_number(plan, "index_zero_sd", 3.0 * arcsecond), arcsecond);
}

double noise_of(const Recordings& recordings, const std::string& name) {
  std::vector<double> changes;
  double least = std::numeric_limits<double>::infinity();
  for (const Recording& recording : recordings) {
    const Channel* channel = find_channel(recording, name);
    for (std::size_t i = 1; channel != nullptr && i < channel->values.size(); ++i) {
      const double change = std::abs(channel->values[i] - channel->values[i - 1]);
      if (std::isnan(change)) continue;
      changes.push_back(change);
      if (change > 0.0) least = std::min(least, change);
    }
  }
  if (changes.empty() || !std::isfinite(least)) return 1.0;
  constexpr double of_normal = 0.6745;  // median of |x| of a standard normal x
  const double noise = median(std::move(changes)) / of_normal / std::sqrt(2.0);
  return noise > 0.0 ? noise : least;
}

double covered_bias(const Plan& plan, const Recordings& recordings, const std::string& name) {
  double covered = 0.0;
  if (!plan.instrument_model.empty())
    for (const auto& participant : participants_of(plan))
      for (const auto& output : participant.model.outputs(participant.truth))
        if (participant.prefix + output.channel == name && output.kind != QuantityKind::count)
          for (const char* term : {"turn_on_repeatability", "bias_instability"})
            if (participant.truth.has(output.noise_prefix + term))
              covered = std::max(covered, participant.truth.number(output.noise_prefix + term));
  const auto channels = all_channels(recordings);
  const auto channel = std::ranges::find(channels, name, &Channel::name);
  const bool as_modelled = channel != channels.end() && ((*channel)->kind == QuantityKind::angular_rate ||
                                                         (*channel)->kind == QuantityKind::specific_force);
  return covered > 0.0 && as_modelled ? covered : 0.1 * noise_of(recordings, name);
}

double rig_number(const Plan& plan, const char* option, double otherwise) {
  return plan.rig.has(option) ? plan.rig.number(option) : otherwise;
}

namespace {

/// The unit that the rig shows the option in.
Unit shown_unit(const Plan& plan, const char* name) {
  for (const Option& option : find_rig(plan.rig_kind).options())
    if (option.name == name) return Unit::parse(option.unit);
  return {};
}

}  // namespace

void add_to_rig(Plan& plan, const char* option, double amount) {
  if (!plan.rig.has(option)) return;
  plan.rig.set_number(option, plan.rig.number(option) + amount, shown_unit(plan, option));
}

void scale_in_rig(Plan& plan, const char* option, double factor) {
  if (!plan.rig.has(option)) return;
  plan.rig.set_number(option, plan.rig.number(option) * factor, shown_unit(plan, option));
}

bool rig_has(const Plan& plan, std::initializer_list<const char*> options) {
  return std::ranges::any_of(options, [&](const char* option) { return plan.rig.has(option); });
}

}  // namespace tumble::entries
