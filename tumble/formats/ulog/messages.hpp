#pragma once

#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

#include "tumble/core/progress.hpp"
#include "tumble/formats/file/window.hpp"
#include "tumble/formats/topics/damage.hpp"
#include "tumble/formats/ulog/definitions.hpp"

namespace tumble::ulog {

using topics::Damage;

constexpr std::string_view magic = "\x55\x4c\x6f\x67\x01\x12\x35";
constexpr std::size_t head_size = 16;    ///< magic, version, u64 time
constexpr std::size_t message_head = 3;  ///< u16 size, u8 type

/// Subscribed messages by their id.
struct Subscription {
  int topic = -1;  ///< index; -1: no such id, or a format that cannot be read
  Size size;       ///< [bytes] of a message without its id
};

/// Subscriptions by id, 0 to 65535.
class Subscriptions {
 public:
  const Subscription& of(std::size_t id) const { return id < all_.size() ? all_[id] : none_; }
  Subscription& at(std::size_t id) {
    if (id >= all_.size()) all_.resize(id + 1);
    return all_[id];
  }
  std::size_t size() const { return all_.size(); }  ///< one above the greatest id

 private:
  std::vector<Subscription> all_;
  Subscription none_;
};

/// A message that is whole and can be what it claims.
struct Message {
  char type;
  const char* body;
  std::size_t size;  ///< [bytes] of the body
};

/// Goes through all messages behind the head of the file. Bytes that cannot be a message of these subscriptions, which
/// may grow on the way, are skipped. Data appended later, where the flags say so, begin at their own places.
/// Throws Error::bad_file for flags that are not known.
Damage walk(const std::string& path, const Subscriptions& subscriptions, const Progress& progress,
            const std::function<void(const Message&)>& take);

}  // namespace tumble::ulog
