#include "tumble/rehearsal/virtual_stream.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "tumble/units/error.hpp"

namespace tumble {
namespace {

constexpr int head = 17;      ///< [byte] of a declared frame: sync 4, counter 4, time 8, status 1
constexpr int real_size = 8;  ///< [byte] of a channel
constexpr int crc_size = 4;

/// The channels of one sample of the plan, in order, and their units.
std::vector<Channel> channels_of_plan(const Plan& plan) {
  VirtualRig rig(plan, 0);
  rig.power(0.0, true);
  const auto blocks = rig.samples(1.5 / plan.sample_rate);
  return blocks.front().channels;
}

/// A frame in which every channel is 0: its bytes in hexadecimal.
std::string zero_frame(int length) {
  std::string bytes(static_cast<std::size_t>(length), '\0');
  std::memcpy(bytes.data(), "TVRF", 4);
  bytes[16] = 1;
  const auto crc = crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(length - crc_size));
  for (int i = 0; i < crc_size; ++i)
    bytes[static_cast<std::size_t>(length - crc_size + i)] = static_cast<char>(crc >> 8 * i);
  std::string hex;
  for (const char byte : bytes)
    hex += fmt::format("{}{:02X}", hex.empty() ? "" : " ", static_cast<unsigned char>(byte));
  return hex;
}

/// The value of a number that has only so many bits: beyond its ends it stays at its end, as a converter does.
double saturated(const FrameField& field, double value) {
  const FrameNumber& number = field.number;
  if (number.kind == FrameNumber::Kind::real || std::isnan(value)) return value;
  const bool sign = number.kind == FrameNumber::Kind::integer;
  const double top = std::ldexp(1.0, number.bits - (sign ? 1 : 0)) - 1.0, bottom = sign ? -top - 1.0 : 0.0;
  // a step inside, so that the rounding of the scale does not leave the range
  return std::clamp((value - field.zero) / field.factor, bottom + 1.0, top - 1.0) * field.factor + field.zero;
}

/// Turns the status bits of a frame over. Those that lie in items are not touched.
void spoil(const FrameStatus& status, std::string& bytes) {
  const FrameNumber& number = status.good.number;
  if (number.item >= 0) return;
  const int at = number.at < 0 ? static_cast<int>(bytes.size()) + number.at : number.at;
  const int byte = number.shift / 8, place = number.big ? at + number.bytes - 1 - byte : at + byte;
  bytes[static_cast<std::size_t>(place)] =
      static_cast<char>(bytes[static_cast<std::size_t>(place)] ^ 1 << number.shift % 8);
}

}  // namespace

std::string frames_for(const Plan& plan) {
  const auto channels = channels_of_plan(plan);
  const int length = head + real_size * static_cast<int>(channels.size()) + crc_size;
  std::string text = fmt::format(
      "title = \"{} on {}, as the virtual rig sends it\"\ncertainty = \"maker\"\norder = \"little\"\n"
      "rate = \"{} Hz\"\n\n[[frame]]\nname = \"sample\"\nsync = \"54 56 52 46\"\nlength = {}\n"
      "check = {{kind = \"crc\", width = 32, poly = \"04C11DB7\", init = \"FFFFFFFF\", xorout = \"FFFFFFFF\", "
      "reflected = true, over = [0, -4], at = -4}}\ncounter = {{at = 4, type = \"u32\"}}\n"
      "time = {{at = 8, type = \"u64\", scale = \"1 ns\"}}\n"
      "status = [{{at = 16, type = \"u8\", bits = 0, equals = 1, text = \"the instrument is in order\"}}]\nchannel = "
      "[\n",
      plan.instrument_model, plan.rig_kind, plan.sample_rate, length);
  int at = head;
  for (const auto& channel : channels) {
    text += fmt::format("  {{name = \"{}\", at = {}, type = \"f64\", scale = \"1 {}\", unit = \"{}\"}},\n",
                        channel.name, at, name(channel.unit.dimension()), channel.unit.text());
    at += real_size;
  }
  text += fmt::format("]\n\n[[vector]]\nmade_by_hand = true\nhex = \"{}\"\ncounter = 0\ntime = \"0 s\"\nvalues = {{",
                      zero_frame(length));
  for (std::size_t c = 0; c < channels.size(); ++c)
    text += fmt::format("{}\"{}\" = \"0 {}\"", c ? ", " : "", channels[c].name, name(channels[c].unit.dimension()));
  return text + "}\n";
}

