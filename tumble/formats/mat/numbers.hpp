#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace tumble::mat {

/// How a number is stored.
enum class Stored : unsigned char { i8, u8, i16, u16, i32, u32, i64, u64, f32, f64 };

std::size_t size_of(Stored type);  ///< [bytes]
/// The type of an element of version 5: 1 to 18; nothing for what holds no numbers or characters.
std::optional<Stored> stored_type(std::uint32_t type);
/// `count` numbers at `from` [as written], in the other byte order where `swapped`.
void convert(const char* from, Stored type, bool swapped, std::size_t count, double* to);
/// Text of these code points [1], as UTF-8 without control characters.
std::string text_of(const std::vector<double>& codes);

}  // namespace tumble::mat
