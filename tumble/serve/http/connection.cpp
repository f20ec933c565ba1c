#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/asio/post.hpp>
#include <boost/beast/http.hpp>
#include <cctype>
#include <chrono>
#include <limits>

#include "tumble/serve/http/server.hpp"
#include "tumble/serve/http/target.hpp"

namespace tumble::http {

namespace message = boost::beast::http;

namespace {

std::chrono::milliseconds milliseconds(double seconds) {
  return std::chrono::milliseconds(static_cast<long>(seconds * 1e3));
}

/// What is refused before any route sees it, in the form of all refusals. The text has no quotes.
HttpResponse plain(unsigned status, const std::string& text) {
  return {status, "application/json", fmt::format(R"({{"problems":["{}"]}})", text)};
}

/// One connection. What goes on holds it by a shared pointer.
struct Connection {
  Server& server;
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
  bool keeps = false, chunked = true, writing = false, ended = false;
  std::size_t drained = 0;

  Connection(Server& of, std::uint64_t id, Tcp::socket socket)
      : server(of), number(id), stream(std::move(socket), of.tls ? &*of.tls : nullptr), heartbeat(of.context) {}
  ~Connection() { server.known.erase(number); }
  void patience(double seconds) { stream.lowest().expires_after(milliseconds(seconds)); }
};

using Shared = std::shared_ptr<Connection>;

void read_head(Shared c);

/// The rest of what the other side sends is read for a moment: closed at once, the answer could be lost on its way.
void drain(Shared c) {
  c->patience(2.0);
  c->stream.lowest().async_read_some(asio::buffer(c->piece), [c](Code code, std::size_t count) {
    c->drained += count;
    if (!code && c->drained < std::size_t{1} << 24) drain(c);
  });
}

void hang_up(Shared c) {
  c->ended = true;
  c->subscription.reset();
  if (c->stream.is_secure()) {
    c->patience(2.0);
    return c->stream.shutdown([c](Code) {});
  }
  Code ignored;
  c->stream.lowest().socket().shutdown(Tcp::socket::shutdown_send, ignored);
  drain(c);
}

void sent(Shared c, Code code) {
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

void send_more(Shared c);

/// An answer that ends without its last chunk is seen to be cut off.
enum class More { another, last, failed };

void send_piece(Shared c, More more) {
  if (more == More::failed) return c->stream.lowest().close();
  c->patience(3.0 * c->server.options.patience);
  const auto go_on = [c](Code code, std::size_t) {
    if (!code) send_more(c);
  };
  if (more == More::last)
    c->chunked
        ? asio::async_write(c->stream, message::make_chunk_last(), [c](Code code, std::size_t) { sent(c, code); })
        : hang_up(c);
  else if (c->outgoing.empty())
    send_more(c);
  else if (c->chunked)
    asio::async_write(c->stream, message::make_chunk(asio::buffer(c->outgoing)), go_on);
  else
    asio::async_write(c->stream, asio::buffer(c->outgoing), go_on);
}

/// Piece after piece from the work pool, until there is no more. The connection is handed on, so that it ends on the
/// network thread.
void send_more(Shared c) {
  Server& server = c->server;
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

void send_events(Shared c) {
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
    c->stream.lowest().expires_never();
    send_events(c);
  });
}

/// A line that says nothing, so that a reader who is no longer there is found.
void beat(Shared c) {
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
      c->stream.lowest().expires_never();
      send_events(c);
      beat(c);
    });
  });
}

void begin_events(Shared c) {
  const std::weak_ptr<Connection> weak = c;
  auto& context = c->server.context;
  c->subscription = c->response.events->subscribe([weak, &context] {
    asio::post(context, [weak] {
      if (const auto strong = weak.lock()) send_events(strong);
    });
  });
  send_events(c);
  beat(c);
}

