#include "tumble/station/guard.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

namespace fs = std::filesystem;

/// Both ends of the link of a device.
struct GuardedLink {
  int ours = -1, device = -1;

  GuardedLink() {
    int ends[2];
    EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends), 0);
    ours = ends[0], device = ends[1];
  }
  GuardedLink(const GuardedLink&) = delete;
  GuardedLink& operator=(const GuardedLink&) = delete;
  ~GuardedLink() { close(ours), close(device); }

  /// What has come to the device, after so many seconds at most without anything.
  std::string heard(double seconds) const {
    pollfd end{device, POLLIN, 0};
    char bytes[64];
    if (poll(&end, 1, static_cast<int>(seconds * 1e3)) <= 0) return "";
    const auto count = read(device, bytes, sizeof bytes);
    return count > 0 ? std::string(bytes, static_cast<std::size_t>(count)) : "";
  }
};

std::vector<GuardOrder> stop_of_table() {
  GuardOrder order;
  order.device = "table", order.verb = ControllerVerb::stop, order.bytes = {"STOP\r"};
  return {order};
}

constexpr double at_once = 30.0;  // [s] on a machine with much other work
constexpr double patience = 0.3;

pid_t process_of_guard(const std::string& run) {
  std::ifstream note(run + "/guard");
  pid_t process = 0;
  note >> process;
  return process;
}

/// The number of its process, once it has written it.
pid_t guard_other_than(pid_t other, const std::string& run, RigGuard& guard) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(at_once);
  while (std::chrono::steady_clock::now() < end) {
    EXPECT_EQ(guard.looked(), "");
    if (const pid_t process = process_of_guard(run); process > 0 && process != other) return process;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ADD_FAILURE() << "no guard";
  return 0;
}

Refused refusal_of_guard(const std::string& run) {
  return refusal_of([&] { RigGuard guard(run, {}, {}, patience); });
}

TEST(RigGuard, OneThatIsNotArmedSendsNothingHoweverLongNobodyLooks) {
  const ScratchFolder scratch;
  const GuardedLink link;
  RigGuard guard(scratch.path.string(), stop_of_table(), {link.ours}, patience);
  guard.arm();
  guard.looked();
  guard.disarm();
  EXPECT_EQ(link.heard(10.0 * patience), "");
  guard.arm();
  EXPECT_EQ(link.heard(at_once), "STOP\r");
  EXPECT_NE(guard.looked(), "");
  guard.dismiss();
}

TEST(RigGuard, OneThatIsKilledIsReplacedAndKnowsTheLinkThatWasOpenedAgain) {
  const ScratchFolder scratch;
  const std::string run = scratch.path.string();
  const GuardedLink first, second;
  {
    RigGuard guard(run, stop_of_table(), {first.ours}, at_once);
    guard.arm();
    const pid_t process = guard_other_than(0, run, guard);
    guard.link_changed(0, second.ours);
    kill(process, SIGKILL);
    guard_other_than(process, run, guard);
  }
  EXPECT_EQ(second.heard(at_once), "STOP\r");
  EXPECT_EQ(first.heard(0.0), "");
}

TEST(RigGuard, AFaultOfTheProcessIsKnownBeforeTheProcessHasEnded) {
  const ScratchFolder scratch;
  const GuardedLink link;
  RigGuard guard(scratch.path.string(), stop_of_table(), {link.ours}, at_once);
  guard.arm();
  leave_rig_to_guard();
  EXPECT_EQ(link.heard(at_once), "STOP\r");
}

TEST(RigGuard, OneThatIsStoppedDoesNotHoldUpTheEnd) {
  const ScratchFolder scratch;
  const std::string run = scratch.path.string();
  const GuardedLink link;
  RigGuard guard(run, stop_of_table(), {link.ours}, at_once);
  kill(guard_other_than(0, run, guard), SIGSTOP);
  guard.dismiss();
  EXPECT_EQ(link.heard(0.0), "");
}

TEST(RigGuard, ReadsWhatASerialLineHasSentSoThatTheDeviceCanListen) {
  const ScratchFolder scratch;
  int device = -1, ours = -1;
  ASSERT_EQ(openpty(&device, &ours, nullptr, nullptr, nullptr), 0);
  termios raw{};
  cfmakeraw(&raw);
  tcsetattr(ours, TCSANOW, &raw);
  fcntl(ours, F_SETFL, O_NONBLOCK);
  fcntl(device, F_SETFL, O_NONBLOCK);
  const std::string answers(4096, 'x');
  while (write(device, answers.data(), answers.size()) > 0) {
  }
  {
    RigGuard guard(scratch.path.string(), stop_of_table(), {ours}, at_once);
    guard.arm();
  }
  pollfd room{device, POLLOUT, 0};
  EXPECT_EQ(poll(&room, 1, static_cast<int>(at_once * 1e3)), 1);
  EXPECT_NE(room.revents & POLLOUT, 0);
  close(device), close(ours);
}

TEST(RigGuard, WritesNothingOutsideTheFolderAndWaitsForNoPipe) {
  const ScratchFolder scratch;
  const fs::path other = scratch.path / "other.txt";
  std::ofstream(other) << "text of somebody";
  const std::string led = (scratch.path / "led").string(), piped = (scratch.path / "piped").string();
  fs::create_directories(led);
  fs::create_directories(piped);
  fs::create_symlink(other, led + "/guard");
  ASSERT_EQ(mkfifo((piped + "/guard").c_str(), 0600), 0);
  for (const std::string& run : {led, piped}) {
    EXPECT_TRUE(
        refuses(Error::Kind::bad_file, Asked{.part = run, .pattern = "cannot be started"}, refusal_of_guard(run)));
    EXPECT_EQ(words_of_guard(run), "");
    EXPECT_TRUE(refusal_of([&] { relieve_guard(run); }).empty());
  }
  std::ifstream file(other);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), "text of somebody");
}

}  // namespace
}  // namespace tumble
