#include <fmt/format.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <memory>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/tasks/departed.hpp"
#include "tumble/units/error.hpp"
#include "verbs.hpp"

namespace tumble::cli {
namespace {

struct SimulateArguments {
  std::string plan, output;
  std::uint64_t seed = 1;
  std::vector<std::string> sets, departures;
};

/// Bytes that no one uses at the moment.
std::size_t free_memory() {
  return static_cast<std::size_t>(sysconf(_SC_AVPHYS_PAGES)) * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

/// Files of a test with departures: one, or where they divide the recording FILE-1, FILE-2.
void write_departed(const Plan& plan, const SimulateArguments& arguments, const std::string& output,
                    const Terminal& terminal) {
  const auto recordings = tumble::simulate_departed(plan, wanted_departures(arguments.departures), arguments.seed);
  if (recordings.size() > 1 && output == standard_output)
    throw Error(Error::Kind::bad_input, "the departure divides the recording: it needs a file to write");
  const std::filesystem::path path(output);
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const auto name = fmt::format("{}-{}{}", path.stem().string(), i + 1, path.extension().string());
    const auto file = recordings.size() == 1 ? output : (path.parent_path() / name).string();
    write_recording(recordings[i], file);
    if (file != standard_output) note(terminal, say("wrote {} (seed {})", Name{file}, arguments.seed));
  }
}

int run(const SimulateArguments& arguments, const Terminal& terminal) {
  const auto output =
      arguments.output.empty() ? std::filesystem::path(arguments.plan).stem().string() + ".h5" : arguments.output;
  check_recording_output(output, {arguments.plan});
  const auto plan = tumble::load_plan(arguments.plan, parse_sets(arguments.sets));
  if (!arguments.departures.empty()) {
    write_departed(plan, arguments, output, terminal);
    return 0;
  }
  {
    ProgressLine line(terminal);
    tumble::simulate_to(output, plan, arguments.seed, free_memory() / 2, line.progress());
  }
  if (output != standard_output) note(terminal, say("wrote {} (seed {})", Name{output}, arguments.seed));
  return 0;
}

}  // namespace

Verb simulate_verb() {
  auto arguments = std::make_shared<SimulateArguments>();
  return {"simulate",
          "Simulate the test of a plan, with rig and instrument",
          {{"PLAN", &arguments->plan, "plan file (.toml) with [rig], [[schedule]] and [truth]", true},
           {"-o,--output", &arguments->output,
            "recording to write (default: <plan>.h5 in this folder); - writes CSV to standard output"},
           {"--seed", &arguments->seed, "seed of the random numbers; the same seed gives the same bytes"},
           departure_argument(arguments->departures),
           sets_argument(arguments->sets, "value that replaces that of the plan: truth.KEY, rig.KEY; repeatable")},
          "Examples:\n"
          "  tumble simulate fog.toml -o fog.h5 --seed 7\n"
          "  tumble simulate fog.toml -o fast.h5 --departure \"clock_fast=300 ppm\"\n"
          "  tumble simulate fog.toml -o quiet.csv --set truth.angle_random_walk=\"0 deg/sqrt(h)\"\n",
          [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

}  // namespace tumble::cli
