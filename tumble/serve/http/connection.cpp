// What a connection reads: heads and bodies.
#include "tumble/serve/http/connection.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <limits>
#include <map>
#include <new>

#include "tumble/serve/http/target.hpp"

namespace tumble::http {
namespace {

/// Whether the other side sent what is no request, rather than nothing more.
bool is_malformed(Code code) {
  return code.category() == message::make_error_code(message::error::bad_version).category() &&
         code != message::error::end_of_stream && code != message::error::partial_message;
}

/// Takes what has come of a body, and is not for a file; nothing: it has room.
std::optional<HttpResponse> take_piece(Connection& c, std::size_t count) {
  c.request.body_bytes += count;
  if (c.request.body_bytes > c.plan.limit)
    return plain(413, fmt::format("the body has more than {} bytes", c.plan.limit));
  if (c.request.file) return std::nullopt;
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
    c->request.file ? write_body_file(c, count, read_body) : read_body(c);
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

void expect_body(Shared c) {
  if (!beast::iequals(c->parser->get()[message::field::expect], "100-continue")) return read_body(c);
  c->outgoing = "HTTP/1.1 100 Continue\r\n\r\n";
  asio::async_write(c->stream, asio::buffer(c->outgoing), [c](Code code, std::size_t) {
    if (!code) read_body(c);
  });
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
  c->party = c->plan.party.empty() ? c->address : c->plan.party;
  if (const auto known = c->server.known.find(c->number); known != c->server.known.end())
    known->second.party = c->party;
  if (c->plan.refusal) return refuse(c, std::move(*c->plan.refusal));
  if (const auto length = c->parser->content_length(); length && *length > c->plan.limit)
    return refuse(c, plain(413, fmt::format("the body has more than {} bytes", c->plan.limit)));
  c->plan.open ? open_body_file(c, expect_body) : expect_body(c);
}

}  // namespace

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

namespace {

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
