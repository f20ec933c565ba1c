#pragma once

#include <algorithm>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "tumble/station/executive.hpp"

namespace tumble::executive {

using Demand = AxisProgress::Demand;
using Purpose = PendingRequest::Purpose;

constexpr int readings_at_rest = 3;        ///< one after the other, so that a sine at its turning point does not count
constexpr int readings_outside = 3;        ///< out of tolerance, after which an attempt fails
constexpr int most_sends = 3;              ///< of one request
constexpr int most_restarts = 10;          ///< of a dwell time
constexpr double rest_deadline = 60.0;     ///< [s] for axes to come to rest
constexpr double standard_zero = 1.75e-4;  ///< [rad/s] what counts as zero rate where nothing is stated: 0.01 deg/s

/// One call of step().
struct Turn {
  ExecutiveState& state;
  const Course& course;
  std::vector<RunAction>& actions;
  double wake = std::numeric_limits<double>::infinity();  ///< [s] the next time that matters

  /// [s]
  double now() const { return state.now; }
  const Station& station() const { return course.station; }
  const Segment& segment() const { return course.schedule[state.segment]; }
  /// Whether that time [s] has come; if not, a tick is wanted then.
  bool reached(double time) {
    if (state.now >= time) return true;
    wake = std::min(wake, time);
    return false;
  }
  template <class T>
  void act(T action) {
    actions.emplace_back(std::move(action));
  }
  void note(EventKind kind, Sentence text) { act(Note{kind, std::move(text)}); }
};

bool has_word(const std::vector<std::string>& list, const std::string& word);

/// The word of a state of the run, which no language changes.
inline Name word_of(RunPhase phase) { return {std::string(name(phase))}; }

// phases.cpp
void enter(Turn& turn, RunPhase phase);
/// preparing to finishing, holding, pausing, paused.
bool is_active(RunPhase phase);
/// moving, settling, dwelling, recording.
bool in_attempt(RunPhase phase);

// devices.cpp
std::size_t device_of(const Turn& turn, const std::string& name);  ///< the number of devices if none has that name
void ask(Turn& turn, std::size_t device, const PendingRequest& request);
/// Requests of this purpose that wait or are on their way.
bool outstanding(const Turn& turn, Purpose purpose);
void drop_requests(Turn& turn);
void take_reply(Turn& turn, const DeviceReply& reply);
void take_lost(Turn& turn, const LinkLost& lost);
void take_up(Turn& turn, const LinkUp& up);
void check_timeouts(Turn& turn);
/// Extends by `overslept` [s] all times within which something had to happen, because nobody looked for so long.
void forgive(Turn& turn, double overslept);
void send_waiting(Turn& turn);

/// [s] in which the verb must be answered.
double time_to_answer(const StationDevice& device, ControllerVerb verb);

// set_points.cpp
/// The request was acknowledged: where it sets a temperature that the controller can read back, it must do so in time.
void expect_set_point(Turn& turn, std::size_t device, const ControllerRequest& request);
std::vector<ControllerRequest> polls_of_set_points(const Turn& turn, std::size_t device);
void take_set_point(Turn& turn, std::size_t device, int axis, const ControllerReply& reply);
bool has_open_set_points(const Turn& turn);
/// Set points that are overdue are failures.
void check_set_points(Turn& turn, std::size_t device);

// axes.cpp
void take_reading(Turn& turn, std::size_t device, int number, const ControllerReply& reply);
void take_values(Turn& turn, const ChannelValues& values);
/// Value [SI] or word of a channel; nothing where its last news is `stale` [s] old.
ChannelReading reading_of(const Turn& turn, const std::string& channel, double stale);
/// Whether the axis already does what the request asks for.
bool has_effect(const Turn& turn, std::size_t device, const ControllerRequest& request);
/// [rad/s] what counts as standing still.
double zero_rate(const StationAxis& axis);
bool all_at_rest(const Turn& turn);
void restart_settling(Turn& turn);
bool all_settled(Turn& turn);
/// An axis with three readings in a row out of tolerance, in words; empty: none.
Sentence left_tolerance(const Turn& turn, int readings);
Sentence why_not_settled(const Turn& turn);
/// [s] the longest of the axes that have a demand.
double settle_timeout(const Turn& turn);
/// [s] the longest of the axes that the segment moves.
double soak_time(const Turn& turn);
void begin_means(Turn& turn);
/// [SI] by channel: what is demanded, and the mean of what was read while recording.
std::map<std::string, double> demanded(const Turn& turn);
/// [SI] by channel.
std::map<std::string, double> achieved(const Turn& turn);

// rates.cpp
/// One more reading of the rate of an axis that turns; `derived` from its positions.
void watch_rate(Turn& turn, const StationAxis& axis, AxisProgress& progress, bool derived);
/// An axis that turns without a command stops the run.
void check_rates(Turn& turn);
/// [rad/s] within which a commanded rate counts as reached.
double rate_tolerance(const StationAxis& axis, double rate);

// motions.cpp
/// Where the axes of the rig are before the segment is recorded, as far as the schedule says: its own motions, what
/// segments before it in this power-up hold, and the begin of its ramps.
std::map<std::string, Motion> motions_before_recording(const Turn& turn);
/// Sends these motions.
void send_motions(Turn& turn);
/// Begins ramps and slews.
void begin_ramps(Turn& turn);
void continue_ramps(Turn& turn);
void end_ramps(Turn& turn);
/// Whether an axis turns, oscillates, or is on its way.
bool is_in_motion(const Turn& turn);
/// Stops what turns or oscillates.
void rest_axes(Turn& turn, Purpose purpose);

// segments.cpp
void next_segment(Turn& turn);
void begin_attempt(Turn& turn);
/// Writes the end of the attempt that is open; nothing where none is.
void end_attempt(Turn& turn, RunRow::Ending ending, const Sentence& reason);
/// The reason is a copy, as for begin_safe.
void attempt_failed(Turn& turn, Sentence reason);
void advance_segment(Turn& turn);
void take_estimate(Turn& turn, const EstimateNow& estimate);

// conduct.cpp
void start(Turn& turn);
void advance_preparing(Turn& turn);
void advance_finishing(Turn& turn);
void begin_finishing(Turn& turn);
void begin_pause(Turn& turn);
void advance_pausing(Turn& turn);
/// True when the axes may go to where the segment begins. In a plan with several power-ups the unit is off until they
/// are there: it begins each power-up soaked and at rest there, as in the simulation of the plan.
bool may_move(Turn& turn);
/// Whether the segment is the first of one of several power-ups, which a supply makes: an attempt that failed is
/// repeated with a further one, because the recording of a power-up begins with it.
bool begins_power_up(const Turn& turn);
/// True when the unit is in the power-up of the segment.
bool power_is_right(Turn& turn);
void power_up_row(Turn& turn);

// streams.cpp
/// Starts the streams that commands start, of the units that are in the run and have power.
void start_streams(Turn& turn);
void stop_streams(Turn& turn);
/// The units were switched off: their streams must be started again.
void forget_streams(Turn& turn);
/// Whether all that were to be started deliver; a unit whose stream is overdue drops out.
bool streams_run(Turn& turn);
void take_started(Turn& turn, const StreamStarted& started);

// watch.cpp
void open_prompt(Turn& turn, OpenPrompt::About about, Sentence text, std::vector<std::string> choices);
void close_prompt(Turn& turn);
void take_answer(Turn& turn, const PromptAnswer& answer);
void take_order(Turn& turn, const RunOrder& order);
void take_unit_failed(Turn& turn, const UnitFailed& failed);
void check_prompt(Turn& turn);
/// `more`: other news have arrived already, so that a channel without any is not judged yet.
void check_interlocks(Turn& turn, bool more);
/// A hold condition that is not met, as it is written; null: all are.
const StationInterlock* broken_hold(Turn& turn);
void advance_holding(Turn& turn);

// safe.cpp
/// Begins the safe list, once. `phase` is stopping or aborting. The reason is a copy: the failures of the state, where
/// it often stands, are cleared here.
void begin_safe(Turn& turn, RunPhase phase, RunEnding ending, Sentence reason);
void advance_safe(Turn& turn);
void take_safe_reply(Turn& turn, std::size_t index, bool refused);

// journal.cpp
void write_row(Turn& turn, RunRow row);
/// Whether it moves the rig, and a row of the journal is not on the disk yet.
bool waits_for_row(const Turn& turn, const PendingRequest& request);
void take_stored(Turn& turn, const RowsStored& stored);

}  // namespace tumble::executive
