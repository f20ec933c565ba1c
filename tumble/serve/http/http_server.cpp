#include "tumble/serve/http_server.hpp"

#include <fmt/format.h>

#include <boost/asio/signal_set.hpp>
#include <chrono>
#include <csignal>

#include "tumble/serve/http/server.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

using namespace http;

namespace {

void accept(Server& server) {
  server.acceptor.async_accept([&server](Code code, Tcp::socket socket) {
    if (code == asio::error::operation_aborted) return;
    if (!code) {
      serve_connection(server, std::move(socket));
      return accept(server);
    }
    server.pause.expires_after(std::chrono::milliseconds(50));  // no descriptor is free: some will be soon
    server.pause.async_wait([&server](Code stopped) {
      if (!stopped) accept(server);
    });
  });
}

void prepare_tls(Server& server) {
  const HttpOptions& options = server.options;
  auto& tls = server.tls.emplace(asio::ssl::context::tls_server);
  Code code;
  tls.set_options(asio::ssl::context::default_workarounds | asio::ssl::context::no_sslv2 |
                  asio::ssl::context::no_sslv3 | asio::ssl::context::no_tlsv1 | asio::ssl::context::no_tlsv1_1);
  std::vector<std::string> problems;
  tls.use_certificate_chain_file(options.certificate, code);
  if (code) problems.push_back("--cert " + options.certificate + ": " + code.message());
  tls.use_private_key_file(options.key, asio::ssl::context::pem, code);
  if (code) problems.push_back("--key " + options.key + ": " + code.message());
  if (!problems.empty()) throw Error{Error::Kind::bad_input, problems};
}

void listen(Server& server) {
  const HttpOptions& options = server.options;
  const auto refuse_with = [&](const std::string& why) {
    throw Error{Error::Kind::bad_input,
                fmt::format("cannot listen at {} port {}: {}", options.host, options.port, why)};
  };
  Code code;
  Tcp::resolver resolver(server.context);
  const auto places = resolver.resolve(options.host, std::to_string(options.port), Tcp::resolver::passive, code);
  if (code || places.empty()) refuse_with(code ? code.message() : "there is no such address");
  const Tcp::endpoint place = *places.begin();
  server.acceptor.open(place.protocol(), code);
  if (!code) server.acceptor.set_option(Tcp::acceptor::reuse_address(true), code);
  if (!code) server.acceptor.bind(place, code);
  if (!code) server.acceptor.listen(512, code);
  if (code) refuse_with(code.message());
}

}  // namespace

struct HttpServer::Within {
  Server server;
};

HttpServer::HttpServer(const HttpOptions& options, HttpHandler handler)
    : within_(new Within{{options, std::move(handler)}}) {
  Server& server = within_->server;
  if (!options.certificate.empty()) prepare_tls(server);
  listen(server);
  accept(server);
}

HttpServer::~HttpServer() {
  stop();
  within_->server.workers.join();
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
  context.run();
}

void HttpServer::stop() { within_->server.context.stop(); }

}  // namespace tumble
