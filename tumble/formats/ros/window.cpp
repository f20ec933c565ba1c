#include "tumble/formats/ros/window.hpp"

#include <bzlib.h>
#include <fmt/format.h>
#include <libdeflate.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "tumble/units/error.hpp"

namespace tumble::ros {
namespace {

constexpr std::size_t smallest_window = 262144, largest_window = std::size_t{8} << 20;

[[noreturn]] void damaged(const Sentence& reason) { throw Error{Error::Kind::bad_file, reason}; }

}  // namespace

namespace unpack {

struct Bytes {
  const char* data;
  std::size_t size;
};
struct Space {
  char* data;
  std::size_t size;
};

/// What one step has used of the packed bytes and made of them.
struct Step {
  std::size_t used = 0, made = 0;
  bool finished = false;  ///< a frame ends here
};

struct Bzip2 {
  bz_stream stream{};
  bool open = false;
  ~Bzip2() { close(); }
  void close() {
    if (open) BZ2_bzDecompressEnd(&stream);
    open = false;
  }
  void reset() {
    close();
    stream = {};
    if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) damaged("bzip2 has no memory");
    open = true;
  }
  Step step(Bytes in, Space out) {
    if (!open) reset();
    stream.next_in = const_cast<char*>(in.data);
    stream.avail_in = static_cast<unsigned>(in.size);
    stream.next_out = out.data;
    stream.avail_out = static_cast<unsigned>(out.size);
    const int code = BZ2_bzDecompress(&stream);
    if (code != BZ_OK && code != BZ_STREAM_END) damaged(say("its bzip2 data are damaged (code {})", code));
    const Step done{in.size - stream.avail_in, out.size - stream.avail_out, code == BZ_STREAM_END};
    if (done.finished) close();
    return done;
  }
};

struct Lz4 {
  LZ4F_dctx* context = nullptr;
  ~Lz4() { LZ4F_freeDecompressionContext(context); }
  void reset() {
    if (context)
      LZ4F_resetDecompressionContext(context);
    else if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION)))
      damaged("LZ4 has no memory");
  }
  Step step(Bytes in, Space out) {
    Step done{in.size, out.size};
    const std::size_t code = LZ4F_decompress(context, out.data, &done.made, in.data, &done.used, nullptr);
    if (LZ4F_isError(code)) damaged(say("its LZ4 data are damaged ({})", LZ4F_getErrorName(code)));
    done.finished = code == 0;
    return done;
  }
};

struct Zstandard {
  ZSTD_DCtx* context = nullptr;
  ~Zstandard() { ZSTD_freeDCtx(context); }
  void reset() {
    if (!context) context = ZSTD_createDCtx();
    if (!context) damaged("Zstandard has no memory");
    ZSTD_DCtx_reset(context, ZSTD_reset_session_only);
  }
  Step step(Bytes in, Space out) {
    ZSTD_inBuffer from{in.data, in.size, 0};
    ZSTD_outBuffer to{out.data, out.size, 0};
    const std::size_t code = ZSTD_decompressStream(context, &to, &from);
    if (ZSTD_isError(code)) damaged(say("its Zstandard data are damaged ({})", ZSTD_getErrorName(code)));
    return {from.pos, to.pos, code == 0};
  }
};

}  // namespace unpack

using unpack::Step;

struct Window::State {
  const file::InputFile* file = nullptr;
  Piece piece;
  std::size_t ahead = 0;
  std::uint64_t offset = 0;  ///< [bytes] of the piece that were read from the file
  std::uint64_t made = 0;    ///< [bytes] that stand before end_ or were skipped in the file
  bool finished = true;      ///< no frame is open
  bool complete = true;      ///< no byte was skipped in the file
  std::uint32_t crc = 0;
  std::vector<char> window, packed;
  std::size_t packed_next = 0, packed_end = 0;
  unpack::Bzip2 bzip2;
  unpack::Lz4 lz4;
  unpack::Zstandard zstandard;

  void reset_unpacker() {
    packed_next = packed_end = 0;
    if (piece.packing == Packing::bzip2) bzip2.reset();
    if (piece.packing == Packing::lz4) lz4.reset();
    if (piece.packing == Packing::zstandard) zstandard.reset();
  }

  std::size_t read(char* to, std::size_t count) {
    count = static_cast<std::size_t>(std::min<std::uint64_t>(count, piece.size - offset));
    const std::size_t got = file->read_at(piece.begin + offset, to, count);
    offset += got;
    return got;
  }

