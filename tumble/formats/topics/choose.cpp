#include "tumble/formats/topics/choose.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "tumble/units/error.hpp"
#include "tumble/units/nearest.hpp"

namespace tumble::topics {
namespace {

bool meets(const std::string& name, const std::string& asked) {
  return name == asked || name.starts_with(asked + ":") || name + ":0" == asked;
}

/// The first of the names that no channel has yet.
std::string free_name(const Topic& topic, const Column& column, std::set<std::string>& taken) {
  for (const std::string& name : column.names)
    if (taken.insert(name).second) return name;
  std::string name = topic.name + "." + column.field;
  while (!taken.insert(name).second) name += "_";
  return name;
}

}  // namespace

std::vector<std::size_t> asked_for(std::size_t count, const std::vector<std::string>& topics,
                                   const std::function<bool(std::size_t, const std::string&)>& meets,
                                   const std::function<Problem(const std::string&)>& refusal) {
  std::vector<std::size_t> chosen;
  Problems problems;
  for (const std::string& asked : topics) {
    bool met = false;
    for (std::size_t i = 0; i < count; ++i) {
      if (!meets(i, asked)) continue;
      met = true;
      if (std::ranges::find(chosen, i) == chosen.end()) chosen.push_back(i);
    }
    if (!met) problems.push_back(refusal(asked));
  }
  if (!problems.empty()) throw Error(Error::Kind::bad_file, problems);
  return chosen;
}

std::vector<std::size_t> asked_for(const std::vector<std::string>& names, const std::vector<std::string>& topics,
                                   const std::string& path) {
  return asked_for(
      names.size(), topics, [&](std::size_t i, const std::string& asked) { return meets(names[i], asked); },
      [&](const std::string& asked) -> Problem {
        return say("'{}': no topic '{}'{} (topics with samples: {})", path, asked, did_you_mean(asked, names),
                   names.empty() ? Sentence("none") : say("{}", fmt::join(names, ", ")));
      });
}

void name_the_others(const std::vector<std::string>& names, const std::vector<std::size_t>& chosen,
                     Findings& findings) {
  std::vector<std::string> others;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (std::ranges::find(chosen, i) == chosen.end()) others.push_back(names[i]);
  if (others.empty()) return;
  findings.push_back({Finding::Severity::info,
                      "topics_not_read",
                      {{"topics", fmt::format("{}", fmt::join(others, ", "))}, {"number", others.size()}}});
}

void name_columns(std::vector<Topic>& topics) {
  std::set<std::string> taken;
  for (Topic& topic : topics)
    for (Column& column : topic.columns) column.names = {free_name(topic, column, taken)};
}

void keep_columns(const std::vector<std::string>& only, std::vector<Topic>& topics) {
  if (!only.empty())
    for (Topic& topic : topics)
      std::erase_if(topic.columns,
                    [&](const Column& column) { return std::ranges::find(only, column.name()) == only.end(); });
  std::erase_if(topics, [](const Topic& topic) { return topic.columns.empty(); });
}

std::vector<std::string> give_units(const std::map<std::string, Unit>& units, Topic& topic) {
  std::vector<std::string> without;
  for (Column& column : topic.columns) {
    if (column.unit) continue;
    const auto given = units.find(column.name());
    if (given == units.end()) without.push_back(column.name());
    column.unit = given == units.end() ? Unit() : given->second;
  }
  return without;
}

void name_channels(const ReadOptions& options, Log& log) {
  name_columns(log.topics);
  keep_columns(options.only, log.topics);
  std::vector<std::string> without_unit;
  for (Topic& topic : log.topics) {
    std::string sources;
    for (const Column& column : topic.columns)
      if (column.name() != topic.name + "." + column.field)
        sources += fmt::format("{}{} = {}", sources.empty() ? "" : ", ", column.name(), column.field);
    for (std::string& name : give_units(options.units, topic)) without_unit.push_back(std::move(name));
    if (sources.empty()) continue;
    std::string& meta = log.frame.meta[topic.name];  // two topics of the log may be halves of one in the file
    meta += (meta.empty() ? "" : ", ") + sources;
  }
  if (log.topics.empty())
    throw Error(Error::Kind::bad_file, say("'{}' has no channel of that name to read", log.frame.origin.file));
  if (!without_unit.empty())
    log.frame.findings.push_back(
        {Finding::Severity::info, "unit_unknown", {{"channels", fmt::format("{}", fmt::join(without_unit, ", "))}}});
}

}  // namespace tumble::topics
