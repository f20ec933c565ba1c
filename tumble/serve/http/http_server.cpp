#include "tumble/serve/http_server.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/ssl.hpp>
#include <cctype>
#include <chrono>
#include <csignal>
#include <limits>

#include "tumble/serve/http/target.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace message = boost::beast::http;
using Tcp = asio::ip::tcp;
using Code = boost::system::error_code;

struct HttpServer::State {
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

  State(const HttpOptions& given, HttpHandler handles)
      : options(given), handler(std::move(handles)), workers(given.workers) {}
};

namespace {

using State = HttpServer::State;

std::chrono::milliseconds milliseconds(double seconds) {
  return std::chrono::milliseconds(static_cast<long>(seconds * 1e3));
}

HttpResponse plain(unsigned status, const std::string& text) {
  return {status, "text/plain; charset=utf-8", text + "\n"};
}

using Plain = beast::tcp_stream;
using Secure = beast::ssl_stream<beast::tcp_stream>;

/// One connection. What goes on holds it by a shared pointer.
template <class Stream>
struct Connection {
  State& server;
  std::uint64_t number;
  Stream stream;
  beast::flat_buffer buffer;
  std::optional<message::request_parser<message::buffer_body>> parser;
  HttpRequest request;
  BodyPlan plan;
  HttpResponse response;
  std::array<char, 1 << 16> piece;
  std::string outgoing;
  message::response<message::string_body> whole;
  message::response<message::empty_body> head;
  std::optional<message::response_serializer<message::empty_body>> head_writer;
  std::shared_ptr<void> subscription;
  asio::steady_timer heartbeat;
  bool keeps = false, writing = false, ended = false;
  std::size_t drained = 0;

