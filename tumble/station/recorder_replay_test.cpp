// A recording of an instrument, played over real links to a process that records: what comes out are the bytes that
// went in, also where that process is killed.

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/station/recorder_session.hpp"

namespace tumble {
namespace {

const std::string frames_folder = TUMBLE_SOURCE_DIR "/examples/frames/";

double replay_clock() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// A process that records from `address` until so many frames came, and tells up to when everything was acknowledged,
/// from the first sample on [s]; 0 before.
struct RecordingProcess {
  RecordingProcess(const LinkAddress& address, const std::string& output, std::uint64_t frames) {
    if (pipe(ends) != 0) return;
    child = fork();
    if (child == 0) work(address, output, frames);
    close(ends[1]);
    tell();  // the link is open
  }
  double tell() {
    double next = 0.0;
    if (read(ends[0], &next, sizeof next) != sizeof next) return -1.0;
    return last = next;
  }
  /// Waits for its end. Returns the last time that it had acknowledged [s].
  double end(bool killed) {
    while (killed && last == 0.0 && tell() >= 0.0) continue;
    if (killed) kill(child, SIGKILL);
    while (tell() >= 0.0) continue;
    close(ends[0]);
    int status = 0;
    waitpid(child, &status, 0);
    EXPECT_TRUE(killed || (WIFEXITED(status) && WEXITSTATUS(status) == 0));
    return last;
  }

 private:
  [[noreturn]] void work(const LinkAddress& address, const std::string& output, std::uint64_t frames) {
    RecordRequest request{frames_folder + "bench_gyro.toml", address, output};
    request.duration = 60.0;
    request.keep = true;
    bool whole = false;
    double first = 0.0;
    RecordWorld world{replay_clock, [] { return std::string("2026-03-01T12:00:00Z"); }, [&] { return whole; }};
    world.show = [&](const RecordView& view) {
      const std::uint64_t count = view.instrument->counts().channel_frames;
      whole = count >= frames;
      if (first == 0.0 && count > 0) first = view.elapsed;
      const double told = first > 0.0 && view.on_disk >= first ? view.on_disk : 0.0;
      if (write(ends[1], &told, sizeof told) < 0) _exit(1);
    };
    try {
      record(request, world);
    } catch (const std::exception&) {
      _exit(1);
    }
    _exit(0);
  }

  pid_t child = 0;
  int ends[2];
  double last = 0.0;
};

/// The other side of its link.
struct Player {
  explicit Player(bool serial) {
    if (serial) {
      const auto terminal = links.open_terminal();
      link = terminal.link;
      address = {.kind = LinkAddress::Kind::serial, .device = terminal.device, .baud = 115200};
    } else {
      address = {.host = "127.0.0.1", .port = links.listen(0)};
    }
  }
  /// Takes the link that was opened.
  void meet() {
    if (address.kind == LinkAddress::Kind::serial) return;
    for (const double until = replay_clock() + 20.0; replay_clock() < until;)
      for (const LinkEvent& event : links.wait(0.1))
        if (event.kind == LinkEvent::Kind::up) {
          link = event.link;
          return;
        }
  }
  /// Sends bytes at about 70 kB/s.
  void play(std::string_view bytes) {
    for (std::size_t sent = 0; sent < bytes.size(); sent += 140) {
      links.send(link, bytes.substr(sent, 140));
      links.wait(0.002);
    }
    while (links.unsent(link) > 0) links.wait(0.002);
  }

  Links links{replay_clock};
  LinkAddress address;
  std::size_t link = 0;
};

std::string received_bytes(const std::string& store, double& last) {
  std::string bytes;
  visit_store(store, [&](const StoreItem& item) {
    last = std::max(last, item.time);
    if (item.kind == StoreItem::Kind::raw && item.direction == StoreDirection::received) bytes += item.bytes;
  });
  return bytes;
}

/// The samples that are there, channel after channel.
std::vector<std::vector<double>> present_samples(const std::string& path, const ReadOptions& options) {
  std::vector<std::vector<double>> samples;
  for (const Channel& channel : read_recording(path, options, {}).channels) {
    auto& present = samples.emplace_back();
    std::ranges::copy_if(channel.values, std::back_inserter(present), [](double value) { return !std::isnan(value); });
  }
  return samples;
}

/// The sealed samples are those that the bytes give by themselves, but for the last `waiting` of a channel at most; their
/// unit may round the last digits.
void expect_samples_of(const std::string& bytes, const std::string& sealed, const ScratchFolder& folder,
                       std::size_t waiting = 0) {
  write_file_atomically(folder.file("bytes.raw"), bytes);
  ReadOptions options;
  options.frames = frames_folder + "bench_gyro.toml";
  const auto expected = present_samples(folder.file("bytes.raw"), options), found = present_samples(sealed, {});
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    ASSERT_LE(found[i].size(), expected[i].size());
    ASSERT_GE(found[i].size() + waiting, expected[i].size());
    for (std::size_t k = 0; k < found[i].size(); ++k)
      ASSERT_NEAR(found[i][k], expected[i][k], 1e-13 * (1.0 + std::abs(expected[i][k])));
  }
}

TEST(Replay, ARecordingPlayedOverALinkComesOutWhole) {
  const std::string raw = read_text_file(frames_folder + "bench_gyro.raw");
  for (const bool serial : {false, true}) {
    const ScratchFolder folder;
    Player player(serial);
    RecordingProcess process(player.address, folder.file("gyro.h5"), 1996);
    player.meet();
    player.play(raw);
    process.end(false);
    double last = 0.0;
    EXPECT_EQ(received_bytes(folder.file("gyro.run"), last), raw);
    EXPECT_EQ(write_raw(folder.file("gyro.run"), folder.file("again.raw")), raw.size());
    EXPECT_EQ(read_text_file(folder.file("again.raw")), raw);
    expect_samples_of(raw, folder.file("gyro.h5"), folder);
  }
}

TEST(Replay, AKilledRecorderLeavesABeginningOfTheBytesThatIsSealed) {
  const std::string raw = read_text_file(frames_folder + "bench_gyro.raw");
  const char* const wanted = std::getenv("TUMBLE_KILLS");
  const int kills = std::max(wanted ? std::atoi(wanted) / 10 : 0, 6);
  for (int i = 0; i < kills; ++i) {
    const ScratchFolder folder;
    Player player(i % 2 == 1);
    RecordingProcess process(player.address, folder.file("gyro.h5"), 1'000'000);
    player.meet();
    player.play(std::string_view(raw).substr(0, raw.size() * static_cast<std::size_t>(20 + i * 29 % 80) / 100));
    const double acknowledged = process.end(true);
    double last = 0.0;
    const std::string kept = received_bytes(folder.file("gyro.run"), last);
    ASSERT_FALSE(kept.empty());
    ASSERT_TRUE(raw.starts_with(kept)) << "kill " << i;
    ASSERT_GE(last, acknowledged) << "kill " << i;
    Disk disk;
    const auto sealed = seal(folder.file("gyro.run"), disk);
    ASSERT_EQ(sealed.at(0).path, folder.file("gyro.h5"));
    EXPECT_TRUE(std::ranges::any_of(sealed.at(0).findings,
                                    [](const Finding& finding) { return finding.code == "recording_interrupted"; }));
    constexpr std::size_t waiting = 16;  // frames behind a loss, of which the killed process had the bytes only
    expect_samples_of(kept, folder.file("gyro.h5"), folder, waiting);
  }
}

}  // namespace
}  // namespace tumble
