#include "tumble/archive/storage/packing.hpp"

#include <fmt/format.h>
#include <zstd.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/formats/sha256.hpp"
#include "tumble/units/error.hpp"

namespace tumble::storage {

namespace fs = std::filesystem;

namespace {

constexpr int level = 3;
constexpr std::size_t block = 1 << 18, hex_digits = 64;
/// A skippable frame of 64 bytes (RFC 8878, 3.1.2).
constexpr std::string_view trailer_head("\x50\x2A\x4D\x18\x40\x00\x00\x00", 8);

[[noreturn]] void damaged(const std::string& what) {
  throw Error(Error::Kind::bad_file, what + ": its bytes have changed since it was archived");
}

struct Unpacker {
  struct Free {
    void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
  };
  std::unique_ptr<ZSTD_DCtx, Free> context{ZSTD_createDCtx()};
  std::string what;
  std::string room = std::string(block, '\0');
  std::size_t open = 0;  ///< not 0: within a frame

  void add(std::string_view bytes, const std::function<void(std::string_view)>& sink) {
    ZSTD_inBuffer in{bytes.data(), bytes.size(), 0};
    bool full = false;
    while (in.pos < in.size || full) {
      ZSTD_outBuffer out{room.data(), room.size(), 0};
      open = ZSTD_decompressStream(context.get(), &out, &in);
      if (ZSTD_isError(open)) damaged(what);
      if (out.pos > 0) sink({room.data(), out.pos});
      full = out.pos == out.size;
    }
  }
};

struct Packer {
  struct Free {
    void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
  };
  std::unique_ptr<ZSTD_CCtx, Free> context{ZSTD_createCCtx()};
  std::string room = std::string(ZSTD_CStreamOutSize(), '\0');

  Packer() { ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, level); }
  void add(std::string_view bytes, bool last, const std::function<void(std::string_view)>& sink) {
    ZSTD_inBuffer in{bytes.data(), bytes.size(), 0};
    for (std::size_t rest = 1; rest != 0;) {
      ZSTD_outBuffer out{room.data(), room.size(), 0};
      rest = ZSTD_compressStream2(context.get(), &out, &in, last ? ZSTD_e_end : ZSTD_e_continue);
      if (ZSTD_isError(rest)) throw Error(Error::Kind::internal, "Zstandard cannot compress");
      sink({room.data(), out.pos});
      if (!last && in.pos == in.size) break;
    }
  }
};

/// The pieces of a file, the last one marked.
void pieces_of(std::istream& stream, const std::string& path,
               const std::function<void(std::string_view, bool last)>& sink) {
  std::string bytes(block, '\0');
  while (stream.good()) {
    stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    sink({bytes.data(), static_cast<std::size_t>(stream.gcount())}, stream.eof());
  }
  if (!stream.eof()) throw Error(Error::Kind::bad_file, "cannot read '" + path + "' to its end");
}

void write_packed(const std::string& place, std::istream& stream, const std::string& path, const std::string& sha256) {
  fs::create_directories(fs::path(place).parent_path());
  AtomicFile file(place);
  Packer packer;
  Sha256 content, stored;
  const auto write = [&](std::string_view bytes) {
    stored.add(bytes);
    file.write(bytes);
  };
  pieces_of(stream, path, [&](std::string_view bytes, bool last) {
    content.add(bytes);
    packer.add(bytes, last, write);
  });
  if (content.hex() != sha256) throw Error(Error::Kind::bad_file, "'" + path + "' has changed while it was archived");
  file.write(std::string(trailer_head) + stored.hex());
  file.commit();
}

}  // namespace

std::string packed(std::string_view text) {
  std::string bytes(ZSTD_compressBound(text.size()), '\0');
  const std::size_t size = ZSTD_compress(bytes.data(), bytes.size(), text.data(), text.size(), level);
  if (ZSTD_isError(size)) throw Error(Error::Kind::internal, "Zstandard cannot compress");
  bytes.resize(size);
  return bytes;
}

std::string unpacked(std::string_view bytes, const std::string& what) {
  std::string text;
  Unpacker unpacker{.what = what};
  unpacker.add(bytes, [&](std::string_view piece) { text += piece; });
  if (unpacker.open != 0) damaged(what);
  return text;
}

std::string place_of(const std::string& folder, const std::string& sha256) {
  return (fs::path(folder) / sha256.substr(0, 2) / (sha256 + ".zst")).string();
}

std::string keep(const std::string& folder, const std::string& path) {
  const std::string sha256 = sha256_of_file(path);
  const std::string place = place_of(folder, sha256);
  if (fs::exists(place)) return sha256;
  std::ifstream stream(path, std::ios::binary);
  write_packed(place, stream, path, sha256);
  return sha256;
}

std::string keep_bytes(const std::string& folder, std::string_view bytes) {
  const std::string sha256 = sha256_of(bytes);
  const std::string place = place_of(folder, sha256);
  if (fs::exists(place)) return sha256;
  std::istringstream stream{std::string(bytes)};
  write_packed(place, stream, sha256, sha256);
  return sha256;
}

void unpack(const std::string& folder, const std::string& sha256, const std::function<void(std::string_view)>& sink) {
  const std::string place = place_of(folder, sha256);
  std::ifstream stream(place, std::ios::binary);
  if (!stream) throw Error(Error::Kind::bad_file, "'" + place + "' is missing: it holds the file of SHA-256 " + sha256);
  const auto size = fs::file_size(place);
  const std::size_t tail = trailer_head.size() + hex_digits;
  if (size < tail) damaged("'" + place + "'");
  Unpacker unpacker{.what = "'" + place + "'"};
  Sha256 content, stored;
  std::string bytes(block, '\0');
  for (auto left = size - tail; left > 0;) {
    stream.read(bytes.data(), static_cast<std::streamsize>(std::min<std::uintmax_t>(left, bytes.size())));
    const std::string_view piece(bytes.data(), static_cast<std::size_t>(stream.gcount()));
    if (piece.empty()) damaged(unpacker.what);
    left -= piece.size();
    stored.add(piece);
    unpacker.add(piece, [&](std::string_view text) {
      content.add(text);
      sink(text);
    });
  }
  std::string trailer(tail, '\0');
  stream.read(trailer.data(), static_cast<std::streamsize>(tail));
  if (unpacker.open != 0 || trailer != std::string(trailer_head) + stored.hex() || content.hex() != sha256)
    damaged(unpacker.what);
}

void unpack_to(const std::string& folder, const std::string& sha256, const std::string& path) {
  AtomicFile file(path);
  unpack(folder, sha256, [&](std::string_view bytes) { file.write(bytes); });
  file.commit();
}

}  // namespace tumble::storage
