#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tumble/reduce/compensation/inputs.hpp"
#include "tumble/reduce/compensation/work.hpp"

namespace tumble::compensation {
namespace {

std::string joined(const std::set<std::string>& words) { return fmt::format("{}", fmt::join(words, ", ")); }

}  // namespace

void say_staying(const Work& work, const std::string& channel, Findings& findings) {
  if (work.staying.empty()) return;
  std::map<std::set<std::string>, std::set<std::string>> terms;  // by the inputs that are missing
  for (const auto& used : work.staying) {
    std::set<std::string> missing;
    for (const std::size_t k : used.missing) missing.insert(inputs()[k].name);
    terms[missing].insert(used.term.name);
  }
  std::vector<std::string> parts;
  for (const auto& [missing, names] : terms) parts.push_back(joined(missing) + ": " + joined(names));
  findings.push_back(
      {Finding::Severity::warning,
       fmt::format("terms that remain in the output, because neither a channel nor a plan states what they "
                   "need: {}. Channel {}.compensation_sd counts them with the range that the calibration "
                   "covered. Name the channels in [channels], or give the plan by --plan",
                   fmt::join(parts, "; "), channel),
       channel});
}

void say(const Counts& counts, const std::string& channel, Findings& findings) {
  const auto add = [&](std::string text) {
    findings.push_back({Finding::Severity::warning, std::move(text), channel});
  };
  if (counts.outside > 0)
    add(
        fmt::format("{:.2g} % of the samples lie outside of what the calibration covered, the first at {:.6g} s: the "
                    "compensation is extrapolated there and its stated uncertainty does not hold; channel "
                    "{}.extrapolated marks them",
                    100.0 * static_cast<double>(counts.outside) / static_cast<double>(counts.samples),
                    counts.first_outside, channel));
  if (counts.blank > 0)
    add(fmt::format("{} samples lack an input of the error model: they could not be compensated and are missing now",
                    counts.blank));
  if (counts.lost > 0)
    add(
        fmt::format("in {} samples the error changes by more than half of what is measured: the error model does not "
                    "hold there, and they are missing now",
                    counts.lost));
}

Table subtracted(const Work& work, const std::string& name, const Unit& unit) {
  Table table{name,
              "what each term of the error model gave over the recording",
              {{"term", Unit()}, {"mean", unit}, {"sd", unit}, {"largest", unit}, {"inputs", Unit()}},
              {}};
  const double n = std::max(1.0, static_cast<double>(work.counts.samples));
  for (const auto& used : work.terms) {
    const double mean = used.sum / n;
    table.rows.push_back({used.term.name, mean, std::sqrt(std::max(0.0, used.squares / n - mean * mean)), used.largest,
                          joined(used.from)});
  }
  for (const auto& used : work.staying)
    table.rows.push_back({used.term.name, std::nan(""), std::nan(""), std::nan(""), std::string("missing: remains")});
  return table;
}

}  // namespace tumble::compensation
