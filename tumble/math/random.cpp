// Elementary functions are written out here because the loops must vectorise and because the C library's last bits
// differ between versions: the same seed gives the same bytes on every machine with IEEE 754 arithmetic. CMakeLists.txt
// gives this file the compiler options for that: no contraction to fused operations, no errno from sqrt.
#include "tumble/math/random.hpp"

#include <Random123/philox.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "tumble/math/circle.hpp"

namespace tumble {

namespace {

using Philox = r123::Philox4x32;  // ten rounds

/// The fourth word of the counter keeps the uses of one key apart.
enum class Use : std::uint32_t { normal, uniform, split_by_name, split_by_number };

struct Bits {
  std::uint64_t first, second;
};

inline Bits bits_at(std::uint64_t key, Use use, std::uint64_t block, std::uint32_t extra = 0) {
  const Philox::ctr_type counter{{static_cast<std::uint32_t>(block), static_cast<std::uint32_t>(block >> 32), extra,
                                  static_cast<std::uint32_t>(use)}};
  const Philox::key_type words{{static_cast<std::uint32_t>(key), static_cast<std::uint32_t>(key >> 32)}};
  const Philox::ctr_type out = Philox{}(counter, words);
  return {out[0] | static_cast<std::uint64_t>(out[1]) << 32, out[2] | static_cast<std::uint64_t>(out[3]) << 32};
}

/// The 52 upper bits as (n + 1/2) / 2^52, exactly: in (0, 1).
inline double open_uniform(std::uint64_t bits) {
  return std::bit_cast<double>(bits >> 12 | 0x3FF0'0000'0000'0000u) - 1.0 + 0x1p-53;
}

/// -2 ln(u) for u in (0, 1): u = m 2^e with m near 1, ln(m) = 2 artanh((m - 1)/(m + 1)) as its series, relative error
/// below 1e-15.
inline double minus_two_log(double u) {
  constexpr std::uint64_t root_half = 0x3FE6'A09E'667F'3BCDu, mantissa = 0x000F'FFFF'FFFF'FFFFu;
  const std::uint64_t scaled = std::bit_cast<std::uint64_t>(u) - root_half;  // the upper bits count powers of two
  const double m = std::bit_cast<double>((scaled & mantissa) + root_half);   // in [sqrt(1/2), sqrt(2))
  const std::uint64_t steps = (scaled + 0x4000'0000'0000'0000u) >> 52;       // e + 1024, made a double by 2^52
  const double e = std::bit_cast<double>(steps | 0x4330'0000'0000'0000u) - (0x1p52 + 1024.0);
  const double s = (m - 1.0) / (m + 1.0), q = s * s;  // q < 0.0295
  const double series = polynomial(q, 1.0 / 21, 1.0 / 19, 1.0 / 17, 1.0 / 15, 1.0 / 13, 1.0 / 11, 1.0 / 9, 1.0 / 7,
                                   1.0 / 5, 1.0 / 3, 1.0);
  return -2.0 * (e * std::numbers::ln2 + 2.0 * s * series);
}

constexpr std::size_t batch = 128;

/// The normal numbers of `count` blocks, two a block (Box and Muller 1958): 2 block is the cosine, 2 block + 1 the
/// sine. Compiled for wider vectors as well, chosen when the program starts: the operations and so the bytes are the
/// same.
#if defined(__x86_64__) && defined(__ELF__) && !defined(__SANITIZE_THREAD__)  // it has to start first
[[gnu::target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")]]
#endif
void normal_blocks(std::uint64_t key, std::uint64_t block, std::size_t count, double* __restrict out) {
  std::uint64_t radius[batch], turn[batch];
  for (std::size_t i = 0; i < count; ++i) {
    const Bits bits = bits_at(key, Use::normal, block + i);
    radius[i] = bits.first;
    turn[i] = bits.second;
  }
  for (std::size_t i = 0; i < count; ++i) {
    const double r = std::sqrt(minus_two_log(open_uniform(radius[i])));
    const CirclePoint point = on_circle(open_uniform(turn[i]));
    out[2 * i] = r * point.cosine;
    out[2 * i + 1] = r * point.sine;
  }
}

}  // namespace

void RandomStream::normal(std::uint64_t first, std::span<double> out) const {
  if (!out.empty() && first % 2 == 1) {
    out[0] = normal(first);
    out = out.subspan(1);
    ++first;
  }
  for (; out.size() >= 2;) {
    const std::size_t count = std::min(batch, out.size() / 2);
    normal_blocks(key_, first / 2, count, out.data());
    out = out.subspan(2 * count);
    first += 2 * count;
  }
  if (!out.empty()) out[0] = normal(first);
}

double RandomStream::normal(std::uint64_t index) const {
  double pair[2];
  normal_blocks(key_, index / 2, 1, pair);
  return pair[index % 2];
}

double RandomStream::uniform(std::uint64_t index) const {
  const Bits bits = bits_at(key_, Use::uniform, index / 2);
  return open_uniform(index % 2 == 0 ? bits.first : bits.second);
}

RandomStream RandomStream::split(std::string_view name) const {
  std::uint64_t hash = 0xCBF2'9CE4'8422'2325u;  // FNV-1a; Philox does the mixing
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x0000'0100'0000'01B3u;
  return RandomStream(bits_at(key_, Use::split_by_name, hash, static_cast<std::uint32_t>(name.size())).first);
}

RandomStream RandomStream::split(std::uint64_t number) const {
  return RandomStream(bits_at(key_, Use::split_by_number, number).first);
}

}  // namespace tumble
