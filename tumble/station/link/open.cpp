// How links are opened: each way ends in a link, or in a message that says what was found and what would be accepted.

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <stdlib.h>
#include <unistd.h>

#include <boost/asio/connect.hpp>
#include <boost/asio/ip/v6_only.hpp>
#include <cerrno>
#include <filesystem>
#include <system_error>

#include "tumble/station/link/baud.hpp"
#include "tumble/station/link/loop.hpp"
#include "tumble/units/error.hpp"

namespace tumble::link {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void refuse(const Sentence& what) { throw Error(Error::Kind::bad_file, what); }

Sentence advice_on(const Code& code) {
  if (code == asio::error::connection_refused)
    return "; nothing listens at this port: is the device on, and is the port right?";
  if (code == asio::error::host_not_found || code == asio::error::host_not_found_try_again)
    return "; the name is not known here: give an address such as 192.168.0.10";
  if (code == asio::error::network_unreachable || code == asio::error::host_unreachable)
    return "; is the cable plugged in, and is this computer in the network of the device?";
  return "";
}

/// Serial devices of this machine, for messages.
std::vector<std::string> serial_devices() {
  std::vector<std::string> found;
  std::error_code unknown;
  for (const char* folder : {"/dev/serial/by-id", "/dev"})
    for (const auto& entry : fs::directory_iterator(folder, unknown)) {
      const std::string name = entry.path().filename().string();
      const bool usual = name.starts_with("ttyUSB") || name.starts_with("ttyACM");
      if (usual || entry.path().parent_path() != "/dev") found.push_back(entry.path().string());
    }
  std::sort(found.begin(), found.end());
  return found;
}

Sentence devices_here() {
  const auto found = serial_devices();
  return found.empty() ? Sentence("this computer has no serial device on USB")
                       : say("serial devices here: {}", fmt::join(found, ", "));
}

[[noreturn]] void refuse_serial(const LinkAddress& address, int code) {
  const std::string device = address.device;
  if (code == ENOENT) refuse(say("there is no serial device '{}'; {}", device, devices_here()));
  if (code == EACCES)
    refuse(
        say("the serial device '{}' may not be opened by this user; on most systems a member of the group "
            "'dialout' may",
            device));
  if (code == EBUSY) refuse(say("the serial device '{}' is in use by another program", device));
  refuse(say("cannot open the serial device '{}': {}", device, tumble::system_reason(code)));
}

}  // namespace

std::size_t Loop::open_tcp(const LinkAddress& address, double timeout, double silence) {
  const std::string name = text_of(address);
  Code code;
  const auto ends = Tcp::resolver(context_).resolve(address.host, std::to_string(address.port), code);
  if (code) refuse(say("cannot open {}: {}{}", Name{name}, tumble::system_reason(code), advice_on(code)));
  auto link = std::make_shared<Connection>(links_.size(), Tcp::socket(context_));
  auto& socket = std::get<Tcp::socket>(link->stream);
  std::optional<Code> result;
  asio::async_connect(socket, ends, [&](const Code& outcome, const Tcp::endpoint&) { result = outcome; });
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                                                            std::chrono::duration<double>(timeout));
  while (!result) {
    context_.restart();
    if (context_.run_one_until(until) > 0 || result) continue;
    Code ignored;
    socket.close(ignored);
    while (!result) context_.restart(), context_.run_one();
    refuse(say("cannot open {}: no answer within {:.3g} s; is the device on, and is the address right?", Name{name},
               timeout));
  }
  if (*result) refuse(say("cannot open {}: {}{}", Name{name}, tumble::system_reason(*result), advice_on(*result)));
  socket.set_option(Tcp::no_delay(true), code);
  return add(link, silence);
}

