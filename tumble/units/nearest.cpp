#include "tumble/units/nearest.hpp"

#include <algorithm>
#include <cstddef>

namespace tumble {

namespace {

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return lower;
}

std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), now(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    now[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      now[j] = std::min({last[j] + 1, now[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) now[j] = std::min(now[j], before[j - 2] + 1);
    }
    std::swap(before, last);
    std::swap(last, now);
  }
  return last[b.size()];
}

/// The shortest of the names that hold the word: a beginning or an end was typed. Empty: none, or the word is too
/// short.
std::string holding(std::string_view word, const std::vector<std::string>& known, bool only_beginnings) {
  std::string best;
  if (word.size() < 3) return best;
  for (const auto& candidate : known) {
    const auto at = lower_case(candidate).find(word);
    const bool holds = at != std::string::npos && (at == 0 || !only_beginnings);
    if (holds && (best.empty() || candidate.size() < best.size())) best = candidate;
  }
  return best;
}

}  // namespace

std::string nearest(std::string_view name, const std::vector<std::string>& known) {
  if (name.size() > 200) return "";
  const std::string mistyped = lower_case(name);
  std::string best;
  std::size_t best_distance = 2 + name.size() / 4;
  for (const auto& candidate : known) {
    const std::size_t slips = distance(mistyped, lower_case(candidate));
    if (slips >= best_distance || slips >= std::max(name.size(), candidate.size())) continue;
    best = candidate;
    best_distance = slips;
  }
  // "insp" is the beginning of inspect rather than two slips from init.
  if (best_distance > 1)
    if (const auto begun = holding(mistyped, known, true); !begun.empty()) return begun;
  return best.empty() ? holding(mistyped, known, false) : best;
}

Sentence did_you_mean(std::string_view name, const std::vector<std::string>& known) {
  const std::string near = nearest(name, known);
  return near.empty() ? Sentence() : say("; did you mean '{}'?", near);
}

}  // namespace tumble
