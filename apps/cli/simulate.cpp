#include <fmt/format.h>
#include <unistd.h>

#include <charconv>
#include <cstdint>
#include <filesystem>
#include <memory>

#include "verbs.hpp"

namespace tumble::cli {
namespace {

struct Arguments {
  std::string plan, output;
  std::uint64_t seed = 1;
  std::vector<std::string> sets;
};

/// Bytes that no one uses at the moment.
std::size_t free_memory() {
  return static_cast<std::size_t>(sysconf(_SC_AVPHYS_PAGES)) * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

int run(const Arguments& arguments, const Terminal& terminal) {
  const auto output =
      arguments.output.empty() ? std::filesystem::path(arguments.plan).stem().string() + ".h5" : arguments.output;
  check_recording_output(output, {arguments.plan});
  const auto plan = tumble::load_plan(arguments.plan, parse_sets(arguments.sets));
  {
    ProgressLine line(terminal);
    tumble::simulate_to(output, plan, arguments.seed, free_memory() / 2, line.progress());
  }
  note(terminal, fmt::format("wrote {} (seed {})", output, arguments.seed));
  return 0;
}

}  // namespace

Verb add_simulate(CLI::App& program) {
  auto* app = program.add_subcommand("simulate", "Simulate the test of a plan, with rig and instrument");
  auto arguments = std::make_shared<Arguments>();
  app->add_option("PLAN", arguments->plan, "plan file (.toml) with [rig], [[schedule]] and [truth]")->required();
  app->add_option("-o,--output", arguments->output, "recording to write (default: <plan>.h5 in this folder)");
  app->add_option("--seed", arguments->seed, "seed of the random numbers; the same seed gives the same bytes")
      ->check(
          [](const std::string& text) {
            std::uint64_t value = 0;
            const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
            return fault == std::errc{} && end == text.data() + text.size()
                       ? std::string()
                       : "a whole number from 0 to 18446744073709551615 is expected, not '" + text + "'";
          },
          "SEED")
      ->capture_default_str();
  add_sets(*app, arguments->sets, "value that replaces that of the plan: truth.KEY, rig.KEY; repeatable");
  app->footer(
      "Examples:\n"
      "  tumble simulate fog.toml -o fog.h5 --seed 7\n"
      "  tumble simulate fog.toml -o quiet.csv --set truth.angle_random_walk=\"0 deg/sqrt(h)\"\n");
  return {app, [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

}  // namespace tumble::cli
