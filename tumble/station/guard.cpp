#include "tumble/station/guard.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <new>
#include <sstream>
#include <thread>

#include "tumble/station/guard/post.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace guard {

constexpr const char* note_name = "guard";
constexpr double most_after = 10.0;  ///< [s] that commands before one which waits are given

std::string note_path(const std::string& run) { return (std::filesystem::path(run) / note_name).string(); }

/// The bytes of each exchange, as if all were answered.
std::vector<std::string> blind_bytes(const Controller& controller, const ControllerRequest& request) {
  std::vector<std::string> bytes;
  const ControllerCommand* const command = controller.find(request.verb);
  if (!command) return bytes;
  for (const ControllerExchange& exchange : command->exchanges) {
    if (!exchange.when.empty() && !request.values.contains(exchange.when)) continue;
    Controller one = controller;
    one.commands = {*command};
    one.commands[0].exchanges = {exchange};
    try {
      bytes.push_back(ControllerHost(one).ask(request));
    } catch (const Error&) {  // it needs what only a conversation knows
    }
  }
  return bytes;
}

/// [byte] of the command line in the memory of this process; 0: it lies elsewhere.
std::size_t room_of_command_line() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  const std::string line{std::istreambuf_iterator<char>(file), {}};
  const std::size_t first = std::min(line.find('\0'), line.size());
  return line.substr(0, first) == program_invocation_name ? line.size() : 0;
}

std::string read_note(int file) {
  char bytes[8192];
  const auto count = pread(file, bytes, sizeof bytes, 0);
  return count > 0 ? std::string(bytes, static_cast<std::size_t>(count)) : "";
}

std::string utc_text(const std::string& seconds) {
  long long number = 0;
  std::from_chars(seconds.data(), seconds.data() + seconds.size(), number);
  const auto time = static_cast<std::time_t>(number);
  std::tm parts{};
  gmtime_r(&time, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

/// Closes `note`, where it is open.
[[noreturn]] void refuse_guard(const Sentence& what, int note) {
  const std::string why = std::strerror(errno);
  if (note >= 0) close(note);
  throw Error(Error::Kind::bad_file, say("the guard of the run cannot be started: {}: {}", what, system_reason(why)));
}

/// The folder of a run may come from anywhere: what leads elsewhere, or is no file, is not the note. -1: there is none.
int open_note(const std::string& path, int flags) {
  const int file = open(path.c_str(), flags | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0666);
  struct stat state {};
  if (file < 0 || (fstat(file, &state) == 0 && S_ISREG(state.st_mode))) return file;
  close(file);
  errno = EINVAL;
  return -1;
}

std::atomic<int> line_of_guard{-1};  ///< of the run of this process, for a signal handler
static_assert(std::atomic<int>::is_always_lock_free);

}  // namespace guard

std::vector<GuardOrder> guard_orders_of(const Station& station, const StationParts& parts, double speed) {
  std::vector<GuardOrder> orders;
  double before = 0.0;
  for (const SafeCommand& command : station.safe) {
    const StationDevice& device = station.devices[command.device];
    const bool once = std::ranges::find(device.once, command.request.verb) != device.once.end();
    const double after = command.wait ? std::clamp(before / speed, 1e-3, guard::most_after) : 0.0;
    orders.push_back({command.device, device.name, command.request.verb,
                      guard::blind_bytes(parts.controllers[command.device], command.request), after, !once});
    before = std::max(before, command.within);
  }
  return orders;
}

struct RigGuard::Inner {
  std::string path;
  std::vector<GuardOrder> orders;
  std::vector<int> descriptors;
  double patience = 0.0;
  guard::Shared* shared = nullptr;
  int line = -1;
  pid_t process = -1;
  bool told = false;

  void begin();
  void end_process();
};

void RigGuard::Inner::begin() {
  const int note = guard::open_note(path, O_RDWR | O_CREAT);
  if (note < 0 || flock(note, LOCK_EX | LOCK_NB) != 0 || ftruncate(note, 0) != 0)
    guard::refuse_guard(say("{}", Name{path}), note);
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) guard::refuse_guard("socketpair", note);
  guard::Post post{
      shared, ends[1], note, descriptors, orders, {}, {ends[1], note}, patience, guard::room_of_command_line()};
  for (const GuardOrder& order : orders) post.words.push_back(name(order.verb) + " to " + order.device);
  for (const int file : descriptors)
    if (file >= 0) post.kept.push_back(file);
  process = _Fork();  // without the handlers of fork(), which wait for work in the background
  if (process == 0) guard::keep_watch(post);
  close(ends[1]);
  if (process < 0) close(ends[0]), guard::refuse_guard("fork", note);
  close(note);
  line = ends[0];
  guard::line_of_guard = line;
}

