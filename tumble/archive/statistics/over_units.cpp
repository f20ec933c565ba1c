#include "tumble/archive/statistics/over_units.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <unordered_map>

#include "tumble/units/error.hpp"

namespace tumble::statistics {

namespace {

[[noreturn]] void refuse_dimensions(const ParameterOverUnits& over, const std::map<std::string, std::int64_t>& shown) {
  std::vector<std::string> where;
  for (const auto& [unit, result] : shown) {
    const auto value = std::ranges::find(over.values, result, &ChartValue::result);
    const auto of = std::ranges::find(over.units, value->unit, [](const auto& one) { return one.first; });
    where.push_back(fmt::format("[{}] of {}/{}", unit, of->second.model, of->second.serial));
  }
  throw Error(Error::Kind::bad_input,
              say("'{}' is not the same quantity in all results: {}; --model or --unit chooses some of them",
                  over.parameter, fmt::join(where, ", ")));
}

}  // namespace

void require_values(const ParameterOverUnits& over, const std::string& model, const UnitName& unit) {
  if (!over.values.empty()) return;
  throw Error(Error::Kind::bad_input,
              !unit.serial.empty() ? say("no result of the unit {}/{} that counts has the parameter '{}'",
                                         Name{unit.model}, Name{unit.serial}, over.parameter)
              : model.empty()
                  ? say("no result of the archive that counts has the parameter '{}'", over.parameter)
                  : say("no result of the model {} that counts has the parameter '{}'", Name{model}, over.parameter));
}

std::vector<std::int64_t> compared_results(const ParameterOverUnits& over) {
  constexpr std::size_t few = 2000;
  std::unordered_map<std::int64_t, std::int64_t> last;
  std::vector<std::int64_t> results;
  for (const auto& value : over.values) {
    if (over.values.size() <= few || !last.contains(value.unit)) results.push_back(value.result);
    last[value.unit] = value.result;
  }
  for (const auto& [unit, result] : last) results.push_back(result);
  return results;
}

Unit shown_unit(const ParameterOverUnits& over, const std::map<std::string, std::int64_t>& shown) {
  const Unit unit = Unit::parse(shown.begin()->first);
  for (const auto& [other, result] : shown)
    if (Unit::parse(other).dimension() != unit.dimension()) refuse_dimensions(over, shown);
  return unit;
}

}  // namespace tumble::statistics
