#include "tumble/formats/ulog/messages.hpp"

#include <algorithm>
#include <array>

#include "tumble/formats/file/number_at.hpp"
#include "tumble/units/error.hpp"

namespace tumble::ulog {
namespace {

/// Whether messages of this type are known, by its letter.
constexpr auto known_types = [] {
  std::array<bool, 256> known{};
  for (const char type : std::string_view("BFIMPQARDLCSO")) known[static_cast<unsigned char>(type)] = true;
  return known;
}();

bool is_known(char type) { return known_types[static_cast<unsigned char>(type)]; }

constexpr std::size_t longest_strange = 10000;  ///< [bytes] of a message of a type that is not known
constexpr int chain = 3;                        ///< messages in a row that show where messages begin again
constexpr std::size_t longest_message = message_head + 65535;

std::size_t size_at(const char* head) { return file::number_at<std::uint16_t>(head); }

std::size_t least_size(char type) {
  switch (type) {
    case 'B':
      return 40;
    case 'A':
    case 'P':
    case 'I':
      return 4;
    case 'S':
      return 8;
    default:
      return 2;
  }
}

/// Whether the head, and of data the id behind it, can begin a message.
bool plausible(const char* head, const Subscriptions& subscriptions) {
  const std::size_t size = size_at(head);
  const char type = head[2];
  if (!is_known(type)) return type >= 'A' && type <= 'Z' && size > 0 && size <= longest_strange;
  if (size < least_size(type)) return false;
  if (type != 'D') return true;
  const Subscription& of = subscriptions.of(size_at(head + message_head));
  return of.topic < 0 || (size - 2 >= of.size.least && size - 2 <= of.size.most);
}

/// Places in the file where data were appended, in order.
std::vector<std::size_t> appended(const char* flags, const std::string& path) {
  for (int byte = 0; byte < 8; ++byte) {
    const auto bits = static_cast<unsigned char>(flags[8 + byte]);
    const int known = byte == 0 ? 1 : 0;
    if ((bits & ~known) != 0)
      throw Error(Error::Kind::bad_file, say("'{}' uses a feature of ULog that is not known here (incompatible flags, "
                                             "byte {} = {}): convert it with the software that wrote it",
                                             path, Name{std::to_string(byte)}, Name{std::to_string(bits)}));
  }
  std::vector<std::size_t> places;
  for (int k = 0; k < 3; ++k) {
    const auto place = file::number_at<std::uint64_t>(flags + 16 + std::ptrdiff_t{8} * k);
    if ((flags[8] & 1) != 0 && place > 0) places.push_back(place);
  }
  std::ranges::sort(places);
  return places;
}

class Walker {
 public:
  Walker(const std::string& path, const Subscriptions& subscriptions, const Progress& progress)
      : path_(path), subscriptions_(subscriptions), progress_(progress), window_(path) {
    window_.skip(head_size);
  }

  template <class Take>
  Damage run(const Take& take) {
    for (std::size_t reported = 0; window_.holds(message_head + 2);) {
      const std::size_t at = window_.position();
      if (at - reported > std::size_t{1} << 22) {
        reported = at;
        report(progress_, static_cast<double>(at) / static_cast<double>(window_.size()), "reading");
      }
      if (!plausible(window_.data(), subscriptions_)) {
        find_next();
        continue;
      }
      const std::size_t size = size_at(window_.data());
      if (crosses(at + message_head + size)) continue;
      if (!window_.holds(message_head + size)) {
        damage_.cut_off = window_.available();
        return damage_;
      }
      give(size, take);
      window_.skip(message_head + size);
    }
    damage_.cut_off = window_.available();
    return damage_;
  }

 private:
  template <class Take>
  void give(std::size_t size, const Take& take) {
    const Message message{window_.data()[2], window_.data() + message_head, size};
    if (message.type == 'B') places_ = appended(message.body, path_);
    if (message.type == 'D' && subscriptions_.of(size_at(message.body)).topic < 0) {
      ++damage_.undescribed;
      return;
    }
    take(message);
  }

  /// True where appended data begin before `end`: then the window stands there, and what lies before is no message.
  bool crosses(std::size_t end) {
    while (!places_.empty() && places_.front() <= window_.position()) places_.erase(places_.begin());
    if (places_.empty() || places_.front() >= end || places_.front() > window_.size()) return false;
    window_.skip(places_.front() - window_.position());
    return true;
  }

  /// Whether messages follow one after the other from `at` on, as far as the bytes up to `end` show it.
  bool begins(const char* at, const char* end) const {
    for (int k = 0; k < chain; ++k) {
      if (at == end || (k > 0 && end - at < static_cast<std::ptrdiff_t>(message_head + 2))) return k > 0;
      if (end - at < static_cast<std::ptrdiff_t>(message_head + 2)) return false;
      if (!plausible(at, subscriptions_) || !is_known(at[2])) return false;
      const std::size_t size = message_head + size_at(at);
      if (static_cast<std::size_t>(end - at) < size) return k > 0;
      at += size;
    }
    return true;
  }

  /// To the next place where messages begin, or to the end of the file.
  void find_next() {
    constexpr std::size_t needed = chain * longest_message;
    const std::size_t start = window_.position();
    window_.skip(1);
    for (bool found = false; !found && window_.holds(1);) {
      const bool whole = window_.holds(needed);
      const char* const end = window_.data() + window_.available();
      const char* const stop = whole ? end - needed + 1 : end;
      const char* at = window_.data();
      while (at < stop && !begins(at, end)) ++at;
      found = at < stop;
      window_.skip(static_cast<std::size_t>(at - window_.data()));
    }
    if (damage_.stretches++ == 0) damage_.first = start;
    damage_.bytes += window_.position() - start;
  }

  const std::string& path_;
  const Subscriptions& subscriptions_;
  const Progress& progress_;
  file::Window window_;
  std::vector<std::size_t> places_;
  Damage damage_;
};

}  // namespace

Damage walk(const std::string& path, const Subscriptions& subscriptions, const Progress& progress,
            const std::function<void(const Message&)>& take) {
  return Walker(path, subscriptions, progress).run(take);
}

}  // namespace tumble::ulog
