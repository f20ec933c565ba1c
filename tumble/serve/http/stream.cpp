#include "tumble/serve/http/stream.hpp"

#include <utility>

namespace tumble::http {

using Secure = beast::ssl_stream<beast::tcp_stream>;

Stream::Stream(Tcp::socket socket, asio::ssl::context* tls)
    : stream_(tls ? Either(std::in_place_type<Secure>, std::move(socket), *tls)
                  : Either(std::in_place_type<beast::tcp_stream>, std::move(socket))) {}

beast::tcp_stream& Stream::lowest() {
  return is_secure() ? beast::get_lowest_layer(std::get<Secure>(stream_)) : std::get<beast::tcp_stream>(stream_);
}

void Stream::handshake(std::function<void(Code)> done) {
  std::get<Secure>(stream_).async_handshake(asio::ssl::stream_base::server, std::move(done));
}

void Stream::shutdown(std::function<void(Code)> done) { std::get<Secure>(stream_).async_shutdown(std::move(done)); }

void Stream::read_some(asio::mutable_buffer room, Done done) {
  std::visit([&](auto& stream) { stream.async_read_some(room, std::move(done)); }, stream_);
}

void Stream::write_some(std::vector<asio::const_buffer> bytes, Done done) {
  std::visit([&](auto& stream) { stream.async_write_some(bytes, std::move(done)); }, stream_);
}

}  // namespace tumble::http
