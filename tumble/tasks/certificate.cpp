#include "tumble/tasks/certificate.hpp"

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/report/report.hpp"
#include "tumble/tasks/plausible.hpp"

namespace tumble {

Certificate certificate_on(const std::string& result_file, const CertificateDetails& details) {
  const std::string text = read_text_file(result_file);
  const Estimate estimate = estimate_from_json(text, result_file);
  std::vector<std::string> undermined;
  for (const auto& parameter : estimate.parameters)
    if (is_undermined(estimate, parameter.name)) undermined.push_back(parameter.name);
  Certificate certificate = certify(estimate, details, undermined);
  certificate.result_file = result_file;
  certificate.result_sha256 = sha256_of(text);
  return certificate;
}

}  // namespace tumble
