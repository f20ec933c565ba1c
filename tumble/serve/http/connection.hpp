#pragma once

#include <array>
#include <boost/asio/post.hpp>
#include <boost/beast/http.hpp>
#include <chrono>
#include <new>
#include <optional>
#include <thread>
#include <utility>

#include "tumble/serve/http/server.hpp"

namespace tumble::http {

namespace message = boost::beast::http;

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
  /// Sets the time [s] after which the operation under way must have ended.
  void patience(double seconds) {
    stream.lowest().expires_after(std::chrono::milliseconds(static_cast<long>(seconds * 1e3)));
  }

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

/// Lets the network thread go on with what a thread of a lane has made; its connection ends there.
template <class Handed, class Next>
void hand_back(Server& server, const std::shared_ptr<Handed>& handed, Next next) {
  for (;;) try {
      asio::post(server.context, [handed, next] { next(std::exchange(handed->c, nullptr), *handed); });
      return;
    } catch (const std::bad_alloc&) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
}

/// Opens the file that takes the body of a request, and goes on; or refuses.
void open_body_file(Shared c, void (*next)(Shared));

/// Writes so many bytes of the piece into it, and goes on; or refuses.
void write_body_file(Shared c, std::size_t count, void (*next)(Shared));

/// The next request of a connection.
void read_head(Shared c);

/// The answer to what was asked.
void send(Shared c, HttpResponse response);

/// An answer after which the connection ends: what else the other side sends is not read.
void refuse(Shared c, HttpResponse response);

/// Has the request answered by a thread of its lane.
void answer(Shared c);

/// Refusal before any route gets the request, in the form of all refusals. The text has no quotes.
HttpResponse plain(unsigned status, const std::string& text);

/// A refusal of somebody who takes too much, in the language of the page.
HttpResponse too_much(const Connection& c, unsigned status, const std::string& text);

}  // namespace tumble::http
