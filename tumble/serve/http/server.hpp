#pragma once

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <map>
#include <optional>

#include "tumble/serve/http/stream.hpp"
#include "tumble/serve/http/work_pool.hpp"
#include "tumble/serve/http_server.hpp"

namespace tumble::http {

/// State that the connections of a server share.
struct Server {
  struct Known {
    std::function<void()> close;
    std::string party;
    bool streams = false;  ///< events
    bool urgent = false;   ///< an order to a run: it is not closed to make room
  };
  HttpOptions options;
  HttpHandler handler;
  std::map<std::uint64_t, Known> known;  ///< connections, the oldest first; they end with the context
  std::uint64_t next = 0;
  std::optional<asio::ssl::context> tls;
  std::map<std::string, std::size_t> body_bytes;  ///< in memory by party, above what each request has free [bytes]
  std::size_t all_body_bytes = 0;
  bool accepting = false;
  std::atomic<bool> ending = false;
  std::map<Lane, WorkPool> lanes;  ///< before the context, whose connections may leave work for them
  asio::io_context context{1};
  Tcp::acceptor acceptor{context};
  asio::steady_timer pause{context};

  Server(const HttpOptions& given, HttpHandler handles);
};

constexpr std::size_t free_body_bytes = std::size_t{1} << 16;      ///< of each request
constexpr std::size_t most_body_bytes = std::size_t{1} << 26;      ///< of all requests above that
constexpr std::size_t most_bytes_of_party = std::size_t{1} << 24;  ///< of one party
constexpr std::size_t most_pending = 200;                          ///< requests of a party in a lane

/// Serves one connection that has come in, until it ends. On the network thread.
void serve_connection(Server& server, Tcp::socket socket);

}  // namespace tumble::http
