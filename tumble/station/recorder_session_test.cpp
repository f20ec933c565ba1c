#include "tumble/station/recorder_session.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <thread>

#include "tumble/formats/format.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/recorder/testing/faulty_disk.hpp"
#include "tumble/recorder/testing/frame_source.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

using testing::DiskFault;
using testing::FaultyDisk;

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// An instrument behind a TCP port or a pseudo-terminal: it answers what it is sent, and streams frames.
class StreamingDevice {
 public:
  explicit StreamingDevice(bool serial, bool answers = true, double dies_after = 1e9)
      : links_(seconds_now), answers_(answers), dies_after_(dies_after) {
    source_.rate = 500.0;
    if (serial) {
      const auto terminal = links_.open_terminal();
      link_ = terminal.link;
      up_ = true;
      address.kind = LinkAddress::Kind::serial;
      address.device = terminal.device;
    } else {
      address.host = "127.0.0.1";
      address.port = links_.listen(0);
    }
    thread_ = std::thread([this] { serve(); });
  }
  ~StreamingDevice() {
    ends_ = true;
    thread_.join();
  }
  std::string heard() {
    ends_ = true;
    thread_.join();
    thread_ = std::thread([] {});
    return heard_;
  }
  LinkAddress address;

 private:
  void serve() {
    double begin = 0.0;
    while (!ends_) {
      for (const LinkEvent& event : links_.wait(0.005)) take(event);
      if (!up_ || (!streams_ && answers_)) continue;
      if (begin == 0.0) begin = seconds_now();
      if (seconds_now() - begin > dies_after_) {
        links_.close(link_);
        up_ = false;
      }
      std::string packet;
      while (static_cast<double>(source_.sent()) < (seconds_now() - begin) * source_.rate) packet += source_.next();
      if (!packet.empty()) links_.send(link_, packet);
    }
  }
  void take(const LinkEvent& event) {
    if (event.kind == LinkEvent::Kind::up) link_ = event.link, up_ = true;
    if (event.kind == LinkEvent::Kind::lost) up_ = false;
    heard_ += event.bytes;
    if (!answers_) return;
    if (event.bytes.find("=OUTPUTFMT,B\n") != std::string::npos) links_.send(link_, "OUTPUTFMT,B\r\n");
    if (event.bytes.find("=CONFIG,0\n") != std::string::npos) streams_ = true;
  }

