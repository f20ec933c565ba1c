#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tumble/recorder/live_estimates.hpp"
#include "tumble/recorder/recorder.hpp"
#include "tumble/wire/frames.hpp"

namespace tumble {

/// Mean, standard deviation and Allan deviation at one averaging time, sample after sample in constant memory.
class LiveNoise {
 public:
  explicit LiveNoise(double tau = 1.0) : tau_(tau) {}  ///< [s]
  void add(double time, double value);                 ///< time [s]; a value that is NaN is a gap
  std::size_t count() const { return count_; }
  double mean() const { return mean_; }  ///< [u]
  double sd() const;                     ///< [u]; NaN for fewer than 2
  /// sigma^2 = mean of (y_{k+1} - y_k)^2/2 over means y_k of adjacent spans of tau; NaN for fewer than 2 spans.
  double allan() const;  ///< [u]

 private:
  double tau_;
  std::size_t count_ = 0, in_span_ = 0, spans_ = 0, pairs_ = 0;
  double mean_ = 0.0, squares_ = 0.0;
  double span_end_ = 0.0, span_sum_ = 0.0, last_mean_ = 0.0, pair_squares_ = 0.0;
  bool running_ = false, last_holds_ = false;
};

/// An instrument whose stream is recorded: its bytes, its samples, and what people want to see of it.
class InstrumentRecorder {
 public:
  struct Shown {
    FrameChannel channel;
    LiveNoise noise;  ///< [SI]; of increments as they come: times rate() they are the signal
    double last = std::numeric_limits<double>::quiet_NaN();  ///< [SI] the last sample, as in `noise`; NaN: none yet
    bool seen = false;                                       ///< a number has come since the beginning
    /// [SI] least and greatest since begin_bar(); NaN: no number has come
    double low = std::numeric_limits<double>::quiet_NaN(), high = std::numeric_limits<double>::quiet_NaN();
  };

  /// `codec` must live as long, and is that of the declaration of the link. `live`, which may be null, gets the samples
  /// too.
  InstrumentRecorder(Recorder& recorder, const FrameCodec& codec, StoreLink link, LiveEstimates* live = nullptr);

  /// Bytes that arrived at `time` [s]: kept, decoded, and the samples kept. False: the recorder has stopped.
  bool receive(double time, std::string_view bytes);
  /// Bytes that were sent to the instrument at `time` [s].
  void sent(double time, std::string_view bytes);
  /// Mean, deviation and Allan deviation are those of the samples from now on.
  void begin_noise();
  /// Least and greatest are those of the samples from now on.
  void begin_bar();
  /// Samples that wait for others before them are kept: nothing more comes.
  void finish();
  /// The link came back: what is half decoded is given up, and the counts begin again.
  void restart();

  const FrameCounts& counts() const { return stream_.counts(); }  ///< since the last restart
  const std::vector<Shown>& shown() const { return shown_; }      ///< channels that were seen, by index in the codec
  double rate() const;  ///< [Hz] of the frames that carry channels; 0: unknown

 private:
  double arrival_of(const StreamFrame& frame) const;  ///< [s]
  void take(const StreamFrame& frame);
  std::size_t stream_of(const FrameContent& content);

  Recorder& recorder_;
  const FrameCodec& codec_;
  LiveEstimates* live_ = nullptr;
  StoreLink description_;
  std::size_t link_ = 0;
  FrameStream stream_;
  std::deque<std::pair<std::uint64_t, double>>
      arrivals_;  ///< the end [byte of the stream] of a piece, and its time [s]
  std::map<std::vector<unsigned char>, std::size_t> streams_;  ///< by presence of the channels
  std::vector<double> values_;
  std::vector<Shown> shown_;
  double first_time_ = 0.0, last_time_ = 0.0;  ///< [s]
  std::uint64_t first_ = 0, last_ = 0;         ///< sequence
  bool running_ = false;
};

}  // namespace tumble