/// Head of an answer whose length is not known: it comes in chunks, or to HTTP/1.0 until the connection is closed.
void send_head(Shared c) {
  c->head = {};
  c->head.version(11);
  c->head.result(c->response.status);
  set_headers(c->head, c->response);
  if (c->response.events || !c->chunked)
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

void send(Shared c, HttpResponse response) {
  c->response = std::move(response);
  const bool only_head = c->request.method == "HEAD";
  if (!only_head && (c->response.more || c->response.events)) return send_head(c);
  c->whole = {};
  c->whole.version(11);
  c->whole.result(c->response.status);
  set_headers(c->whole, c->response);
  const bool has_length = !c->response.more && !c->response.events;
  c->keeps = c->keeps && has_length;
  c->whole.keep_alive(c->keeps);
  const std::size_t length = c->response.body.size();
  if (!only_head) c->whole.body() = std::move(c->response.body);
  if (has_length) c->whole.content_length(length);
  c->patience(6.0 * c->server.options.patience);
  message::async_write(c->stream, c->whole, [c](Code code, std::size_t) { sent(c, code); });
}

void answer(Shared c) {
  c->stream.lowest().expires_never();
  Server& server = c->server;
  asio::post(server.workers, [c = std::move(c), &server]() mutable {
    auto response = std::make_shared<HttpResponse>(server.handler.answer(c->request));
    asio::post(server.context, [c = std::move(c), response]() mutable { send(std::move(c), std::move(*response)); });
  });
}

void refuse(Shared c, HttpResponse response) {
  c->keeps = false;
  send(c, std::move(response));
}

/// Whether the other side sent what is no request, rather than nothing more.
bool is_malformed(Code code) {
  return code.category() == message::make_error_code(message::error::bad_version).category() &&
         code != message::error::end_of_stream && code != message::error::partial_message;
}

/// False: the body does not fit, or cannot be written.
bool take_piece(Connection& c, std::size_t count) {
  c.request.body_bytes += count;
  if (c.request.body_bytes > c.plan.limit) return false;
  if (c.request.file) return c.request.file->write(c.piece.data(), count);
  c.request.body.append(c.piece.data(), count);
  return true;
}

void read_body(Shared c) {
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

/// One thing said twice, or a coding of the body that is not taken off: who looks at the one may mean the other.
bool is_ambiguous(const message::request<message::buffer_body>& head) {
  using message::field;
  for (const auto name : {field::authorization, field::origin, field::content_type, field::transfer_encoding})
    if (head.count(name) > 1) return true;
  for (const char* name : {"sec-fetch-site", "sec-fetch-mode"})
    if (head.count(name) > 1) return true;
  return head.count(field::transfer_encoding) > 0 && !beast::iequals(head[field::transfer_encoding], "chunked");
}

void take_head(Shared c) {
  const auto& head = c->parser->get();
  c->request = {};
  c->request.method = std::string(head.method_string());
  for (const auto& field : head) {
    std::string name(field.name_string());
    std::ranges::transform(name, name.begin(), [](unsigned char letter) { return std::tolower(letter); });
    c->request.headers[name] = std::string(field.value());
  }
  c->chunked = head.version() == 11;
  c->keeps = head.keep_alive() && c->chunked;
  const std::string_view target{head.target().data(), head.target().size()};
  if (head.count(message::field::host) != 1 || is_ambiguous(head) || !take_target(target, c->request))
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

void read_head(Shared c) {
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
bool make_room(Server& server) {
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

}  // namespace

void serve_connection(Server& server, Tcp::socket socket) {
  Code ignored;
  socket.set_option(Tcp::no_delay(true), ignored);
  if (!make_room(server)) return;
  const auto number = server.next++;
  const auto c = std::make_shared<Connection>(server, number, std::move(socket));
  server.known[number].close = [weak = std::weak_ptr(c)] {
    if (const auto strong = weak.lock()) strong->stream.lowest().close();
  };
  if (!c->stream.is_secure()) return read_head(c);
  c->patience(server.options.patience);
  c->stream.handshake([c](Code code) {
    if (!code) read_head(c);
  });
}

}  // namespace tumble::http
