#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "tumble/recorder/recorder_stream.hpp"
#include "tumble/station/carry_out.hpp"
#include "tumble/station/conduct/hearing.hpp"
#include "tumble/station/conduct/stream_line.hpp"
#include "tumble/station/wires.hpp"

namespace tumble::conduct {

/// An instrument at its wire: its stream, which is recorded, the commands that start the stream, and when a sample came
/// last.
class InstrumentLine {
 public:
  /// A link of the station by its number, on the wires, which must live as long.
  struct Wire {
    const Wires& wires;
    std::size_t link = 0;
  };

  /// Instrument, declaration and wires must live as long.
  ///
  /// Given     stream  what records it; null: nothing is recorded
  ///           time    [s] from which on samples are missed
  InstrumentLine(const StationInstrument& instrument, const StationParts::Stream& parts,
                 std::unique_ptr<InstrumentRecorder> stream, Wire wire, double time);

  const std::string& slot() const { return instrument_->slot; }
  const InstrumentRecorder* stream() const { return stream_.get(); }  ///< null: nothing is recorded

  /// Bytes that arrived at `time` [s]. Returned: the stream runs from now on.
  bool receive(std::string_view bytes, double time);
  /// The link came back at `time` [s]: what was half decoded, or sent, may be lost.
  void link_is_up(double time);
  /// Sends the commands that start the stream, or those that stop it.
  void start(double time) { start_.start(time); }  ///< [s]
  void stop() { start_.stop(); }
  /// Sends again what is overdue at `now` [s]. Returned: what did not come; empty: nothing is overdue.
  Sentence at(double now) { return start_.at(now); }
  /// [s] when at() has something to do.
  double next() const { return start_.next(); }

  /// Mean and deviation, or least and greatest, are those of the samples from now on.
  void begin_noise();
  void begin_bar();
  /// Nothing more comes.
  void finish();

  /// [s] without a sample, where that is longer than the station lets it be; 0: it is not.
  double silence(const Hearing& hearing, double now) const;
  /// It has failed: nothing is expected of it any more.
  void give_up();
  /// In words what did not come until `now` [s], the end of a segment; empty: all came.
  Sentence missing(const Hearing& hearing, double now) const;

 private:
  const StationInstrument* instrument_;
  std::unique_ptr<InstrumentRecorder> stream_;
  StreamLine start_;
  double heard_;  ///< [s] the last sample
};

}  // namespace tumble::conduct
