#include "tumble/exchange/certificate_number.hpp"

#include <gtest/gtest.h>

namespace tumble {
namespace {

TEST(CertificateNumber, MayBeOfAnyScript) {
  for (const char* number :
       {"2026-0001", "A/17 b.3", "校准字（2026）第001号", "№ 12", "Прот-7", "x_1", "Zürich 5", "1\xf0\x9f\x94\xa7"})
    EXPECT_EQ(problem_of_certificate_number(number), "") << number;
}

TEST(CertificateNumber, MustNotLookLikeAnother) {
  for (const char* number :
       {"2026\u20110001", "2026\u20130001", "2026\u22120001", "2026-0001\u200b", "\u202e1000", "2026\u00a01",
        "2026\u00ad1", "\uff12\uff10\uff126", "2026  1", " 1", "1 ", "1\n", "\ufeff1", "1\u30002", "1\u3164"})
    EXPECT_NE(problem_of_certificate_number(number), "") << number;
  EXPECT_NE(problem_of_certificate_number("2026\u20110001").text().find("U+2011"), std::string::npos);
}

}  // namespace
}  // namespace tumble