  Step unpack_step(unpack::Space to) {
    const unpack::Bytes from{packed.data() + packed_next, packed_end - packed_next};
    switch (piece.packing) {
      case Packing::bzip2:
        return bzip2.step(from, to);
      case Packing::lz4:
        return lz4.step(from, to);
      default:
        return zstandard.step(from, to);
    }
  }

  /// Bytes put there; 0 at the end.
  std::size_t produce(char* to, std::size_t count) {
    if (piece.packing == Packing::none) return read(to, count);
    for (;;) {
      if (packed_next == packed_end) {
        packed_next = 0;
        packed_end = read(packed.data(), packed.size());
        if (packed_end == 0 && finished) return 0;
      }
      const bool at_end = packed_end == 0;
      const Step step = unpack_step({to, count});
      packed_next += step.used;
      finished = step.finished || (finished && step.used == 0 && step.made == 0);
      if (made + step.made > piece.unpacked)
        damaged(say("it unpacks to more than the {} bytes that the file states", piece.unpacked));
      if (step.made > 0) return step.made;
      if (at_end) damaged("its packed data end too early");
      if (step.used == 0 && packed_next < packed_end) damaged("its packed data do not end where they should");
    }
  }
};

Window::Window() : state_(std::make_unique<State>()) {}
Window::~Window() = default;
Window::Window(Window&&) noexcept = default;

void Window::open(const file::InputFile& file, const Piece& piece, std::size_t ahead) {
  State& state = *state_;
  state.file = &file;
  state.piece = piece;
  state.offset = state.made = 0;
  state.finished = state.complete = true;
  state.crc = 0;
  const bool packed = piece.packing != Packing::none;
  // The whole frame in one step is unpacked without a copy between.
  const auto whole = static_cast<std::size_t>(std::min<std::uint64_t>(piece.unpacked, largest_window));
  const std::size_t size = std::max(smallest_window, packed ? whole + longest : std::size_t{0});
  if (state.window.size() < size) state.window.resize(size);
  state.ahead = packed ? state.window.size() : std::min(ahead, state.window.size());
  if (packed) {
    const auto input = static_cast<std::size_t>(std::min<std::uint64_t>(piece.size, largest_window));
    if (state.packed.size() < input) state.packed.resize(std::max(smallest_window, input));
  }
  state.reset_unpacker();
  next_ = end_ = state.window.data();
}

bool Window::refill(std::size_t count) {
  State& state = *state_;
  if (count > longest) damaged(say("a part of {} bytes, where at most {} are expected", count, longest));
  char* const begin = state.window.data();
  const auto rest = static_cast<std::size_t>(end_ - next_);
  std::memmove(begin, next_, rest);
  std::size_t filled = rest;
  const std::size_t most = std::min(state.window.size(), std::max(count, state.ahead));
  while (filled < count) {
    const std::size_t got = state.produce(begin + filled, most - filled);
    if (got == 0) break;
    if (state.piece.crc != 0) state.crc = libdeflate_crc32(state.crc, begin + filled, got);
    filled += got;
    state.made += got;
  }
  next_ = begin;
  end_ = begin + filled;
  return filled >= count;
}

bool Window::skip(std::uint64_t count) {
  State& state = *state_;
  const auto here = static_cast<std::uint64_t>(end_ - next_);
  if (count <= here) {
    next_ += count;
    return true;
  }
  count -= here;
  next_ = end_;
  if (state.piece.packing == Packing::none) {
    const std::uint64_t remains = state.piece.size - state.offset;
    const std::uint64_t step = std::min(count, remains);
    state.offset += step;
    state.made += step;
    state.complete = false;
    return step == count;
  }
  while (count > 0) {
    if (!refill(1)) return false;
    const auto step = std::min<std::uint64_t>(count, static_cast<std::uint64_t>(end_ - next_));
    next_ += step;
    count -= step;
  }
  return true;
}

std::uint64_t Window::position() const { return state_->made - static_cast<std::uint64_t>(end_ - next_); }

bool Window::crc_agrees() const {
  return state_->piece.crc == 0 || !state_->complete || state_->crc == state_->piece.crc;
}

void Window::read_ahead(std::size_t bytes) { state_->ahead = std::min(bytes, state_->window.size()); }

bool is_packed(std::string_view message) { return message.starts_with("\x28\xb5\x2f\xfd"); }

std::string_view unpacked(std::string_view message, std::vector<char>& room) {
  room.resize(Window::longest);
  const std::size_t size = ZSTD_decompress(room.data(), room.size(), message.data(), message.size());
  return ZSTD_isError(size) ? std::string_view() : std::string_view(room.data(), size);
}

}  // namespace tumble::ros
