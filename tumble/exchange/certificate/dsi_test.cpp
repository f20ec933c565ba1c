#include <gtest/gtest.h>

#include <algorithm>

#include "tumble/exchange/certificate.hpp"
#include "tumble/units/words.hpp"

namespace tumble {
namespace {

std::string shown(const char* text) { return dsi_unit(Unit::parse(text)).value_or("none"); }

TEST(DsiUnit, WritesTheUnitsOfTheField) {
  EXPECT_EQ(shown("deg/h"), "\\hour\\tothe{-1}\\degree");
  EXPECT_EQ(shown("deg/sqrt(h)"), "\\hour\\tothe{-0.5}\\degree");
  EXPECT_EQ(shown("deg/h^1.5"), "\\hour\\tothe{-1.5}\\degree");
  EXPECT_EQ(shown("arcsec"), "\\arcsecond");
  EXPECT_EQ(shown("m/s^2"), "\\metre\\second\\tothe{-2}");
  EXPECT_EQ(shown("(m/s)/sqrt(h)"), "none");
  EXPECT_EQ(shown("ppm"), "\\ppm");
  EXPECT_EQ(shown("1"), "\\one");
  EXPECT_EQ(shown("degC"), "\\degreecelsius");
  EXPECT_EQ(shown("K"), "\\kelvin");
  EXPECT_EQ(shown("ug"), "none");
}

TEST(DsiUnit, OfADimensionIsCoherent) {
  EXPECT_EQ(dsi_unit(Unit::parse("deg/h/g").dimension()), "\\metre\\tothe{-1}\\second\\radian");
  EXPECT_EQ(dsi_unit(Unit::parse("ug/g^2").dimension()), "\\metre\\tothe{-1}\\second\\tothe{2}");
  EXPECT_EQ(dsi_unit(Unit::parse("pulse/s/g").dimension()), "\\metre\\tothe{-1}\\second");
  EXPECT_EQ(dsi_unit(Unit::parse("pulse").dimension()), "\\one");
  EXPECT_EQ(dsi_unit(Unit::parse("1/sqrt(h)").dimension()), "\\second\\tothe{-0.5}");
}

/// A minimal DCC fragment: dcc_problems() looks at every unit in it.
bool is_accepted(const std::string& unit) {
  const auto problems = dcc_problems("<dcc:digitalCalibrationCertificate><si:unit>" + unit +
                                     "</si:unit></dcc:digitalCalibrationCertificate>");
  return std::ranges::none_of(problems,
                              [](const auto& problem) { return problem.text().find("D-SI") != std::string::npos; });
}

TEST(DsiUnit, EveryWordOfAUnitHasOneThatTheRulesAccept) {
  for (const auto& [word, prefixes] : unit_words()) {
    std::vector<std::string> all{std::string(word)};
    for (const char prefix : prefixes) all.push_back(prefix + std::string(word));
    for (const auto& text : all) {
      const Unit unit = Unit::parse(text);
      EXPECT_TRUE(is_accepted(dsi_unit(unit.dimension()))) << text << " " << dsi_unit(unit.dimension());
      if (const auto in_own = dsi_unit(unit)) {
        EXPECT_TRUE(is_accepted(*in_own)) << text << " " << *in_own;
      }
    }
  }
}

TEST(DsiUnit, RulesRefuseOtherTexts) {
  for (const char* text :
       {"m/s^2", "\\standardgravity", "\\metre/\\second", "\\micro", "\\tothe{2}", "\\metre\\tothe{}",
        "\\metre\\tothe{a}", "\\micro\\one", "\\micro\\milli\\metre", "metre", ""})
    EXPECT_FALSE(is_accepted(text)) << text;
  EXPECT_TRUE(is_accepted("\\micro\\metre\\second\\tothe{-2}"));
}

}  // namespace
}  // namespace tumble
