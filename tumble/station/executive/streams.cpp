
#include "tumble/station/executive/turn.hpp"

namespace tumble::executive {

using Stream = StreamProgress::Status;

void start_streams(Turn& turn) {
  for (std::size_t i = 0; i < turn.state.streams.size(); ++i) {
    const auto& instrument = turn.station().instruments[i];
    auto& progress = turn.state.streams[i];
    if (!instrument.start || progress.status != Stream::off || has_word(turn.state.units_out, instrument.slot))
      continue;
    progress = {Stream::starting, turn.now() + instrument.start_within};
    turn.act(StreamSwitch{instrument.slot, true});
  }
}

void stop_streams(Turn& turn) {
  for (std::size_t i = 0; i < turn.state.streams.size(); ++i) {
    if (turn.state.streams[i].status == Stream::off) continue;
    turn.state.streams[i].status = Stream::off;
    turn.act(StreamSwitch{turn.station().instruments[i].slot, false});
  }
}

void forget_streams(Turn& turn) {
  for (auto& progress : turn.state.streams) progress.status = Stream::off;
}

bool streams_run(Turn& turn) {
  bool all = true;
  for (std::size_t i = 0; i < turn.state.streams.size(); ++i) {
    auto& progress = turn.state.streams[i];
    const auto& instrument = turn.station().instruments[i];
    if (progress.status != Stream::starting || has_word(turn.state.units_out, instrument.slot)) continue;
    if (turn.reached(progress.due))
      take_unit_failed(turn,
                       {instrument.slot, say("its stream has not started within {:.3g} s", instrument.start_within)});
    else
      all = false;
  }
  return all && is_active(turn.state.phase);
}

void take_started(Turn& turn, const StreamStarted& started) {
  for (std::size_t i = 0; i < turn.state.streams.size(); ++i) {
    auto& progress = turn.state.streams[i];
    if (turn.station().instruments[i].slot != started.slot || progress.status != Stream::starting) continue;
    progress.status = Stream::on;
    turn.note(EventKind::stream, say("the unit in slot {} delivers since it was started", Name{started.slot}));
  }
}

}  // namespace tumble::executive