  Links links_;
  FrameSource source_{"kvh_1775", "B"};
  std::size_t link_ = 0;
  bool up_ = false, answers_, streams_ = false;
  double dies_after_;
  std::string heard_;
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

RecordRequest request_for(const StreamingDevice& device, const ScratchFolder& folder) {
  RecordRequest request;
  request.instrument = "kvh_1775";
  request.link = device.address;
  request.output = folder.file("fog.h5");
  request.duration = 1.0;
  return request;
}

RecordWorld outside_world() {
  return {seconds_now, [] { return std::string("2026-03-01T12:00:00Z"); }, [] { return false; }};
}

Refused record_refusal(const RecordRequest& request) {
  return refusal_of([&] { record(request, outside_world()); });
}

TEST(Record, RecordsAnInstrumentOverTcpAndOverASerialLine) {
  for (const bool serial : {false, true}) {
    const ScratchFolder folder;
    StreamingDevice device(serial);
    RecordWorld outside = outside_world();
    int shown = 0;
    outside.show = [&](const RecordView& view) {
      ++shown;
      EXPECT_LE(view.on_disk, view.elapsed);
      for (const auto& channel : view.instrument->shown())
        EXPECT_EQ(std::isnan(channel.last), channel.noise.count() == 0) << channel.channel.name;
    };
    const RecordOutcome outcome = record(request_for(device, folder), outside);
    EXPECT_TRUE(outcome.whole) << outcome.ending.text();
    EXPECT_GT(shown, 2);
    EXPECT_EQ(folder.entries(), 1u) << "the store is removed";
    const Recording recording = read_recording(outcome.sealed.path, {}, {});
    EXPECT_EQ(recording.meta.at("clock_start"), "2026-03-01T12:00:00Z");
    const Channel& gyro = *find_channel(recording, "gyro.x");
    ASSERT_TRUE(gyro.timeline.uniform());
    EXPECT_GT(gyro.values.size(), 100u);
    for (const double value : gyro.values) ASSERT_FALSE(std::isnan(value));
    EXPECT_EQ(device.heard(), "=CONFIG,1\n=OUTPUTFMT,B\n=CONFIG,0\n");
  }
}

TEST(Record, SealsWhatCameBeforeTheLinkWasLost) {
  const ScratchFolder folder;
  StreamingDevice device(false, true, 0.5);
  RecordRequest request = request_for(device, folder);
  request.duration = 0.0;
  const RecordOutcome outcome = record(request, outside_world());
  EXPECT_FALSE(outcome.whole);
  EXPECT_EQ(outcome.ending, "the link was lost: the other side closed the link");
  EXPECT_TRUE(std::filesystem::exists(folder.file("fog.h5")));
  EXPECT_EQ(outcome.store, folder.file("fog.run"));
  EXPECT_TRUE(std::ranges::any_of(outcome.sealed.findings,
                                  [](const Finding& finding) { return finding.code == "recording_link_lost"; }));
}

TEST(Record, SealsWhatWasAcknowledgedBeforeTheDiskFailedOrWasFull) {
  for (const auto& [kind, words] : {std::pair{DiskFault::Kind::fails, "failed"}, {DiskFault::Kind::full, "is full"}}) {
    const ScratchFolder folder;
    StreamingDevice device(false);
    RecordRequest request = request_for(device, folder);
    request.duration = 20.0;  // the disk ends it long before
    RecordWorld outside = outside_world();
    FaultyDisk disk({kind, 120, 0});
    outside.disk = &disk.disk();
    double on_disk = 0.0;
    outside.show = [&](const RecordView& view) { on_disk = view.on_disk; };
    const RecordOutcome outcome = record(request, outside);
    EXPECT_FALSE(outcome.whole);
    EXPECT_NE(outcome.ending.text().find(words), std::string::npos) << outcome.ending.text();
    EXPECT_EQ(outcome.store, folder.file("fog.run"));
    ASSERT_GT(on_disk, 0.1);
    double last = 0.0;
    std::size_t samples = 0;
    visit_store(outcome.store, [&](const StoreItem& item) {
      last = std::max(last, item.time);
      if (item.kind == StoreItem::Kind::sample) ++samples;
    });
    EXPECT_GE(last, on_disk);
    const Recording recording = read_recording(outcome.sealed.path, {}, {});
    EXPECT_EQ(find_channel(recording, "gyro.x")->values.size(), samples) << "sealed, every one of them";
  }
}

TEST(Record, EndsWhenSomebodyWantsItTo) {
  const ScratchFolder folder;
  StreamingDevice device(false);
  RecordRequest request = request_for(device, folder);
  request.duration = 0.0;
  request.keep = true;
  RecordWorld outside = outside_world();
  const double until = seconds_now() + 0.5;
  outside.ended = [&] { return seconds_now() > until; };
  const RecordOutcome outcome = record(request, outside);
  EXPECT_TRUE(outcome.whole);
  Disk disk;
  EXPECT_EQ(seal(outcome.store, disk).at(0).sha256, outcome.sealed.sha256) << "from the store that was kept";
}

TEST(Record, RefusesWhatItCannotBegin) {
  const ScratchFolder folder;
  StreamingDevice device(false, false);
  RecordRequest request = request_for(device, folder);
  EXPECT_TRUE(refuses(Error::Kind::bad_data, Asked{.part = "'=OUTPUTFMT,B.'", .pattern = "--no-start"},
                      record_refusal(request)));
  EXPECT_EQ(folder.entries(), 0u) << "nothing is kept of an instrument that does not start";
  request.start = false;
  { std::ofstream(folder.file("fog.h5")) << "measured before"; }
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {folder.file("fog.h5")}, .pattern = "does not replace"},
                      record_refusal(request)));
  std::filesystem::remove(folder.file("fog.h5"));
  request.start = true;
  request.link = {.kind = LinkAddress::Kind::udp, .port = 9};
  EXPECT_TRUE(refuses(Error::Kind::bad_input, Asked{.values = {"udp:9", "9"}}, record_refusal(request)));
  request.instrument = "sbg_ecm";
  EXPECT_TRUE(refuses(Error::Kind::unsupported, Asked{.values = {"sbg_ecm", "sbg_ecom"}}, record_refusal(request)));
  EXPECT_EQ(folder.entries(), 0u) << "nothing is written";
}

}  // namespace
}  // namespace tumble
