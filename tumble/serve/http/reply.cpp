// What a connection sends: answers, pieces, events.
#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <chrono>
#include <new>
#include <thread>
#include <utility>

#include "tumble/serve/http/connection.hpp"

namespace tumble::http {

HttpResponse plain(unsigned status, const std::string& text) {
  return {status, "application/json", fmt::format(R"({{"problems":["{}"]}})", text)};
}

namespace {

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
    if (code) return end_events(c);
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
    send_events(c);  // also what could not be said while there was no memory
    if (c->writing || ++c->ticks % ticks_of_a_line != 0) return beat(c);
    c->writing = true;
    c->outgoing = ": \n\n";
    c->patience(c->server.options.patience);
    asio::async_write(c->stream, asio::buffer(c->outgoing), [c](Code failed, std::size_t) {
      c->writing = false;
      if (failed) return end_events(c);
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
    try {
      asio::post(context, [weak] {
        if (const auto strong = weak.lock()) send_events(strong);
      });
    } catch (const std::bad_alloc&) {  // beat() looks, too
    }
  });
  c->stream.lowest().expires_never();
  c->stream.async_read_some(asio::buffer(c->piece), [c](Code, std::size_t) {
    if (!c->ended) end_events(c);  // a reader says nothing more: it has left
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

}  // namespace

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
  c->request.came = std::chrono::steady_clock::now();
  const Way way = server.handler.way ? server.handler.way(c->request) : Way{};
  c->lane = way.lane;
  const bool urgent = c->lane == Lane::orders || c->lane == Lane::stops;
  if (const auto known = server.known.find(c->number); known != server.known.end()) known->second.urgent = urgent;
  auto& pool = server.lanes.at(c->lane);
  const std::string party = c->lane == Lane::sign_in ? c->address : way.line.empty() ? c->party : way.line;
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
}  // namespace tumble::http
