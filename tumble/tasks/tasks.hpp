#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/evidence.hpp"
#include "tumble/core/progress.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/reduce/compensate.hpp"
#include "tumble/sim/simulate.hpp"

/// One function per user intent: all that a front end may call.
namespace tumble {

/// The `--set key=value` of a command line. Plain keys are [settings] of the method, "truth.key" and "rig.key" those of
/// the other tables, "channels.role" that of [channels]; "rate", "missing", "columns", "segment_column", "topic",
/// "frames" and "unit.column" say what a file does not.
using Sets = std::vector<std::pair<std::string, std::string>>;

/// Reads and checks a plan; `sets` override it. What they say of reading files becomes Plan::reading.
/// Throws Error::bad_input with every unknown key, bare number, wrong dimension and unknown name at once, each as
/// "plan.toml:LINE: ..."; Error::bad_file when the file cannot be read.
Plan load_plan(const std::string& path, const Sets& sets);

/// A plan that is only a method's name and its settings, for methods that need none. Throws Error::bad_input.
Plan plan_for_method(const std::string& method, const Sets& sets);

/// For verbs that read files without a plan: `sets`, all of which speak of reading. Throws Error::bad_input for
/// anything else.
ReadOptions read_options(const Sets& sets);

/// Reads the recordings (the plan's, then those given), gives marks from the schedule to files that have none, and
/// checks that every recording has the channels the method needs, in units of the right dimension.
/// Throws Error::bad_data with everything that is missing or wrong in any file; Error::bad_file.
Evidence gather(Plan plan, const std::vector<std::string>& recordings, const Progress& progress);

/// Gathers as above, with recordings that are in memory already after those of files; of their channels those that the
/// method needs.
Evidence gather(Plan plan, const std::vector<std::string>& files, std::vector<Recording> in_memory,
                const Progress& progress);

/// Runs the plan's method; adds the findings of readers and checks, judges the limits, fills in the provenance. Where
/// encoders recorded that an axis turned or oscillated with another phase than the plan says, theirs is used
/// (reduce/table/recorded_turns.hpp).
Estimate identify(const Evidence& evidence, const Progress& progress);
Estimate identify(Evidence&& evidence, const Progress& progress);  ///< the same without a copy of the samples

/// Gathers and identifies. A recording whose samples take more than `memory` bytes is worked through block after block
/// where the method can: with the same result except for the findings of the checks, which see a recording as a whole,
/// and what the method's page says.
Estimate identify(const Plan& plan, const std::vector<std::string>& recordings, std::uintmax_t memory,
                  const Progress& progress);

/// The plan carried out on a simulated rig and instrument of known truth.
using tumble::simulate;

/// The plan simulated into a file: at once where the samples take less than `memory` bytes, else block after block, so
/// that the recording may be larger than memory. Either way the file holds the same samples.
void simulate_to(const std::string& path, const Plan& plan, std::uint64_t seed, std::size_t memory,
                 const Progress& progress);

/// The uncertainties before a sample is taken, with the plan's truth as values: from the plan's method, or, if it does
/// not predict or the plan has no method, from the instrument's table of terms over the schedule. Terms that cannot be
/// distinguished give a finding, which says what to add to the schedule.
/// Throws Error::bad_input with all that the plan lacks.
Estimate predict(const Plan& plan);

/// The uncertainties from the table of terms, for any method; `terms` limits it to these, empty: all. `advise`: say
/// which motions would distinguish the terms that the schedule does not.
Estimate predict_model(const Plan& plan, const std::vector<std::string>& terms, bool advise = true);

/// Pass, fail or undecided for every limit, from the 95 % interval of the parameter (Student's t). A limit on a
/// parameter that the result does not have, because the evidence does not show it or the name is wrong, is undecided:
/// `findings` says so. Throws Error::bad_input with every wrong unit.
std::vector<Verdict> judge(const std::vector<Limit>& limits, const Estimate& estimate, Findings& findings);

/// From one file and format to another.
using tumble::convert;

/// One channel of a recording in numbers.
struct ChannelSummary {
  std::string name;
  QuantityKind kind = QuantityKind::other;
  Unit unit;
  bool uniform = true;  ///< evenly sampled by declaration, without stamps
  std::size_t samples = 0, missing = 0;
  double first = 0.0, last = 0.0;                             ///< [s]
  double minimum = 0.0, mean = 0.0, maximum = 0.0, sd = 0.0;  ///< of the samples that are not missing [SI]

  double rate() const { return samples > 1 ? static_cast<double>(samples - 1) / (last - first) : 0.0; }  ///< [Hz]
};

/// Contents of a file.
struct Inspection {
  Recording header;  ///< everything but the samples
  std::vector<ChannelSummary> channels;
  Findings findings;  ///< of the reader and, unless the file was too large for it, of the checks
};

/// Files up to `whole_below` bytes are read whole and pass the checks; larger ones are streamed.
Inspection inspect(const std::string& path, const ReadOptions& options, const Progress& progress,
                   std::uintmax_t whole_below = 2'000'000'000);

}  // namespace tumble
