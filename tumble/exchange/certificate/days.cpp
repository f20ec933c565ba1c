#include <fmt/format.h>

#include "tumble/exchange/certificate/work.hpp"
#include "tumble/exchange/test_days.hpp"

namespace tumble::certificate {

CertificateDetails with_days_of_test(CertificateDetails details, const Estimate& estimate) {
  const auto days = test_days(estimate);
  if (!days) return details;
  if (!details.begun) details.begun = days->begun;
  if (!details.ended) details.ended = days->ended;
  return details;
}

std::vector<Sentence> doubts_about_days(const CertificateDetails& stated, const Estimate& estimate) {
  constexpr std::chrono::days zone{1};  // the recorder and the laboratory may be in two time zones
  using Day = std::chrono::sys_days;
  std::vector<Sentence> doubts;
  for (const auto& [file, begun, ended] : recording_days(estimate)) {
    const bool early = stated.begun && begun < Day(*stated.begun) - zone;
    const bool late = stated.ended && ended > Day(*stated.ended) + zone;
    if (!early && !late) continue;
    doubts.push_back(say(
        "{} was measured from {} to {} by its own clock, which is not within begun and ended of the certificate: one "
        "of the two is wrong",
        Name{file}, Name{iso_date(Date(begun))}, Name{iso_date(Date(ended))}));
  }
  return doubts;
}

}  // namespace tumble::certificate
