#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tumble/pyramid/pyramid.hpp"
#include "tumble/pyramid/store/paged.hpp"
#include "tumble/pyramid/store/store.hpp"

namespace tumble::store {

/// A file in the memory of the process, read only.
class Mapped {
 public:
  /// Throws Error::bad_file.
  explicit Mapped(const std::string& path);
  Mapped(const Mapped&) = delete;
  Mapped& operator=(const Mapped&) = delete;
  ~Mapped();

  std::size_t size() const { return size_; }
  const char* at(std::uint64_t place) const { return bytes_ + place; }

  /// `count` numbers; throws Error::bad_file where they do not lie in the file.
  template <class Number>
  const Number* numbers(const Json& place, std::size_t count) const {
    const auto begin = place.get<std::uint64_t>();
    if (begin % 8 != 0 || begin > size_ || count > (size_ - begin) / sizeof(Number)) damaged();
    return reinterpret_cast<const Number*>(bytes_ + begin);
  }
  /// Throws Error::bad_file.
  [[noreturn]] static void damaged();

 private:
  const char* bytes_ = nullptr;
  std::size_t size_ = 0;
};

/// Numbers that stand in the file in pieces.
struct Pieces {
  struct Piece {
    std::size_t first;
    const double* numbers;
  };
  std::vector<Piece> pieces;
  std::size_t count = 0;

  Pieces() = default;
  Pieces(const Mapped& file, const Json& places, std::size_t total) : count(total) {
    for (std::size_t i = 0; i + 1 < places.size(); i += 2) {
      const auto first = places[i].get<std::size_t>();
      const std::size_t end = i + 2 < places.size() ? places[i + 2].get<std::size_t>() : total;
      if (first > end || end > total || (i == 0 && first != 0)) Mapped::damaged();
      pieces.push_back({first, file.numbers<double>(places[i + 1], end - first)});
    }
  }
  bool empty() const { return pieces.empty(); }
  /// Number `index` [as written].
  double at(std::size_t index) const { return of(index)->numbers[index - of(index)->first]; }
  /// Appends `number` of them [as written], from `first` on.
  void append(std::size_t first, std::size_t number, std::vector<double>& to) const {
    for (auto piece = of(first); number > 0; ++piece) {
      const std::size_t end = piece + 1 < pieces.end() ? (piece + 1)->first : count;
      const std::size_t now = std::min(number, end - first);
      to.insert(to.end(), piece->numbers + (first - piece->first), piece->numbers + (first - piece->first) + now);
      first += now;
      number -= now;
    }
  }
  std::vector<Piece>::const_iterator of(std::size_t index) const {
    return std::upper_bound(pieces.begin(), pieces.end(), index,
                            [](std::size_t i, const Piece& piece) { return i < piece.first; }) -
           1;
  }
};

struct LiveTrack;

struct MappedLevel {
  std::size_t count = 0;
  Paged<float> low, high;
  Paged<std::uint8_t> flags;
};

struct MappedMoments {
  std::size_t count = 0;
  Paged<Moments> blocks;
};

struct MappedChannel {
  std::size_t count = 0, clock = 0;
  double offset = 0.0, start = 0.0, rate = 0.0;
  Pieces samples, stamps;
  std::vector<MappedLevel> levels;
  std::vector<MappedMoments> moments;
  std::shared_ptr<const LiveTrack> track;  ///< of a recording that is being made; else null
};

/// The channels of a recording that is being made.
struct LiveChannels {
  std::vector<MappedChannel> channels;
  std::vector<std::shared_ptr<const void>> owners;  ///< of the pages
};

/// A channel by what the file says of it, and that of the whole file. Throw Error::bad_file, Json::exception.
MappedChannel mapped(const Mapped& file, const Json& entry);
Json description_in(const Mapped& file);

}  // namespace tumble::store
