#include "tumble/tasks/validate.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>

#include "tumble/math/parallel.hpp"
#include "tumble/tasks/validation/bench.hpp"
#include "tumble/tasks/validation/coverage.hpp"
#include "tumble/tasks/validation/sizes.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace validation {
namespace {

/// Says how far the work is, from the thread that began it alone.
class Counted {
 public:
  Counted(const Progress& progress, std::size_t all) : progress_(progress), all_(static_cast<double>(all)) {}
  void add(std::size_t tests, std::string_view what) {
    const std::size_t done = done_ += tests;
    if (std::this_thread::get_id() == own_) report(progress_, std::min(1.0, static_cast<double>(done) / all_), what);
  }

 private:
  const Progress& progress_;
  const double all_;
  std::atomic<std::size_t> done_ = 0;
  const std::thread::id own_ = std::this_thread::get_id();
};

/// The worst first: what moves a parameter furthest unnoticed, and of these what does so at the smallest size.
bool is_worse(const DepartureStudy& a, const DepartureStudy& b) {
  if (a.exposure != b.exposure) return a.exposure < b.exposure;
  if (a.exposure == Exposure::unnoticed && a.shift != b.shift) return a.shift > b.shift;
  const auto in_covered = [](const DepartureStudy& one) {
    return one.moves > 0.0 ? one.moves / one.covered : INFINITY;
  };
  return in_covered(a) < in_covered(b);
}

void study_departures(const Bench& bench, const std::vector<Cell>& cells, const ValidateOptions& options,
                      Counted& counted, Validation& validation) {
  std::vector<Studied> studied(cells.size());
  parallel_for(cells.size(), [&](std::size_t i) {
    studied[i] = study(bench, cells[i], options.size);
    counted.add(tests_of_a_cell, cells[i].departure->name);
  });
  for (std::size_t i = 0; i < cells.size(); ++i) {
    validation.tests += studied[i].tests;
    if (studied[i].why_not)
      validation.not_tried.push_back({cells[i].departure, cells[i].target, *studied[i].why_not});
    else
      validation.departures.push_back(std::move(studied[i].study));
  }
  std::ranges::stable_sort(validation.departures, is_worse);
}

/// The answers of all sound tests.
std::vector<Answer> answers_of(const Bench& bench) {
  std::vector<Answer> answers;
  for (const Outcome& one : bench.sound) answers.push_back(one.answer);
  return answers;
}

void refuse_options(const ValidateOptions& options) {
  if (options.trials < seeds) throw Error(Error::Kind::bad_input, say("a validation needs {} trials or more", seeds));
  if (options.size && options.departure.empty())
    throw Error(Error::Kind::bad_input, say("a size needs the departure that has it"));
  if (!options.target.empty() && options.departure.empty())
    throw Error(Error::Kind::bad_input, say("a target needs the departure that happens to it"));
  if (!options.departure.empty()) find_departure(options.departure);
}

}  // namespace
}  // namespace validation

std::string_view name(Exposure exposure) {
  switch (exposure) {
    case Exposure::unnoticed:
      return "unnoticed";
    case Exposure::named_in_time:
      return "named in time";
    case Exposure::harmless:
      break;
  }
  return "harmless";
}

Validation validate(const Plan& plan, const ValidateOptions& options, const Progress& progress) {
  using namespace validation;
  refuse_options(options);
  Bench bench = bench_of(plan, options.seed);
  const auto cells = cells_of(bench, options);
  const std::size_t all = options.trials + tests_of_a_cell * cells.size();
  if (options.begun) options.begun(all - 1);
  Counted counted(progress, all);
  carry_out_sound_tests(bench, options.trials, [&] { counted.add(1, "sound tests"); });
  Validation validation{.plan = plan, .trials = options.trials, .seed = options.seed, .tests = options.trials};
  validation.parameters = validated_parameters(bench);
  validation.not_predicted = bench.not_predicted;
  validation.sound = accusations_in(answers_of(bench));
  study_departures(bench, cells, options, counted, validation);
  return validation;
}

}  // namespace tumble
