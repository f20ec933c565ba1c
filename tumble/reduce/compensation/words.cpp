#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tumble/core/columns.hpp"
#include "tumble/reduce/compensation/work.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble::compensation {
namespace {

std::string in_a_row(const std::set<std::string>& words) { return joined(std::vector(words.begin(), words.end())); }

}  // namespace

void say_staying(const Work& work, const std::string& channel, Findings& findings) {
  std::map<std::set<std::string>, std::set<std::string>> terms;  // by the inputs that are missing
  for (const auto& used : work.staying)
    if (!used.remains) terms[used.missing].insert(used.name);
  if (terms.empty()) return;
  std::vector<std::string> parts;
  for (const auto& [missing, names] : terms) parts.push_back(in_a_row(missing) + ": " + in_a_row(names));
  findings.push_back({Finding::Severity::warning,
                      "terms_remain",
                      {{"terms", fmt::format("{}", fmt::join(parts, "; "))}, {"channel", channel}},
                      channel});
}

void tell(const Counts& counts, const std::string& channel, Findings& findings) {
  const auto add = [&](std::string code, std::size_t count, Place first = {}, std::vector<FindingValue> values = {}) {
    if (count > 0)
      findings.push_back(
          {Finding::Severity::warning, std::move(code), std::move(values), channel, {count, std::move(first), {}}});
  };
  const double share = static_cast<double>(counts.outside) / static_cast<double>(counts.samples);
  add("extrapolated", counts.outside, counts.first_outside, {{"share", share, "%"}, {"channel", channel}});
  add("input_missing", counts.blank);
  add("error_model_does_not_hold", counts.lost);
}

Table subtracted(const Work& work, const std::string& name, const Unit& unit) {
  struct Row {
    std::string term;
    double mean, sd, largest;
    std::string inputs;
  };
  std::vector<Row> rows;
  const double n = std::max(1.0, static_cast<double>(work.counts.samples));
  for (const auto& used : work.terms) {
    const double mean = used.sum / n, sd = std::sqrt(std::max(0.0, used.squares / n - mean * mean));
    rows.push_back({used.name, mean, sd, used.largest, in_a_row(used.from)});
  }
  for (const auto& used : work.staying)
    rows.push_back(
        {used.name, std::nan(""), std::nan(""), std::nan(""), used.remains ? "remains" : "missing: remains"});
  return tabulate(name, "size of each term of the error model over the recording", rows,
                  {{"term", &Row::term},
                   {"mean", unit, &Row::mean},
                   {"sd", unit, &Row::sd},
                   {"largest", unit, &Row::largest},
                   {"inputs", &Row::inputs}});
}

}  // namespace tumble::compensation
