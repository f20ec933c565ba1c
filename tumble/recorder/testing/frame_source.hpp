#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tumble/wire/instruments.hpp"

namespace tumble {

/// For tests: an instrument that sends frames of a shipped declaration, with white noise on every channel.
class FrameSource {
 public:
  explicit FrameSource(const std::string& name, const std::string& layout,
                       const std::vector<std::string>& variants = {})
      : codec(codec_of(find_instrument(name), variants)) {
    while (codec.frames[content_.frame].name != layout) ++content_.frame;
    content_.values.resize(codec.channels.size());
    content_.present.resize(codec.channels.size());
    for (const FrameField& field : codec.frames[content_.frame].fields)
      if (!field.when) content_.present[field.channel] = 1;
  }

  FrameCodec codec;
  double rate = 1000.0;              ///< [Hz]
  double mean = 1e-5, noise = 1e-6;  ///< [SI] of every channel but the temperature

  /// The next frame.
  std::string next() {
    for (std::size_t i = 0; i < codec.channels.size(); ++i)
      content_.values[i] = codec.channels[i].name.starts_with("temp") ? 298.15 : mean + noise * random_();
    if (const auto& counter = codec.frames[content_.frame].counter) content_.counter = sent_ % counter->modulus;
    content_.time = static_cast<double>(sent_) / rate;
    ++sent_;
    return encode_frame(codec, content_);
  }
  std::uint64_t sent() const { return sent_; }

 private:
  FrameContent content_;
  std::uint64_t sent_ = 0;
  struct Noise {
    std::uint64_t state = 12345;
    double operator()() {  // a sum of four uniform numbers, of mean 0 and standard deviation 1
      double sum = 0.0;
      for (int i = 0; i < 4; ++i) {
        state = state * 6364136223846793005ULL + 1442695040888963407ULL;
        sum += static_cast<double>(state >> 11) * 0x1p-53 - 0.5;
      }
      return sum * 1.7320508075688772;
    }
  } random_;
};

}  // namespace tumble
