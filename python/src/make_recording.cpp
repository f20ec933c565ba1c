#include <algorithm>
#include <memory>
#include <span>

#include "recordings.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/formats/sha256.hpp"
#include "tumble/math/interruption.hpp"
#include "tumble/units/error.hpp"

namespace tumble::python {
namespace {

std::vector<double> copied(const Samples& samples) { return {samples.data(), samples.data() + samples.shape(0)}; }

/// SHA-256 of numbers, which Ctrl+C ends.
std::string checksum_of(std::span<const double> values) {
  constexpr std::size_t piece = std::size_t{1} << 20;
  Sha256 sum;
  for (std::size_t first = 0; first < values.size(); first += piece) {
    stop_if_asked();
    const auto part = values.subspan(first, std::min(piece, values.size() - first));
    sum.add({reinterpret_cast<const char*>(part.data()), part.size_bytes()});
  }
  return sum.hex();
}

/// SHA-256 of the checksums of all channels: names, units, times and samples.
std::string checksum_of(const Recording& recording) {
  std::string text;
  for (const auto& channel : recording.channels) {
    const auto& timeline = channel.timeline;
    text += channel.name + "[" + channel.unit.text() + "]" + checksum_of(channel.values);
    text += timeline.uniform() ? checksum_of(std::vector<double>{timeline.start, timeline.rate})
                               : checksum_of(*timeline.stamps);
  }
  return sha256_of(text);
}

/// Samples in memory have a checksum too, so that two different tests have different provenances.
void sign(Recording& recording) {
  recording.origin.checksum = [sum = checksum_of(recording)] { return sum; };
}

Channel channel_of(const ChannelParts& parts) {
  Channel channel{parts.name, QuantityKind::other, Unit::parse(parts.unit), {}, copied(parts.values)};
  channel.kind = kind_of(channel.unit);
  if (!parts.si)
    for (double& value : channel.values) value = channel.unit.to_si(value);
  channel.timeline.start = parts.start;
  channel.timeline.rate = parts.rate;
  if (parts.stamps) {
    channel.timeline = {};
    channel.timeline.stamps = std::make_shared<const std::vector<double>>(copied(*parts.stamps));
  }
  return channel;
}

}  // namespace

Recording make_recording(const std::vector<ChannelParts>& channels,
                         const std::vector<std::tuple<std::string, double, int, double>>& marks,
                         const std::string& file, const std::string& instrument,
                         const std::map<std::string, std::string>& meta, const std::string& checksum) {
  Recording recording;
  Problems problems;
  for (const auto& parts : channels) try {
      recording.channels.push_back(channel_of(parts));
    } catch (const Error& error) {
      for (const auto& problem : error.problems) problems.push_back(say("'{}': {}", parts.name, problem));
    }
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  for (const auto& [label, begin, run, end] : marks) recording.marks.push_back({label, begin, run, end});
  recording.instrument = instrument;
  recording.meta = meta;
  recording.origin.file = file;
  if (checksum == "file") recording.origin.checksum = sha256_in_background(file);
  if (checksum == "samples") sign(recording);
  return recording;
}

Recording between(const Recording& recording, double begin, double end) {
  Recording part;
  part.instrument = recording.instrument;
  part.meta = recording.meta;
  part.origin.file = recording.origin.file;
  for (const auto& channel : recording.channels) {
    const std::size_t first = index_at(channel, begin), last = std::max(first, index_at(channel, end));
    Channel piece{channel.name, channel.kind, channel.unit, channel.timeline, {}};
    piece.values.assign(channel.values.begin() + static_cast<std::ptrdiff_t>(first),
                        channel.values.begin() + static_cast<std::ptrdiff_t>(last));
    if (channel.timeline.uniform())
      piece.timeline.start = channel.time(first);
    else
      piece.timeline.stamps = std::make_shared<const std::vector<double>>(
          channel.timeline.stamps->begin() + static_cast<std::ptrdiff_t>(first),
          channel.timeline.stamps->begin() + static_cast<std::ptrdiff_t>(last));
    part.channels.push_back(std::move(piece));
  }
  for (const auto& mark : recording.marks)
    if (mark.begin < end && !(mark.end <= begin)) {
      if (!part.marks.empty() && mark.begin <= begin) part.marks.clear();  // one that begins later, but before the part
      part.marks.push_back(mark);
      part.marks.back().begin = std::max(mark.begin, begin);
    }
  sign(part);
  return part;
}

}  // namespace tumble::python
