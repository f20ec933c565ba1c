#include "tumble/archive/storage/packing.hpp"

#include <fmt/format.h>
#include <zstd.h>

#include <filesystem>
#include <fstream>
#include <memory>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/formats/new_file.hpp"
#include "tumble/formats/sha256.hpp"
#include "tumble/units/error.hpp"

namespace tumble::storage {

namespace fs = std::filesystem;

namespace {

constexpr int level = 3;
constexpr std::size_t block = 1 << 18, hex_digits = 64, part_bytes = 1 << 20;
/// A skippable frame of 64 bytes (RFC 8878, 3.1.2).
constexpr std::string_view trailer_head("\x50\x2A\x4D\x18\x40\x00\x00\x00", 8);
constexpr std::size_t trailer_bytes = 8 + hex_digits;

[[noreturn]] void damaged(const Sentence& what) {
  throw Error(Error::Kind::bad_file, say("{}: its bytes have changed since it was archived", what));
}

struct Unpacker {
  struct Free {
    void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
  };
  std::unique_ptr<ZSTD_DCtx, Free> context{ZSTD_createDCtx()};
  Sentence what;
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
  if (!stream.eof()) throw Error(Error::Kind::bad_file, say("cannot read '{}' to its end", path));
}

/// Packs a stream, sealed at its end. Throws where its bytes have not this SHA-256.
void pack(std::istream& stream, const std::string& path, const std::string& sha256,
          const std::function<void(std::string_view)>& sink) {
  Packer packer;
  Sha256 content, stored;
  const auto write = [&](std::string_view bytes) {
    stored.add(bytes);
    sink(bytes);
  };
  pieces_of(stream, path, [&](std::string_view bytes, bool last) {
    content.add(bytes);
    packer.add(bytes, last, write);
  });
  if (content.hex() != sha256) throw Error(Error::Kind::bad_file, say("'{}' has changed while it was archived", path));
  sink(std::string(trailer_head) + stored.hex());
}

/// Unpacks what comes piece by piece, and compares it with its seal.
class SealedBytes {
 public:
  SealedBytes(Sentence what, const std::function<void(std::string_view)>& sink)
      : unpacker_{.what = std::move(what)}, sink_(sink) {}

  void add(std::string_view bytes) {
    pending_ += bytes;
    if (pending_.size() <= trailer_bytes) return;
    const std::string_view ready(pending_.data(), pending_.size() - trailer_bytes);
    stored_.add(ready);
    unpacker_.add(ready, [&](std::string_view text) {
      content_.add(text);
      sink_(text);
    });
    pending_.erase(0, ready.size());
  }
  void finish(const std::string& sha256) {
    if (unpacker_.open != 0 || pending_ != std::string(trailer_head) + stored_.hex() || content_.hex() != sha256)
      damaged(unpacker_.what);
  }
  const Sentence& what() const { return unpacker_.what; }

