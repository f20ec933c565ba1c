#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace tumble {

/// Where a device is reached.
struct LinkAddress {
  enum class Kind { tcp, udp, serial };
  Kind kind = Kind::tcp;
  std::string host;  ///< tcp, udp; empty for udp: whoever sends to that port of this computer
  std::uint16_t port = 0;
  std::string device;   ///< serial: "/dev/ttyUSB0"
  long baud = 0;        ///< [baud]; 0: not said
  std::string framing;  ///< "8N1": data bits, parity N, E or O, stop bits; empty: not said
};

/// `tcp:HOST:PORT`, `udp:HOST:PORT`, `udp:PORT` or `serial:DEVICE[:BAUD[:8N1]]`. An address of IPv6 stands in brackets.
/// Throws Error::bad_input with all problems and what would be accepted.
LinkAddress parse_link(std::string_view text);
/// The text of an address, as parse_link() reads it.
std::string text_of(const LinkAddress& address);

/// An event on a link.
struct LinkEvent {
  enum class Kind { up, bytes, lost };
  Kind kind = Kind::bytes;
  std::size_t link = 0;
  double time = 0.0;       ///< [s] of the clock given
  std::string bytes;       ///< received
  Sentence reason;         ///< lost: why
  std::uint16_t port = 0;  ///< up: of our door at which the other side came in
};

/// Links to devices, and doors at which others open links to us, served by one thread: the one that calls wait().
class Links {
 public:
  explicit Links(std::function<double()> clock);  ///< [s] that stamps what arrives
  Links(const Links&) = delete;
  Links& operator=(const Links&) = delete;
  ~Links();

  /// Opens a link. One of UDP has an event for each datagram, and is lost by silence alone; `udp:PORT` only listens:
  /// what is sent on it is dropped.
  ///
  /// Given     timeout  [s] for the connection
  ///           silence  [s] without a byte after which the link counts as lost; 0: never
  /// Returned  its number; wait() has no event for its opening
  /// Throws    Error::bad_file: the device or host is missing, busy, not allowed, refuses; with what would be accepted
  std::size_t open(const LinkAddress& address, double timeout = 5.0, double silence = 0.0);

  /// A door for others at a TCP port of this machine; 0: any free one. Each connection is a link of its own, with an
  /// event `up`. Returns the port. Throws Error::bad_file.
  std::uint16_t listen(std::uint16_t port, const std::string& host = "127.0.0.1");
  /// A serial line of our own making: a pseudo-terminal, which the other side opens by the name returned.
  struct Terminal {
    std::size_t link = 0;
    std::string device;
  };
  Terminal open_terminal();

  /// Queues bytes to be sent; a link that is lost ignores them.
  void send(std::size_t link, std::string_view bytes);
  std::size_t unsent(std::size_t link) const;  ///< [byte] that are queued
  void close(std::size_t link);                ///< without an event
  bool is_up(std::size_t link) const;
  /// The numeric address of the other side of a link of TCP or UDP; empty: none is connected.
  std::string peer(std::size_t link) const;
  int descriptor(std::size_t link) const;  ///< of its file; -1: it is not up

  /// Events of the links: returns at once where something happened, else after at most `seconds` [s] with nothing.
  /// Bytes that arrived before a loss come before it. A call gives at most 64 kB of a link more than a read: the next
  /// call has more.
  std::vector<LinkEvent> wait(double seconds);
  /// Has wait() return; from any thread.
  void wake();

 private:
  struct Inner;
  std::unique_ptr<Inner> inner_;
};

}  // namespace tumble
