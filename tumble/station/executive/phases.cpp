
#include <algorithm>
#include <cassert>
#include <initializer_list>

#include "tumble/station/executive/turn.hpp"

namespace tumble {
namespace {

/// What may follow, except stopping and aborting, which may follow each state that is not an end.
std::initializer_list<RunPhase> followers(RunPhase phase) {
  using enum RunPhase;
  static constexpr std::initializer_list<RunPhase> of_idle{preparing}, of_preparing{ready},
      of_ready{moving, finishing, holding, pausing}, of_moving{settling, moving, between, holding, pausing},
      of_settling{dwelling, moving, between, holding, pausing},
      of_dwelling{recording, settling, moving, between, holding, pausing},
      of_recording{between, moving, holding, pausing}, of_between{moving, finishing, holding, pausing},
      of_finishing{complete}, of_holding{ready, moving, settling, between, pausing}, of_pausing{paused},
      of_paused{between}, of_stopping{safe, faulted}, none{};
  switch (phase) {
    case idle:
      return of_idle;
    case preparing:
      return of_preparing;
    case ready:
      return of_ready;
    case moving:
      return of_moving;
    case settling:
      return of_settling;
    case dwelling:
      return of_dwelling;
    case recording:
      return of_recording;
    case between:
      return of_between;
    case finishing:
      return of_finishing;
    case holding:
      return of_holding;
    case pausing:
      return of_pausing;
    case paused:
      return of_paused;
    case stopping:
    case aborting:
      return of_stopping;
    case complete:
    case safe:
    case faulted:
      break;
  }
  return none;
}

}  // namespace

const std::vector<RunPhase>& all_phases() {
  using enum RunPhase;
  static const std::vector<RunPhase> phases{idle,      preparing, ready,     moving,   settling, dwelling,
                                            recording, between,   finishing, complete, holding,  pausing,
                                            paused,    stopping,  aborting,  safe,     faulted};
  return phases;
}

bool is_end(RunPhase phase) {
  return phase == RunPhase::complete || phase == RunPhase::safe || phase == RunPhase::faulted;
}

bool may_follow(RunPhase from, RunPhase to) {
  using enum RunPhase;
  if (to == stopping || to == aborting) return !is_end(from) && from != stopping && from != aborting;
  const auto list = followers(from);
  return std::find(list.begin(), list.end(), to) != list.end();
}

namespace executive {

bool has_word(const std::vector<std::string>& list, const std::string& word) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

void enter(Turn& turn, RunPhase phase) {
  assert(may_follow(turn.state.phase, phase));
  turn.act(Note{EventKind::phase, say("{} -> {}", word_of(turn.state.phase), word_of(phase)), phase});
  turn.state.phase = phase;
  turn.state.entered = turn.now();
}

bool is_active(RunPhase phase) {
  using enum RunPhase;
  return phase != idle && !is_end(phase) && phase != stopping && phase != aborting;
}

bool in_attempt(RunPhase phase) {
  using enum RunPhase;
  return phase == moving || phase == settling || phase == dwelling || phase == recording;
}

}  // namespace executive
}  // namespace tumble
