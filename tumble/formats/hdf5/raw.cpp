#include "tumble/formats/hdf5/raw.hpp"

#include <libdeflate.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <memory>
#include <vector>

#include "tumble/math/parallel.hpp"

namespace tumble::hdf5 {
namespace {

/// A chunk in the file, and which of its samples are wanted where.
struct Piece {
  haddr_t place = 0;
  std::size_t bytes = 0;  ///< in the file
  std::size_t from = 0, count = 0;
  double* to = nullptr;
};

bool read_bytes(int descriptor, haddr_t place, void* to, std::size_t bytes) {
  auto* next = static_cast<char*>(to);
  while (bytes > 0) {
    const ssize_t got = pread(descriptor, next, bytes, static_cast<off_t>(place));
    if (got <= 0) return false;
    next += got;
    place += static_cast<haddr_t>(got);
    bytes -= static_cast<std::size_t>(got);
  }
  return true;
}

using Bytes = unsigned char __attribute__((vector_size(16)));

/// The bytes of both in turn: of their first halves, of their second ones.
void interleave(const Bytes& a, const Bytes& b, Bytes& first, Bytes& second) {
  first = __builtin_shufflevector(a, b, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
  second = __builtin_shufflevector(a, b, 8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31);
}

/// The filter "shuffle" puts the first bytes of all samples before their second ones, and so on.
void unshuffle(const char* from, std::size_t count, double* to) {
  constexpr std::size_t planes = sizeof(double), width = sizeof(Bytes);
  auto* out = reinterpret_cast<char*>(to);
  std::size_t i = 0;
  for (; i + width <= count; i += width) {
    Bytes now[planes], next[planes];
    for (std::size_t k = 0; k < planes; ++k) std::memcpy(&now[k], from + k * count + i, width);
    for (int stage = 0; stage < 3; ++stage) {
      for (std::size_t k = 0; k < planes / 2; ++k) interleave(now[k], now[k + 4], next[2 * k], next[2 * k + 1]);
      std::memcpy(now, next, sizeof now);
    }
    std::memcpy(out + i * planes, now, sizeof now);
  }
  for (; i < count; ++i)
    for (std::size_t k = 0; k < planes; ++k) out[i * planes + k] = from[k * count + i];
}

struct Release {
  void operator()(libdeflate_decompressor* one) const { libdeflate_free_decompressor(one); }
};

/// The whole chunk is unpacked, into its place where all of it is wanted.
bool unpack(const RawSamples& samples, const Piece& piece) {
  thread_local const std::unique_ptr<libdeflate_decompressor, Release> unpacker(libdeflate_alloc_decompressor());
  thread_local std::vector<char> packed;
  thread_local std::vector<double> whole, shuffled;
  const std::size_t bytes = samples.chunk * sizeof(double);
  packed.resize(std::max(packed.size(), piece.bytes));
  if (!unpacker || !read_bytes(samples.descriptor, piece.place, packed.data(), piece.bytes)) return false;
  const bool all = piece.count == samples.chunk;
  if (!all) whole.resize(samples.chunk);
  double* const unpacked = all ? piece.to : whole.data();
  if (samples.shuffled) shuffled.resize(samples.chunk);
  if (libdeflate_zlib_decompress(unpacker.get(), packed.data(), piece.bytes,
                                 samples.shuffled ? shuffled.data() : unpacked, bytes, nullptr) != LIBDEFLATE_SUCCESS)
    return false;
  if (samples.shuffled) unshuffle(reinterpret_cast<const char*>(shuffled.data()), samples.chunk, unpacked);
  if (!all) std::copy_n(unpacked + piece.from, piece.count, piece.to);
  return true;
}

/// False: a chunk is not there, was not filtered as the others, or lies outside of the file.
bool find_pieces(const RawSamples& samples, hid_t dataset, hsize_t first, hsize_t count, double* to,
                 std::vector<Piece>& pieces) {
  for (const hsize_t end = first + count; first < end;) {
    const hsize_t begin = first / samples.chunk * samples.chunk, now = std::min(begin + samples.chunk, end) - first;
    unsigned skipped = 0;
    Piece piece{HADDR_UNDEF, 0, first - begin, now, to};
    hsize_t bytes = 0;
    if (H5Dget_chunk_info_by_coord(dataset, &begin, &skipped, &piece.place, &bytes) < 0) return false;
    if (skipped != 0 || piece.place == HADDR_UNDEF || piece.place > samples.file_size ||
        bytes > samples.file_size - piece.place || (!samples.deflated && bytes != samples.chunk * sizeof(double)))
      return false;
    piece.bytes = bytes;
    pieces.push_back(piece);
    first += now;
    to += now;
  }
  return true;
}

/// Only shuffle and deflate, in this order.
bool known_filters(hid_t plist, RawSamples& samples) {
  const int filters = H5Pget_nfilters(plist);
  for (int i = 0; i < filters; ++i) {
    unsigned flags = 0;
    std::size_t none = 0;
    const H5Z_filter_t filter = H5Pget_filter2(plist, i, &flags, &none, nullptr, 0, nullptr, nullptr);
    if (samples.deflated || (filter != H5Z_FILTER_DEFLATE && (filter != H5Z_FILTER_SHUFFLE || samples.shuffled)))
      return false;
    (filter == H5Z_FILTER_DEFLATE ? samples.deflated : samples.shuffled) = true;
  }
  return filters == 0 || samples.deflated;
}

}  // namespace

std::optional<RawSamples> raw_samples(hid_t file, hid_t dataset, hid_t plist, int rank, hsize_t count,
                                      std::size_t file_size) {
  const Handle type(H5Dget_type(dataset), H5Tclose), creation(H5Fget_create_plist(file), H5Pclose),
      access(H5Fget_access_plist(file), H5Pclose);
  hsize_t user_block = 1;
  if (rank != 1 || H5Tequal(type, H5T_NATIVE_DOUBLE) <= 0 || H5Pget_userblock(creation, &user_block) < 0 ||
      user_block != 0 || H5Pget_driver(access) != H5FD_SEC2)
    return std::nullopt;
  int* descriptor = nullptr;
  if (H5Fget_vfd_handle(file, H5P_DEFAULT, reinterpret_cast<void**>(&descriptor)) < 0 || !descriptor)
    return std::nullopt;
  RawSamples samples{*descriptor, file_size, 0, count, 0, false, false};
  switch (H5Pget_layout(plist)) {
    case H5D_CONTIGUOUS:
      samples.place = H5Dget_offset(dataset);
      if (samples.place == HADDR_UNDEF || samples.place > file_size ||
          count > (file_size - samples.place) / sizeof(double))
        return std::nullopt;
      return samples;
    case H5D_CHUNKED:
      if (H5Pget_chunk(plist, 1, &samples.chunk) == 1 && known_filters(plist, samples)) return samples;
      return std::nullopt;
    default:
      return std::nullopt;
  }
}

bool read_raw(const RawSamples& samples, hid_t dataset, hsize_t first, hsize_t count, double* to) {
  if (samples.chunk == 0)
    return read_bytes(samples.descriptor, samples.place + first * sizeof(double), to, count * sizeof(double));
  std::vector<Piece> pieces;
  if (!find_pieces(samples, dataset, first, count, to, pieces)) return false;
  std::atomic<bool> good = true;
  const auto read = [&](std::size_t i) {
    const Piece& piece = pieces[i];
    if (!(samples.deflated ? unpack(samples, piece)
                           : read_bytes(samples.descriptor, piece.place + piece.from * sizeof(double), piece.to,
                                        piece.count * sizeof(double))))
      good = false;
  };
  if (samples.deflated && pieces.size() > 1)
    parallel_for(pieces.size(), read);
  else
    for (std::size_t i = 0; i < pieces.size(); ++i) read(i);
  return good;
}

}  // namespace tumble::hdf5
