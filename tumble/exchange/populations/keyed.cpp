#include "tumble/exchange/populations/keyed.hpp"

#include <algorithm>

#include "tumble/core/budget.hpp"
#include "tumble/math/linear_algebra.hpp"

namespace tumble::populations {

SharedErrors::SharedErrors(const std::vector<const Estimate*>& results) : as_(results) {
  std::map<Key, std::pair<std::size_t, std::size_t>> seen;  // results that have it, draws
  std::set<Key> unlike;
  for (const auto* result : results)
    for (const auto& line : result->budget) {
      const Key key{line.source, as_.of(line)};
      if (key.second.empty()) continue;
      auto& [count, draws] = seen[key];
      if (count > 0 && draws != line.factor.columns) unlike.insert(key);
      ++count, draws = line.factor.columns;
    }
  for (const auto& [key, found] : seen) {
    if (found.first < 2 || unlike.contains(key)) continue;
    first_[key] = {draws_, found.second};
    draws_ += found.second;
  }
}

Matrix SharedErrors::columns_of(const Estimate& result, const std::vector<std::size_t>& rows) const {
  Matrix out(rows.size(), draws_);
  for (const auto& line : result.budget)
    if (const auto place = first_.find({line.source, as_.of(line)}); place != first_.end())
      set_block(out, 0, place->second.first, chosen_rows(line.factor, rows));
  return out;
}

Matrix SharedErrors::private_of(const Estimate& result, const std::vector<std::size_t>& rows) const {
  std::vector<Contribution> own;
  for (const auto& line : result.budget)
    if (!holds(line)) own.push_back(line);
  const Matrix all = covariance_of(own, result.parameters.size());
  Matrix out = chosen_columns(chosen_rows(all, rows), rows);
  for (std::size_t i = 0; i < rows.size(); ++i)
    out(i, i) = std::max(out(i, i), 1e-8 * result.covariance(rows[i], rows[i]));
  return out;
}

Table left_out_table(const std::vector<std::pair<std::string, Sentence>>& unit_and_why) {
  Table table{"left_out", "results that are not used", {{"unit", Unit()}, {"why", Unit()}}, {}};
  for (const auto& [unit, why] : unit_and_why) table.rows.push_back({unit, why.text()});
  return table;
}

}  // namespace tumble::populations
