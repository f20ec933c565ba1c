// Records streams over TCP of this machine as `tumble record` and a station do, and prints a page: what was lost,
// processor time, memory, the time to the disk. The sources are another process, which is not counted.
//
//   recorder FOLDER [SECONDS of 20 channels at 2 kHz, 600] [SECONDS of 8 instruments at 4 Mbit/s, 120]
//
// 0 seconds leave a part out; for the memory of the second part leave out the first, whose file is read to be checked.
#include <fmt/format.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <random>

#include "tumble/formats/format.hpp"
#include "tumble/station/recorder_session.hpp"
#include "tumble/units/error.hpp"

namespace {

using namespace tumble;
namespace fs = std::filesystem;

constexpr std::size_t channels = 20, frame_bytes = 2 + 2 + 4 * channels + 2;

double steady() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// [s] of this process in all its threads.
double processor() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) { return double(time.tv_sec) + 1e-6 * double(time.tv_usec); };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// [MB] of memory that the process has now.
double memory() {
  std::size_t size = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> size >> resident;
  return 1e-6 * double(resident) * double(sysconf(_SC_PAGESIZE));
}

/// A frame of zeros, as the declaration has to give one.
std::string zero_frame() {
  unsigned crc = 0xFFFF;
  for (std::size_t bit = 0; bit < 8 * (frame_bytes - 4); ++bit)
    crc = (crc & 0x8000 ? crc << 1 ^ 0x1021 : crc << 1) & 0xFFFF;
  std::string text = "AA 55";
  for (std::size_t i = 2; i < frame_bytes - 2; ++i) text += " 00";
  return text + fmt::format(" {:02X} {:02X}", crc & 0xFF, crc >> 8);
}

std::string declaration(double rate) {
  std::string text = fmt::format(
      "title = \"bench of {0} channels\"\ncertainty = \"maker\"\norder = \"little\"\nrate = \"{1} Hz\"\n\n[[frame]]\n"
      "name = \"sample\"\nsync = \"AA 55\"\nlength = {2}\n"
      "check = {{kind = \"crc\", width = 16, poly = \"1021\", init = \"FFFF\", over = [2, {3}], at = {3}}}\n"
      "counter = {{at = 2, type = \"u16\"}}\nchannel = [\n",
      channels, rate, frame_bytes, frame_bytes - 2);
  for (std::size_t i = 0; i < channels; ++i)
    text += fmt::format("  {{name = \"c{}\", at = {}, type = \"i32\", scale = \"2^-20 deg/s\"}},\n", i, 4 + 4 * i);
  text += fmt::format("]\n\n[[vector]]\nsource = \"zeros\"\nhex = \"{}\"\ncounter = 0\nvalues = {{", zero_frame());
  for (std::size_t i = 0; i < channels; ++i) text += fmt::format("{}c{} = \"0 deg/s\"", i == 0 ? "" : ", ", i);
  return text + "}\n";
}

/// All frames of a cycle of the counter, one behind the other.
std::string cycle_of(const FrameCodec& codec) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise(0.0, 0.001);
  FrameContent content;
  content.values.resize(codec.channels.size());
  content.present.assign(codec.channels.size(), 1);
  std::string bytes;
  for (std::uint64_t count = 0; count < 65536; ++count) {
    content.counter = count;
    for (double& value : content.values) value = noise(random);
    bytes += encode_frame(codec, content);
  }
  return bytes;
}

/// The other process: every link that is opened to it gets so many frames at a rate [Hz]. Gives its port.
struct Sources {
  Sources(const FrameCodec& codec, double rate, std::uint64_t frames) {
    int ends[2];
    if (pipe(ends) != 0) std::abort();
    child = fork();
    if (child == 0) {
      Links links(steady);
      port = links.listen(0);
      if (write(ends[1], &port, sizeof port) < 0) _exit(1);
      serve(links, cycle_of(codec), rate, frames);
    }
    if (read(ends[0], &port, sizeof port) < 0) std::abort();
  }
  ~Sources() {
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
  }
  std::uint16_t port = 0;

 private:
  struct Served {
    std::size_t link = 0;
    double begin = 0.0;
    std::uint64_t sent = 0;
  };
  [[noreturn]] static void serve(Links& links, const std::string& cycle, double rate, std::uint64_t frames) {
    std::vector<Served> served;
    for (;;) {
      for (const LinkEvent& event : links.wait(0.002))
        if (event.kind == LinkEvent::Kind::up) served.push_back({event.link, steady()});
      for (Served& one : served) {
        const auto due = std::min(frames, static_cast<std::uint64_t>((steady() - one.begin) * rate));
        while (one.sent < due) {
          const std::uint64_t from = one.sent % 65536, many = std::min(due - one.sent, 65536 - from);
          links.send(one.link, std::string_view(cycle).substr(from * frame_bytes, many * frame_bytes));
          one.sent += many;
        }
      }
    }
  }
  pid_t child = 0;
};