std::size_t Loop::open_udp(const LinkAddress& address, double silence) {
  const std::string name = text_of(address);
  const auto check = [&](const Code& code) {
    if (code) refuse(say("cannot open {}: {}{}", Name{name}, tumble::system_reason(code), advice_on(code)));
  };
  Code code;
  const bool listens = address.host.empty();
  Udp::endpoint end(Udp::v6(), address.port);
  if (!listens) {
    const auto ends = Udp::resolver(context_).resolve(address.host, std::to_string(address.port), code);
    check(code);
    end = *ends.begin();
  }
  Udp::socket socket(context_);
  socket.open(end.protocol(), code);
  if (code && listens) end = {Udp::v4(), address.port}, socket.open(end.protocol(), code);  // no IPv6 here
  check(code);
  Code ignored;
  socket.set_option(asio::ip::v6_only(false), ignored);
  socket.set_option(asio::socket_base::receive_buffer_size(1 << 22), ignored);  // what comes while we are busy
  if (listens)
    socket.bind(end, code);
  else
    socket.connect(end, code);
  check(code);
  // Read as a file: a read is a datagram, a write too.
  auto link = std::make_shared<Connection>(links_.size(), asio::posix::stream_descriptor(context_, socket.release()));
  link->datagrams = true;
  link->listens = listens;
  return add(link, silence);
}

std::size_t Loop::open_serial(const LinkAddress& address, double silence) {
  const int descriptor = ::open(address.device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) refuse_serial(address, errno);
  auto link = std::make_shared<Connection>(links_.size(), asio::posix::stream_descriptor(context_, descriptor));
  if (isatty(descriptor) != 1) refuse(say("'{}' is not a serial device; {}", address.device, devices_here()));
  if (const auto reason = take_alone(descriptor); !reason.empty())
    refuse(say("the serial device '{}' is not free: {}", address.device, tumble::system_reason(reason)));
  if (const auto reason = set_line(descriptor, address.baud, address.framing); !reason.empty())
    refuse(say("the serial device '{}' cannot be set to {}: {}", address.device, Name{text_of(address)},
               tumble::system_reason(reason)));
  return add(link, silence);
}

std::uint16_t Loop::listen(std::uint16_t port, const std::string& host) {
  Code code;
  const auto address = asio::ip::make_address(host, code);
  if (code) refuse(say("'{}' is not an address of this computer: {}", host, tumble::system_reason(code)));
  auto door = std::make_shared<Tcp::acceptor>(context_);
  const Tcp::endpoint end(address, port);
  door->open(end.protocol(), code);
  if (!code) door->set_option(Tcp::acceptor::reuse_address(true), code);
  if (!code) door->bind(end, code);
  if (!code) door->listen(asio::socket_base::max_listen_connections, code);
  if (code) refuse(say("cannot listen at {}:{}: {}", Name{host}, port, tumble::system_reason(code)));
  doors_.push_back(door);
  accept(door);
  return door->local_endpoint().port();
}

void Loop::accept(const std::shared_ptr<Tcp::acceptor>& door) {
  door->async_accept([this, door](const Code& code, Tcp::socket socket) {
    if (code == asio::error::operation_aborted || !door->is_open()) return;
    if (code) return accept_later(door);
    Code ignored;
    socket.set_option(Tcp::no_delay(true), ignored);
    const auto link = add(std::make_shared<Connection>(links_.size(), std::move(socket)), 0.0);
    events_.push_back({LinkEvent::Kind::up, link, clock_(), {}, {}, door->local_endpoint(ignored).port()});
    accept(door);
  });
}

/// Nobody can come in, for example without a file handle: at once again would be for ever.
void Loop::accept_later(const std::shared_ptr<Tcp::acceptor>& door) {
  auto timer = std::make_shared<asio::steady_timer>(context_, std::chrono::milliseconds(100));
  timer->async_wait([this, door, timer](const Code& code) {
    if (!code && door->is_open()) accept(door);
  });
}

Links::Terminal Loop::open_terminal() {
  const int descriptor = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (descriptor < 0) refuse(say("this system gives no pseudo-terminal: {}", tumble::system_reason(errno)));
  auto link = std::make_shared<Connection>(links_.size(), asio::posix::stream_descriptor(context_, descriptor));
  char name[128];
  if (grantpt(descriptor) != 0 || unlockpt(descriptor) != 0 || ptsname_r(descriptor, name, sizeof name) != 0)
    refuse(say("this system gives no pseudo-terminal: {}", tumble::system_reason(errno)));
  link->other_side = ::open(name, O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (const auto reason = set_line(link->other_side, 0, "8N1"); !reason.empty())
    refuse(say("a pseudo-terminal cannot be set up: {}", tumble::system_reason(reason)));
  return {add(link, 0.0), name};
}

}  // namespace tumble::link
