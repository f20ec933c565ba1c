#include "tumble/formats/mat/packed.hpp"

#include <zlib.h>

#include <algorithm>
#include <cstring>

#include "tumble/units/error.hpp"

namespace tumble::mat {

namespace {

constexpr std::size_t best_packing = 1032;  ///< zlib packs at most 1032 to 1

[[noreturn]] void cut() { throw Error(Error::Kind::bad_file, "it is cut off: the file ends within it"); }

}  // namespace

struct Bytes::Inflater {
  z_stream stream{};
};

Bytes::Bytes(file::Window& window, std::size_t size, bool packed) : window_(window), rest_(size) {
  if (!packed) return;
  inflater_ = std::make_unique<Inflater>();
  if (inflateInit(&inflater_->stream) != Z_OK) throw Error(Error::Kind::internal, "zlib cannot be started");
}

Bytes::~Bytes() {
  if (inflater_) inflateEnd(&inflater_->stream);
}

std::size_t Bytes::most() const {
  const std::size_t in_file = std::min(rest_, window_.size() - window_.position());
  return inflater_ ? in_file * best_packing + best_packing : in_file;
}

void Bytes::read(char* to, std::size_t count) {
  position_ += count;
  if (inflater_) return unpack(to, count);
  if (count > rest_) cut();
  rest_ -= count;
  while (count > 0) {
    if (!window_.holds(1)) cut();
    const std::size_t now = std::min(count, window_.available());
    std::memcpy(to, window_.data(), now);
    window_.skip(now);
    to += now;
    count -= now;
  }
}

/// One step of zlib: fills what there is room for. False at the end of the packed bytes.
bool Bytes::step() {
  z_stream& stream = inflater_->stream;
  if (rest_ > 0) window_.holds(1);
  const std::size_t now = std::min(rest_, window_.available());
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(window_.data()));
  stream.avail_in = static_cast<uInt>(now);
  const int status = inflate(&stream, Z_NO_FLUSH);
  const std::size_t used = now - stream.avail_in;
  window_.skip(used);
  rest_ -= used;
  if (status == Z_STREAM_END) return false;
  if (status != Z_OK && status != Z_BUF_ERROR)
    throw Error(Error::Kind::bad_file,
                say("its packed bytes are damaged: {}", stream.msg ? stream.msg : "zlib gives no reason"));
  if (used == 0 && now == 0 && stream.avail_out > 0) cut();
  return true;
}

void Bytes::unpack(char* to, std::size_t count) {
  z_stream& stream = inflater_->stream;
  stream.next_out = reinterpret_cast<Bytef*>(to);
  stream.avail_out = static_cast<uInt>(count);
  while (stream.avail_out > 0)
    if (!step() && stream.avail_out > 0) cut();
}

void Bytes::finish(bool read_whole) {
  if (!inflater_) return;
  char trash[64];
  for (int more = 0; more < 16; ++more) {  // a few bytes of padding; what follows them is not of this variable
    inflater_->stream.next_out = reinterpret_cast<Bytef*>(trash);
    inflater_->stream.avail_out = sizeof trash;
    while (inflater_->stream.avail_out > 0)
      if (!step()) return;
  }
  if (read_whole) throw Error(Error::Kind::bad_file, "its packed bytes are damaged: they hold more than the variable");
}

void Bytes::skip(std::size_t count) {
  if (!inflater_) {
    position_ += count;
    if (count > rest_) cut();
    rest_ -= count;
    const std::size_t before = window_.position();
    window_.skip(count);
    if (window_.position() - before < count) cut();
    return;
  }
  char trash[16384];
  for (std::size_t now = 0; count > 0; count -= now) {
    now = std::min(count, sizeof trash);
    read(trash, now);
  }
}

}  // namespace tumble::mat