struct Watch {
  double wall = steady(), used = processor(), first = 0.0, most = 0.0, last = 0.0, late = 0.0, looked = 0.0,
         stopped = 0.0;
  void look(double elapsed, double on_disk) {
    last = memory();
    if (looked > 0.0) stopped = std::max(stopped, steady() - looked);
    looked = steady();
    if (first == 0.0 && elapsed > 10.0) first = last;
    most = std::max(most, last);
    if (elapsed > 1.0) late = std::max(late, elapsed - on_disk);
  }
  std::string text(double seconds, const StoreLoad& load) const {
    return fmt::format(
        "processor {:.1f} s in {:.1f} s: {:.1f} % of one core. Memory {:.1f} MB after 10 s, {:.1f} MB at the end, "
        "{:.1f} MB at most. {} commits, the longest {:.3f} s; at most {:.2f} MB waited; what arrived was on the disk "
        "after at most {:.3f} s (looked at every 0.1 s; where the machine had no time for the process, after {:.3f} "
        "s).\n\n",
        processor() - used, seconds, 100.0 * (processor() - used) / seconds, first, last, most, load.commits,
        load.longest_commit, 1e-6 * double(load.most_pending), late, stopped);
  }
};

void one_instrument(const fs::path& folder, double seconds) {
  const double rate = 2000.0;
  const auto frames = static_cast<std::uint64_t>(rate * seconds);
  const fs::path file = folder / "bench.toml";
  std::ofstream(file) << declaration(rate);
  const FrameCodec codec = read_frames(declaration(rate), "bench.toml", {});
  const Sources sources(codec, rate, frames);
  RecordRequest request{file.string(), {.host = "127.0.0.1", .port = sources.port}, (folder / "one.h5").string()};
  request.duration = seconds + 3.0;
  Watch watch;
  StoreLoad load;
  FrameCounts counts;
  std::string measured;
  RecordWorld world{steady, [] { return std::string("2026-01-01T00:00:00Z"); }, [] { return false; }};
  world.show = [&](const RecordView& view) {
    watch.look(std::min(view.elapsed, seconds), view.on_disk);
    load = view.load;
    counts = view.instrument->counts();
  };
  world.sealing = [&] { measured = watch.text(steady() - watch.wall, load); };
  const RecordOutcome outcome = record(request, world);
  const Recording recording = read_recording(outcome.sealed.path, {}, {});
  std::uint64_t whole = 0;
  for (const Channel& channel : recording.channels)
    whole += static_cast<std::uint64_t>(
        std::ranges::count_if(channel.values, [](double value) { return !std::isnan(value); }));
  fmt::print("## {} channels at {:.0f} Hz, {:.0f} s, one instrument, as `tumble record`\n\n", channels, rate, seconds);
  fmt::print("{} frames sent, {} recorded; lost {}, damaged {}, repeated {}; {} of {} samples in the sealed file.\n\n",
             frames, counts.channel_frames, counts.lost, counts.damaged.count, counts.repeated.count, whole,
             frames * channels);
  fmt::print("{}", measured);
}

void eight_instruments(const fs::path& folder, double seconds) {
  constexpr std::size_t instruments = 8;
  const double rate = std::ceil(4e6 / (8.0 * frame_bytes));
  const auto frames = static_cast<std::uint64_t>(rate * seconds);
  const FrameCodec codec = read_frames(declaration(rate), "bench.toml", {});
  const Sources sources(codec, rate, frames);
  const fs::path store = folder / "eight.run";
  fs::create_directory(store);
  const double begin = steady();
  Disk disk;
  RecorderOptions options;
  options.clock = steady;
  Recorder recorder(store.string(), disk, options);
  Links links([&] { return steady() - begin; });
  std::vector<std::unique_ptr<InstrumentRecorder>> all;
  for (std::size_t i = 0; i < instruments; ++i) {
    links.open({.host = "127.0.0.1", .port = sources.port});
    all.push_back(std::make_unique<InstrumentRecorder>(
        recorder, codec, StoreLink{"tcp", fmt::format("slot{}", i), declaration(rate), "bench.toml", {}}));
  }
  const auto received = [&] {
    std::uint64_t sum = 0;
    for (const auto& one : all) sum += one->counts().channel_frames;
    return sum;
  };
  Watch watch;
  double next = 0.0;
  while (received() < instruments * frames && steady() - begin < seconds + 10.0) {
    for (const LinkEvent& event : links.wait(0.1))
      if (event.kind == LinkEvent::Kind::bytes) all[event.link]->receive(event.time, event.bytes);
    if (const double now = steady() - begin; now > next)
      watch.look(now, recorder.acknowledged().time), next = now + 0.1;
  }
  const bool kept = recorder.flush();
  fmt::print("## {} instruments at 4 Mbit/s each, {:.0f} s, one process and one store\n\n", instruments, seconds);
  std::uint64_t lost = 0, damaged = 0;
  for (const auto& one : all) lost += one->counts().lost, damaged += one->counts().damaged.count;
  fmt::print("{} frames of {} bytes sent, {} recorded; lost {}, damaged {}; the recorder {}.\n\n", instruments * frames,
             frame_bytes, received(), lost, damaged, kept ? "goes on" : recorder.failure()->text);
  fmt::print("{}", watch.text(steady() - watch.wall, recorder.load()));
  recorder.close(steady() - begin, "complete");
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 2) return 2;
  const auto seconds = [&](int place, double usual) { return count > place ? std::atof(arguments[place]) : usual; };
  try {
    if (seconds(2, 600.0) > 0.0) one_instrument(arguments[1], seconds(2, 600.0));
    if (seconds(3, 120.0) > 0.0) eight_instruments(arguments[1], seconds(3, 120.0));
  } catch (const Error& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 3;
  }
  return 0;
}
