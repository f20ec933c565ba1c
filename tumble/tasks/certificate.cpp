#include "tumble/tasks/certificate.hpp"

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/report/report.hpp"
#include "tumble/tasks/plausible.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

namespace {

std::string plan_of(const Estimate& estimate) {
  return estimate.provenance.plans.empty() ? "" : estimate.provenance.plans.front().sha256;
}

void add_validation(const std::string& file, Certificate& certificate) {
  const std::string text = read_text_file(file);
  CertifiedValidation validation{estimate_from_json(text, file), file, sha256_of(text)};
  if (validation.estimate.method != "validation")
    throw Error(Error::Kind::bad_input, say("{}: is not what `tumble validate PLAN -o FILE` writes", Name{file}));
  if (plan_of(validation.estimate) != plan_of(certificate.estimate))
    certificate.notes.push_back(say("{}: the validation is of another text of the plan than the result", Name{file}));
  certificate.validation = std::move(validation);
}

}  // namespace

Certificate certificate_on(const std::string& result_file, const CertificateDetails& details,
                           const std::string& validation_file) {
  const std::string text = read_text_file(result_file);
  const Estimate estimate = estimate_from_json(text, result_file);
  std::vector<std::string> undermined;
  for (const auto& parameter : estimate.parameters)
    if (is_undermined(estimate, parameter.name)) undermined.push_back(parameter.name);
  Certificate certificate = certify(estimate, details, undermined);
  certificate.result_file = result_file;
  certificate.result_sha256 = sha256_of(text);
  if (!validation_file.empty()) add_validation(validation_file, certificate);
  return certificate;
}

}  // namespace tumble
