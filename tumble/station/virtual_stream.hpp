#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tumble/core/plan.hpp"
#include "tumble/station/virtual_rig.hpp"
#include "tumble/wire/frames.hpp"

namespace tumble {

/// A declaration of frames (docs/formats/frames.md) for the outputs and sensors that a plan simulates, where no real
/// instrument is named: sync, counter, time of the device, status, each channel as f64 in the unit in which people see
/// it, CRC-32. Returned: the text in TOML, which may be written to a file; its vector is made by hand.
/// Throws Error::bad_input with all that the plan lacks.
std::string frames_for(const Plan& plan);

/// One frame of a stream.
struct TimedBytes {
  double time = 0.0;  ///< [s] when it has been sent
  std::string bytes;
};

/// Turns samples into the frames of a declaration, one a sample: the first of its frames that carries channels.
class VirtualStream {
 public:
  /// `names`: the channel of the rig for a channel of the declaration, where they differ. A channel of the declaration
  /// that the rig does not have is NaN, or 0 where its bytes cannot say that.
  /// Throws Error::bad_input where no frame carries a channel. `sample_rate` [Hz].
  VirtualStream(FrameCodec codec, double sample_rate, std::map<std::string, std::string> names = {});

  /// A frame for each sample; its time is the end of the sample. What does not fit into its bytes stays at their end.
  /// Throws Error::bad_input where a channel of the rig is of another dimension than that of the declaration.
  std::vector<TimedBytes> frames_of(const VirtualSamples& samples);
  /// The bytes of these frames alone, behind what `out` holds. Throws as frames_of().
  void append_frames(const VirtualSamples& samples, std::string& out);

  /// Faults of the unit: the counter stands at `counter` with the next frame; the clock jumps by `step` [s]; the
  /// statuses of the frame are not good, or good again; the channel shows what it showed.
  void set_counter(std::uint64_t counter) { counter_ = counter; }
  void step_clock(double step) { clock_ += step; }
  void set_status(bool good) { good_ = good; }
  void freeze(const std::string& channel, bool on);

  const FrameCodec& codec() const { return codec_; }

 private:
  void find_sources(const VirtualSamples& samples);
  double sent_value(const FrameField& field, double value);
  void append_frame(std::size_t k, double device_time, std::string& out);
  template <class Took>
  void append_each(const VirtualSamples& samples, std::string& out, Took took);

  FrameCodec codec_;
  std::size_t layout_ = 0;  ///< the first that carries channels
  FrameEncoder encoder_;
  FrameContent content_;                 ///< of the frame that is made
  std::vector<const Channel*> sources_;  ///< of the samples that are sent, by field; null: the rig has none
  double rate_;
  std::map<std::string, std::string> names_;
  std::map<std::string, std::optional<double>> frozen_;  ///< [SI] by channel; empty until the next sample
  std::uint64_t counter_ = 0;
  double clock_ = 0.0;
  bool good_ = true;
  int power_up_ = 0;
};

}  // namespace tumble