  Connection(State& of, std::uint64_t id, Stream&& with)
      : server(of), number(id), stream(std::move(with)), heartbeat(of.context) {}
  ~Connection() { server.known.erase(number); }
  void patience(double seconds) { beast::get_lowest_layer(stream).expires_after(milliseconds(seconds)); }
};

template <class Stream>
using Shared = std::shared_ptr<Connection<Stream>>;

template <class Stream>
void read_head(Shared<Stream> c);

/// The rest of what the other side sends is read for a moment: closed at once, the answer could be lost on its way.
template <class Stream>
void drain(Shared<Stream> c) {
  c->patience(2.0);
  beast::get_lowest_layer(c->stream).async_read_some(asio::buffer(c->piece), [c](Code code, std::size_t count) {
    c->drained += count;
    if (!code && c->drained < std::size_t{1} << 24) drain(c);
  });
}

template <class Stream>
void hang_up(Shared<Stream> c) {
  c->ended = true;
  c->subscription.reset();
  Code ignored;
  beast::get_lowest_layer(c->stream).socket().shutdown(Tcp::socket::shutdown_send, ignored);
  drain(c);
}

void hang_up(Shared<Secure> c) {
  c->ended = true;
  c->subscription.reset();
  c->patience(2.0);
  c->stream.async_shutdown([c](Code) {});
}

template <class Stream>
void sent(Shared<Stream> c, Code code) {
  c->response = {};
  c->request = {};
  c->plan = {};
  c->outgoing.clear();
  if (code || !c->keeps) return code ? void() : hang_up(c);
  read_head(c);
}

template <class Fields>
void set_headers(Fields& fields, const HttpResponse& response) {
  fields.set(message::field::content_type, response.type);
  for (const auto& [name, value] : response.headers) fields.set(name, value);
}

template <class Stream>
void send_more(Shared<Stream> c);

/// An answer that ends without its last chunk is seen to be cut off.
enum class More { another, last, failed };

template <class Stream>
void send_piece(Shared<Stream> c, More more) {
  if (more == More::failed) return beast::get_lowest_layer(c->stream).close();
  c->patience(3.0 * c->server.options.patience);
  if (more == More::last)
    asio::async_write(c->stream, message::make_chunk_last(), [c](Code code, std::size_t) { sent(c, code); });
  else if (c->outgoing.empty())
    send_more(c);
  else
    asio::async_write(c->stream, message::make_chunk(asio::buffer(c->outgoing)), [c](Code code, std::size_t) {
      if (!code) send_more(c);
    });
}

/// Piece after piece from the work pool, until there is no more. The connection is handed on, so that it ends on the
/// network thread.
template <class Stream>
void send_more(Shared<Stream> c) {
  State& server = c->server;
  asio::post(server.workers, [c = std::move(c), &server]() mutable {
    auto more = More::failed;
    c->outgoing.clear();
    try {
      more = c->response.more(c->outgoing) ? More::another : More::last;
    } catch (const std::exception&) {
      c->outgoing.clear();
    }
    asio::post(server.context, [c = std::move(c), more]() mutable { send_piece(std::move(c), more); });
  });
}

template <class Stream>
void send_events(Shared<Stream> c) {
  if (c->writing || c->ended) return;
  c->outgoing = c->response.events->after(c->response.seen);
  if (c->outgoing.empty()) return;
  if (c->response.said) c->outgoing = c->response.said(c->outgoing);
  c->writing = true;
  c->patience(3.0 * c->server.options.patience);
  asio::async_write(c->stream, asio::buffer(c->outgoing), [c](Code code, std::size_t) {
    c->writing = false;
    if (code) {
      c->ended = true;
      c->subscription.reset();
      c->heartbeat.cancel();
      return;
    }
    beast::get_lowest_layer(c->stream).expires_never();
    send_events(c);
  });
}

/// A line that says nothing, so that a reader who is no longer there is found.
template <class Stream>
void beat(Shared<Stream> c) {
  c->heartbeat.expires_after(std::chrono::seconds(15));
  c->heartbeat.async_wait([c](Code code) {
    if (code || c->ended) return;
    if (c->writing) return beat(c);
    c->writing = true;
    c->outgoing = ": \n\n";
    c->patience(c->server.options.patience);
    asio::async_write(c->stream, asio::buffer(c->outgoing), [c](Code failed, std::size_t) {
      c->writing = false;
      if (failed) {
        c->ended = true;
        c->subscription.reset();
        return;
      }
      beast::get_lowest_layer(c->stream).expires_never();
      send_events(c);
      beat(c);
    });
  });
}

template <class Stream>
void begin_events(Shared<Stream> c) {
  const std::weak_ptr<Connection<Stream>> weak = c;
  auto& context = c->server.context;
  c->subscription = c->response.events->subscribe([weak, &context] {
    asio::post(context, [weak] {
      if (const auto strong = weak.lock()) send_events(strong);
    });
  });
  send_events(c);
  beat(c);
}

/// Head of an answer whose length is not known.
template <class Stream>
void send_head(Shared<Stream> c) {
  c->head = {};
  c->head.version(11);
  c->head.result(c->response.status);
  set_headers(c->head, c->response);
  if (c->response.events)
    c->keeps = false;
  else
    c->head.chunked(true);
  c->head.keep_alive(c->keeps);
  c->head_writer.emplace(c->head);
  c->patience(c->server.options.patience);
  message::async_write_header(c->stream, *c->head_writer, [c](Code code, std::size_t) {
    if (code) return;
    if (c->response.events)
      begin_events(c);
    else
      send_more(c);
  });
}

template <class Stream>
void send(Shared<Stream> c, HttpResponse response) {
  c->response = std::move(response);
  const bool only_head = c->request.method == "HEAD";
  if (!only_head && (c->response.more || c->response.events)) return send_head(c);
  c->whole = {};
  c->whole.version(11);
  c->whole.result(c->response.status);
  set_headers(c->whole, c->response);
  c->whole.keep_alive(c->keeps);
  const std::size_t length = c->response.body.size();
  if (!only_head) c->whole.body() = std::move(c->response.body);
  c->whole.content_length(length);
  c->patience(6.0 * c->server.options.patience);
  message::async_write(c->stream, c->whole, [c](Code code, std::size_t) { sent(c, code); });
}

template <class Stream>
void answer(Shared<Stream> c) {
  beast::get_lowest_layer(c->stream).expires_never();
  State& server = c->server;
  asio::post(server.workers, [c = std::move(c), &server]() mutable {
    auto response = std::make_shared<HttpResponse>(server.handler.answer(c->request));
    asio::post(server.context, [c = std::move(c), response]() mutable { send(std::move(c), std::move(*response)); });
  });
}

template <class Stream>
void refuse(Shared<Stream> c, HttpResponse response) {
  c->keeps = false;
  send(c, std::move(response));
}

/// Whether the other side sent what is no request, rather than nothing more.
bool is_malformed(Code code) {
  return code.category() == message::make_error_code(message::error::bad_version).category() &&
         code != message::error::end_of_stream && code != message::error::partial_message;
}

/// False: the body does not fit, or cannot be written.
template <class Stream>
bool take_piece(Connection<Stream>& c, std::size_t count) {
  c.request.body_bytes += count;
  if (c.request.body_bytes > c.plan.limit) return false;
  if (c.request.file) return c.request.file->write(c.piece.data(), count);
  c.request.body.append(c.piece.data(), count);
  return true;
}

template <class Stream>
void read_body(Shared<Stream> c) {
  if (c->parser->is_done()) return answer(c);
  auto& body = c->parser->get().body();
  const std::size_t room = std::min<std::uint64_t>(c->piece.size(), c->plan.limit - c->request.body_bytes + 1);
  body.data = c->piece.data();
  body.size = room;
  c->patience(c->server.options.patience);
  message::async_read(c->stream, c->buffer, *c->parser, [c, room](Code code, std::size_t) {
    if (code == message::error::need_buffer) code = {};
    if (is_malformed(code)) return refuse(c, plain(400, "the body is not as its head says"));
    if (code) return;
    const std::size_t count = room - c->parser->get().body().size;
    const auto before = c->request.body_bytes;
    if (!take_piece(*c, count))
      return refuse(c, before + count > c->plan.limit
                           ? plain(413, fmt::format("the body has more than {} bytes", c->plan.limit))
                           : plain(507, "the disk is full, or cannot be written"));
    read_body(c);
  });
}

template <class Stream>
void take_head(Shared<Stream> c) {
  const auto& head = c->parser->get();
  c->request = {};
  c->request.method = std::string(head.method_string());
  for (const auto& field : head) {
    std::string name(field.name_string());
    std::ranges::transform(name, name.begin(), [](unsigned char letter) { return std::tolower(letter); });
    c->request.headers[name] = std::string(field.value());
  }
  c->keeps = head.keep_alive() && head.version() == 11;
  const std::string_view target{head.target().data(), head.target().size()};
  if (head.count(message::field::host) != 1 || !http::take_target(target, c->request))
    return refuse(c, plain(400, "the request is not well formed"));
  c->plan = c->server.handler.admit(c->request);
  c->request.file = c->plan.file;
  const auto known = c->server.known.find(c->number);
  if (known != c->server.known.end() && c->plan.trusted) known->second.trusted = true;
  if (c->plan.refusal) return refuse(c, std::move(*c->plan.refusal));
  if (const auto length = c->parser->content_length(); length && *length > c->plan.limit)
    return refuse(c, plain(413, fmt::format("the body has more than {} bytes", c->plan.limit)));
  if (!beast::iequals(head[message::field::expect], "100-continue")) return read_body(c);
  c->outgoing = "HTTP/1.1 100 Continue\r\n\r\n";
  asio::async_write(c->stream, asio::buffer(c->outgoing), [c](Code code, std::size_t) {
    if (!code) read_body(c);
  });
}

template <class Stream>
void read_head(Shared<Stream> c) {
  c->plan = {};
  c->parser.emplace();
  c->parser->header_limit(16384);
  c->parser->body_limit(std::numeric_limits<std::uint64_t>::max());
  c->patience(c->server.options.patience);
  message::async_read_header(c->stream, c->buffer, *c->parser, [c](Code code, std::size_t) {
    if (!code) return take_head(c);
    c->request = {};
    if (code == message::error::header_limit) return refuse(c, plain(431, "the head of the request is too long"));
    if (is_malformed(code)) refuse(c, plain(400, "the request is not well formed"));
  });
}

/// Room for one more: the oldest connection that has not shown the token is closed.
bool make_room(State& server) {
  if (server.known.size() < server.options.connections) return true;
  for (auto& [number, known] : server.known)
    if (!known.trusted) {
      const auto close = known.close;
      server.known.erase(number);
      close();
      return true;
    }
  return false;
}

template <class Stream>
Shared<Stream> admitted(State& server, Stream&& stream) {
  const auto number = server.next++;
  auto c = std::make_shared<Connection<Stream>>(server, number, std::move(stream));
  const std::weak_ptr<Connection<Stream>> weak = c;
  server.known[number].close = [weak] {
    if (const auto strong = weak.lock()) beast::get_lowest_layer(strong->stream).close();
  };
  return c;
}

void begin(State& server, Tcp::socket socket) {
  Code ignored;
  socket.set_option(Tcp::no_delay(true), ignored);
  if (!make_room(server)) return;
  if (!server.tls) return read_head(admitted(server, Plain(std::move(socket))));
  auto c = admitted(server, Secure(std::move(socket), *server.tls));
  c->patience(server.options.patience);
  c->stream.async_handshake(asio::ssl::stream_base::server, [c](Code code) {
    if (!code) read_head(c);
  });
}

void accept(State& server) {
  server.acceptor.async_accept([&server](Code code, Tcp::socket socket) {
    if (code == asio::error::operation_aborted) return;
    if (!code) {
      begin(server, std::move(socket));
      return accept(server);
    }
    server.pause.expires_after(std::chrono::milliseconds(50));  // no descriptor is free: some will be soon
    server.pause.async_wait([&server](Code stopped) {
      if (!stopped) accept(server);
    });
  });
}

void prepare_tls(State& server) {
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

void listen(State& server) {
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

HttpServer::HttpServer(const HttpOptions& options, HttpHandler handler)
    : state_(std::make_unique<State>(options, std::move(handler))) {
  if (!options.certificate.empty()) prepare_tls(*state_);
  listen(*state_);
  accept(*state_);
}

HttpServer::~HttpServer() {
  stop();
  state_->workers.join();
}

unsigned HttpServer::port() const { return state_->acceptor.local_endpoint().port(); }

void HttpServer::run(bool until_signal) {
  asio::signal_set signals(state_->context);
  if (until_signal) {
    signals.add(SIGINT);
    signals.add(SIGTERM);
    signals.async_wait([this](Code code, int) {
      if (!code) state_->context.stop();
    });
  }
  state_->context.run();
}

void HttpServer::stop() { state_->context.stop(); }

}  // namespace tumble
