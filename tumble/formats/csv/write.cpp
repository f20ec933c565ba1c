#include "tumble/formats/csv/write.hpp"

#include <fmt/compile.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/csv/cells.hpp"
#include "tumble/formats/csv/read.hpp"
#include "tumble/formats/file/annotations.hpp"
#include "tumble/formats/file/plain_value.hpp"
#include "tumble/math/interruption.hpp"
#include "tumble/units/error.hpp"

namespace tumble::csv {

namespace {

constexpr std::size_t flush_at = std::size_t{1} << 20;

struct Text {
  char characters[32];
  std::size_t size = 0;
  explicit Text(double value)
      : size(static_cast<std::size_t>(fmt::format_to(characters, FMT_COMPILE("{}"), value) - characters)) {}
};

}  // namespace

void append_value(std::string& text, double value_si, const Unit& unit) {
  if (std::isnan(value_si)) return;
  const Text shortest(file::plain_value(value_si, unit));
  text.append(shortest.characters, shortest.size);
}

void append_even_time(std::string& text, double t, double interval) {
  const int places = std::clamp(6 - static_cast<int>(std::floor(std::log10(interval))), 0, 15);
  const double scale = std::pow(10.0, places);
  const double scaled = std::nearbyint(t * scale);
  const Text shortest(std::abs(scaled) < 9e15 ? scaled / scale : t);
  text.append(shortest.characters, shortest.size);
}

namespace {

/// A header cell; quoted where the name holds what would be read otherwise. The name of the clock is taken, and blanks
/// at the ends are not read back: behind one, what a spreadsheet would take for a formula is text.
std::string header_cell(const Channel& channel) {
  constexpr std::string_view formulas = "=+-@";
  const bool formula = !channel.name.empty() && formulas.find(channel.name.front()) != std::string_view::npos;
  const std::string cell = (formula ? " " : "") + channel.name + "[" + channel.unit.text() + "]";
  const bool plain = !formula && cell.find_first_of(",;\t\"\n\r") == std::string::npos;
  const bool other = channel.name.empty() || channel.name == "time" || trimmed(channel.name) != channel.name;
  if (cell.find_first_of("\n\r\"") != std::string::npos || other)
    throw Error{Error::Kind::bad_input, say("the channel name '{}' cannot be written in a CSV header", channel.name)};
  return plain ? cell : '"' + cell + '"';
}

class Writer {
 public:
  explicit Writer(const std::string& path) : path_(path), file_(path) {}

  void append(const Recording& block) {
    check(block);
    if (!started_) begin(block);
    const std::size_t rows = block.channels.front().values.size();
    const Timeline& timeline = block.channels.front().timeline;
    for (std::size_t row = 0; row < rows; ++row) {
      if (timeline.uniform())
        append_even_time(text_, clock_.time(written_ + row), 1.0 / clock_.rate);
      else
        append_value(text_, timeline.time(row), seconds_);
      for (const Channel& channel : block.channels) {
        text_ += ',';
        if (std::isinf(channel.values[row])) refuse_infinity(channel, timeline.time(row));
        append_value(text_, channel.values[row], channel.unit);
      }
      text_ += '\n';
      if (text_.size() >= flush_at) flush();
    }
    written_ += rows;
  }

  void commit() {
    flush();
    file_.commit();
  }

 private:
  static bool same(const Timeline& a, const Timeline& b) {
    return a.start == b.start && a.rate == b.rate &&
           (a.stamps == b.stamps || (a.stamps && b.stamps && *a.stamps == *b.stamps));
  }

  void check(const Recording& block) const {
    if (block.channels.empty()) throw Error{Error::Kind::bad_input, say("'{}': there is no channel to write", path_)};
    const Channel& first = block.channels.front();
    for (const Channel& channel : block.channels)
      if (!same(channel.timeline, first.timeline) || channel.values.size() != first.values.size())
        throw Error{Error::Kind::bad_input, say("'{}': a CSV file has one time column, but '{}' and '{}' were sampled "
                                                "at different times; write to a .h5 file instead",
                                                path_, first.name, channel.name)};
  }

  [[noreturn]] void refuse_infinity(const Channel& channel, double t) const {
    throw Error{Error::Kind::bad_data,
                say("'{}': '{}' is infinite at {}; only finite and missing samples can be written", path_, channel.name,
                    say("{} s", t))};
  }

  void begin(const Recording& block) {
    for (const auto& [key, json] : file::annotations_of(block)) text_ += "# " + key + ": " + json + "\n";
    clock_ = block.channels.front().timeline;
    if (clock_.uniform())
      text_ += "# clock: " + nlohmann::ordered_json{{"start", clock_.start}, {"rate", clock_.rate}}.dump() + "\n";
    text_ += "time[s]";
    for (const Channel& channel : block.channels) text_ += "," + header_cell(channel);
    text_ += '\n';
    started_ = true;
  }

  void flush() {
    stop_if_asked();
    file_.write(text_);
    text_.clear();
  }

  std::string path_;
  AtomicFile file_;
  std::string text_;
  Timeline clock_;
  Unit seconds_ = Unit::parse("s");
  std::size_t written_ = 0;
  bool started_ = false;
};

}  // namespace

RecordingWriter writer(const std::string& path) {
  const auto state = std::make_shared<Writer>(path);
  return {[state](const Recording& block) { state->append(block); }, [state] { state->commit(); }};
}

}  // namespace tumble::csv
