#include "tumble/units/sentence.hpp"

#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include "tumble/units/error.hpp"

namespace tumble {
namespace {

TEST(Sentence, HasThePatternAndTheTypesOfItsValues) {
  const Sentence said = say("{1} of '{0}' is {2:.3g}{{: {3}", Name{"a b"}, "words", 3.14159, say("no {}", 7));
  EXPECT_EQ(said.text(), "words of 'a b' is 3.14{: no 7");
  EXPECT_EQ(said.pattern, "{} of '{}' is {}{{: {}");
  using Kind = SentenceValue::Kind;
  ASSERT_EQ(said.values.size(), 4u);
  EXPECT_EQ(said.values[0].kind, Kind::sentence);
  EXPECT_EQ(said.values[1].kind, Kind::name);
  EXPECT_EQ(said.values[2].kind, Kind::number);
  EXPECT_EQ(said.values[2].number, 3.14159);
  EXPECT_EQ(said.values[3].nested.at(0).pattern, "no {}");
}

TEST(Sentence, OfWordsOrOfATextHasItsEnglish) {
  EXPECT_EQ(Sentence("{a} b").text(), "{a} b");
  EXPECT_EQ(Sentence(std::string("{a} b")).text(), "{a} b");
  EXPECT_TRUE(Sentence().empty());
}

TEST(Sentence, IsNotAsLongAsWhatItNames) {
  std::string key;
  for (int i = 0; i < 200'000; ++i) key += "\u00e9";
  const std::string text = say("there is no '{}' here", key).text();
  EXPECT_LT(text.size(), 11'000u);
  EXPECT_TRUE(text.starts_with("there is no '\u00e9\u00e9"));
  EXPECT_TRUE(text.ends_with("\u00e9\u00e9' here"));
  EXPECT_NE(text.find("\u00e9 ... \u00e9"), std::string::npos);  // whole characters
  const std::vector<std::string> names(50'000, "a");
  EXPECT_TRUE(say("without unit: {}", fmt::join(names, ", ")).text().ends_with("a, a, ..."));
}

TEST(Problem, WithinKeepsWhatIsKnownOfThePlace) {
  const Problem problem =
      within(Where{.file = "p.toml", .line = 7, .table = "outer", .place = say("{}:{}", Name{"p.toml"}, 7)},
             within(Where{.table = "[rig]", .key = "kind", .place = "[rig]: kind"}, "is wrong"));
  EXPECT_EQ(problem.text(), "p.toml:7: [rig]: kind: is wrong");
  EXPECT_EQ(problem.where.file, "p.toml");
  EXPECT_EQ(problem.where.line, 7u);
  EXPECT_EQ(problem.where.table, "[rig]");
  EXPECT_EQ(problem.where.key, "kind");
}

TEST(Problem, ALineOfOneFileIsNoneOfAnother) {
  const Problem problem = within(Where{.file = "outer.toml", .line = 7, .column = 2},
                                 within(Where{.file = "inner.csv", .channel = "gyro"}, "is wrong"));
  EXPECT_EQ(problem.where.file, "inner.csv");
  EXPECT_EQ(problem.where.line, 0u);
  EXPECT_EQ(problem.where.column, 0u);
}

TEST(Problem, InASentenceKeepsItsPatternAndItsPlace) {
  const Sentence said = say("not archived: {}", within(say("{}:{}", Name{"p.toml"}, 7), say("no {}", 3)));
  EXPECT_EQ(said.text(), "not archived: p.toml:7: no 3");
  ASSERT_EQ(said.values.at(0).kind, SentenceValue::Kind::sentence);
  const Sentence& nested = said.values[0].nested.at(0);
  EXPECT_EQ(nested.pattern, "{}: {}");
  EXPECT_EQ(nested.values.at(0).nested.at(0).pattern, "{}:{}");
  EXPECT_EQ(nested.values.at(1).nested.at(0).pattern, "no {}");
  EXPECT_EQ(say("x {}", Problem("y")).values.at(0).nested.at(0).pattern, "y");  // without a place: what alone
}

TEST(Problem, NamesOfFilesAreToldFromAFolderOn) {
  const Problem problem = within(Where{.file = "/a b/c.csv", .place = say("'{}'", Name{"/a b/c.csv"})},
                                 say("{}: {}", Name{"/a b/d"}, say("no {}", Name{"/a b/e"})));
  const Problem shorter = named_from("/a b", problem);
  EXPECT_EQ(shorter.text(), "'c.csv': d: no e");
  EXPECT_EQ(shorter.where.file, "c.csv");
}

TEST(ErrorOfSentences, SaysAllProblemsInEnglish) {
  const Error error(Error::Kind::bad_file, Problems{say("cannot read '{}'", Name{"x"}), "and more"});
  EXPECT_STREQ(error.what(), "cannot read 'x'\nand more");
}

}  // namespace
}  // namespace tumble