/// One that was told to end and does not, because it was stopped itself, is not waited for.
void RigGuard::Inner::end_process() {
  constexpr int most_looks = 2000;
  for (int look = 0; look < most_looks; ++look) {
    const pid_t ended = waitpid(process, nullptr, WNOHANG);
    if (ended == process || (ended < 0 && errno != EINTR)) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  kill(process, SIGKILL);
  while (waitpid(process, nullptr, 0) < 0 && errno == EINTR) {
  }
}

RigGuard::RigGuard(const std::string& folder, const std::vector<GuardOrder>& orders,
                   const std::vector<int>& descriptors, double patience)
    : inner_(new Inner{guard::note_path(folder), orders, descriptors, patience}) {
  void* const memory = mmap(nullptr, sizeof(guard::Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) guard::refuse_guard("memory", -1);
  inner_->shared = new (memory) guard::Shared;
  inner_->begin();
}

RigGuard::~RigGuard() {
  if (inner_->line >= 0) {
    guard::line_of_guard = -1;
    close(inner_->line);
    if (inner_->shared->armed)
      waitpid(inner_->process, nullptr, WNOHANG);  // one that acts has the time it needs
    else
      inner_->end_process();
  }
  if (inner_->shared) munmap(inner_->shared, sizeof(guard::Shared));
}

void RigGuard::arm() { inner_->shared->armed = true; }
void RigGuard::disarm() { inner_->shared->armed = false; }

Sentence RigGuard::looked() {
  ++inner_->shared->looks;
  if (inner_->shared->acted && !std::exchange(inner_->told, true))
    return "nobody looked at the rig for too long, and the guard of the run has stopped it";
  char byte;
  const bool is_there = inner_->line < 0 || recv(inner_->line, &byte, 1, MSG_PEEK | MSG_DONTWAIT) != 0;
  if (is_there) return {};
  close(std::exchange(inner_->line, -1));
  guard::line_of_guard = -1;
  inner_->end_process();
  try {
    inner_->begin();
    return {};
  } catch (const Error& error) {
    return say("the guard of the run was ended: {}", reason_of(error));
  }
}

void leave_rig_to_guard() {
  if (const int line = guard::line_of_guard; line >= 0) shutdown(line, SHUT_RDWR);
}

void RigGuard::link_changed(std::size_t wire, int descriptor) {
  if (wire >= inner_->descriptors.size()) return;
  inner_->descriptors[wire] = descriptor;
  guard::Change change{wire};
  iovec part{&change, sizeof change};
  alignas(cmsghdr) char room[CMSG_SPACE(sizeof(int))] = {};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  if (descriptor >= 0) {
    message.msg_control = room;
    message.msg_controllen = sizeof room;
    cmsghdr* const head = CMSG_FIRSTHDR(&message);
    head->cmsg_level = SOL_SOCKET;
    head->cmsg_type = SCM_RIGHTS;
    head->cmsg_len = CMSG_LEN(sizeof(int));
    std::memcpy(CMSG_DATA(head), &descriptor, sizeof descriptor);
  }
  sendmsg(inner_->line, &message, MSG_DONTWAIT | MSG_NOSIGNAL);
}

void RigGuard::dismiss() {
  if (inner_->line < 0) return;
  inner_->shared->dismissed = true;
  guard::line_of_guard = -1;
  close(std::exchange(inner_->line, -1));
  inner_->end_process();
}

void relieve_guard(const std::string& run) {
  const int file = guard::open_note(guard::note_path(run), O_RDWR);
  if (file < 0) return;
  constexpr int most_looks = 1000;
  bool ended = false;
  for (int look = 0; look < most_looks && !ended; ++look) {
    ended = flock(file, LOCK_EX | LOCK_NB) == 0;
    long process = 0;
    const std::string note = guard::read_note(file);
    std::from_chars(note.data(), note.data() + note.size(), process);
    if (!ended && process > 1) kill(static_cast<pid_t>(process), SIGUSR2);
    if (!ended) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  close(file);
  if (!ended)
    throw Error(Error::Kind::bad_file, say("the guard of the run '{}' has not ended: is the run going on?", run));
}

Sentence words_of_guard(const std::string& run) {
  const int file = guard::open_note(guard::note_path(run), O_RDONLY);
  if (file < 0) return {};
  std::istringstream lines(guard::read_note(file));
  close(file);
  std::string line, head;
  std::getline(lines, line);  // the number of its process
  std::vector<std::string> done;
  while (std::getline(lines, line)) {
    if (line.starts_with("sent ") || line.starts_with("not sent "))
      done.push_back(line);
    else
      head = line, done.clear();
  }
  if (head.empty()) return {};
  const auto space = head.find(' ');
  const Name time{guard::utc_text(head.substr(0, space))};
  if (head.substr(space + 1) == "silent")
    return say("the run did not look at its rig at {}; its guard: {}; no device has confirmed it", time,
               fmt::join(done, ", "));
  return say("the process of the run ended without a word at {}; its guard: {}; no device has confirmed it", time,
             fmt::join(done, ", "));
}

}  // namespace tumble
