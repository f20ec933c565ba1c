#pragma once

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "tumble/station/link.hpp"

namespace tumble::link {

namespace asio = boost::asio;
using Tcp = asio::ip::tcp;
using Udp = asio::ip::udp;
using Code = boost::system::error_code;

/// One link that is open. Work under way holds it by a shared pointer.
struct Connection {
  std::size_t number = 0;
  std::variant<Tcp::socket, asio::posix::stream_descriptor> stream;
  std::array<char, 1 << 16> room;
  bool datagrams = false;        ///< each read is one, of any length
  bool listens = false;          ///< nobody to send to
  std::string waiting, sending;  ///< to be sent
  bool up = true;
  std::size_t taken = 0;  ///< [byte] in this wait
  int reads = 0;          ///< in this wait
  int other_side = -1;    ///< of a pseudo-terminal: kept open, so that it does not end when nobody has it open
  std::unique_ptr<asio::steady_timer> silence_timer;
  double silence = 0.0;                              ///< [s]
  std::chrono::steady_clock::time_point heard = {};  ///< when the last bytes came

  Connection(std::size_t index, Tcp::socket socket) : number(index), stream(std::move(socket)) {}
  Connection(std::size_t index, asio::posix::stream_descriptor line) : number(index), stream(std::move(line)) {}
  ~Connection();
};
using Shared = std::shared_ptr<Connection>;

/// All links of a Links, and what happened on them.
class Loop {
 public:
  explicit Loop(std::function<double()> clock) : clock_(std::move(clock)) {}  ///< clock [s]
  ~Loop();

  /// Opens links as Links does; times [s].
  std::size_t open_tcp(const LinkAddress& address, double timeout, double silence);
  std::size_t open_udp(const LinkAddress& address, double silence);     ///< [s]
  std::size_t open_serial(const LinkAddress& address, double silence);  ///< [s]
  std::uint16_t listen(std::uint16_t port, const std::string& host);
  Links::Terminal open_terminal();
  void send(std::size_t link, std::string_view bytes);
  std::size_t unsent(std::size_t link) const;
  void close(std::size_t link);
  std::string peer(std::size_t link) const;
  int descriptor(std::size_t link) const;
  bool is_up(std::size_t link) const { return link < links_.size() && links_[link] && links_[link]->up; }
  std::vector<LinkEvent> wait(double seconds);  ///< at most so many [s]
  void wake();

 private:
  std::size_t add(Shared link, double silence);
  void read(const Shared& link);
  void read_on(const Shared& link);
  void do_what_is_ready();
  void write(const Shared& link);
  void lose(const Shared& link, const Sentence& reason);
  void watch(const Shared& link);
  void accept(const std::shared_ptr<Tcp::acceptor>& door);
  void accept_later(const std::shared_ptr<Tcp::acceptor>& door);

  asio::io_context context_;
  std::function<double()> clock_;
  std::vector<Shared> links_;  ///< by number; null: it was closed
  std::vector<std::shared_ptr<Tcp::acceptor>> doors_;
  std::vector<LinkEvent> events_;
  std::vector<Shared> sated_;  ///< that have had their part of this wait
  bool woken_ = false;
};

}  // namespace tumble::link