VirtualStream::VirtualStream(FrameCodec codec, double sample_rate, std::map<std::string, std::string> names)
    : codec_(std::move(codec)), rate_(sample_rate), names_(std::move(names)) {
  while (layout_ < codec_.frames.size() && codec_.frames[layout_].fields.empty()) ++layout_;
  if (layout_ == codec_.frames.size())
    throw Error(Error::Kind::bad_input, say("{}: no frame carries a channel", Name{codec_.name}));
}

void VirtualStream::freeze(const std::string& channel, bool on) {
  if (on)
    frozen_.emplace(channel, std::nullopt);
  else
    frozen_.erase(channel);
}

void VirtualStream::find_sources(const VirtualSamples& samples) {
  sources_.clear();
  for (const FrameField& field : codec_.frames[layout_].fields) {
    const FrameChannel& channel = codec_.channels[field.channel];
    const auto renamed = names_.find(channel.name);
    const auto& wanted = renamed == names_.end() ? channel.name : renamed->second;
    const auto found = std::ranges::find(samples.channels, wanted, &Channel::name);
    sources_.push_back(found == samples.channels.end() ? nullptr : &*found);
    if (sources_.back() && !(found->unit.dimension() == channel.unit.dimension()))
      throw Error(Error::Kind::bad_input, say("{}: {} is in {}, but the rig gives {}", Name{codec_.name},
                                              Name{channel.name}, Name{channel.unit.text()}, Name{found->unit.text()}));
  }
}

/// The value of a channel as its field sends it [SI].
double VirtualStream::sent_value(const FrameField& field, double value) {
  const FrameChannel& channel = codec_.channels[field.channel];
  if (!frozen_.empty())
    if (const auto frozen = frozen_.find(channel.name); frozen != frozen_.end()) {
      if (!frozen->second) frozen->second = value;
      value = *frozen->second;
    }
  return saturated(field, channel.increment ? value / rate_ : value);
}

void VirtualStream::append_frame(std::size_t k, double device_time, std::string& out) {
  const FrameLayout& layout = codec_.frames[layout_];
  content_.frame = layout_;
  content_.values.assign(codec_.channels.size(), std::numeric_limits<double>::quiet_NaN());
  content_.present.assign(codec_.channels.size(), 0);
  for (std::size_t f = 0; f < layout.fields.size(); ++f) {
    const FrameField& field = layout.fields[f];
    content_.present[field.channel] = 1;
    if (sources_[f]) content_.values[field.channel] = sent_value(field, sources_[f]->values[k]);
  }
  if (layout.counter) content_.counter = counter_ % layout.counter->modulus;
  if (!layout.time.empty()) {
    const double wrap = layout.time.front().wrap;
    content_.time = wrap > 0.0 ? device_time - wrap * std::floor(device_time / wrap) : std::max(0.0, device_time);
  }
  const std::size_t begin = out.size();
  encoder_.append(codec_, content_, out);
  if (good_ || layout.statuses.empty()) return;
  std::string bytes = out.substr(begin);
  out.resize(begin);
  for (const FrameStatus& status : layout.statuses) spoil(status, bytes);
  std::ranges::fill(content_.present, 0);
  out += encode_frame(codec_, content_, bytes);  // with the checksums of what is not good
}

/// Frame after frame: `took` is called behind each with its number in the block.
template <class Took>
void VirtualStream::append_each(const VirtualSamples& samples, std::string& out, Took took) {
  if (samples.power_up != power_up_) {
    power_up_ = samples.power_up;
    counter_ = 0;
    clock_ = 0.0;
  }
  find_sources(samples);
  const auto& counter = codec_.frames[layout_].counter;
  const std::uint64_t step = counter && counter->step > 0 ? counter->step : 1;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const double since = static_cast<double>(samples.first + k) / rate_;
    append_frame(k, since + clock_, out);
    counter_ += step;
    took(k);
  }
}

void VirtualStream::append_frames(const VirtualSamples& samples, std::string& out) {
  append_each(samples, out, [](std::size_t) {});
}

std::vector<TimedBytes> VirtualStream::frames_of(const VirtualSamples& samples) {
  std::vector<TimedBytes> frames;
  frames.reserve(samples.size());
  std::string bytes;
  append_each(samples, bytes, [&](std::size_t k) {
    frames.push_back(
        {samples.channels.front().timeline.start + static_cast<double>(k + 1) / rate_, std::exchange(bytes, {})});
  });
  return frames;
}

}  // namespace tumble
