#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/asio/post.hpp>
#include <boost/beast/http.hpp>
#include <cctype>
#include <chrono>
#include <limits>
#include <map>
#include <new>
#include <thread>
#include <utility>

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
  std::string address, party;
  Lane lane = Lane::usual;
  bool keeps = false, chunked = true, writing = false, ended = false;
  std::size_t drained = 0, charged = 0, ticks = 0;

  Connection(Server& of, std::uint64_t id, Tcp::socket socket, std::string from)
      : server(of),
        number(id),
        stream(std::move(socket), of.tls ? &*of.tls : nullptr),
        heartbeat(of.context),
        address(std::move(from)) {}
  ~Connection() {
    server.known.erase(number);
    release_body();
  }
  void patience(double seconds) { stream.lowest().expires_after(milliseconds(seconds)); }

  /// Whether the body may take so many bytes of memory more.
  bool charge_body(std::size_t count) {
    if (request.body.size() + count <= free_body_bytes) return true;
    auto& bytes = server.body_bytes[party];
    if (bytes + count > most_bytes_of_party || server.all_body_bytes + count > most_body_bytes) return false;
    bytes += count, charged += count, server.all_body_bytes += count;
    return true;
  }
  void release_body() {
    request.body = {};
    const auto share = server.body_bytes.find(party);
    if (charged == 0 || share == server.body_bytes.end()) return;
    server.all_body_bytes -= charged;
    if ((share->second -= charged) == 0) server.body_bytes.erase(share);
    charged = 0;
  }
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
  c->release_body();
  if (const auto known = c->server.known.find(c->number); known != c->server.known.end()) known->second.urgent = false;
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

/// What a thread of a lane makes for the network thread. It is made here, so that no other memory is needed there.
struct Handed {
  Shared c;
  HttpResponse response;
  More more = More::failed;
};

/// Lets the network thread go on, and takes its connection from what is handed: it ends there.
template <class Next>
void hand_back(Server& server, const std::shared_ptr<Handed>& handed, Next next) {
  for (;;) try {
      asio::post(server.context, [handed, next] { next(std::exchange(handed->c, nullptr), *handed); });
      return;
    } catch (const std::bad_alloc&) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
}

/// Piece after piece, until there is no more.
void send_more(Shared c) {
  Server& server = c->server;
  auto& pool = server.lanes.at(c->lane);
  const std::string party = c->party;
  const auto handed = std::make_shared<Handed>(Handed{std::move(c), {}});
  pool.post(party, [handed, &server] {
    Connection& connection = *handed->c;
    connection.outgoing.clear();
    try {
      handed->more = connection.response.more(connection.outgoing) ? More::another : More::last;
    } catch (const std::exception&) {
      connection.outgoing.clear();
    }
    hand_back(server, handed, [](Shared back, Handed& what) { send_piece(std::move(back), what.more); });
  });
}

void end_events(Shared c) {
  c->ended = true;
  c->subscription.reset();
  c->heartbeat.cancel();
  c->stream.lowest().close();
}

/// Whoever signed out, was removed, or may less than before hears nothing more.
bool may_hear(const Shared& c) { return !c->response.allowed || c->response.allowed(); }

