#pragma once

#include <boost/asio/buffer.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/ssl.hpp>
#include <functional>
#include <memory>
#include <variant>
#include <vector>

namespace tumble::http {

namespace asio = boost::asio;
namespace beast = boost::beast;
using Tcp = asio::ip::tcp;
using Code = boost::system::error_code;

/// A connection over TCP, in the clear or by TLS. What reads and writes messages is compiled once for both: what
/// follows is kept in a std::function, which costs one allocation a piece of 64 kB.
class Stream {
 public:
  using executor_type = beast::tcp_stream::executor_type;
  using Done = std::function<void(Code, std::size_t)>;

  Stream(Tcp::socket socket, asio::ssl::context* tls);  ///< null: in the clear

  /// The stream of TCP, which has the timer.
  beast::tcp_stream& lowest();
  executor_type get_executor() { return lowest().get_executor(); }
  bool is_secure() const { return stream_.index() == 1; }
  /// Handshake and shutdown of TLS; a stream without TLS has neither.
  void handshake(std::function<void(Code)> done);
  void shutdown(std::function<void(Code)> done);

  template <class Buffers, class Handler>
  void async_read_some(const Buffers& buffers, Handler&& handler) {
    asio::mutable_buffer first;
    for (auto at = asio::buffer_sequence_begin(buffers); at != asio::buffer_sequence_end(buffers); ++at)
      if (first.size() == 0) first = *at;
    read_some(first, kept(std::forward<Handler>(handler)));
  }
  template <class Buffers, class Handler>
  void async_write_some(const Buffers& buffers, Handler&& handler) {
    write_some({asio::buffer_sequence_begin(buffers), asio::buffer_sequence_end(buffers)},
               kept(std::forward<Handler>(handler)));
  }

 private:
  template <class Handler>
  static Done kept(Handler&& handler) {
    auto shared = std::make_shared<std::decay_t<Handler>>(std::forward<Handler>(handler));
    return [shared](Code code, std::size_t count) { (*shared)(code, count); };
  }
  void read_some(asio::mutable_buffer room, Done done);
  void write_some(std::vector<asio::const_buffer> bytes, Done done);

  using Either = std::variant<beast::tcp_stream, beast::ssl_stream<beast::tcp_stream>>;
  Either stream_;
};

}  // namespace tumble::http
