#include "tumble/recorder/live_store/slot_reader.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "tumble/wire/frames.hpp"

namespace tumble::live_store {

namespace {

/// Frames after which the counter of a link begins again; 0: it has none.
double modulus_of(const StoreContent& content, std::optional<std::size_t> link) {
  if (!link || *link >= content.links.size() || content.links[*link].declaration.empty()) return 0.0;
  const StoreLink& of = content.links[*link];
  double modulus = 0.0;
  for (const FrameLayout& layout : read_frames(of.declaration, of.declaration_name, of.variants).frames)
    if (layout.counter)
      modulus = static_cast<double>(layout.counter->modulus) /
                static_cast<double>(std::max<std::uint64_t>(layout.counter->step, 1));
  return modulus;
}

/// Whether the file of a recording has room for it: its numbers are finite in the unit of the channel.
bool can_be_kept(const FrameChannel& channel, double value) {
  constexpr double fastest = 1e6;  // [Hz] by which increments are multiplied at most
  return !std::isinf(channel.unit.from_si(value) * (channel.increment ? fastest : 1.0));
}

}  // namespace

std::vector<std::string> slots_of(const StoreContent& content) {
  std::set<std::string> slots;
  for (const StoreStream& stream : content.streams)
    if (!stream.slot.empty()) slots.insert(stream.slot);
  if (slots.empty()) slots.insert("");
  return {slots.begin(), slots.end()};
}

SlotReader::SlotReader(const StoreContent& content, std::string slot) {
  std::map<std::string, std::size_t> known;
  for (const StoreStream& stream : content.streams) {
    auto& signals = signals_of_stream_.emplace_back();
    if (!stream.slot.empty() && stream.slot != slot) continue;
    if (instrument_.empty()) instrument_ = stream.name;
    const double modulus = modulus_of(content, stream.link);
    for (const FrameChannel& channel : stream.channels) {
      const auto [place, is_new] = known.try_emplace(channel.name, signals_.size());
      if (is_new)
        signals_.push_back({channel, SampleClock(stream.rate, modulus), stream.rate, stream.link, true, {}, {}});
      Signal& signal = signals_[place->second];
      if (!is_new) signal.one_sequence = signal.one_sequence && stream.link && stream.link == signal.link;
      signals.push_back(place->second);
    }
  }
}

void SlotReader::look(const StoreItem& item) {
  if (item.kind != StoreItem::Kind::sample) return;
  const auto& indices = signals_of_stream_[item.source];
  for (std::size_t k = 0; k < indices.size(); ++k) {
    Signal& signal = signals_[indices[k]];
    signal.clock.add(item.sample.sequence, item.time, item.sample.device);
    if (can_be_kept(signal.channel, item.sample.values[k])) continue;
    if (signal.infinite.count++ == 0) signal.infinite.first = Place("", item.time);
  }
}

void SlotReader::settle() {
  for (Signal& signal : signals_) {
    signal.clock.settle();
    signal.one_sequence = signal.one_sequence && signal.clock.even();
  }
}

bool SlotReader::streams() const {
  return std::ranges::all_of(signals_, [](const Signal& signal) {
    return signal.clock.count() == 0 || (signal.one_sequence && signal.clock.placed());
  });
}

bool SlotReader::has_samples() const {
  return std::ranges::any_of(signals_, [](const Signal& signal) { return signal.clock.count() > 0; });
}

void SlotReader::rewind() {
  for (Signal& signal : signals_) {
    signal.values.clear();
    signal.stamps.clear();
    signal.given = 0;
  }
}

std::size_t SlotReader::waiting() const {
  std::size_t most = 0;
  for (const Signal& signal : signals_) most = std::max(most, signal.values.size());
  return most;
}

void SlotReader::take(const StoreItem& item) {
  if (item.kind != StoreItem::Kind::sample) return;
  const auto& indices = signals_of_stream_[item.source];
  for (std::size_t k = 0; k < indices.size(); ++k) {
    Signal& signal = signals_[indices[k]];
    const bool kept = can_be_kept(signal.channel, item.sample.values[k]);
    const double value = kept ? item.sample.values[k] : std::nan("");
    if (signal.one_sequence) {
      signal.clock.place(item.sample.sequence, item.time);
      const std::size_t at = signal.clock.index(item.sample.sequence) - signal.given;
      if (at >= signal.values.size()) signal.values.resize(at + 1, std::nan(""));  // lost ones are missing
      signal.values[at] = value;
    } else {
      signal.values.push_back(value);
      signal.stamps.push_back(item.time);
    }
  }
}

namespace {

/// [Hz] by which increments are multiplied: the even clock, what was declared, or the mean over the stamps.
double samples_a_second(const SampleClock& clock, bool even, double declared, const std::vector<double>& stamps) {
  if (even) return clock.rate();
  if (declared > 0.0) return declared;
  const double span = stamps.size() > 1 ? stamps.back() - stamps.front() : 0.0;
  return span > 0.0 ? static_cast<double>(stamps.size() - 1) / span : 1.0;
}

}  // namespace

std::vector<Channel> SlotReader::channels() {
  std::vector<Channel> channels;
  std::shared_ptr<const std::vector<double>> stamps;
  for (Signal& signal : signals_) {
    if (signal.clock.count() == 0) continue;
    if (signal.channel.increment) {
      const double rate = samples_a_second(signal.clock, signal.one_sequence, signal.declared, signal.stamps);
      for (double& value : signal.values) value *= rate;
    }
    Timeline timeline;
    if (signal.one_sequence) {
      timeline = signal.clock.timeline();
    } else {
      if (!stamps || *stamps != signal.stamps)
        stamps = std::make_shared<const std::vector<double>>(std::move(signal.stamps));
      timeline.stamps = stamps;
    }
    signal.given += signal.values.size();
    channels.push_back({signal.channel.name, kind_of(signal.channel.unit), signal.channel.unit, timeline,
                        std::exchange(signal.values, {})});
  }
  return channels;
}

std::string SlotReader::instrument() const { return instrument_; }

/// An instrument that sends at another rate than declared is configured otherwise; one that sends infinite samples has
/// a fault, and those are missing in the recording.
Findings SlotReader::findings() const {
  Findings findings;
  for (const Signal& signal : signals_)
    if (signal.infinite.count > 0)
      findings.push_back({Finding::Severity::warning,
                          "infinite_samples",
                          {{"topic", signal.channel.name}},
                          signal.channel.name,
                          signal.infinite});
  constexpr double tolerance = 0.01;
  constexpr std::uint64_t enough = 100;
  for (const Signal& signal : signals_) {
    const double rate = signal.clock.arrival_rate(), declared = signal.declared;
    if (signal.clock.count() < enough || !(declared > 0.0) || !signal.one_sequence) continue;
    if (!(std::abs(rate / declared - 1.0) > tolerance)) continue;
    findings.push_back({Finding::Severity::warning,
                        "recording_rate",
                        {{"rate", rate, "Hz"}, {"declared", declared, "Hz"}},
                        signal.channel.name});
    break;
  }
  return findings;
}

}  // namespace tumble::live_store
