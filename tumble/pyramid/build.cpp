#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "tumble/core/json_text.hpp"
#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/formats/conflicts.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/pyramid/pyramid.hpp"
#include "tumble/pyramid/store/store.hpp"

namespace tumble {
namespace {

using store::Json;

constexpr std::size_t samples_at_a_time = 1 << 18;

template <class Number>
std::string_view bytes_of(const std::vector<Number>& numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(Number)};
}

/// Writes the blocks of a recording to a pyramid as they come: samples and stamps at once, levels at the end.
class Builder {
 public:
  Builder(const std::string& path, bool keeps_samples) : file_(path), keeps_samples_(keeps_samples) {
    put({store::signature, 8});
  }

  void add(const Recording& block) {
    if (description_.is_null()) begin(block);
    for (std::size_t i = 0; i < block.channels.size(); ++i) add(block, i);
  }

  void finish() {
    Json& channels = description_["channels"];
    for (std::size_t i = 0; i < parts_.size(); ++i) finish(parts_[i], channels[i]);
    const std::string text = json_text(description_);
    const std::uint64_t place = place_, size = text.size();
    put(text);
    put({reinterpret_cast<const char*>(&size), 8});
    put({reinterpret_cast<const char*>(&place), 8});
    put({store::signature, 8});
    file_.commit();
  }

 private:
  struct Part {
    store::Levels levels;
    std::size_t count = 0;                       ///< samples so far
    std::vector<std::uint64_t> samples, stamps;  ///< number of the first one and place in the file, in turn
    std::size_t clock = 0;                       ///< the channel that holds the stamps of this one
    bool stamped = false;
    double first = 0.0, last = 0.0;  ///< [s]
    std::vector<double> times;       ///< [s] of the block, never backwards
  };

  void begin(const Recording& block) {
    description_ = store::description_of(block);
    parts_.resize(block.channels.size());
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const auto& stamps = block.channels[i].timeline.stamps;
      parts_[i].stamped = stamps != nullptr;
      parts_[i].clock = i;
      for (std::size_t k = 0; stamps && k < i; ++k)
        if (block.channels[k].timeline.stamps == stamps) parts_[i].clock = std::min(parts_[i].clock, k);
    }
  }

  void put(std::string_view bytes) {
    file_.write(bytes);
    place_ += bytes.size();
    if (const std::size_t rest = place_ % 8) put(std::string_view("\0\0\0\0\0\0\0", 8 - rest));
  }

  void add(const Recording& block, std::size_t number) {
    const Channel& channel = block.channels[number];
    if (channel.values.empty()) return;
    Part& part = parts_[number];
    if (part.stamped && part.clock == number) take_stamps(channel, part);
    const Part& clock = parts_[part.clock];
    if (part.count == 0) part.first = part.stamped ? clock.times.front() : channel.time(0);
    part.last = part.stamped ? clock.times.back() : channel.time(channel.values.size() - 1);
    if (keeps_samples_) {
      part.samples.insert(part.samples.end(), {part.count, place_});
      put(bytes_of(channel.values));
    }
    part.levels.add(channel.values.data(), part.stamped ? clock.times.data() : nullptr, channel.values.size());
    part.count += channel.values.size();
  }

  /// A clock that runs backwards stands still here until it is where it was.
  void take_stamps(const Channel& channel, Part& part) {
    double latest = part.count == 0 ? channel.time(0) : part.last;
    part.times.resize(channel.values.size());
    for (std::size_t i = 0; i < part.times.size(); ++i) part.times[i] = latest = std::max(latest, channel.time(i));
    part.stamps.insert(part.stamps.end(), {part.count, place_});
    put(bytes_of(part.times));
  }

  template <class Number>
  std::uint64_t placed(const std::vector<Number>& numbers) {
    const std::uint64_t begin = place_;
    put(bytes_of(numbers));
    return begin;
  }

  void finish(Part& part, Json& entry) {
    part.levels.finish();
    Json levels = Json::array(), moments = Json::array();
    for (const store::Level& level : part.levels.levels())
      levels.push_back({{"count", level.low.size()},
                        {"low", placed(level.low)},
                        {"high", placed(level.high)},
                        {"flags", placed(level.flags)}});
    for (const auto& level : part.levels.moments())
      moments.push_back({{"count", level.size()}, {"place", placed(level)}});
    entry["count"] = part.count;
    entry["offset"] = part.levels.offset();
    entry["first"] = part.first;
    entry["last"] = part.last;
    entry["clock"] = part.clock;
    entry["samples"] = part.samples;
    entry["stamps"] = part.stamps;
    entry["levels"] = levels;
    entry["moments"] = moments;
  }

  Json description_;
  AtomicFile file_;
  bool keeps_samples_;
  std::uint64_t place_ = 0;
  std::vector<Part> parts_;
};

}  // namespace

std::function<std::string()> build_pyramid(const std::string& recording, const ReadOptions& options,
                                           const std::string& path, const Progress& progress) {
  std::error_code unknown;
  const bool folder = std::filesystem::is_directory(recording, unknown);
  const Format& format = format_of(recording, options);
  auto checksum = folder ? [] { return std::string(); } : sha256_in_background(recording);
  Builder builder(path, !sample_reader(recording, options));
  bool first = true;
  stream_recording(
      format, recording, options, samples_at_a_time,
      [&](const Recording& block) {
        if (std::exchange(first, false)) refuse_conflicts(block, options);
        builder.add(block);
      },
      progress);
  builder.finish();
  return checksum;
}

}  // namespace tumble
