#include <fmt/format.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <memory>

#include "tumble/formats/atomic_file.hpp"
#include "verbs.hpp"

namespace tumble::cli {
namespace {

struct SimulateArguments {
  std::string plan, output;
  std::uint64_t seed = 1;
  std::vector<std::string> sets;
};

/// Bytes that no one uses at the moment.
std::size_t free_memory() {
  return static_cast<std::size_t>(sysconf(_SC_AVPHYS_PAGES)) * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

int run(const SimulateArguments& arguments, const Terminal& terminal) {
  const auto output =
      arguments.output.empty() ? std::filesystem::path(arguments.plan).stem().string() + ".h5" : arguments.output;
  check_recording_output(output, {arguments.plan});
  const auto plan = tumble::load_plan(arguments.plan, parse_sets(arguments.sets));
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
           sets_argument(arguments->sets, "value that replaces that of the plan: truth.KEY, rig.KEY; repeatable")},
          "Examples:\n"
          "  tumble simulate fog.toml -o fog.h5 --seed 7\n"
          "  tumble simulate fog.toml -o quiet.csv --set truth.angle_random_walk=\"0 deg/sqrt(h)\"\n",
          [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

}  // namespace tumble::cli
