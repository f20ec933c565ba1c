#include <fmt/format.h>

#include <atomic>
#include <csignal>
#include <memory>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/rehearsal/serve_bench.hpp"
#include "tumble/units/error.hpp"
#include "verbs.hpp"
#include "wall_clock.hpp"

namespace tumble::cli {
namespace {

struct VirtualRigArguments {
  std::string plan, station, faults, speed = "1";
  std::uint64_t seed = 1;
};

std::atomic<bool> service_should_end{false};
static_assert(std::atomic<bool>::is_always_lock_free);

extern "C" void end_service(int) { service_should_end = true; }

std::vector<VirtualFault> faults_of(const std::string& path) {
  return path.empty() ? std::vector<VirtualFault>{} : read_faults(read_text_file(path), path);
}

int run(const VirtualRigArguments& arguments, const Terminal& terminal) {
  const Plan plan = tumble::load_plan(arguments.plan, {});
  Station station = load_station(arguments.station);
  const StationParts parts = parts_of(station);
  const double speed = speed_of(arguments.speed);
  VirtualBench bench(plan, station, parts, arguments.seed,
                     timed_faults(faults_of(arguments.faults), arguments.seed, random_faults_until(plan)));
  bench.put(mounted_for(plan, station));
  const double begin = wall_time();
  BenchServer server(
      bench, station, [begin, speed] { return speed * (wall_time() - begin); }, speed);
  std::vector<std::string> names;
  for (const auto& device : station.devices) names.push_back(device.name);
  for (const auto& instrument : station.instruments) names.push_back(instrument.slot);
  for (std::size_t w = 0; w < names.size(); ++w)
    if (!server.addresses()[w].empty()) print(fmt::format("{:16} {}\n", names[w], server.addresses()[w]));
  for (const int number : {SIGINT, SIGTERM}) std::signal(number, end_service);
  note(terminal, "the virtual rig is ready; Ctrl+C ends it");
  server.serve(service_should_end);
  return 0;
}

}  // namespace

Verb virtual_rig_verb() {
  auto arguments = std::make_shared<VirtualRigArguments>();
  return {"virtual-rig",
          "Play the rig of a plan at the links of a station, for other programs and for tests",
          {{"PLAN", &arguments->plan, "plan file (.toml) with [rig] and [truth]", true},
           {"--station", &arguments->station, "station file; its TCP ports are served on this machine", true},
           {"--faults", &arguments->faults, "file of faults that happen"},
           {"--speed", &arguments->speed, "how fast its clock goes: 50 means 50 s in each second"},
           {"--seed", &arguments->seed, "seed of the random numbers"}},
          "Example:\n"
          "  tumble virtual-rig north.toml --station bench.toml --speed 50\n",
          [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

}  // namespace tumble::cli
