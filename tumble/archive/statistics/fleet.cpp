#include "tumble/archive/statistics/fleet.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "tumble/math/population/spread.hpp"
#include "tumble/math/square.hpp"

namespace tumble::statistics {

namespace {

constexpr std::size_t most_units = 60, fewest_for_trend = 5;
constexpr std::int64_t close_days = 14;  ///< in which no drift is seen

/// Half the mean square of the differences of days that are close, less what the stated uncertainties give.
void take_days(const std::vector<std::vector<Occasion>>& histories, FleetDrift& fleet) {
  double sum = 0.0;
  std::size_t pairs = 0;
  for (const auto& history : histories)
    for (std::size_t i = 1; i < history.size(); ++i) {
      const auto &a = history[i - 1], &b = history[i];
      if (b.day - a.day > close_days || b.day == a.day || a.sources != b.sources) continue;
      sum += 0.5 * (square(b.value - a.value) - square(a.private_sd) - square(b.private_sd));
      ++pairs;
    }
  fleet.day_known = pairs > 0;
  if (pairs > 0) fleet.day_sd = std::sqrt(std::max(0.0, sum / static_cast<double>(pairs)));
}

/// Mean and spread of the trends of units, at the most probable random walk.
void take_trends(const std::vector<UnitHistory>& histories, FleetDrift& fleet) {
  fleet.rate_sd = std::numeric_limits<double>::infinity();
  const auto likeliest = std::ranges::max_element(fleet.walks.weight) - fleet.walks.weight.begin();
  const double walk = fleet.walks.walk[static_cast<std::size_t>(likeliest)];
  std::vector<UnitValue> trends;
  for (const auto& history : histories) {
    const auto trend = drift_rate(history, walk);
    if (std::isfinite(trend.value) && std::isfinite(trend.sd) && trend.sd > 0.0)
      trends.push_back({trend.value, trend.sd});
  }
  if (trends.size() < fewest_for_trend) return;
  const auto spread = spread_of_units(trends);
  fleet.rate = spread.mean;
  fleet.rate_sd = std::hypot(spread.sd, spread.mean_sd);
}

/// The histories of all units, each anew from every adjustment of its unit on.
std::vector<std::vector<Occasion>> histories_of(const std::vector<Occasion>& occasions,
                                                const std::vector<std::vector<double>>& adjustments) {
  std::vector<std::vector<Occasion>> last(adjustments.size()), all;
  const auto adjusted = [&](std::size_t unit, double moment) {
    return std::ranges::upper_bound(adjustments[unit], moment) - adjustments[unit].begin();
  };
  for (const auto& occasion : occasions) {
    auto& open = last[occasion.unit];
    if (!open.empty() && adjusted(occasion.unit, open.back().moment) != adjusted(occasion.unit, occasion.moment))
      all.push_back(std::exchange(open, {}));
    open.push_back(occasion);
  }
  all.insert(all.end(), last.begin(), last.end());
  std::erase_if(all, [](const auto& history) { return history.size() < 2; });
  std::ranges::stable_sort(all, {}, [](const auto& history) { return history.front().unit; });
  return all;
}

}  // namespace

UnitHistory history_of(const std::vector<Occasion>& occasions, double origin, double day_sd,
                       const SharedBySource& errors) {
  UnitHistory history;
  for (const auto& occasion : occasions)
    history.visits.push_back({occasion.moment - origin, occasion.value, std::hypot(occasion.private_sd, day_sd)});
  history.rate_sd = std::numeric_limits<double>::infinity();
  history.shared = shared_factors(occasions, errors);
  return history;
}

FleetDrift drift_of_fleet(const std::vector<Occasion>& occasions, const std::vector<std::vector<double>>& adjustments,
                          const SharedBySource& errors) {
  auto by_unit = histories_of(occasions, adjustments);
  if (by_unit.size() > most_units) by_unit.resize(most_units);
  FleetDrift fleet;
  std::set<std::size_t> units;
  for (const auto& history : by_unit) units.insert(history.front().unit);
  fleet.units = units.size();
  take_days(by_unit, fleet);
  std::vector<UnitHistory> histories;
  for (const auto& history : by_unit)
    histories.push_back(history_of(history, history.front().moment, fleet.day_sd, errors));
  fleet.walks = walk_of_units(histories);
  take_trends(histories, fleet);
  if (!std::isfinite(fleet.rate_sd)) return fleet;
  for (auto& history : histories) history.rate = fleet.rate, history.rate_sd = fleet.rate_sd;
  fleet.walks = walk_of_units(histories);
  return fleet;
}

}  // namespace tumble::statistics
