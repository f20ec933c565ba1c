#include "tumble/serve/http_server.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/signal_set.hpp>
#include <chrono>
#include <csignal>
#include <new>
#include <thread>

#include "tumble/serve/http/server.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

using namespace http;

namespace {

void accept(Server& server) {
  server.acceptor.async_accept([&server](Code code, Tcp::socket socket) {
    server.accepting = false;
    if (code == asio::error::operation_aborted) return;
    if (!code) {
      serve_connection(server, std::move(socket));
      return accept(server);
    }
    server.accepting = true;
    server.pause.expires_after(std::chrono::milliseconds(50));  // no descriptor is free: some will be soon
    server.pause.async_wait([&server](Code stopped) {
      server.accepting = false;
      if (!stopped) accept(server);
    });
  });
  server.accepting = true;
}

/// Where there is no memory for what one connection wants, that connection ends, and the server goes on.
void run_network(Server& server) {
  for (;;) try {
      if (!server.accepting) accept(server);
      server.context.run();
      return;
    } catch (const std::bad_alloc&) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
}

void prepare_tls(Server& server) {
  const HttpOptions& options = server.options;
  auto& tls = server.tls.emplace(asio::ssl::context::tls_server);
  Code code;
  tls.set_options(asio::ssl::context::default_workarounds | asio::ssl::context::no_sslv2 |
                  asio::ssl::context::no_sslv3 | asio::ssl::context::no_tlsv1 | asio::ssl::context::no_tlsv1_1);
  Problems problems;
  tls.use_certificate_chain_file(options.certificate, code);
  if (code) problems.push_back(say("--cert {}: {}", Name{options.certificate}, system_reason(code)));
  tls.use_private_key_file(options.key, asio::ssl::context::pem, code);
  if (code) problems.push_back(say("--key {}: {}", Name{options.key}, system_reason(code)));
  if (!problems.empty()) throw Error{Error::Kind::bad_input, problems};
}

void listen(Server& server) {
  const HttpOptions& options = server.options;
  const auto refuse_with = [&](const Sentence& why) {
    throw Error{Error::Kind::bad_input, say("cannot listen at {} port {}: {}", Name{options.host}, options.port, why)};
  };
  Code code;
  Tcp::resolver resolver(server.context);
  const auto places = resolver.resolve(options.host, std::to_string(options.port), Tcp::resolver::passive, code);
  if (code || places.empty()) refuse_with(code ? system_reason(code) : Sentence("there is no such address"));
  const Tcp::endpoint place = *places.begin();
  server.acceptor.open(place.protocol(), code);
  if (!code) server.acceptor.set_option(Tcp::acceptor::reuse_address(true), code);
  if (!code) server.acceptor.bind(place, code);
  if (!code) server.acceptor.listen(512, code);
  if (code) refuse_with(system_reason(code));
}

}  // namespace

http::Server::Server(const HttpOptions& given, HttpHandler handles) : options(given), handler(std::move(handles)) {
  const auto add = [&](Lane lane, std::size_t threads, std::size_t each) { lanes.try_emplace(lane, threads, each); };
  add(Lane::usual, given.workers, std::max<std::size_t>(given.workers, 2) - 1);
  add(Lane::looks, 4, 3);
  add(Lane::sign_in, 1, 1);
  add(Lane::begins, 2, 1);
  add(Lane::orders, 4, 3);
  add(Lane::stops, 8, 1);  // in lines by run: one that does not answer keeps one thread
  add(Lane::files, 3, 2);
}

struct HttpServer::Within {
  Server server;
};

HttpServer::HttpServer(const HttpOptions& options, HttpHandler handler)
    : within_(new Within{Server(options, std::move(handler))}) {
  Server& server = within_->server;
  if (!options.certificate.empty()) prepare_tls(server);
  listen(server);
  accept(server);
}

HttpServer::~HttpServer() {
  stop();
  within_->server.ending = true;
  within_->server.lanes.clear();
}

unsigned HttpServer::port() const { return within_->server.acceptor.local_endpoint().port(); }

void HttpServer::run(bool until_signal) {
  auto& context = within_->server.context;
  asio::signal_set signals(context);
  if (until_signal) {
    signals.add(SIGINT);
    signals.add(SIGTERM);
    signals.async_wait([&context](Code code, int) {
      if (!code) context.stop();
    });
  }
  run_network(within_->server);
}

void HttpServer::stop() { within_->server.context.stop(); }

}  // namespace tumble
