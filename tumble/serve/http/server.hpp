#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <map>
#include <optional>

#include "tumble/serve/http/stream.hpp"
#include "tumble/serve/http_server.hpp"

namespace tumble::http {

/// What the connections of a server share.
struct Server {
  struct Known {
    std::function<void()> close;
    bool trusted = false;
  };
  HttpOptions options;
  HttpHandler handler;
  std::map<std::uint64_t, Known> known;  ///< connections, the oldest first; they end with the context
  std::uint64_t next = 0;
  std::optional<asio::ssl::context> tls;
  asio::io_context context{1};
  asio::thread_pool workers;
  Tcp::acceptor acceptor{context};
  asio::steady_timer pause{context};

  Server(const HttpOptions& given, HttpHandler handles)
      : options(given), handler(std::move(handles)), workers(given.workers) {}
};

/// Serves one connection that has come in, until it ends. On the network thread.
void serve_connection(Server& server, Tcp::socket socket);

}  // namespace tumble::http