void send_events(Shared c) {
  if (c->writing || c->ended) return;
  if (!may_hear(c)) return end_events(c);
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

/// Looks whether the reader may still hear, and writes a line that says nothing now and then, so that a reader who is
/// no longer there is found.
void beat(Shared c) {
  constexpr std::size_t ticks_of_a_line = 8;
  c->heartbeat.expires_after(std::chrono::seconds(2));
  c->heartbeat.async_wait([c](Code code) {
    if (code || c->ended) return;
    if (!may_hear(c)) return end_events(c);
    if (c->writing || ++c->ticks % ticks_of_a_line != 0) return beat(c);
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

/// A quarter of the connections: of all that one party may keep open for events.
bool has_room_for_stream(const Connection& c) {
  const auto& known = c.server.known;
  const auto open = static_cast<std::size_t>(std::ranges::count_if(
      known, [&](const auto& entry) { return entry.second.streams && entry.second.party == c.party; }));
  return open < std::max<std::size_t>(c.server.options.connections / 4, 1);
}

/// A refusal that no route made, as if one had.
HttpResponse finished(const Connection& c, HttpResponse response) {
  if (c.server.handler.finish) c.server.handler.finish(c.request, response);
  return response;
}

HttpResponse too_much(const Connection& c, unsigned status, const std::string& text) {
  HttpResponse response = plain(status, text);
  response.headers.emplace_back("Retry-After", "2");
  return finished(c, std::move(response));
}

void send(Shared c, HttpResponse response) {
  if (response.events && c->request.method != "HEAD") {
    if (has_room_for_stream(*c)) {
      if (const auto known = c->server.known.find(c->number); known != c->server.known.end())
        known->second.streams = true;
    } else {
      response = too_much(*c, 429, "too many streams of events are open for this user: close some pages");
    }
  }
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

void refuse(Shared c, HttpResponse response) {
  c->keeps = false;
  send(c, std::move(response));
}

void answer(Shared c) {
  c->stream.lowest().expires_never();
  Server& server = c->server;
  c->lane = server.handler.lane ? server.handler.lane(c->request) : Lane::usual;
  const bool urgent = c->lane == Lane::orders || c->lane == Lane::stops;
  if (const auto known = server.known.find(c->number); known != server.known.end()) known->second.urgent = urgent;
  auto& pool = server.lanes.at(c->lane);
  const std::string party = c->lane == Lane::sign_in ? c->address : c->party;
  if (c->lane != Lane::stops && pool.pending(party) >= most_pending)
    return refuse(c, too_much(*c, 503, "too many requests of this user wait: try again in a moment"));
  const auto handed = std::make_shared<Handed>(Handed{std::move(c), {}});
  pool.post(party, [handed, &server] {
    try {
      handed->response = server.handler.answer(handed->c->request);
    } catch (const std::exception&) {
      handed->response.status = 503;  // not even the words of a refusal have room
    }
    hand_back(server, handed, [](Shared back, Handed& what) { send(std::move(back), std::move(what.response)); });
  });
}

/// Whether the other side sent what is no request, rather than nothing more.
bool is_malformed(Code code) {
  return code.category() == message::make_error_code(message::error::bad_version).category() &&
         code != message::error::end_of_stream && code != message::error::partial_message;
}

/// Takes what has come of a body; nothing: it has room.
std::optional<HttpResponse> take_piece(Connection& c, std::size_t count) {
  c.request.body_bytes += count;
  if (c.request.body_bytes > c.plan.limit)
    return plain(413, fmt::format("the body has more than {} bytes", c.plan.limit));
  if (c.request.file)
    return c.request.file->write(c.piece.data(), count)
               ? std::nullopt
               : std::optional(plain(507, "the disk is full, or cannot be written"));
  try {
    if (c.charge_body(count)) {
      c.request.body.append(c.piece.data(), count);
      return std::nullopt;
    }
  } catch (const std::bad_alloc&) {
  }
  c.release_body();
  return too_much(c, 503, "there is no memory for this body: too much is being sent at once");
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
    if (auto refusal = take_piece(*c, count)) return refuse(c, std::move(*refusal));
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
  c->request.address = c->address;
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
  c->party = c->plan.party.empty() ? c->address : c->plan.party;
  if (const auto known = c->server.known.find(c->number); known != c->server.known.end())
    known->second.party = c->party;
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

/// Room for one more: where there are too many connections, one of the party that has most is closed, a stream of
/// events before others, the oldest first. Who has not asked yet counts by address. So there is room for everybody
/// else, and for each order to a run.
void make_room(Server& server) {
  if (server.known.size() < server.options.connections) return;
  std::map<std::string_view, std::size_t> numbers;
  for (const auto& [number, known] : server.known)
    if (!known.urgent) ++numbers[known.party];
  const auto most = std::ranges::max_element(numbers, {}, [](const auto& entry) { return entry.second; });
  if (most == numbers.end()) return;
  auto chosen = server.known.end();
  for (auto one = server.known.begin(); one != server.known.end(); ++one) {
    if (one->second.urgent || one->second.party != most->first) continue;
    if (chosen == server.known.end() || (one->second.streams && !chosen->second.streams)) chosen = one;
  }
  const auto close = chosen->second.close;
  server.known.erase(chosen);
  close();
}

}  // namespace

void serve_connection(Server& server, Tcp::socket socket) {
  Code ignored;
  socket.set_option(Tcp::no_delay(true), ignored);
  const auto from = socket.remote_endpoint(ignored).address().to_string();
  make_room(server);
  const auto number = server.next++;
  const auto c = std::make_shared<Connection>(server, number, std::move(socket), "from " + from);
  c->party = c->address;
  auto& known = server.known[number];
  known.party = c->party;
  known.close = [weak = std::weak_ptr(c)] {
    if (const auto strong = weak.lock()) strong->stream.lowest().close();
  };
  if (!c->stream.is_secure()) return read_head(c);
  c->patience(server.options.patience);
  c->stream.handshake([c](Code code) {
    if (!code) read_head(c);
  });
}

}  // namespace tumble::http
