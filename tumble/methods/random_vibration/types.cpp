#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <sstream>

#include "tumble/methods/random_vibration/statistics.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"

namespace tumble::random_vibration {

namespace {

/// Units by their names, and which of them have a type.
struct NamedUnits {
  std::vector<std::string> names;
  std::vector<bool> taken;
};

/// One type, "name: unit unit"; absent, with a problem, where the text is none.
std::optional<Type> type_in(const std::string& part, NamedUnits& units, Problems& problems) {
  const std::size_t colon = part.find(':');
  std::istringstream name(part.substr(0, colon)), members(colon == std::string::npos ? "" : part.substr(colon + 1));
  Type type;
  std::string more;
  if (!(name >> type.name) || name >> more || colon == std::string::npos) {
    problems.push_back(say("[settings] types: '{}' is not \"name: unit unit\"", part));
    return std::nullopt;
  }
  for (std::string unit; members >> unit;) {
    if (unit.ends_with(',')) unit.pop_back();
    const auto recorded = std::ranges::find(units.names, unit);
    if (recorded == units.names.end()) {
      problems.push_back(say("[settings] types: no unit '{}' is recorded{} (units: {})", unit,
                             did_you_mean(unit, units.names), fmt::join(units.names, ", ")));
      continue;
    }
    const auto u = static_cast<std::size_t>(recorded - units.names.begin());
    if (units.taken[u]) problems.push_back(say("[settings] types: unit '{}' is named twice", unit));
    units.taken[u] = true;
    type.units.push_back(u);
  }
  if (type.units.empty()) problems.push_back(say("[settings] types: '{}' has no unit", type.name));
  return type;
}

}  // namespace

std::vector<Type> types_of(const std::string& text, const std::vector<vibration::UnitUnderTest>& units) {
  std::vector<Type> types;
  if (text.empty()) {
    for (std::size_t u = 0; u < units.size(); ++u) types.push_back({units[u].name, {u}});
    return types;
  }
  Problems problems;
  NamedUnits named{{}, std::vector<bool>(units.size(), false)};
  for (const auto& unit : units) named.names.push_back(unit.name);
  std::istringstream parts(text);
  for (std::string part; std::getline(parts, part, ';');) {
    auto type = type_in(part, named, problems);
    if (!type) continue;
    if (std::ranges::find(types, type->name, &Type::name) != types.end())
      problems.push_back(say("[settings] types: '{}' is named twice", type->name));
    types.push_back(std::move(*type));
  }
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  return types;
}

}  // namespace tumble::random_vibration
