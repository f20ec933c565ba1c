#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <map>
#include <optional>

#include "tumble/serve/http/stream.hpp"
#include "tumble/serve/http_server.hpp"

struct tumble::HttpServer::State {
  struct Known {
    std::function<void()> close;
    bool trusted = false;
  };
  HttpOptions options;
  HttpHandler handler;
  std::map<std::uint64_t, Known> known;  ///< connections, the oldest first; they end with the context
  std::uint64_t next = 0;
  std::optional<http::asio::ssl::context> tls;
  http::asio::io_context context{1};
  http::asio::thread_pool workers;
  http::Tcp::acceptor acceptor{context};
  http::asio::steady_timer pause{context};

  State(const HttpOptions& given, HttpHandler handles)
      : options(given), handler(std::move(handles)), workers(given.workers) {}
};

namespace tumble::http {

/// Serves one connection that has come in, until it ends. On the network thread.
void serve_connection(HttpServer::State& server, Tcp::socket socket);

}  // namespace tumble::http
