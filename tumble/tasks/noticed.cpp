#include "tumble/tasks/noticed.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <utility>

namespace tumble {
namespace {

/// One kind of finding over all recordings.
struct Kind {
  Finding first;
  std::size_t places = 1;
  std::size_t most = 0;  ///< occurrences in one place
};

std::string place_of(const std::string& file, const Finding& finding) {
  return file + (finding.where.empty() ? "" : ", " + finding.where);
}

/// A text from a file without codes is its own kind.
bool same_kind(const Finding& a, const Finding& b) {
  return a.severity == b.severity && a.code == b.code && (!a.code.empty() || a.message == b.message);
}

void add(const std::string& file, Finding finding, std::vector<Kind>& kinds) {
  const auto known = std::ranges::find_if(kinds, [&](const Kind& kind) { return same_kind(kind.first, finding); });
  const std::size_t count = finding.occurrences.count;
  finding.where = place_of(file, finding);
  if (known == kinds.end()) {
    kinds.push_back({std::move(finding), 1, count});
    return;
  }
  ++known->places;
  auto& occurrences = known->first.occurrences;
  occurrences.count += count;
  if (count > known->most) occurrences.worst = Place(finding.where);
  known->most = std::max(known->most, count);
}

Finding finished(Kind kind) {
  if (kind.places == 1) return kind.first;
  auto& [count, first, worst] = kind.first.occurrences;
  first = Place(kind.first.where);
  if (!worst.given()) worst = first;
  kind.first.where += fmt::format(" and {} more {}", kind.places - 1, kind.places == 2 ? "place" : "places");
  return kind.first;
}

}  // namespace

Findings gathered(const std::vector<NoticedIn>& noticed) {
  if (noticed.size() == 1) return noticed.front().findings;
  std::vector<Kind> kinds;
  for (const auto& [file, findings] : noticed)
    for (const auto& finding : findings) add(file, finding, kinds);
  Findings result;
  for (auto& kind : kinds) result.push_back(finished(std::move(kind)));
  return result;
}

}  // namespace tumble
