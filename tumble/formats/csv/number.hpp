#pragma once

#include <fast_float/fast_float.h>
#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>

namespace tumble::csv {

/// Bytes that must be readable before and behind the text of a number.
constexpr std::size_t number_padding = 33;

namespace detail {

constexpr double exact_powers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                   1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
constexpr std::uint64_t integer_powers[] = {1, 10, 100, 1000, 10000, 100000, 1000000, 10000000, 100000000};

/// Eight decimal digits, one a byte and the first in the lowest, as a number: pairs, then fours, then all eight.
inline std::uint64_t eight_digits(std::uint64_t bytes) {
  bytes = bytes * 10 + (bytes >> 8);
  return (((bytes & 0x000000FF000000FFu) * 0x000F424000000064u) +
          (((bytes >> 16) & 0x000000FF000000FFu) * 0x0000271000000001u)) >>
         32;
}

/// Appends the digits at `p` to `mantissa` (modulo 2^64), eight bytes a step; returns where they end.
inline const char* take_digits(const char* p, std::uint64_t& mantissa) {
  static_assert(std::endian::native == std::endian::little);
  for (;;) {
    std::uint64_t bytes = 0;
    std::memcpy(&bytes, p, sizeof bytes);
    bytes ^= 0x3030303030303030u;
    const std::uint64_t others = (bytes | (bytes + 0x7676767676767676u)) & 0x8080808080808080u;
    if (others == 0) {
      mantissa = mantissa * integer_powers[8] + eight_digits(bytes);
      p += 8;
      continue;
    }
    const int bits = std::countr_zero(others) & ~7;  // eight for each digit
    if (bits == 0) return p;
    mantissa = mantissa * integer_powers[bits / 8] + eight_digits(bytes << (64 - bits));
    return p + bits / 8;
  }
}

/// 10^exponent * mantissa to the nearest double; false where these few steps do not determine it.
inline bool scaled(std::uint64_t mantissa, int exponent, double& value) {
  // Both exact, hence one rounding. The bound could be 2^53; but full doubles are written with 16 or 17 digits at
  // random, and a branch between those would be mispredicted.
  if (mantissa < 1000000000000000u && exponent >= -22 && exponent <= 22) {
    value = static_cast<double>(mantissa);
    value = exponent < 0 ? value / exact_powers[-exponent] : value * exact_powers[exponent];
    return true;
  }
  const auto rounded = fast_float::compute_float<fast_float::binary_format<double>>(exponent, mantissa);
  if (rounded.power2 < 0 || rounded.power2 == fast_float::binary_format<double>::infinite_power()) return false;
  value = std::bit_cast<double>(rounded.mantissa | static_cast<std::uint64_t>(rounded.power2) << 52);
  return true;
}

/// The exponent behind an e; null when there is no number.
inline const char* take_exponent(const char* p, int& exponent) {
  const bool negative = *p == '-';
  if (*p == '-' || *p == '+') ++p;
  const char* const first = p;
  int written = 0;
  for (; *p >= '0' && *p <= '9'; ++p) written = std::min(written * 10 + (*p - '0'), 100000);
  if (p == first) return nullptr;
  exponent += negative ? -written : written;
  return p;
}

/// The digits at `p`, with at most one mark among them.
struct Decimal {
  std::uint64_t mantissa = 0;
  int fraction = 0;           ///< digits behind the mark
  const char* end = nullptr;  ///< null: not taken
};

/// For any processor, and any length of the text.
inline Decimal take_decimal_portably(const char* p, char mark) {
  Decimal decimal;
  const char* const first = p;
  p = take_digits(p, decimal.mantissa);
  auto digits = p - first;
  if (*p == mark) {
    const char* const fraction = ++p;
    p = take_digits(p, decimal.mantissa);
    digits += p - fraction;
    decimal.fraction = static_cast<int>(p - fraction);
  }
  if (digits > 19)  // leading zeros do not count
    for (const char* zero = first; *zero == '0' || *zero == mark; ++zero) digits -= *zero == '0';
  if (digits > 0 && digits <= 19) decimal.end = p;
  return decimal;
}

#ifdef __SSE2__
inline __m128i load(const void* p) { return _mm_loadu_si128(static_cast<const __m128i*>(p)); }

/// Bit i is set where p[i] is not a digit, for 32 characters.
inline std::uint32_t other_than_digits(const char* p) {
  const auto digits = [p](int offset) {
    const __m128i value = _mm_sub_epi8(load(p + offset), _mm_set1_epi8('0'));
    return static_cast<std::uint32_t>(_mm_movemask_epi8(_mm_cmpeq_epi8(_mm_min_epu8(value, _mm_set1_epi8(9)), value)));
  };
  return ~(digits(0) | digits(16) << 16);
}

alignas(64) constexpr unsigned char last_bytes[64] = {
    0,    0,    0,    0,    0,    0,    0,    0,    0,    0,    0,    0,    0,    0,    0,    0,
    0,    0,    0,    0,    0,    0,    0,    0,    0,    0,    0,    0,    0,    0,    0,    0,
    0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff,
    0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff};

/// Four numbers of four digits from 16 characters that end before `end`: the last `digits` of 32 (`first` = 0:
/// characters 17 to 32 from the end; 16: the last 16), those before the last `fraction` taken one place earlier, over
/// the mark.
inline __m128i four_digit_groups(const char* end, int first, int fraction, int digits) {
  const __m128i behind = load(last_bytes + first + fraction);
  const char* const p = end - 32 + first;
  __m128i bytes = _mm_or_si128(_mm_and_si128(behind, load(p)), _mm_andnot_si128(behind, load(p - 1)));
  bytes = _mm_and_si128(_mm_sub_epi8(bytes, _mm_set1_epi8('0')), load(last_bytes + first + digits));
  const __m128i pairs = _mm_srli_epi16(_mm_mullo_epi16(bytes, _mm_set1_epi16(0x0A01)), 8);  // 10 * first + second
  return _mm_madd_epi16(pairs, _mm_set1_epi32(0x00010064));
}

/// For up to 31 characters, without a branch on the number of digits. A minus at `p` is skipped where `negative` says
/// so; the search for the end does not wait for it.
inline Decimal take_decimal(const char* p, bool negative, char mark) {
  std::uint32_t others = other_than_digits(p) & ~static_cast<std::uint32_t>(negative);
  if (others == 0) return take_decimal_portably(p + negative, mark);
  int length = std::countr_zero(others);
  int digits = length - negative;
  int fraction = 0;
  int behind = digits;  // the mark: without one nothing moves
  if (p[length] == mark) {
    others &= others - 1;
    if (others == 0) return take_decimal_portably(p + negative, mark);
    const int end = std::countr_zero(others);
    fraction = behind = end - length - 1;
    digits = end - 1 - negative;
    length = end;
  }
  if (digits == 0) return {};
  const char* const end = p + length;
  const __m128i fours = _mm_packs_epi32(digits <= 16 ? _mm_setzero_si128() : four_digit_groups(end, 0, behind, digits),
                                        four_digit_groups(end, 16, behind, digits));
  const __m128i eights = _mm_madd_epi16(fours, _mm_set1_epi32(0x00012710));
  const auto high = static_cast<std::uint64_t>(_mm_cvtsi128_si64(eights));
  const auto low = static_cast<std::uint64_t>(_mm_cvtsi128_si64(_mm_unpackhi_epi64(eights, eights)));
  // The first eight of 32 digits in the low half of `high`, the next in its high half: 1843 * 10^16 fits 64 bits.
  if ((high & 0xFFFFFFFFu) != 0 || (high >> 32) > 1843) return {};
  const std::uint64_t mantissa = (high >> 32) * 10000000000000000u + (low & 0xFFFFFFFFu) * 100000000u + (low >> 32);
  return {mantissa, fraction, end};
}
#else
inline Decimal take_decimal(const char* p, bool negative, char mark) {
  return take_decimal_portably(p + negative, mark);
}
#endif

}  // namespace detail

/// The decimal number at `p` to the nearest double, for the forms that instruments write: digits, one decimal mark, an
/// exponent. What it does not take (null) is not always wrong: a leading plus, or more than 19 significant digits, are
/// left to slower code.
///
/// Given     p         text, with `number_padding` readable bytes before and behind it
///           mark      the decimal mark
/// Returned  where the number ends; its value [as written]; exponent of ten of its last digit (-3 for 0.125)
/// Accuracy  correctly rounded: one rounding of exact numbers (Clinger 1990) or the product with a 128-bit power of
///           ten (Lemire, "Number parsing at a gigabyte per second", 2021)
inline const char* parse_number(const char* p, char mark, double& value, int& exponent) {
  const bool negative = *p == '-';
  const detail::Decimal decimal = detail::take_decimal(p, negative, mark);
  p = decimal.end;
  if (p == nullptr) return nullptr;
  exponent = -decimal.fraction;
  if ((*p | 0x20) == 'e') {
    p = detail::take_exponent(p + 1, exponent);
    if (p == nullptr) return nullptr;
  }
  if (!detail::scaled(decimal.mantissa, exponent, value)) return nullptr;
  // The sign bit, not a branch on a sign that noise makes random.
  value = std::bit_cast<double>(std::bit_cast<std::uint64_t>(value) ^ static_cast<std::uint64_t>(negative) << 63);
  return p;
}

}  // namespace tumble::csv
