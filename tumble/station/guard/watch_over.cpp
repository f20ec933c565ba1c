// The guard in its own process. Only what a signal handler may call is called here.
#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <ctime>

#include "tumble/station/guard/post.hpp"

namespace tumble::guard {
namespace {

constexpr int look_every = 100;       // [ms]
constexpr double longest_look = 1.0;  // [s]: the guard itself was late, which is no evidence
constexpr double between_exchanges = 0.05, before_again = 0.2, linger = 1.0;  // [s]
constexpr int longest_send = 500;                                             // [ms]
constexpr double longest_wait = 10.0;                                         // [s] between commands

double monotonic_now() {  // does not count while the machine is suspended
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void put(int file, const char* text, std::size_t size) {
  while (size > 0) {
    const auto count = write(file, text, size);
    if (count < 0 && errno != EINTR) return;
    if (count > 0) text += count, size -= static_cast<std::size_t>(count);
  }
}

void put(int file, const char* text) { put(file, text, std::strlen(text)); }

void put_number(int file, long long number) {
  char digits[24];
  std::size_t at = sizeof digits;
  do digits[--at] = static_cast<char>('0' + number % 10);
  while ((number /= 10) > 0);
  put(file, digits + at, sizeof digits - at);
}

void close_between(unsigned first, unsigned last) {
  constexpr unsigned most = 65536;  // where the system has no close_range
  if (close_range(first, last, 0) == 0) return;
  for (unsigned file = first; file <= std::min(last, most); ++file) close(static_cast<int>(file));
}

/// All other files of the process of the run are closed here: a lease, a pipe whose other side waits for its end.
void keep_only(Post& post) {
  auto& kept = post.kept;
  const int nothing = open("/dev/null", O_RDWR);
  for (const int file : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) dup2(nothing, file);
  std::sort(kept.begin(), kept.end());
  unsigned from = 3;
  for (const int file : kept) {
    if (file < static_cast<int>(from)) continue;
    if (file > static_cast<int>(from)) close_between(from, static_cast<unsigned>(file) - 1);
    from = static_cast<unsigned>(file) + 1;
  }
  close_between(from, ~0u);
}

/// Who ends programs by their name or their command line does not end the guard with the run.
void take_own_name(std::size_t room) {
  constexpr char own[] = "rig-guard";  // not found by the name of the program
  prctl(PR_SET_NAME, own);
  if (room < sizeof own) return;
  std::memset(program_invocation_name, 0, room);
  std::memcpy(program_invocation_name, own, sizeof own);
}

bool is_relieved() {
  sigset_t waiting;
  return sigpending(&waiting) == 0 && sigismember(&waiting, SIGUSR2) == 1;
}

void take_change(Post& post, const Change& change, int file) {
  if (change.wire >= post.descriptors.size()) return;
  int& mine = post.descriptors[change.wire];
  if (mine >= 0) close(mine);
  mine = file;
}

/// What the process of the run says. False: it has ended.
bool hear(Post& post) {
  Change change;
  iovec part{&change, sizeof change};
  alignas(cmsghdr) char room[CMSG_SPACE(sizeof(int))];
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = room;
  message.msg_controllen = sizeof room;
  const auto count = recvmsg(post.line, &message, MSG_DONTWAIT);
  if (count < 0) return errno == EAGAIN || errno == EINTR;
  if (count == 0) return false;
  int file = -1;
  if (const cmsghdr* head = CMSG_FIRSTHDR(&message); head && head->cmsg_type == SCM_RIGHTS)
    std::memcpy(&file, CMSG_DATA(head), sizeof file);
  take_change(post, change, file);
  return true;
}

/// Bytes that a device has sent, which nobody needs. False: there are none. A serial line is no socket, and is read
/// only where that does not wait.
bool take_some(int file) {
  static char room[1 << 14];
  if (recv(file, room, sizeof room, MSG_DONTWAIT) > 0) return true;
  const int flags = errno == ENOTSOCK ? fcntl(file, F_GETFL) : -1;
  return flags >= 0 && (flags & O_NONBLOCK) != 0 && read(file, room, sizeof room) > 0;
}

/// So many seconds, in which the devices are read: one that cannot get rid of its answers may not listen. True: nothing
/// has changed, and the guard goes on.
bool wait_and_drain(Post& post, double seconds, std::uint64_t looks) {
  const double until = monotonic_now() + seconds;
  for (double now = monotonic_now(); now < until; now = monotonic_now()) {
    if (is_relieved() || post.shared->dismissed || post.shared->looks != looks) return false;
    for (const int file : post.descriptors)
      for (int i = 0; file >= 0 && i < 64 && take_some(file); ++i) {
      }
    poll(nullptr, 0, static_cast<int>(std::min(0.02, until - now) * 1e3) + 1);
  }
  return true;
}

bool send_bytes(int file, const std::string& bytes) {
  const char* at = bytes.data();
  std::size_t left = bytes.size();
  for (int tries = 0; file >= 0 && left > 0 && tries < 8; ++tries) {
    const auto count = write(file, at, left);
    if (count > 0) at += count, left -= static_cast<std::size_t>(count);
    if (count < 0 && errno != EAGAIN && errno != EINTR) return false;
    pollfd ready{file, POLLOUT, 0};
    if (left > 0) poll(&ready, 1, longest_send / 8);
  }
  return file >= 0 && left == 0;
}

bool send_order(Post& post, const GuardOrder& order) {
  bool sent = !order.bytes.empty();
  for (std::size_t i = 0; i < order.bytes.size(); ++i) {
    if (i > 0) poll(nullptr, 0, static_cast<int>(between_exchanges * 1e3));
    sent = send_bytes(post.descriptors[order.wire], order.bytes[i]) && sent;
  }
  return sent;
}

void note_sent(Post& post, std::size_t index, bool sent) {
  put(post.note, sent ? "sent " : "not sent ");
  put(post.note, post.words[index].data(), post.words[index].size());
  put(post.note, "\n");
}

/// What waits for nothing goes at once, and again: the first may have followed half a line of the process that has
/// ended.
void send_first(Post& post) {
  for (std::size_t i = 0; i < post.orders.size(); ++i)
    if (post.orders[i].after == 0.0) note_sent(post, i, send_order(post, post.orders[i]));
}

void act(Post& post, const char* why) {
  const std::uint64_t looks = post.shared->looks;
  post.shared->acted = true;
  put_number(post.note, static_cast<long long>(std::time(nullptr)));
  put(post.note, " ");
  put(post.note, why);
  put(post.note, "\n");
  send_first(post);
  bool goes_on = wait_and_drain(post, before_again, looks);
  for (std::size_t i = 0; i < post.orders.size() && goes_on; ++i)
    if (post.orders[i].after == 0.0 && post.orders[i].again) send_order(post, post.orders[i]);
  for (std::size_t i = 0; i < post.orders.size() && goes_on; ++i) {
    if (post.orders[i].after == 0.0) continue;
    goes_on = wait_and_drain(post, std::min(post.orders[i].after, longest_wait), looks);
    if (goes_on) note_sent(post, i, send_order(post, post.orders[i]));
  }
  if (goes_on) wait_and_drain(post, linger, looks);
}

}  // namespace

void keep_watch(Post& post) {
  sigset_t all;
  sigfillset(&all);
  sigprocmask(SIG_SETMASK, &all, nullptr);  // SIGUSR2 is looked for; a terminal ends the run, and not its guard
  std::signal(SIGUSR2, SIG_DFL);            // an ignored one would not wait to be seen
  std::signal(SIGPIPE, SIG_IGN);
  keep_only(post);
  setsid();
  take_own_name(post.own_name);
  if (chdir("/") != 0) put(post.note, "");
  put_number(post.note, getpid());
  put(post.note, "\n");
  std::uint64_t looks = 0;
  double silent = 0.0, before = monotonic_now();
  for (bool there = true; there;) {
    pollfd line{post.line, POLLIN, 0};
    if (poll(&line, 1, look_every) > 0) there = hear(post);
    if (post.shared->dismissed || (!there && !post.shared->armed)) _exit(0);
    const double now = monotonic_now();
    const bool seen = post.shared->looks != looks || !post.shared->armed;
    silent = seen ? 0.0 : silent + std::min(now - before, longest_look);
    before = now;
    looks = post.shared->looks;
    if (!there) act(post, "ended");
    if (there && silent > post.patience && !post.shared->acted) act(post, "silent");
  }
  _exit(0);
}

}  // namespace tumble::guard
