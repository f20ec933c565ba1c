#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "tumble/formats/checksum.hpp"
#include "tumble/formats/file/number_at.hpp"
#include "tumble/formats/file/window.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/formats/wav/layout.hpp"
#include "tumble/math/room.hpp"
#include "tumble/units/error.hpp"

namespace tumble::wav {

namespace {

using Type = Layout::Type;

/// A channel of the file that is read.
struct Source {
  std::size_t index;
  double factor, offset;  ///< of a sample as written, to SI
};

/// What is read of a file.
struct Opened {
  Layout layout;
  Recording frame;  ///< no samples
  std::vector<Source> sources;
};

bool wanted(const ReadOptions& options, const std::string& name) {
  return options.only.empty() || std::ranges::find(options.only, name) != options.only.end();
}

/// Integers are counts, or parts of full scale where the user gives another unit.
Source source_of(const Layout& layout, std::size_t index, const Unit& unit) {
  const bool counts = kind_of(unit) == QuantityKind::count;
  const double scale = is_integer(layout.type) && !counts ? 1.0 / full_scale(layout.type) : 1.0;
  return {index, scale * unit.factor(), unit.offset()};
}

Opened open(const std::string& path, const ReadOptions& options) {
  Opened opened{layout_of(path), {}, {}};
  const Layout& layout = opened.layout;
  opened.frame.origin.file = path;
  opened.frame.meta = layout.meta;
  opened.frame.findings = layout.findings;
  std::vector<std::string> without_unit, scaled;
  for (std::size_t i = 0; i < layout.channels; ++i) {
    const std::string name = fmt::format("channel{}", i + 1);
    if (!wanted(options, name)) continue;
    const auto given = options.units.find(name);
    if (given == options.units.end() && !is_integer(layout.type)) {
      without_unit.push_back(name);
      continue;
    }
    const Unit unit = given == options.units.end() ? Unit::parse("LSB") : given->second;
    if (is_integer(layout.type) && kind_of(unit) != QuantityKind::count) scaled.push_back(name);
    opened.frame.channels.push_back({name, kind_of(unit), unit, {0.0, layout.rate, nullptr}, {}});
    opened.sources.push_back(source_of(layout, i, unit));
  }
  if (!without_unit.empty())
    throw Error(Error::Kind::bad_file,
                say("'{}': the samples of {} are floating-point numbers, and the file does not say their unit; give "
                    "it: --set unit.{}=g, or in the plan's [channels] table: role = \"{}[g]\"",
                    path, fmt::join(without_unit, ", "), Name{without_unit.front()}, Name{without_unit.front()}));
  if (opened.sources.empty())
    throw Error(Error::Kind::bad_file,
                say("'{}' has no channel of that name; its channels are channel1 to channel{}", path, layout.channels));
  if (!scaled.empty())
    opened.frame.findings.push_back(
        {Finding::Severity::info, "full_scale_is_one", {{"channels", fmt::format("{}", fmt::join(scaled, ", "))}}});
  return opened;
}

double sample_at(const char* at, Type type) {
  switch (type) {
    case Type::u8:
      return file::number_at<std::uint8_t>(at) - 128.0;
    case Type::i16:
      return file::number_at<std::int16_t>(at);
    case Type::i24: {
      std::uint32_t bits = 0;
      std::memcpy(reinterpret_cast<char*>(&bits) + 1, at, 3);
      return static_cast<double>(static_cast<std::int32_t>(bits) / 256);
    }
    case Type::i32:
      return file::number_at<std::int32_t>(at);
    case Type::f32:
      return file::number_at<float>(at);
    case Type::f64:
      break;
  }
  return file::number_at<double>(at);
}

double sample_of(const char* at, const Layout& layout) {
  if (!layout.big) return sample_at(at, layout.type);
  char bytes[sizeof(double)];
  std::reverse_copy(at, at + size_of(layout.type), bytes);
  return sample_at(bytes, layout.type);
}

/// Reads the next `count` frames, at most as many as a window holds, and appends them to `to`. False at the end.
bool take(const Opened& opened, file::Window& window, std::size_t count, std::vector<Channel>& to,
          std::size_t& infinite) {
  const std::size_t size = size_of(opened.layout.type), frame = size * opened.layout.channels;
  if (!window.holds(count * frame)) return false;
  for (std::size_t c = 0; c < to.size(); ++c) {
    const Source& source = opened.sources[c];
    const char* at = window.data() + source.index * size;
    for (std::size_t k = 0; k < count; ++k, at += frame) {
      const double value = sample_of(at, opened.layout) * source.factor + source.offset;
      infinite += std::isinf(value);
      to[c].values.push_back(std::isinf(value) ? std::numeric_limits<double>::quiet_NaN() : value);
    }
  }
  window.skip(count * frame);
  return true;
}

void say_infinite(const std::string& path, std::size_t infinite, Findings& findings) {
  if (infinite > 0)
    findings.push_back({Finding::Severity::warning, "infinite_samples", {{"topic", path}}, "", {infinite, {}, {}}});
}

void each_block(const std::string& path, Opened& opened, std::size_t samples, const Progress& progress,
                const std::function<void(std::size_t first, std::size_t infinite)>& done) {
  const Layout& layout = opened.layout;
  const std::size_t fitting = file::Window::longest / (size_of(layout.type) * layout.channels);
  const std::size_t longest = std::max<std::size_t>(1, std::min(samples, fitting));
  file::Window window(path);
  window.skip(layout.first);
  for (std::uint64_t first = 0; first < layout.frames;) {
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(longest, layout.frames - first));
    std::size_t infinite = 0;
    if (!take(opened, window, count, opened.frame.channels, infinite))
      throw Error(Error::Kind::bad_file, say("'{}' became shorter while it was read", path));
    report(progress, static_cast<double>(first) / static_cast<double>(layout.frames), "reading");
    done(static_cast<std::size_t>(first), infinite);
    first += count;
  }
}

Recording read(const std::string& path, const ReadOptions& options, const Progress& progress) {
  Opened opened = open(path, options);
  opened.frame.origin.checksum = sha256_in_background(path);
  for (Channel& channel : opened.frame.channels) make_room(channel.values, opened.layout.frames);
  std::size_t infinite = 0;
  each_block(path, opened, opened.layout.frames, progress,
             [&](std::size_t, std::size_t of_block) { infinite += of_block; });
  say_infinite(path, infinite, opened.frame.findings);
  return std::move(opened.frame);
}

std::uintmax_t memory(const std::string& path, const ReadOptions& options) {
  const Opened opened = open(path, options);
  return opened.layout.frames * opened.sources.size() * sizeof(double);
}

void stream(const std::string& path, const ReadOptions& options, std::size_t samples, const BlockSink& sink,
            const Progress& progress) {
  Opened opened = open(path, options);
  Recording& block = opened.frame;
  each_block(path, opened, samples, progress, [&](std::size_t first, std::size_t infinite) {
    say_infinite(path, infinite, block.findings);
    for (Channel& channel : block.channels) channel.timeline.start = static_cast<double>(first) / opened.layout.rate;
    sink(block);
    block.findings.clear();
    for (Channel& channel : block.channels) channel.values.clear();
  });
}

}  // namespace

extern const Format wav{.name = "wav",
                        .summary = "WAV: channels of one rate, integers as counts or floating-point numbers",
                        .extensions = {".wav", ".rf64"},
                        .recognises = is_wave,
                        .read = read,
                        .memory = memory,
                        .stream = stream};

}  // namespace tumble::wav
