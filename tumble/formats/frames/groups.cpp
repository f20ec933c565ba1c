#include "tumble/formats/frames/groups.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "tumble/clocks/clock.hpp"

namespace tumble::frames {

namespace {

/// Where a channel stands: layout, item, and under which condition.
using Place = std::tuple<std::size_t, int, int, std::uint64_t, std::uint64_t>;

std::vector<Place> places_of(const FrameCodec& codec, std::size_t channel) {
  std::vector<Place> places;
  for (std::size_t i = 0; i < codec.frames.size(); ++i)
    for (const FrameField& field : codec.frames[i].fields)
      if (field.channel == channel)
        places.emplace_back(i, field.number.item, field.when ? field.when->number.at : -1,
                            field.when ? field.when->modulus : 0, field.when ? field.when->equals : 0);
  return places;
}

/// [s] of the last digit of a part of the time; 0 where it does not show.
double last_digit(const FrameLayout& layout, const FrameTime& part) {
  if (part.number.kind != FrameNumber::Kind::real) return part.factor;
  if (part.number.form != FrameNumber::Form::decimal) return 0.0;
  const int decimals = layout.text->cells[static_cast<std::size_t>(part.number.item)].format.decimals;
  return decimals < 0 ? 0.0 : part.factor * std::pow(10.0, -decimals);
}

}  // namespace

void Group::add(double t, double place, std::size_t most) {
  clock.add(t, place);
  if (count++ < most) stamps.push_back(t);
  last = t;
}

std::vector<Group> groups_of(const FrameCodec& codec, const std::vector<std::string>& only) {
  std::vector<Group> groups;
  std::map<std::vector<Place>, std::size_t> known;
  for (std::size_t channel = 0; channel < codec.channels.size(); ++channel) {
    if (!only.empty() && std::ranges::find(only, codec.channels[channel].name) == only.end()) continue;
    const auto places = places_of(codec, channel);
    if (places.empty()) continue;
    const auto [at, is_new] = known.try_emplace(places, groups.size());
    if (is_new) groups.emplace_back();
    groups[at->second].channels.push_back(channel);
    groups[at->second].increments |= codec.channels[channel].increment;
  }
  return groups;
}

double rate_of(const Group& group) {
  if (const auto even = group.clock.timeline()) return even->rate;
  if (group.stamps.size() < 2) return 0.0;
  const std::size_t count = std::min(group.stamps.size(), stamps_for_rate);
  Channel channel;
  channel.timeline.stamps = std::make_shared<const std::vector<double>>(
      group.stamps.begin(), group.stamps.begin() + static_cast<std::ptrdiff_t>(count));
  channel.values.resize(count);
  return clock_of(channel).rate;
}

std::vector<double> steps_of(const FrameCodec& codec) {
  std::vector<double> steps;
  for (const FrameLayout& layout : codec.frames) {
    double step = 0.0;
    for (const FrameTime& part : layout.time)
      if (const double last = last_digit(layout, part); last > 0.0) step = step > 0.0 ? std::min(step, last) : last;
    steps.push_back(step);
  }
  return steps;
}

}  // namespace tumble::frames
