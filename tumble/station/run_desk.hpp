#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tumble/station/carry_out.hpp"

/// The desk of a run: where other processes watch it, answer its questions, and give it orders. It is a socket in the
/// folder of the run, which the user of the run alone may open. The live store has one connection (decision 072), so
/// that what is seen of a run comes from the process that carries it out.
namespace tumble {

/// Name of the socket in the folder of a run.
inline constexpr std::string_view desk_name = "desk";

/// Facts of a run that do not change while it goes on.
struct RunFacts {
  std::string title, station, who;
  std::string rig;                           ///< empty: a real one; else "virtual" or "rehearsed"
  std::map<std::string, std::string> units;  ///< serial number by slot
  struct Segment {
    std::string label;
    double duration = 0.0;  ///< [s]
    std::string rule;       ///< its stopping rule
  };
  std::vector<Segment> segments;
};
RunFacts facts_of(const std::string& title, const Course& course, const std::string& who, const std::string& rig);

/// The side of the run. Its thread speaks with the others, so that the run waits for none of them; one that does not
/// read what is sent is hung up on. All functions are called by the thread of the run.
class RunDesk {
 public:
  RunDesk();
  RunDesk(const RunDesk&) = delete;
  RunDesk& operator=(const RunDesk&) = delete;
  ~RunDesk();  ///< says that the process has ended, and hangs up

  /// Opens the socket in the folder of the run.
  ///
  /// Given     speed  [1] of the clock of the run against that of the wall; 0: as fast as it goes
  ///
  /// Throws    Error::bad_file where there can be no socket; a run goes on without
  void open(const std::string& folder, const RunFacts& facts, double speed);
  void remember(std::uint64_t sequence, const StoreEvent& event);
  /// The run has ended; the process still works on its files.
  void ended(const RunEnd& end);

  /// A company that hears of the run what this one does, and gives the orders of both.
  RunCompany beside(RunCompany company);

 private:
  struct Inner;
  std::unique_ptr<Inner> inner_;
};

/// Gives a desk the events that a run which is carried on recorded before. Throws Error::bad_file.
void remember_run(RunDesk& desk, const std::string& folder);

/// Opens the desk of a run, whose clock has this speed [1] as in open(), and gives the company beside which it is.
/// Where the folder can have no socket, the run goes on without, and a note says so.
RunCompany at_desk(RunDesk& desk, const std::string& folder, const RunFacts& facts, double speed,
                   const RunCompany& company);

/// Asks a run that goes on, and returns its answer, one line of JSON.
///
/// Given     run      its folder
///           request  {"ask": "state"}, or {"order": ORDER, "who": NAME}, where ORDER is pause, resume, stop, abort, or
///                    answer with "prompt": NUMBER and "choice": WORD
///
///           patience [s] until it must have answered
///
/// Throws    Error::unsupported: the run does not go on; Error::bad_input: the run refuses, with its reason;
///           Error::bad_file: it has not answered
std::string ask_desk(const std::string& run, const std::string& request, double patience = 10.0);

/// Stops a run by its desk. Where that does not answer, its process gets the signal by which `tumble stop` stops it,
/// and goes on if somebody had suspended it; then the desk is asked once more. Returns when the run has taken the
/// order, or has ended: after at most two times `patience` [s] and a moment. Throws Error::unsupported: the run does
/// not go on; Error::bad_input: it refuses; Error::bad_file: it belongs to another user, or has got the signal and does
/// not answer, so that nobody knows whether it stops.
void stop_run(const std::string& run, const std::string& who, double patience = 10.0);

/// The process that a desk belongs to; nothing where the run does not go on. It is not waited for.
std::optional<long> process_at_desk(const std::string& run);

/// Events of a run that goes on, line after line.
class DeskWatch {
 public:
  struct Line {
    std::string name;  ///< "happened", "view", "end"
    std::uint64_t sequence = 0;
    std::string json;
  };
  /// Throws Error::unsupported: the run does not go on.
  explicit DeskWatch(const std::string& run);
  DeskWatch(const DeskWatch&) = delete;
  DeskWatch& operator=(const DeskWatch&) = delete;
  ~DeskWatch();

  /// The events of the run so far come first, then what happens. Nothing: the run has ended, or close() was called.
  std::optional<Line> next();
  /// From any thread: next() returns.
  void close();

 private:
  int socket_ = -1;
  std::string waiting_;
};

/// The state of a run that does not go on, as {"ask": "state"} gives that of one that does. Throws Error::bad_file.
std::string state_of_ended_run(const std::string& run);

}  // namespace tumble
