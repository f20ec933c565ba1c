#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "tumble/core/finding.hpp"

namespace tumble::wav {

/// How the samples of a file lie.
struct Layout {
  enum class Type { u8, i16, i24, i32, f32, f64 };
  Type type = Type::i16;
  bool big = false;  ///< the first byte has the highest digits (RIFX)
  std::size_t channels = 0;
  double rate = 0.0;         ///< [Hz]
  std::size_t first = 0;     ///< [bytes] where the samples begin
  std::uint64_t frames = 0;  ///< samples of each channel
  std::map<std::string, std::string> meta;
  Findings findings;
};

std::size_t size_of(Layout::Type type);  ///< [bytes] of a sample
bool is_integer(Layout::Type type);
double full_scale(Layout::Type type);  ///< [count] of an integer type, 32768 for i16

/// Whether it begins as a RIFF or RF64 file of sound.
bool is_wave(const std::string& path);

/// Throws Error::bad_file.
Layout layout_of(const std::string& path);

}  // namespace tumble::wav
