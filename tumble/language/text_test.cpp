#include "tumble/language/text.hpp"

#include <gtest/gtest.h>
#include <toml++/toml.h>

#include <algorithm>

#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace assets {
extern const std::string_view en_toml;
extern const std::string_view zh_toml;
}  // namespace assets

namespace {

/// "{0}", "{1}" of a sentence, in order of their numbers.
std::string places_in(const std::string& sentence) {
  std::string places;
  for (std::size_t i = 0; i + 2 < sentence.size(); ++i)
    if (sentence[i] == '{' && sentence[i + 2] == '}') places += sentence[i + 1];
  std::ranges::sort(places);
  return places;
}

TEST(Text, EveryLanguageHasTheWordsOfTheCertificateAndOfTheReport) {
  const auto english = toml::parse(assets::en_toml), chinese = toml::parse(assets::zh_toml);
  for (const char* section : {"certificate", "report", "terminal", "archive", "list"}) {
    const auto& ours = *english[section].as_table();
    const auto& theirs = *chinese[section].as_table();
    EXPECT_EQ(ours.size(), theirs.size());
    for (const auto& [key, value] : ours) {
      ASSERT_TRUE(theirs.contains(key)) << section << "." << key;
      EXPECT_EQ(places_in(*value.value<std::string>()), places_in(*theirs[key].value<std::string>())) << key;
    }
  }
}

TEST(Text, AKeyThatALanguageLacksIsADefect) {
  EXPECT_EQ(text_of(Language::chinese, "certificate", "pass"), "合格");
  EXPECT_EQ(text_of(Language::english, "certificate", "pass"), "Pass");
  EXPECT_TRUE(refuses(Error::Kind::internal, Asked{.values = {"certificate", "nothing"}},
                      [&] { text_of(Language::chinese, "certificate", "nothing"); }));
  EXPECT_TRUE(refuses(Error::Kind::internal, Asked{.values = {"nothing", "pass"}},
                      [&] { text_of(Language::chinese, "nothing", "pass"); }));
}

TEST(Text, LanguagesHaveTheirCodes) {
  ASSERT_EQ(language_codes().size(), 2u);
  EXPECT_EQ(code_of(Language::english), "en");
  EXPECT_EQ(code_of(Language::chinese), "zh");
}

}  // namespace
}  // namespace tumble
