#include "tumble/station/conduct/view.hpp"

#include <algorithm>

namespace tumble::conduct {
namespace {

void add_stream(RunView& view, const std::string& slot, const InstrumentRecorder& stream) {
  const FrameCounts& counts = stream.counts();
  view.frames += counts.good;
  view.lost += counts.lost;
  view.damaged += counts.damaged.count;
  for (const auto& shown : stream.shown())
    view.channels.push_back({slot, shown.channel.name, shown.channel.unit, shown.noise.mean(), shown.noise.sd(),
                             shown.noise.allan(), shown.low, shown.high});
}

}  // namespace

RunView view_of(const ExecutiveState& state, const std::vector<InstrumentLine>& instruments, double time,
                double recorded) {
  RunView view;
  const Course& course = *state.course;
  view.time = time;
  view.phase = state.phase;
  view.segment = state.segment;
  view.segments = course.schedule.size();
  if (state.segment < course.schedule.size()) view.label = course.schedule[state.segment].label;
  for (std::size_t s = state.segment; s < course.schedule.size(); ++s) view.left += course.schedule[s].duration;
  if (state.recording) {
    view.recorded = std::min(recorded, course.schedule[state.segment].duration);
    view.left -= view.recorded;
  }
  view.progress = state.segments;
  for (std::size_t a = 0; a < state.axes.size(); ++a) {
    const AxisProgress& axis = state.axes[a];
    view.axes.push_back({course.station.axes[a].name, course.station.axes[a].kind, axis.demand, axis.value,
                         axis.position, axis.rate, axis.temperature});
  }
  for (const InstrumentLine& instrument : instruments)
    if (instrument.stream()) add_stream(view, instrument.slot(), *instrument.stream());
  return view;
}

}  // namespace tumble::conduct
