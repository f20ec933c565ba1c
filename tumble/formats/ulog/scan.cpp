#include "tumble/formats/ulog/scan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <set>

#include "tumble/core/instant.hpp"
#include "tumble/formats/file/number_at.hpp"

namespace tumble::ulog {
namespace {

/// Text for people: without the zeros at the end, control characters replaced.
std::string printable(std::string_view bytes) {
  std::string text(bytes.substr(0, bytes.find('\0')));
  std::ranges::replace_if(
      text, [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  return text;
}

/// Takes the messages that come before the samples, and counts the samples.
class Taker {
 public:
  explicit Taker(Scan& scan) : scan_(scan) {}

  void take(const Message& message) {
    switch (message.type) {
      case 'D':
        return take_data(message);
      case 'F':
        return take_format({message.body, message.size});
      case 'A':
        return subscribe(message);
      case 'R':
        scan_.subscriptions.at(file::number_at<std::uint16_t>(message.body)) = {};
        return;
      case 'I':
        return note({message.body, message.size}, scan_.information);
      case 'P':
        return note({message.body, message.size}, scan_.parameters);
      case 'O':
        return drop(1e-3 * file::number_at<std::uint16_t>(message.body));
      default:
        return;
    }
  }

  /// Topics of formats with two descriptions hold samples of one or the other: none is read.
  void leave_contradictory() {
    for (Scan::Topic& topic : scan_.topics) {
      if (!holds(scan_.definitions, topic.format, contradictory_)) continue;
      scan_.damage.undescribed += topic.messages;
      topic.messages = 0;
      if (std::ranges::find(scan_.unreadable, topic.format) == scan_.unreadable.end())
        scan_.unreadable.push_back(topic.format);
    }
  }

 private:
  void take_format(std::string_view text) {
    Definitions one;
    if (!define(text, one)) return;
    const auto& [name, fields] = *one.begin();
    const auto [known, is_new] = scan_.definitions.try_emplace(name, fields);
    if (!is_new && known->second != fields) contradictory_.insert(name);
  }

  void take_data(const Message& message) {
    const auto id = file::number_at<std::uint16_t>(message.body);
    ++scan_.topics[static_cast<std::size_t>(scan_.subscriptions.of(id).topic)].messages;
    if (message.size < 10) return;
    time_ = file::number_at<std::uint64_t>(message.body + 2);
    if (!first_) first_ = time_;
    if (const auto date = dates_.find(id); date != dates_.end() && !scan_.begun) take_date(message, date->second);
  }

  /// The first date that a receiver is sure of; before, it says 0.
  void take_date(const Message& message, std::size_t offset) {
    constexpr std::uint64_t latest = 9'000'000'000'000'000;  // us; what 63 bits of ns hold
    if (message.size < 2 + offset + sizeof(std::uint64_t)) return;
    const auto date = file::number_at<std::uint64_t>(message.body + 2 + offset);
    const auto since_first = static_cast<std::int64_t>(time_ - *first_);
    if (date < latest && is_set(1000 * static_cast<std::int64_t>(date)) &&
        std::abs(since_first) < std::int64_t{1} << 50)
      scan_.begun = static_cast<std::int64_t>(date) - since_first;
  }

  /// Notes where messages of this id have a date, if they do.
  void find_date(std::uint16_t id, const std::string& format) {
    dates_.erase(id);
    for (const Place& place : places_in(scan_.definitions, format))
      if (place.field == "time_utc_usec" && place.number == topics::Number::u64) dates_[id] = place.offset;
  }

  void subscribe(const Message& message) {
    const std::string format = printable({message.body + 3, message.size - 3});
    const auto instance = static_cast<unsigned char>(message.body[0]);
    const auto id = file::number_at<std::uint16_t>(message.body + 1);
    const auto size = size_of(scan_.definitions, format);
    if (!size || !has_time(format)) {
      if (std::ranges::find(scan_.unreadable, format) == scan_.unreadable.end()) scan_.unreadable.push_back(format);
      scan_.subscriptions.at(id) = {};
      return;
    }
    const std::string name = fmt::format("{}:{}", format, instance);
    const auto [at, is_new] = index_.try_emplace(name, scan_.topics.size());
    if (is_new) scan_.topics.push_back({name, format, 0});
    scan_.subscriptions.at(id) = {static_cast<int>(at->second), *size};
    find_date(id, format);
  }

  bool has_time(const std::string& format) const {
    const auto& fields = scan_.definitions.find(format)->second;
    return std::ranges::any_of(fields, [](const Field& field) {
      return field.name == "timestamp" && field.type == "uint64_t" && field.length == 1;
    });
  }

  /// "int32_t CAL_GYRO0_ID" and its value.
  static void note(std::string_view body, std::map<std::string, std::string>& to) {
    const std::size_t length = static_cast<unsigned char>(body[0]);
    if (body.size() < 1 + length) return;
    const std::string key = printable(body.substr(1, length));
    const std::string_view value = body.substr(1 + length);
    const auto space = key.find(' ');
    if (space == key.npos) return;
    const std::string type = key.substr(0, space), name = key.substr(space + 1);
    if (type.starts_with("char")) to.try_emplace(name, printable(value));
    if (const auto number = number_of(type); number && value.size() >= topics::size_of(*number))
      to.try_emplace(name, *number == topics::Number::f32
                               ? fmt::format("{}", file::number_at<float>(value.data()))
                               : fmt::format("{}", topics::number_at(value.data(), *number)));
  }

  void drop(double seconds) {
    auto& dropouts = scan_.dropouts;
    const double at = static_cast<double>(time_) / 1e6;
    if (dropouts.count++ == 0) dropouts.first_at = at;
    dropouts.total += seconds;
    if (seconds < dropouts.longest) return;
    dropouts.longest = seconds;
    dropouts.longest_at = at;
  }

  Scan& scan_;
  std::map<std::string, std::size_t> index_;
  std::set<std::string> contradictory_;
  std::map<std::uint16_t, std::size_t> dates_;  // [bytes] where the date stands in a message, by id
  std::uint64_t time_ = 0;
  std::optional<std::uint64_t> first_;
};

}  // namespace

Scan scan(const std::string& path) {
  Scan result;
  Taker taker(result);
  result.damage = walk(path, result.subscriptions, {}, [&](const Message& message) { taker.take(message); });
  taker.leave_contradictory();
  return result;
}

void replay(const std::string& path, const Progress& progress, const Take& take) {
  Scan again;
  Taker taker(again);
  walk(path, again.subscriptions, progress, [&](const Message& message) {
    if (message.type != 'D') return taker.take(message);
    const auto id = file::number_at<std::uint16_t>(message.body);
    take(static_cast<std::size_t>(again.subscriptions.of(id).topic), message.body + 2);
  });
}

}  // namespace tumble::ulog
