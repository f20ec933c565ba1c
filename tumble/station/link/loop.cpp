#include "tumble/station/link/loop.hpp"

#include <fmt/format.h>
#include <netdb.h>
#include <sys/socket.h>
#include <unistd.h>

#include <boost/asio/post.hpp>
#include <boost/asio/write.hpp>
#include <utility>

#include "tumble/units/error.hpp"

namespace tumble::link {

namespace {

constexpr std::size_t most_taken = std::size_t{1} << 16;  ///< [byte] of a link in one wait
constexpr int most_reads = 256;                           ///< of a link in one wait
constexpr int most_work = 4096;                           ///< pieces of work in one wait: at doors, timers

std::chrono::steady_clock::duration duration_of(double seconds) {
  return std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(seconds));
}

/// Why a link ended.
Sentence loss_of(const Code& code) {
  if (code == asio::error::eof) return "the other side closed the link";
  if (code == asio::error::connection_reset) return "the other side broke the link off";
  if (code.value() == EIO) return "the device was unplugged or its other side was closed";
  return tumble::system_reason(code);
}

/// An empty datagram, or one of ours that nobody took: the device may be switched on later.
bool is_passing(const Code& code) { return code == asio::error::eof || code == asio::error::connection_refused; }

}  // namespace

Connection::~Connection() {
  if (other_side >= 0) ::close(other_side);
}

Loop::~Loop() {
  for (std::size_t number = 0; number < links_.size(); ++number) close(number);
  for (const auto& door : doors_) {
    Code ignored;
    door->close(ignored);
  }
  context_.restart();
  context_.poll();  // what is under way ends
}

std::size_t Loop::add(Shared link, double silence) {
  links_.push_back(link);
  if (silence > 0.0) {
    link->silence = silence;
    link->heard = std::chrono::steady_clock::now();
    link->silence_timer = std::make_unique<asio::steady_timer>(context_);
    watch(link);
  }
  read(link);
  return link->number;
}

void Loop::read(const Shared& link) {
  std::visit(
      [&](auto& stream) {
        stream.async_read_some(asio::buffer(link->room), [this, link](Code code, std::size_t count) {
          if (!link->up || code == asio::error::operation_aborted) return;
          if (link->datagrams && is_passing(code)) code = {};
          if (count > 0) {
            link->heard = std::chrono::steady_clock::now();
            events_.push_back({LinkEvent::Kind::bytes, link->number, clock_(), {link->room.data(), count}, {}});
          }
          if (code) return lose(link, loss_of(code));
          link->taken += count;
          ++link->reads;
          read_on(link);
        });
      },
      link->stream);
}

/// However fast the other side sends, a wait takes a part of it, and the other links have theirs: the rest is left to
/// the next wait, and then to the operating system, which lets the sender wait.
void Loop::read_on(const Shared& link) {
  if (link->taken < most_taken && link->reads < most_reads) return read(link);
  sated_.push_back(link);
}

void Loop::do_what_is_ready() {
  for (int work = 0; work < most_work && context_.poll_one() > 0; ++work) {
  }
}

void Loop::write(const Shared& link) {
  if (!link->sending.empty() || link->waiting.empty()) return;
  link->sending = std::exchange(link->waiting, {});
  std::visit(
      [&](auto& stream) {
        asio::async_write(stream, asio::buffer(link->sending), [this, link](const Code& code, std::size_t) {
          link->sending.clear();
          if (!link->up || code == asio::error::operation_aborted) return;
          if (code && !(link->datagrams && is_passing(code))) return lose(link, loss_of(code));
          write(link);
        });
      },
      link->stream);
}

void Loop::watch(const Shared& link) {
  link->silence_timer->expires_at(link->heard + duration_of(link->silence));
  link->silence_timer->async_wait([this, link](const Code& code) {
    if (code || !link->up) return;
    if (std::chrono::steady_clock::now() - link->heard >= duration_of(link->silence))
      return lose(link, say("nothing was received for {:.3g} s", link->silence));
    watch(link);
  });
}

void Loop::lose(const Shared& link, const Sentence& reason) {
  if (!link->up) return;
  close(link->number);
  events_.push_back({LinkEvent::Kind::lost, link->number, clock_(), {}, reason});
}

void Loop::close(std::size_t number) {
  if (!is_up(number)) return;
  const Shared link = std::move(links_[number]);  // it ends with what is under way
  link->up = false;
  if (link->silence_timer) link->silence_timer->cancel();
  std::visit(
      [](auto& stream) {
        Code ignored;
        stream.close(ignored);
      },
      link->stream);
}

void Loop::send(std::size_t link, std::string_view bytes) {
  if (!is_up(link) || links_[link]->listens) return;
  links_[link]->waiting += bytes;
  write(links_[link]);
}

std::size_t Loop::unsent(std::size_t link) const {
  return is_up(link) ? links_[link]->waiting.size() + links_[link]->sending.size() : 0;
}

int Loop::descriptor(std::size_t link) const {
  if (!is_up(link)) return -1;
  return std::visit([](auto& stream) { return static_cast<int>(stream.native_handle()); }, links_[link]->stream);
}

std::string Loop::peer(std::size_t link) const {
  sockaddr_storage end{};
  socklen_t size = sizeof end;
  char host[NI_MAXHOST];
  auto* const address = reinterpret_cast<sockaddr*>(&end);
  const bool known = is_up(link) && getpeername(descriptor(link), address, &size) == 0 &&
                     getnameinfo(address, size, host, sizeof host, nullptr, 0, NI_NUMERICHOST) == 0;
  return known ? host : "";
}

std::vector<LinkEvent> Loop::wait(double seconds) {
  const auto until = std::chrono::steady_clock::now() + duration_of(std::max(seconds, 0.0));
  for (const Shared& link : links_)
    if (link) link->taken = 0, link->reads = 0;
  for (const Shared& link : std::exchange(sated_, {}))
    if (link->up) read(link);
  context_.restart();
  do_what_is_ready();
  while (events_.empty() && !woken_) {
    context_.restart();
    asio::executor_work_guard<asio::io_context::executor_type> guard(context_.get_executor());
    const bool is_over = context_.run_one_until(until) == 0;
    context_.restart();
    do_what_is_ready();  // also what has arrived while this process was stopped, past the end of the wait
    if (is_over) break;
  }
  woken_ = false;
  return std::exchange(events_, {});
}

void Loop::wake() {
  asio::post(context_, [this] { woken_ = true; });
}

}  // namespace tumble::link
