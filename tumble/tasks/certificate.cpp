#include "tumble/tasks/certificate.hpp"

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/report/report.hpp"
#include "tumble/tasks/plausible.hpp"

namespace tumble {

Certificate certificate_on(const std::string& result_file, const CertificateDetails& details) {
  const std::string text = read_text_file(result_file);
  const Estimate estimate = estimate_from_json(text, result_file);
  Findings about_answer;  // without those on limits that no parameter has
  for (const auto& finding : estimate.findings)
    if (!finding.code.starts_with("limit_")) about_answer.push_back(finding);
  std::vector<std::string> undermined;
  for (const auto& parameter : estimate.parameters)
    if (is_undermined(parameter.name, estimate.parameters, about_answer)) undermined.push_back(parameter.name);
  Certificate certificate = certify(estimate, details, undermined);
  certificate.result_file = result_file;
  certificate.result_sha256 = sha256_of(text);
  return certificate;
}

}  // namespace tumble
