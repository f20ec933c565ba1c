#pragma once

#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tumble/recorder/live_estimates.hpp"
#include "tumble/recorder/recorder.hpp"
#include "tumble/station/executive.hpp"
#include "tumble/station/wires.hpp"
#include "tumble/wire/controller.hpp"
#include "tumble/wire/frames.hpp"

/// Carries a plan out: the pure executive decides, this does what it says over wires and writes it all into the live
/// store. The only other part that acts is the link layer.
namespace tumble {

/// The declarations that a station names, in the order of its devices and instruments.
struct StationParts {
  /// A declaration of frames with its text, so that a run can be decoded again.
  struct Stream {
    std::string name, text;
    std::vector<std::string> variants;
    FrameCodec codec;
  };
  std::vector<Controller> controllers;
  std::vector<Stream> streams;
};

/// Reads them: shipped ones by name, others from files beside the station file. The verbs that each controller has are
/// entered into the station.
/// Throws Error::bad_input with all problems.
StationParts parts_of(Station& station);

/// State of a run that a person may see while it goes on.
struct RunView {
  double time = 0.0;  ///< [s] since it began
  RunPhase phase = RunPhase::idle;
  std::size_t segment = 0, segments = 0;
  std::string label;
  double left = 0.0;                      ///< [s] of the schedule, without ways and waiting
  double recorded = 0.0;                  ///< [s] of this segment
  std::vector<SegmentProgress> progress;  ///< by segment of the course
  struct AxisView {
    std::string name;
    StationAxis::Kind kind = StationAxis::Kind::angle;
    AxisProgress::Demand demand = AxisProgress::Demand::none;
    double demanded = 0.0;  ///< [SI]
    std::optional<double> position, rate, temperature;
  };
  std::vector<AxisView> axes;
  struct ChannelView {
    std::string slot, name;
    Unit unit;
    double mean = 0.0, sd = 0.0, allan = 0.0;  ///< [SI] of this segment
    /// [SI] least and greatest sample since the last view; NaN: none has come
    double low = std::numeric_limits<double>::quiet_NaN(), high = std::numeric_limits<double>::quiet_NaN();
  };
  std::vector<ChannelView> channels;
  struct EstimateView {
    std::string slot, name;
    Unit unit;
    double value = 0.0, sd = 0.0;  ///< [SI]
  };
  std::vector<EstimateView> estimates;              ///< the answer of the method from what has been recorded so far
  std::uint64_t frames = 0, lost = 0, damaged = 0;  ///< of all streams
  std::optional<Prompt> prompt;
  double acknowledged = 0.0;   ///< [s] up to which everything is on the disk
  std::uint64_t sequence = 0;  ///< up to which items are on the disk, and their events were handed out
};

/// People who take part in a run, and the functions that show it to them.
struct RunCompany {
  /// Orders and answers since the last call.
  std::function<std::vector<decltype(RunEvent::what)>()> orders = {};
  std::function<void(const Prompt&)> ask = {};
  /// Axes that a person has moved, as the answers to prompts say [SI].
  std::function<void(const std::map<std::string, double>&)> by_hand = {};
  /// Takes a note of each event, and "records" for each segment; `time` [s] since the begin.
  std::function<void(const Note& note, double time)> note = {};
  /// The events of the store, in order, once they are on the disk; `sequence` is 0 where the recording has stopped.
  std::function<void(std::uint64_t sequence, const StoreEvent& event)> event = {};
  /// The rows of the journal in the same order, each with its time [s] in the store.
  std::function<void(std::uint64_t sequence, double time, const RunRow& row)> row = {};
  std::function<void(const RunView&)> show = {};
  double show_every = 0.5;  ///< [s] of the station's clock
  /// [s of the station's clock] that the disk may take for a row of the journal. What would move the rig waits for it,
  /// and the supervision goes on; after it the rig is brought to its safe state. Infinite: a rehearsal, whose clock
  /// stands while the disk works.
  double longest_commit = std::numeric_limits<double>::infinity();
  /// Is called with each look at the rig. Returned: why somebody else has stopped the rig; empty: nobody has.
  std::function<Sentence()> looked = {};
  std::function<void()> over = {};     ///< nobody looks at the rig any more; what was recorded is written still
  LiveEstimates* estimates = nullptr;  ///< stopping rules need it
};

/// Carries the course out from this state to its end.
///
/// Given     state     from start_state() or resume_state()
///           parts     of the station; must live as long
///           recorder  open; its end record is written here
///
/// Returned  how it ended, in words for a person
RunEnd carry_out(ExecutiveState state, const StationParts& parts, const Wires& wires, Recorder& recorder,
                 const RunCompany& company = {});

/// The journal of a run, from its live store: what resume_state() takes. Throws Error::bad_file.
std::vector<RunRow> journal_of(const std::string& run);

/// [s] of the latest item of its live store; 0: it has none. What goes on with the run has later times. Throws
/// Error::bad_file.
double end_of(const std::string& run);

/// These wires, with a clock that stands at `later` [s] when theirs stands at 0.
Wires shifted(Wires wires, double later);

}  // namespace tumble
