#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <concepts>
#include <optional>
#include <string>
#include <vector>

#include "tumble/units/error.hpp"

/// For the tests of refusals: they ask for the kind, the values and the place of a problem. The English words may
/// change without a change of the test.
namespace tumble {

/// How work ended.
struct Refused {
  std::optional<Error::Kind> kind = {};  ///< absent: the work was done, nothing was thrown
  Problems problems = {};

  bool empty() const { return !kind; }
};

/// A question of a test about one problem of a refusal. An empty member is not asked.
struct Asked {
  std::vector<std::string> values =
      {};                    ///< as they are shown, in their order: those of the place, then of the sentence
  std::string part = {};     ///< stands in one value: of a list, or of a sentence
  std::string pattern = {};  ///< part of the pattern: only for a sentence that no value distinguishes
  std::string file = {}, table = {}, key = {}, channel = {};
  std::size_t line = 0, column = 0;
};

/// Runs the work, and returns how it ended. Exceptions other than Error pass.
template <std::invocable Work>
Refused refusal_of(const Work& work) {
  try {
    static_cast<void>(work());
  } catch (const Error& error) {
    return {error.kind, error.problems};
  }
  return {};
}

/// Every value of a sentence and of the sentences in it that is no sentence itself, as it is shown.
inline void add_values(const Sentence& said, std::vector<std::string>& values) {
  for (const SentenceValue& value : said.values) {
    if (value.kind != SentenceValue::Kind::sentence) values.push_back(value.text);
    for (const Sentence& nested : value.nested) add_values(nested, values);
  }
}

/// Whether the words stand in one value, which may be a sentence.
inline bool has_part(const Sentence& said, const std::string& words) {
  return std::ranges::any_of(said.values,
                             [&](const SentenceValue& value) { return value.text.find(words) != std::string::npos; });
}

/// Whether the pattern of a sentence, or of one in it, holds the words.
inline bool has_pattern(const Sentence& said, const std::string& words) {
  const auto nested_has = [&](const Sentence& nested) { return has_pattern(nested, words); };
  return said.pattern.find(words) != std::string::npos || std::ranges::any_of(said.values, [&](const SentenceValue& v) {
           return std::ranges::any_of(v.nested, nested_has);
         });
}

inline bool is_asked(const Problem& problem, const Asked& asked) {
  const Where& where = problem.where;
  const auto same = [](const std::string& wanted, const std::string& found) {
    return wanted.empty() || wanted == found;
  };
  if (!same(asked.file, where.file) || !same(asked.table, where.table) || !same(asked.key, where.key)) return false;
  if (!same(asked.channel, where.channel) || (asked.line != 0 && asked.line != where.line)) return false;
  if (asked.column != 0 && asked.column != where.column) return false;
  if (!has_pattern(problem.what, asked.pattern) && !has_pattern(where.place, asked.pattern)) return false;
  std::vector<std::string> values;
  add_values(where.place, values);
  add_values(problem.what, values);
  if (!asked.part.empty() && !has_part(where.place, asked.part) && !has_part(problem.what, asked.part)) return false;
  auto wanted = asked.values.begin();
  for (const std::string& value : values)
    if (wanted != asked.values.end() && value == *wanted) ++wanted;
  return wanted == asked.values.end();
}

/// The problem with its place, pattern and values, for who reads a test that fails.
inline std::string shown_for_test(const Problem& problem) {
  std::vector<std::string> values;
  add_values(problem.where.place, values);
  add_values(problem.what, values);
  std::string text = problem.text() + "\n    pattern: " + problem.what.pattern + "\n    values:";
  for (const std::string& value : values) text += " [" + value + "]";
  const Where& where = problem.where;
  text += "\n    where: file [" + where.file + "] line " + std::to_string(where.line) + " column ";
  return text + std::to_string(where.column) + " table [" + where.table + "] key [" + where.key + "] channel [" +
         where.channel + "]\n";
}

/// Whether the problem is as it is asked.
inline ::testing::AssertionResult is_problem(const Problem& problem, const Asked& asked) {
  if (is_asked(problem, asked)) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "the problem is\n  " << shown_for_test(problem);
}

/// Whether there is such a problem.
inline ::testing::AssertionResult has_problem(const Problems& problems, const Asked& asked) {
  std::string all;
  for (const Problem& problem : problems) {
    if (is_asked(problem, asked)) return ::testing::AssertionSuccess() << "there is\n  " << shown_for_test(problem);
    all += "\n  " + shown_for_test(problem);
  }
  return ::testing::AssertionFailure() << "no such problem among " << problems.size() << ":" << all;
}

/// Whether the work was refused with this kind and for each of `all` with a problem of its own.
inline ::testing::AssertionResult refuses(Error::Kind kind, const std::vector<Asked>& all, const Refused& refusal) {
  static constexpr std::array kinds{"bad_input", "bad_data", "bad_file", "unsupported", "internal"};
  if (!refusal.kind) return ::testing::AssertionFailure() << "nothing was thrown";
  std::vector<const Problem*> left;
  for (const Problem& problem : refusal.problems) left.push_back(&problem);
  std::string missing;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto found = std::ranges::find_if(left, [&](const Problem* problem) { return is_asked(*problem, all[i]); });
    if (found != left.end())
      left.erase(found);
    else
      missing += " " + std::to_string(i + 1);
  }
  if (*refusal.kind == kind && missing.empty()) return ::testing::AssertionSuccess();
  auto failure = ::testing::AssertionFailure() << "kind " << kinds[static_cast<std::size_t>(*refusal.kind)];
  if (!missing.empty()) failure << ", no problem like number" << missing << " of those that are asked";
  for (const Problem& problem : refusal.problems) failure << "\n  " << shown_for_test(problem);
  return failure;
}

inline ::testing::AssertionResult refuses(Error::Kind kind, const Asked& asked, const Refused& refusal) {
  return refuses(kind, std::vector<Asked>{asked}, refusal);
}

/// Runs the work, and asks for its refusal as above.
template <std::invocable Work>
::testing::AssertionResult refuses(Error::Kind kind, const Asked& asked, const Work& work) {
  return refuses(kind, asked, refusal_of(work));
}
template <std::invocable Work>
::testing::AssertionResult refuses(Error::Kind kind, const std::vector<Asked>& all, const Work& work) {
  return refuses(kind, all, refusal_of(work));
}

}  // namespace tumble