 private:
  Unpacker unpacker_;
  const std::function<void(std::string_view)>& sink_;
  Sha256 content_, stored_;
  std::string pending_;
};

std::ifstream opened_file(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw Error(Error::Kind::bad_file, say("cannot read '{}'", path));
  return stream;
}

/// Makes a folder so that its name survives a power cut.
void make_folder(const fs::path& folder) {
  std::error_code problem;
  if (!fs::create_directories(folder, problem) && problem)
    throw Error(Error::Kind::bad_file, say("cannot make the folder '{}': {}", folder.string(), system_reason(problem)));
  synchronise_folder(folder.parent_path().string());
}

void keep_in_folder(const std::string& place, const std::string& path, const std::string& sha256) {
  std::ifstream stream = opened_file(path);
  if (!fs::exists(fs::path(place).parent_path())) make_folder(fs::path(place).parent_path());
  AtomicFile file(place);
  pack(stream, path, sha256, [&](std::string_view bytes) { file.write(bytes); });
  file.commit();
}

/// In a transaction of its own. Another writer may keep the same file at the same time: then its parts are found the
/// second time.
void keep_in_database(const Place& place, const std::string& path, const std::string& sha256) {
  place.database->transact([&] {
    if (is_kept(place, sha256)) return;
    std::ifstream stream = opened_file(path);
    std::string part;
    std::int64_t number = 0;
    const auto flush = [&](std::size_t least) {
      for (; part.size() >= least && !part.empty(); part.erase(0, part_bytes)) {
        place.database->run("INSERT INTO contents (sha256, part, packed) VALUES (?, ?, ?)",
                            {sha256, number++, database::Bytes{part.substr(0, part_bytes)}});
        if (place.database->changed() != 1)
          throw database::Refusal{database::Refusal::Kind::failed,
                                  say("the database did not keep a part of '{}'", path)};
      }
    };
    pack(stream, path, sha256, [&](std::string_view bytes) {
      part += bytes;
      flush(part_bytes);
    });
    flush(1);
  });
}

}  // namespace

std::string packed(std::string_view text) {
  std::string bytes(ZSTD_compressBound(text.size()), '\0');
  const std::size_t size = ZSTD_compress(bytes.data(), bytes.size(), text.data(), text.size(), level);
  if (ZSTD_isError(size)) throw Error(Error::Kind::internal, "Zstandard cannot compress");
  bytes.resize(size);
  return bytes + std::string(trailer_head) + sha256_of(bytes);
}

std::string seal_of(std::string_view bytes) {
  const bool sealed =
      bytes.size() > trailer_bytes && bytes.substr(bytes.size() - trailer_bytes).starts_with(trailer_head);
  return sealed ? sha256_of(bytes) : std::string();
}

std::string unpacked(std::string_view bytes, const Sentence& what) {
  const bool sealed = !seal_of(bytes).empty();
  const std::string_view frame = sealed ? bytes.substr(0, bytes.size() - trailer_bytes) : bytes;
  if (sealed && sha256_of(frame) != bytes.substr(bytes.size() - hex_digits)) damaged(what);
  std::string text;
  Unpacker unpacker{.what = what};
  unpacker.add(frame, [&](std::string_view piece) { text += piece; });
  if (unpacker.open != 0) damaged(what);
  return text;
}

std::string place_of(const std::string& folder, const std::string& sha256) {
  return (fs::path(folder) / sha256.substr(0, 2) / (sha256 + ".zst")).string();
}

bool is_kept(const Place& place, const std::string& sha256) {
  if (!place.folder.empty()) return fs::exists(place_of(place.folder, sha256));
  return !place.database->ask("SELECT 1 FROM contents WHERE sha256 = ? AND part = 0", {sha256}).empty();
}

std::string keep(const Place& place, const std::string& path) {
  const std::string sha256 = sha256_of_file(path);
  if (is_kept(place, sha256)) return sha256;
  if (place.folder.empty())
    keep_in_database(place, path, sha256);
  else
    keep_in_folder(place_of(place.folder, sha256), path, sha256);
  return sha256;
}

void unpack(const Place& place, const std::string& sha256, const std::function<void(std::string_view)>& sink) {
  const std::string file = place.folder.empty() ? "the file " + sha256 : place_of(place.folder, sha256);
  SealedBytes sealed(say("'{}'", file), sink);
  const auto missing = [&] {
    throw Error(Error::Kind::bad_file, say("'{}' is missing: it holds the file of SHA-256 {}", file, Name{sha256}));
  };
  if (place.folder.empty()) {
    for (std::int64_t part = 0;; ++part) {
      const auto rows =
          place.database->ask("SELECT packed FROM contents WHERE sha256 = ? AND part = ?", {sha256, part});
      if (rows.empty() && part == 0) missing();
      if (rows.empty()) break;
      sealed.add(database::bytes(rows[0], 0));
    }
  } else {
    std::ifstream stream(file, std::ios::binary);
    if (!stream) missing();
    std::string bytes(block, '\0');
    while (stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size())), stream.gcount() > 0)
      sealed.add({bytes.data(), static_cast<std::size_t>(stream.gcount())});
  }
  sealed.finish(sha256);
}

void unpack_to(const Place& place, const std::string& sha256, const std::string& path) {
  AtomicFile file(path);
  unpack(place, sha256, [&](std::string_view bytes) { file.write(bytes); });
  file.commit();
}

}  // namespace tumble::storage
