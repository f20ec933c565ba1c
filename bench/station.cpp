// How soon a station stops its rig over real TCP links of this machine, how soon what arrives is on the disk, and how
// long rehearsals take; prints a page. It is run in the root of the repository, for its plans.
//
//   station FOLDER [TRIALS, 1000] [SECONDS that acknowledgements are watched, 60] [HOURS to rehearse, 72]
//
// 0 leaves a part out.
#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <deque>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tumble/recorder/disk.hpp"
#include "tumble/rehearsal/made_station.hpp"
#include "tumble/rehearsal/rehearse.hpp"
#include "tumble/rehearsal/virtual_stream.hpp"
#include "tumble/station/carry_out.hpp"
#include "tumble/station/link_wires.hpp"
#include "tumble/station/run_folder.hpp"
#include "tumble/tasks/tasks.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace {

using namespace tumble;
namespace fs = std::filesystem;

double steady() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

rusage used() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage;
}

/// [s] of this process in all its threads.
double processor() {
  const rusage usage = used();
  const auto seconds = [](const timeval& time) { return double(time.tv_sec) + 1e-6 * double(time.tv_usec); };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// [MB] of memory that the process has had at most.
double most_memory() { return 1e-3 * double(used().ru_maxrss); }

/// Cells of a table: median, 99 %, 99.9 % and the longest of times [s], in ms.
std::string distribution(std::vector<double> times) {
  if (times.empty()) return "none |";
  std::ranges::sort(times);
  const auto at = [&](double part) {
    return 1e3 * times[std::min(times.size() - 1, std::size_t(part * double(times.size())))];
  };
  return fmt::format("{:.2f} ms | {:.2f} ms | {:.2f} ms | {:.2f} ms |", at(0.5), at(0.99), at(0.999),
                     1e3 * times.back());
}

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
    company.note = [&](const Note& note, double) { records = records || note.kind == EventKind::records; };
    carry_out(start_state(course), parts, links.wires(), recorder, company);
  }
  end = true;
  serving.join();
  sending.join();
  fs::remove_all(folder);
  return table.stopped_at - table.tripped_at;
}

void measure_stops(const std::string& folder, int trials) {
  Plan plan = load_plan("plans/gyro_scale_factor.toml", {});
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
  fmt::print("## From the sample that breaks an interlock to the stop\n\n");
  fmt::print("| trials that stopped | median | 99 % | 99.9 % | longest |\n|---|---:|---:|---:|---:|\n");
  fmt::print("| {} of {} | {}\n\n", times.size(), trials, distribution(times));
}

/// Each 10 ms the bytes and the samples of 20 channels at 2 kHz: how long each portion waits until it is on the disk.
void measure_acknowledgements(const std::string& folder, double seconds) {
  fs::create_directories(folder + "/acknowledged");
  std::mutex mutex;
  std::deque<std::pair<std::uint64_t, double>> waiting;  // sequence number, [s] arrival
  std::vector<double> times;
  RecorderOptions options;
  options.on_commit = [&](const Acknowledged& acknowledged) {
    const std::lock_guard lock(mutex);
    for (; !waiting.empty() && waiting.front().first <= acknowledged.sequence; waiting.pop_front())
      times.push_back(steady() - waiting.front().second);
  };
  Disk disk;
  {
    Recorder recorder(folder + "/acknowledged", disk, options);
    const std::size_t link = recorder.add_link({.name = "bench"});
    const std::size_t stream = recorder.add_stream({.name = "bench", .channels = std::vector<FrameChannel>(20)});
    const std::string bytes(20 * 88, 'x');
    const std::vector<double> values(20);
    const double begin = steady();
    for (std::uint64_t portion = 0; steady() < begin + seconds; ++portion) {
      std::this_thread::sleep_until(
          std::chrono::steady_clock::time_point(std::chrono::duration_cast<std::chrono::steady_clock::duration>(
              std::chrono::duration<double>(begin + 0.01 * double(portion)))));
      const double now = steady();
      std::uint64_t last = recorder.raw(link, StoreDirection::received, now - begin, bytes);
      for (std::uint64_t k = 0; k < 20; ++k)
        last = recorder.sample(stream, {now - begin, {}, 20 * portion + k, values});
      const std::lock_guard lock(mutex);
      waiting.emplace_back(last, now);
    }
    recorder.flush();
  }
  fs::remove_all(folder + "/acknowledged");
  fmt::print("## From the arrival of 20 channels at 2 kHz to the disk\n\n");
  fmt::print("| portions of 10 ms | median | 99 % | 99.9 % | longest |\n|---|---:|---:|---:|---:|\n");
  fmt::print("| {} | {}\n\n", times.size(), distribution(times));
}

void measure_rehearsal(const std::string& folder, const std::string& what, const Plan& plan) {
  Rehearsal rehearsal;
  rehearsal.plan = plan;
  rehearsal.folder = folder + "/rehearsed";
  const double begin = steady(), before = processor();
  const Rehearsed rehearsed = rehearse(rehearsal);
  fmt::print("| {} | {:.2f} h | {} | {:.1f} s | {:.1f} s | {:.0f} MB |\n", what, rehearsed.simulated / hour,
             name(rehearsed.end.ending), steady() - begin, processor() - before, most_memory());
  fs::remove_all(rehearsal.folder);
}

void measure_rehearsals(const std::string& folder, double hours) {
  fmt::print("## Rehearsals, sealed\n\n| plan | simulated | ending | wall | processor | memory at most |\n");
  fmt::print("|---|---:|---|---:|---:|---:|\n");
  measure_rehearsal(folder, "`north_finding.toml`", load_plan("plans/north_finding.toml", {}));
  measure_rehearsal(folder, "`rlg_north_finder.toml`", load_plan("plans/rlg_north_finder.toml", {}));
  Plan plan = load_plan("plans/imu_turntable_short.toml", {});
  plan.sample_rate = 100.0;
  measure_rehearsal(folder, "`imu_turntable_short.toml`, 6 channels at 100 Hz", plan);
  plan.schedule.resize(1);
  plan.schedule[0].duration = hours * hour;
  measure_rehearsal(folder, "6 channels at 100 Hz, turning", plan);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "station FOLDER [TRIALS] [SECONDS] [HOURS]\n");
    return 2;
  }
  const auto number = [&](int place, double usual) { return argc > place ? std::atof(argv[place]) : usual; };
  try {
    if (number(2, 1000.0) > 0.0) measure_stops(argv[1], int(number(2, 1000.0)));
    if (number(3, 60.0) > 0.0) measure_acknowledgements(argv[1], number(3, 60.0));
    if (number(4, 72.0) > 0.0) measure_rehearsals(argv[1], number(4, 72.0));
  } catch (const Error& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 3;
  }
  return 0;
}
