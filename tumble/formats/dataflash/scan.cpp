#include "tumble/formats/dataflash/scan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "tumble/formats/dataflash/gps_time.hpp"

namespace tumble::dataflash {
namespace {

/// Multipliers are written as binary32 widened to binary64: to seven digits they are what was meant.
double seven_digits(double value) { return std::strtod(fmt::format("{:.6e}", value).c_str(), nullptr); }

/// Counts messages, and takes those that describe the log.
class Taker {
 public:
  explicit Taker(Scan& scan) : scan_(scan), counts_(256) {}

  void take(std::uint8_t id, const char* message) {
    const Description& description = scan_.descriptions[id];
    auto& counts = counts_[id];
    if (counts.all++ == 0) begin(description, id, message, counts);
    if (counts.special) take_special(description, message);
    if (counts.gps && !scan_.started) scan_.started = start_by_gps(description, message);
    if (!counts.instance) return;
    if (counts.by_instance.empty()) counts.by_instance.resize(256);
    Instance& one = counts.by_instance[static_cast<unsigned char>(message[counts.instance->offset])];
    if (one.messages++ == 0) one.first = time_of(description, message);
  }

  void finish() {
    leave_contradictory();
    for (std::size_t id = 0; id < counts_.size(); ++id) {
      const auto& counts = counts_[id];
      const Description& description = scan_.descriptions[id];
      if (counts.all == 0 || counts.special || description.name == "FMT") continue;
      if (counts.by_instance.empty())
        scan_.streams.push_back({description.name, static_cast<std::uint8_t>(id), -1, counts.all, counts.first});
      for (std::size_t i = 0; i < counts.by_instance.size(); ++i)
        if (const Instance& one = counts.by_instance[i]; one.messages > 0)
          scan_.streams.push_back({fmt::format("{}:{}", description.name, i), static_cast<std::uint8_t>(id),
                                   static_cast<int>(i), one.messages, one.first});
    }
  }

 private:
  struct Instance {
    std::size_t messages = 0;
    std::optional<double> first;  ///< [s]
  };
  struct Counts {
    std::size_t all = 0;
    std::optional<double> first;  ///< [s]
    std::vector<Instance> by_instance;
    const Field* instance = nullptr;
    bool special = false, gps = false;
  };

  void begin(const Description& description, std::uint8_t id, const char* message, Counts& counts) const {
    counts.special = is_special(description.name);
    counts.gps = description.name == "GPS";
    counts.instance = scan_.instance_field(id);
    counts.first = time_of(description, message);
  }

  static bool is_special(const std::string& name) {
    static constexpr const char* names[] = {"FMTU", "UNIT", "MULT", "PARM", "MSG", "DSF"};
    return std::ranges::find(names, name) != std::end(names);
  }

  void take_special(const Description& description, const char* message) {
    const auto value = [&](const char* label) { return value_of(description, message, label); };
    const auto text = [&](const char* label) { return text_of(description, message, label); };
    const std::string& name = description.name;
    if (name == "FMTU") {
      if (const auto type = value("FmtType"); type && *type >= 0.0 && *type < 256.0)
        take_units(static_cast<std::size_t>(*type), {text("UnitIds"), text("MultIds")});
    } else if (name == "UNIT" && value("Id")) {
      define(static_cast<char>(static_cast<int>(*value("Id"))), text("Label"), scan_.units, changed_units_);
    } else if (name == "MULT" && value("Id") && value("Mult")) {
      define(static_cast<char>(static_cast<int>(*value("Id"))), seven_digits(*value("Mult")), scan_.multipliers,
             changed_multipliers_);
    } else if (name == "PARM" && value("Value")) {
      scan_.parameters.try_emplace(text("Name"), *value("Value"));
    } else if (name == "MSG" && scan_.firmware.empty()) {
      scan_.firmware = text("Message");
    } else if (name == "DSF" && value("Dp")) {
      scan_.rejected = std::max(scan_.rejected, *value("Dp"));
    }
  }

  /// What is defined again, as something else, is noted: samples before and after it mean different things.
  template <class Value>
  static void define(char character, const Value& value, std::map<char, Value>& to, std::string& changed) {
    const auto [known, is_new] = to.try_emplace(character, value);
    if (!is_new && !(known->second == value)) changed += character;
  }

  void take_units(std::size_t id, const FieldUnits& units) {
    FieldUnits& known = scan_.field_units[id];
    const bool is_new = known.units.empty() && known.multipliers.empty();
    if (!is_new && (known.units != units.units || known.multipliers != units.multipliers))
      scan_.descriptions[id].ambiguous = true;
    known = units;
  }

  /// Messages whose units or multipliers change within the log are not read, as those with two descriptions.
  void leave_contradictory() {
    for (std::size_t id = 0; id < scan_.field_units.size(); ++id) {
      const FieldUnits& units = scan_.field_units[id];
      if (units.units.find_first_of(changed_units_) != std::string::npos ||
          units.multipliers.find_first_of(changed_multipliers_) != std::string::npos)
        scan_.descriptions[id].ambiguous = true;
    }
  }

  Scan& scan_;
  std::vector<Counts> counts_;
  std::string changed_units_, changed_multipliers_;  ///< characters
};

}  // namespace

const Field* Scan::instance_field(std::uint8_t id) const {
  const auto usable = [](const Field* field) { return field && size_of(field->type) == 1 ? field : nullptr; };
  const Description& description = descriptions[id];
  if (const auto at = field_units[id].units.find('#'); at < description.fields.size())
    return usable(&description.fields[at]);
  return usable(find_field(description, "I"));
}

Scan scan(const std::string& path) {
  Scan result;
  Taker taker(result);
  result.damage =
      walk(path, result.descriptions, {}, [&](std::uint8_t id, const char* message) { taker.take(id, message); });
  taker.finish();
  return result;
}

}  // namespace tumble::dataflash
