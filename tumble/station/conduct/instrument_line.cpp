#include "tumble/station/conduct/instrument_line.hpp"

#include <limits>
#include <utility>

namespace tumble::conduct {

InstrumentLine::InstrumentLine(const StationInstrument& instrument, const StationParts::Stream& parts,
                               std::unique_ptr<InstrumentRecorder> stream, Wire wire, double time)
    : instrument_(&instrument),
      stream_(std::move(stream)),
      start_(
          parts.codec.link,
          [recorded = stream_.get(), wire](std::string_view bytes) {
            if (recorded) recorded->sent(wire.wires.now(), bytes);
            wire.wires.send(wire.link, bytes);
          },
          instrument.answer_within),
      heard_(time) {}

bool InstrumentLine::receive(std::string_view bytes, double time) {
  const std::uint64_t before = stream_->counts().channel_frames;
  stream_->receive(time, bytes);
  const bool has_frame = stream_->counts().channel_frames > before;  // bytes alone are no measurement
  if (has_frame) heard_ = time;
  return start_.receive(bytes, has_frame, time);
}

void InstrumentLine::link_is_up(double time) {
  stream_->restart();
  start_.link_is_up(time);
}

void InstrumentLine::begin_noise() {
  if (stream_) stream_->begin_noise();
}

void InstrumentLine::begin_bar() {
  if (stream_) stream_->begin_bar();
}

void InstrumentLine::finish() {
  if (stream_) stream_->finish();
}

double InstrumentLine::silence(const Hearing& hearing, double now) const {
  if (!stream_) return 0.0;
  const double silence = hearing.silence(heard_, now);
  return silence <= silence_of(*instrument_) ? 0.0 : silence;
}

void InstrumentLine::give_up() { heard_ = std::numeric_limits<double>::infinity(); }

Sentence InstrumentLine::missing(const Hearing& hearing, double now) const {
  return stream_ ? hearing.missing(heard_, stream_->rate(), now) : Sentence();
}

}  // namespace tumble::conduct
