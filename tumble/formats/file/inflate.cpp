#include "tumble/formats/file/inflate.hpp"

#include <zlib.h>

#include <algorithm>
#include <new>

#include "tumble/units/error.hpp"

namespace tumble::file {

struct Inflater::State {
  z_stream stream{};
};

Inflater::Inflater(Wrapping wrapping, std::string from)
    : state_(new State), wrapping_(wrapping), from_(std::move(from)) {
  const int windows = wrapping == Wrapping::gzip ? 16 + MAX_WBITS : -MAX_WBITS;
  if (inflateInit2(&state_->stream, windows) != Z_OK) {
    delete state_;
    throw std::bad_alloc();
  }
}

Inflater::~Inflater() {
  inflateEnd(&state_->stream);
  delete state_;
}

void Inflater::add(std::string_view packed, const ByteSink& sink) {
  z_stream& stream = state_->stream;
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));  // NOLINT: zlib's type, it only reads
  stream.avail_in = static_cast<uInt>(packed.size());
  char buffer[65536];
  while (stream.avail_in > 0 && !padding_) {
    if (ended_) {  // a further member, or what pads the file
      if (wrapping_ == Wrapping::raw || *stream.next_in != 0x1f) {
        padding_ = true;
        break;
      }
      inflateReset(&stream);
      ended_ = false;
    }
    started_ = true;
    int result = Z_OK;
    do {
      stream.next_out = reinterpret_cast<Bytef*>(buffer);  // NOLINT: zlib's type
      stream.avail_out = sizeof buffer;
      result = inflate(&stream, Z_NO_FLUSH);
      if (result != Z_OK && result != Z_STREAM_END && result != Z_BUF_ERROR)
        throw Error{Error::Kind::bad_file, say("'{}': its packed bytes are damaged", from_)};
      if (const std::size_t count = sizeof buffer - stream.avail_out; count > 0) sink({buffer, count});
    } while (result == Z_OK && (stream.avail_in > 0 || stream.avail_out == 0));
    ended_ = result == Z_STREAM_END;
    if (result == Z_BUF_ERROR) break;
  }
}

void Inflater::finish() const {
  if (!started_ || !ended_)
    throw Error{Error::Kind::bad_file, say("'{}': its packed bytes end too early; the file was cut off", from_)};
}

}  // namespace tumble::file
