// How soon a station stops its rig over real TCP links of this machine, and how long a rehearsal of days takes; prints
// a page.
//
//   station FOLDER [TRIALS, 1000] [HOURS to rehearse, 72]
#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include "tumble/formats/checksum.hpp"
#include "tumble/station/carry_out.hpp"
#include "tumble/station/disk.hpp"
#include "tumble/station/link_wires.hpp"
#include "tumble/station/made_station.hpp"
#include "tumble/station/rehearse.hpp"
#include "tumble/station/run_folder.hpp"
#include "tumble/station/virtual_stream.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/constants.hpp"

namespace {

using namespace tumble;
namespace fs = std::filesystem;

double steady() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// [MB] of memory that the process has had at most.
double most_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1e-3 * double(usage.ru_maxrss);
}

Plan gyro_plan() { return load_plan(TUMBLE_SOURCE_DIR "/plans/gyro_scale_factor.toml", {}); }

/// A table that answers its polls: when told to, it has tripped its interlock.
struct Table {
  Links links{steady};
  std::uint16_t port = links.listen(0);
  std::string received;
  double rate = 0.0, tripped_at = 0.0, stopped_at = 0.0;

  void answer(std::size_t link, const std::string& line) {
    if (line == "STOP") {
      if (stopped_at == 0.0) stopped_at = steady();
      rate = 0.0;
    }
    if (line.starts_with("RATE ")) rate = std::atof(line.c_str() + 5);
    if (line == "READ?") return links.send(link, fmt::format("{:.6f},{:.6f}\n", 0.0, rate));
    if (line == "STATE?") return links.send(link, "READY\n");
    links.send(link, line == "*IDN?" ? "bench\n" : "OK\n");
  }
  /// Serves until the stop has come and the run has read that the table stands.
  void serve(const std::atomic<bool>& end) {
    while (!end)
      for (const LinkEvent& event : links.wait(0.002)) {
        received += event.bytes;
        for (auto at = received.find('\n'); at != std::string::npos; at = received.find('\n')) {
          answer(event.link, received.substr(0, at));
          received.erase(0, at + 1);
        }
      }
  }
};

/// Frames of the instrument: sound ones at 100 Hz, and one whose first channel is beyond every limit.
struct Unit {
  VirtualStream stream;
  VirtualSamples samples;
  double next = 0.0;

  explicit Unit(const Plan& plan) : stream(read_frames(frames_for(plan), "frames"), plan.sample_rate) {
    VirtualRig rig(plan, 1);
    rig.power(0.0, true);
    samples = rig.samples(1.5 / plan.sample_rate).front();
    for (Channel& channel : samples.channels) channel.values.resize(1);
  }
  std::string frame(double value) {
    samples.channels.front().values[0] = value;
    ++samples.first;
    return stream.frames_of(samples).front().bytes;
  }
  const std::string& channel() const { return samples.channels.front().name; }
};

/// One run until an interlock stops it. Returned: [s] from the sending of the sample to the arrival of the stop.
double trial(const Plan& plan, Station station, const std::string& folder, int number) {
  Table table;
  Unit unit(plan);
  Links source(steady);
  const std::uint16_t door = source.listen(0);
  station.devices[0].link = fmt::format("tcp:127.0.0.1:{}", table.port);
  station.instruments[0].link = fmt::format("tcp:127.0.0.1:{}", door);
  station.interlocks = {{.require = parse_requirement("unit." + unit.channel() + " < 1e6")}};
  std::atomic<bool> end{false}, records{false};
  std::thread serving([&] { table.serve(end); });
  std::thread sending([&] {
    std::optional<std::size_t> link;
    double trips = 0.0;
    while (!end) {
      for (const LinkEvent& event : source.wait(0.01))
        if (event.kind == LinkEvent::Kind::up) link = event.link;
      if (records && trips == 0.0) trips = steady() + 0.0137 * (1 + number % 17);
      if (!link) continue;
      const bool trip = trips > 0.0 && steady() >= trips && table.tripped_at == 0.0;
      const std::string bytes = unit.frame(trip ? 1e9 : 0.0);
      if (trip) table.tripped_at = steady();
      source.send(*link, bytes);
    }
  });
  const StationParts parts = parts_of(station);
  const auto course = course_of(plan, station, {{"unit", "1"}});
  LinkWires links(station, steady);
  fs::create_directories(folder);
  Disk disk;
  {
    Recorder recorder(folder, disk);
    RunCompany company;
    company.note = [&](const Note& note, double) { records = records || note.kind == "records"; };
    carry_out(start_state(course), parts, links.wires(), recorder, company);
  }
  end = true;
  serving.join();
  sending.join();
  fs::remove_all(folder);
  return table.stopped_at - table.tripped_at;
}

void measure_stops(const std::string& folder, int trials) {
  Plan plan = gyro_plan();
  plan.sample_rate = 100.0;
  plan.schedule = {{"turning", 1000.0, 1, {{"table", {.kind = Motion::Kind::rate, .value = 10.0 * degree}}}}};
  Station station = station_for(plan);
  std::erase_if(station.devices, [](const auto& device) { return device.name == "supply"; });
  station.power.device.reset();
  station.by_hand.clear();
  station.axes[0].settle.hold = 0.05;
  station.file = folder + "/station.toml";
  fs::create_directories(folder);
  std::ofstream(folder + "/" + std::string(made_frames_name)) << frames_for(plan);
  std::vector<double> times;
  for (int number = 0; number < trials; ++number) {
    const double time = trial(plan, station, folder + "/trial", number);
    if (time > 0.0) times.push_back(time);
  }
  std::ranges::sort(times);
  const auto at = [&](double part) {
    return 1e3 * times[std::min(times.size() - 1, std::size_t(part * double(times.size())))];
  };
  fmt::print("| trials that stopped | median | 99 % | 99.9 % | longest |\n|---|---|---|---|---|\n");
  fmt::print("| {} of {} | {:.2f} ms | {:.2f} ms | {:.2f} ms | {:.2f} ms |\n\n", times.size(), trials, at(0.5),
             at(0.99), at(0.999), 1e3 * times.back());
}

void measure_rehearsal(const std::string& folder, double hours) {
  Plan plan = load_plan(TUMBLE_SOURCE_DIR "/plans/imu_turntable_short.toml", {});
  plan.sample_rate = 100.0;
  plan.schedule.resize(1);
  plan.schedule[0].duration = hours * hour;
  Rehearsal rehearsal;
  rehearsal.plan = plan;
  rehearsal.folder = folder + "/days";
  const double begin = steady();
  const Rehearsed rehearsed = rehearse(rehearsal);
  fmt::print("| simulated | channels | ending | wall | memory |\n|---|---|---|---|---|\n");
  fmt::print("| {:.1f} h | 6 at 100 Hz | {} | {:.0f} s | {:.0f} MB |\n", rehearsed.simulated / hour,
             name(rehearsed.end.ending), steady() - begin, most_memory());
  fs::remove_all(rehearsal.folder);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "station FOLDER [TRIALS] [HOURS]\n");
    return 2;
  }
  const int trials = argc > 2 ? std::atoi(argv[2]) : 1000;
  const double hours = argc > 3 ? std::atof(argv[3]) : 72.0;
  if (trials > 0) measure_stops(argv[1], trials);
  if (hours > 0.0) measure_rehearsal(argv[1], hours);
}
