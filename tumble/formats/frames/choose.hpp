#pragma once

#include <string>
#include <vector>

#include "tumble/core/read_options.hpp"
#include "tumble/wire/frames.hpp"

namespace tumble::frames {

inline constexpr std::size_t first_bytes = 65536;  ///< of a file, by which it is recognised

/// How well a shipped declaration explains the first bytes of a file.
struct Match {
  std::string name;
  std::uint64_t frames = 0;  ///< good ones that carry channels
  double part = 0.0;         ///< of the bytes that good frames explain
  bool explains = false;     ///< enough of them
};

/// The shipped declarations that find a good frame in these bytes, the best first.
std::vector<Match> matches_of(std::string_view bytes);

/// The first bytes of a file. Throws Error::bad_file.
std::string beginning_of(const std::string& path);

/// The frames of a file: as the options say, or as its first bytes show.
struct Chosen {
  FrameCodec codec;
  bool recognised = false;  ///< nobody named it
  double part = 1.0;        ///< of the first bytes that it explains
};

/// Throws Error::bad_input for options that name no declaration, or one with a scale that a variant has to say;
/// Error::bad_file, with the candidates, where the bytes do not show which.
Chosen choose(const std::string& path, const ReadOptions& options);

}  // namespace tumble::frames
